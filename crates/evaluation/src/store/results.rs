//! Reads a results directory: whatever is there, exactly once per task, and what is missing.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::Arc;

use rayon::prelude::*;

use super::Layout;
use super::builds::Builds;
use super::dropped::{Dropped, Needed, read_dropped};
use super::manifest::{Manifest, Task};
use super::packed::Packed;
use super::record::{OTHER_MANIFEST, Outcome, Record, RowKind};
use crate::sample::{Design, Look};
use crate::store::error::StoreError;
use basics::hash::sha256;

/// A results directory in memory: of 10^6 episodes about 200 MB.
#[derive(Debug, Clone, PartialEq)]
pub struct Results {
    /// What the run is; of a sample that grows, as far as it has.
    pub manifest: Arc<Manifest>,
    /// sha256 of the manifest of the whole run, which every record carries.
    pub sha256: String,
    /// What was known of the whole family when a balanced sample was drawn.
    pub design: Option<Design>,
    /// Methods that a sample that grows no longer has.
    pub dropped: Vec<Dropped>,
    /// All tasks; of a sample that grows, those of the point MDPs that it has so far.
    plan: Vec<Task>,
    /// The record of every task, in the order of the plan.
    records: Vec<Option<Arc<Record>>>,
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
        Self::load_known(layout, &Arc::new(Manifest::read(layout)?))
    }

    /// Reads everything as [`Self::load_all`] does, for whoever has read the manifest.
    ///
    /// # Errors
    ///
    /// Those of [`Self::load`].
    pub fn load_known(layout: &Layout, manifest: &Arc<Manifest>) -> Result<Self, StoreError> {
        let plan = manifest.identity.tasks();
        let sha256 = manifest.sha256();
        let mut records = Vec::with_capacity(plan.len());
        let damaged = read_records(layout, &plan, &sha256, &Arc::new, &mut |_, record| {
            records.push(record);
        })?;
        refuse(layout, records.iter().flatten().count(), damaged)?;
        let design = read_design(layout, manifest)?;
        let dropped = read_dropped(layout, &manifest.identity)?;
        Ok(Self { manifest: manifest.clone(), sha256, design, dropped, plan, records })
    }

    /// Returns the last look that is complete, the first where none is; everything, where the sample does not grow.
    pub fn so_far(self) -> Self {
        let Some(growth) = &self.manifest.identity.sample.growth else { return self };
        let needed = Needed::of(&self.manifest.identity.sample, &self.dropped);
        let missing = self.missing().filter(|task| needed.has(task));
        let missing: BTreeSet<&str> = missing.map(|task| &*task.point).collect();
        let is_complete = |look: &Look| !look.draws.iter().any(|d| missing.contains(&*d.point));
        let last = growth.looks.iter().rposition(is_complete).unwrap_or(0);
        self.at_look(last).unwrap_or(self)
    }

    /// Returns the look that is under way: the first that has every task with a record, and every task that was begun;
    /// everything, where the sample does not grow.
    ///
    /// # Arguments
    ///
    /// * `begun` — whether something was done on a task without a record, or somebody was asked to do it.
    pub fn under_way(self, begun: impl Fn(usize) -> bool) -> Self {
        let rows = self.rows().filter(|(task, record)| record.is_some() || begun(task.task));
        let points: BTreeSet<&str> = rows.map(|(task, _)| &*task.point).collect();
        let look = self.manifest.identity.sample.first_look_with(&points).map(|(look, _)| look);
        look.and_then(|look| self.at_look(look)).unwrap_or(self)
    }

    /// Returns the tasks and records that a look has, counted from 0; `None` for a look that the sample has not.
    pub fn at_look(&self, look: usize) -> Option<Self> {
        let sample = self.manifest.identity.sample.at_look(look)?;
        let of_look: BTreeSet<&str> = sample.draws.iter().map(|d| d.point.as_str()).collect();
        let mut manifest = Manifest::clone(&self.manifest);
        manifest.identity.points.retain(|p| of_look.contains(p.point.as_str()));
        let rows = self.plan.iter().zip(&self.records);
        let needed = Needed::of(&self.manifest.identity.sample, &self.dropped);
        let rows = rows.filter(|(task, _)| of_look.contains(&*task.point) && needed.has(task));
        let (plan, records) = rows.map(|(task, record)| (task.clone(), record.clone())).unzip();
        manifest.identity.sample = sample;
        let (sha256, design) = (self.sha256.clone(), self.design.clone());
        let dropped = self.dropped.clone();
        Some(Self { manifest: Arc::new(manifest), sha256, design, dropped, plan, records })
    }

    /// Returns other tasks on the same point MDPs, with what is known of their family.
    ///
    /// # Arguments
    ///
    /// * `rows` — tasks of a point MDP follow one another.
    pub(crate) fn with(&self, manifest: Manifest, rows: Vec<(Task, Option<Arc<Record>>)>) -> Self {
        let (plan, records) = rows.into_iter().unzip();
        let design = self.design.clone();
        let (manifest, dropped) = (Arc::new(manifest), Vec::new());
        Self { manifest, sha256: String::new(), design, dropped, plan, records }
    }

    /// Returns all tasks.
    pub fn plan(&self) -> &[Task] {
        &self.plan
    }

    /// Returns all tasks, each with its record, in the order of the plan.
    pub fn rows(&self) -> impl ExactSizeIterator<Item = (&Task, Option<&Record>)> {
        self.plan.iter().zip(self.records.iter().map(Option::as_deref))
    }

    /// Returns the tasks that have a record.
    pub fn done(&self) -> impl Iterator<Item = (&Task, &Record)> {
        self.rows().filter_map(|(task, record)| Some((task, record?)))
    }

    /// Returns the record of the task at a position of [`Self::plan`].
    pub fn record(&self, position: usize) -> Option<&Record> {
        self.records.get(position)?.as_deref()
    }

    /// Returns the names of the metrics that some episode of training or evaluation has.
    pub fn episode_metrics(&self) -> BTreeSet<&String> {
        let rows = self.done().flat_map(|(_, record)| &record.rows);
        let rows = rows.filter(|row| matches!(row.kind, RowKind::Evaluation | RowKind::Training));
        rows.flat_map(|row| row.metrics.keys()).collect()
    }

    /// Returns the tasks without a record.
    pub fn missing(&self) -> impl Iterator<Item = &Task> {
        self.rows().filter(|(_, record)| record.is_none()).map(|(task, _)| task)
    }

    /// Returns the finished tasks that left a model, each with its record, as far as the files are there.
    pub fn models<'a>(
        &'a self,
        layout: &'a Layout,
    ) -> impl Iterator<Item = (&'a Task, &'a Record)> {
        self.done().filter(|(task, _)| layout.model(task.task).is_file())
    }

    /// Returns the builds that did the tasks.
    pub fn builds(&self) -> Builds {
        let mut builds = Builds::default();
        self.done().for_each(|(_, record)| builds.add(&record.summary.wall));
        builds
    }

    /// Returns the tasks that failed.
    pub fn failed(&self) -> impl Iterator<Item = (&Task, &Record)> {
        self.done().filter(|(_, record)| record.summary.outcome == Outcome::Failed)
    }
}

