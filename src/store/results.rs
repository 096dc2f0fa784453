//! Reads a results directory: whatever is there, exactly once per task, and what is missing.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

use rayon::prelude::*;

use super::Layout;
use super::manifest::{Manifest, Task, read_plan};
use super::record::{OTHER_MANIFEST, Outcome, Record};
use crate::files::{self, limits};
use crate::hash::sha256;
use crate::sample::{Design, Look};
use crate::store::error::StoreError;

/// Records that are read at once, by as many threads as there are processors.
const AT_ONCE: usize = 4096;

/// A results directory in memory.
#[derive(Debug, Clone, PartialEq)]
pub struct Results {
    /// What the run is; of a sample that grows, as far as it has.
    pub manifest: Manifest,
    /// sha256 of the manifest of the whole run, which every record carries.
    pub sha256: String,
    /// All tasks; of a sample that grows, those of the point MDPs that it has so far.
    pub plan: Vec<Task>,
    /// Records by task.
    pub records: BTreeMap<usize, Record>,
    /// What was known of the whole family when a balanced sample was drawn.
    pub design: Option<Design>,
}

impl Results {
    /// Reads what counts in a results directory: everything, or of a sample that grows the last look that is complete, the
    /// first where none is.
    ///
    /// # Errors
    ///
    /// [`StoreError`] when it is no results directory or a file in it is damaged.
    pub fn load(layout: &Layout) -> Result<Self, StoreError> {
        Self::load_all(layout).map(Self::so_far)
    }

    /// Reads everything in a results directory, also what of a look is done before it is complete.
    ///
    /// # Errors
    ///
    /// Those of [`Self::load`].
    pub fn load_all(layout: &Layout) -> Result<Self, StoreError> {
        let manifest = Manifest::read(layout)?;
        let plan = read_plan(layout, &manifest.identity)?;
        let sha256 = manifest.sha256();
        let mut records = BTreeMap::new();
        let damaged = read_records(layout, &plan, &sha256, &mut |task, record| {
            records.insert(task, record);
        })?;
        refuse(layout, records.len(), damaged)?;
        let design = read_design(layout, &manifest)?;
        Ok(Self { manifest, sha256, plan, records, design })
    }

    /// Returns the last look that is complete, the first where none is; everything, where the sample does not grow.
    pub fn so_far(self) -> Self {
        let Some(growth) = &self.manifest.identity.sample.growth else { return self };
        let missing: BTreeSet<&str> = self.missing().map(|task| task.point.as_str()).collect();
        let is_complete = |look: &Look| !look.draws.iter().any(|d| missing.contains(&*d.point));
        let last = growth.looks.iter().rposition(is_complete).unwrap_or(0);
        self.at_look(last).unwrap_or(self)
    }

    /// Returns the tasks and records that a look has, counted from 0; `None` for a look that the sample has not.
    pub fn at_look(&self, look: usize) -> Option<Self> {
        let sample = self.manifest.identity.sample.at_look(look)?;
        let of_look: BTreeSet<&str> = sample.draws.iter().map(|d| d.point.as_str()).collect();
        let mut manifest = self.manifest.clone();
        manifest.identity.points.retain(|p| of_look.contains(p.point.as_str()));
        let has = |task: &&Task| of_look.contains(task.point.as_str());
        let plan: Vec<Task> = self.plan.iter().filter(has).cloned().collect();
        let record = |task: &Task| Some((task.task, self.records.get(&task.task)?.clone()));
        let records = plan.iter().filter_map(record).collect();
        manifest.identity.sample = sample;
        let (sha256, design) = (self.sha256.clone(), self.design.clone());
        Some(Self { manifest, sha256, plan, records, design })
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

/// A record that cannot be used.
pub(super) struct Damaged {
    pub(super) task: usize,
    pub(super) path: PathBuf,
    pub(super) reason: String,
}

/// Reads the records of tasks, hands those that are sound to `sound`, and returns the damaged ones in order.
///
/// # Errors
///
/// [`StoreError::Io`] when one cannot be read.
pub(super) fn read_records(
    layout: &Layout,
    tasks: &[Task],
    sha256: &str,
    sound: &mut dyn FnMut(usize, Record),
) -> Result<Vec<Damaged>, StoreError> {
    let mut damaged = Vec::new();
    for part in tasks.chunks(AT_ONCE) {
        let read: Vec<_> = part.par_iter().map(|task| Record::read(layout, task, sha256)).collect();
        for (&Task { task, .. }, record) in part.iter().zip(read) {
            match record {
                Err(StoreError::Record { path, reason }) => {
                    damaged.push(Damaged { task, path, reason })
                }
                record => record?.into_iter().for_each(|record| sound(task, record)),
            }
        }
    }
    Ok(damaged)
}

/// Returns how many tasks have a sound record of a manifest.
///
/// # Errors
///
/// [`StoreError::Io`] when one cannot be read.
pub fn sound_records(layout: &Layout, tasks: &[Task], sha256: &str) -> Result<usize, StoreError> {
    let mut sound = 0;
    read_records(layout, tasks, sha256, &mut |_, _| sound += 1)?;
    Ok(sound)
}

/// Returns how many whole records are of another manifest, where that shows that the manifest is what is damaged: none is
/// of this one.
pub(super) fn all_of_another(sound: usize, damaged: &[Damaged]) -> Option<usize> {
    let of_another = damaged.iter().filter(|record| record.reason == OTHER_MANIFEST).count();
    Some(of_another).filter(|of_another| *of_another > 0 && sound == 0)
}

/// Refuses damaged records, all at once; the manifest, where it is what is damaged.
fn refuse(layout: &Layout, sound: usize, damaged: Vec<Damaged>) -> Result<(), StoreError> {
    if let Some(records) = all_of_another(sound, &damaged) {
        return Err(StoreError::OtherManifest { path: layout.manifest(), records });
    }
    let mut damaged: Vec<_> = damaged.into_iter().map(|d| (d.path, d.reason)).collect();
    match damaged.pop() {
        None => Ok(()),
        Some((path, reason)) if damaged.is_empty() => Err(StoreError::Record { path, reason }),
        Some(last) => {
            damaged.push(last);
            Err(StoreError::Records(damaged))
        }
    }
}

/// Reads `design.json`, which must be what the manifest's sample was spread over.
pub(super) fn read_design(
    layout: &Layout,
    manifest: &Manifest,
) -> Result<Option<Design>, StoreError> {
    let expected = &manifest.identity.sample.design;
    if expected.is_empty() {
        return Ok(None);
    }
    let path = layout.design();
    let malformed = |reason: String| StoreError::Design { path: path.clone(), reason };
    let bytes = files::if_present(files::read(&path, limits::DOCUMENT))?;
    let bytes = bytes.ok_or_else(|| malformed("it is missing".to_owned()))?;
    if sha256(&bytes) != *expected {
        let reason = "it is not what the sample of manifest.json was spread over";
        return Err(malformed(reason.to_owned()));
    }
    serde_json::from_slice(&bytes).map(Some).map_err(|e| malformed(e.to_string()))
}
