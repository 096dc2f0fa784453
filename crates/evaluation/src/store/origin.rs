//! Where records are, for whoever needs of all of them what is too much to be kept: they are read again, or their
//! episodes are read from what was set aside of them.

use std::io::ErrorKind;
use std::sync::Arc;

use rayon::prelude::*;

use super::Layout;
use super::aside::Aside;
use super::manifest::Task;
use super::record::{Record, Row};
use crate::store::error::StoreError;
use basics::files::FileError;

/// Records that are read at once, by as many threads as there are processors: few, as whole trainings are in memory.
const AT_ONCE: usize = 512;

/// The tasks of a run, and where their records are.
#[derive(Debug, Clone)]
pub struct Origin {
    /// The results directory.
    pub layout: Layout,
    /// sha256 of the manifest of the whole run, which every record carries.
    pub sha256: String,
    /// The tasks.
    pub plan: Arc<Vec<Task>>,
    /// The episodes of the records, where they were set aside when these were read.
    pub(super) aside: Option<Arc<Aside>>,
}

impl PartialEq for Origin {
    fn eq(&self, other: &Self) -> bool {
        // What was set aside says nothing that records do not.
        (&self.layout, &self.sha256, &self.plan) == (&other.layout, &other.sha256, &other.plan)
    }
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
        let read = |position: usize| -> Result<T, StoreError> {
            let task = &self.plan[position];
            let record = Record::read(&self.layout, task, &self.sha256)?;
            let gone = || {
                let path = self.layout.record(task.task);
                FileError::at("read", &path)(ErrorKind::NotFound.into())
            };
            Ok(of(position, record.ok_or_else(gone)?))
        };
        self.in_order(wanted, read, &mut found)
    }

    /// Hands on what `of` makes of the episodes of records, as [`Self::each`] does; records are read again only where their
    /// episodes were not set aside.
    ///
    /// # Errors
    ///
    /// Those of [`Self::each`], and [`StoreError`] when what was set aside cannot be read.
    pub fn each_rows<T: Send, E: From<StoreError>>(
        &self,
        wanted: impl Fn(usize) -> bool,
        of: impl Fn(usize, Vec<Row>) -> T + Sync,
        mut found: impl FnMut(T) -> Result<(), E>,
    ) -> Result<(), E> {
        let Some(aside) = &self.aside else {
            return self.each(wanted, |position, record| of(position, record.rows), found);
        };
        let read = |position: usize| -> Result<T, StoreError> {
            Ok(of(position, aside.rows(self.plan[position].task)?))
        };
        self.in_order(wanted, read, &mut found)
    }

    /// Reads in several threads, and hands on in the order of the plan.
    fn in_order<T: Send, E: From<StoreError>>(
        &self,
        wanted: impl Fn(usize) -> bool,
        read: impl Fn(usize) -> Result<T, StoreError> + Sync,
        found: &mut dyn FnMut(T) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut positions = (0..self.plan.len()).filter(|position| wanted(*position));
        loop {
            let part: Vec<usize> = positions.by_ref().take(AT_ONCE).collect();
            if part.is_empty() {
                return Ok(());
            }
            let read: Vec<_> = part.into_par_iter().map(&read).collect();
            for of_task in read {
                found(of_task?)?;
            }
        }
    }
}
