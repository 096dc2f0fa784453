//! Reads a results directory: whatever is there, exactly once per task, and what is missing.

use std::collections::BTreeMap;
use std::fs;

use rayon::prelude::*;

use super::Layout;
use super::manifest::{Manifest, Task, read_plan};
use super::record::{Outcome, Record};
use crate::files::FileError;
use crate::hash::sha256;
use crate::sample::Design;
use crate::store::error::StoreError;

/// Records that are read at once, by as many threads as there are processors.
const AT_ONCE: usize = 4096;

/// A results directory in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Results {
    /// What the run is.
    pub manifest: Manifest,
    /// All tasks.
    pub plan: Vec<Task>,
    /// Records by task.
    pub records: BTreeMap<usize, Record>,
    /// What was known of the whole family when a balanced sample was drawn.
    pub design: Option<Design>,
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
        for part in plan.chunks(AT_ONCE) {
            let read = |task: &Task| Record::read(layout, task, &sha256);
            let read: Vec<_> = part.par_iter().map(read).collect();
            for (task, record) in part.iter().zip(read) {
                records.extend(record?.map(|record| (task.task, record)));
            }
        }
        let design = read_design(layout, &manifest)?;
        Ok(Self { manifest, plan, records, design })
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

/// Reads `design.json`, which must be what the manifest's sample was spread over.
fn read_design(layout: &Layout, manifest: &Manifest) -> Result<Option<Design>, StoreError> {
    let expected = &manifest.identity.sample.design;
    if expected.is_empty() {
        return Ok(None);
    }
    let path = layout.design();
    let bytes = fs::read(&path).map_err(FileError::at("read", &path))?;
    let malformed = |reason: String| StoreError::Malformed { path: path.clone(), reason };
    if sha256(&bytes) != *expected {
        let reason = "it is not what the sample of manifest.json was spread over; restore both, or start anew with \
                      another --out";
        return Err(malformed(reason.to_owned()));
    }
    serde_json::from_slice(&bytes).map(Some).map_err(|e| malformed(e.to_string()))
}