/// A record that cannot be used.
pub(super) struct Damaged {
    pub(super) task: usize,
    pub(super) path: PathBuf,
    pub(super) reason: String,
}

/// Reads the records of tasks, hands what `of` makes of each to `found` in the order of the tasks, and returns the
/// damaged ones; they and missing ones are `None`.
///
/// # Errors
///
/// [`StoreError::Io`] when one cannot be read.
pub(super) fn read_records<T: Send>(
    layout: &Layout,
    tasks: &[Task],
    sha256: &str,
    of: &(dyn Fn(Record) -> T + Sync),
    found: &mut dyn FnMut(usize, Option<T>),
) -> Result<Vec<Damaged>, StoreError> {
    let mut damaged = Vec::new();
    let packed = Packed::of(layout)?;
    let read = |task: &Task| {
        let record = match &packed {
            Some(packed) => packed.record(task, sha256)?,
            None => Record::read(layout, task, sha256)?,
        };
        Ok(record.map(of))
    };
    let read: Vec<_> = tasks.par_iter().map(read).collect();
    for (&Task { task, .. }, record) in tasks.iter().zip(read) {
        let record = match record {
            Err(StoreError::Record { path, reason }) => {
                damaged.push(Damaged { task, path, reason });
                None
            }
            record => record?,
        };
        found(task, record);
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
    read_records(layout, tasks, sha256, &drop, &mut |_, found| {
        sound += usize::from(found.is_some());
    })?;
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
    let bytes =
        layout.document("design.json")?.ok_or_else(|| malformed("it is missing".to_owned()))?;
    if sha256(&bytes) != *expected {
        let reason = "it is not what the sample of manifest.json was spread over";
        return Err(malformed(reason.to_owned()));
    }
    serde_json::from_slice(&bytes).map(Some).map_err(|e| malformed(e.to_string()))
}
