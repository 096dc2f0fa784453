//! Where records are, for whoever needs of all of them what is too much to be kept: they are read again.

use std::io::ErrorKind;
use std::sync::Arc;

use rayon::prelude::*;

use super::Layout;
use super::manifest::Task;
use super::record::Record;
use crate::files::FileError;
use crate::store::error::StoreError;

/// Records that are read at once, by as many threads as there are processors: few, as whole trainings are in memory.
const AT_ONCE: usize = 512;

/// The tasks of a run, and where their records are.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Origin {
    /// The results directory.
    pub layout: Layout,
    /// sha256 of the manifest of the whole run, which every record carries.
    pub sha256: String,
    /// The tasks.
    pub plan: Arc<Vec<Task>>,
}

impl Origin {
    /// Reads records again and hands on what `of` makes of them, in the order of the plan.
    ///
    /// # Arguments
    ///
    /// * `wanted` — whether to read the record of the task at a position of the plan.
    /// * `of` — is given the position and the record; runs in several threads.
    ///
    /// # Errors
    ///
    /// [`StoreError`] when a record is damaged, is gone or cannot be read, and what `found` returns.
    pub fn each<T: Send, E: From<StoreError>>(
        &self,
        wanted: impl Fn(usize) -> bool,
        of: impl Fn(usize, Record) -> T + Sync,
        mut found: impl FnMut(T) -> Result<(), E>,
    ) -> Result<(), E> {
        let read = |position: &usize| -> Result<T, StoreError> {
            let task = &self.plan[*position];
            let record = Record::read(&self.layout, task, &self.sha256)?;
            let gone = || {
                let path = self.layout.record(task.task);
                FileError::at("read", &path)(ErrorKind::NotFound.into())
            };
            Ok(of(*position, record.ok_or_else(gone)?))
        };
        let mut positions = (0..self.plan.len()).filter(|position| wanted(*position));
        loop {
            let part: Vec<usize> = positions.by_ref().take(AT_ONCE).collect();
            if part.is_empty() {
                return Ok(());
            }
            let read: Vec<_> = part.par_iter().map(read).collect();
            for of_task in read {
                found(of_task?)?;
            }
        }
    }
}
