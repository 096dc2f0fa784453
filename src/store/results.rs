//! Reads a results directory: whatever is there, exactly once per task, and what is missing.

use std::collections::BTreeMap;

use super::Layout;
use super::manifest::{Manifest, Task, read_plan};
use super::record::{Outcome, Record};
use crate::store::error::StoreError;

/// A results directory in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Results {
    /// What the run is.
    pub manifest: Manifest,
    /// All tasks.
    pub plan: Vec<Task>,
    /// Records by task.
    pub records: BTreeMap<usize, Record>,
}

impl Results {
    /// Reads everything in a results directory.
    ///
    /// # Errors
    ///
    /// [`StoreError`] when it is no results directory or a file in it is damaged.
    pub fn load(layout: &Layout) -> Result<Self, StoreError> {
        let manifest = Manifest::read(layout)?;
        let plan = read_plan(layout, &manifest.identity)?;
        let sha256 = manifest.sha256();
        let mut records = BTreeMap::new();
        for task in &plan {
            if let Some(record) = Record::read(layout, task, &sha256)? {
                records.insert(task.task, record);
            }
        }
        Ok(Self { manifest, plan, records })
    }

    /// Returns the tasks without a record.
    pub fn missing(&self) -> impl Iterator<Item = &Task> {
        self.plan.iter().filter(|t| !self.records.contains_key(&t.task))
    }

    /// Returns the records of failed tasks.
    pub fn failed(&self) -> impl Iterator<Item = &Record> {
        self.records.values().filter(|r| r.summary.outcome == Outcome::Failed)
    }
}
