//! Reads a results directory: whatever is there, exactly once per task, what is damaged, and what is missing.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use rayon::prelude::*;

use super::Layout;
use super::dropped::{Dropped, is_needed, read_dropped};
use super::error::{Damage, Remedy, StoreError};
use super::manifest::{Manifest, Task};
use super::packed::Packed;
use super::record::{OTHER_MANIFEST, Outcome, Record, RowKind};
use crate::sample::{Design, Look};
use basics::hash::sha256;

/// A results directory in memory: of 10^6 episodes about 200 MB.
#[derive(Debug, Clone, PartialEq)]
pub struct Results {
    /// What the run is; of a sample that grows, as far as it has.
    pub manifest: Arc<Manifest>,
    /// sha256 of the manifest of the whole run.
    pub sha256: String,
    /// What was known of the whole family when a balanced sample was drawn.
    pub design: Option<Design>,
    /// Methods that a sample that grows no longer has.
    pub dropped: Vec<Dropped>,
    /// All tasks; of a sample that grows, those of the point MDPs that it has so far.
    plan: Vec<Task>,
    /// The record of every task, in the order of the plan.
    records: Vec<Option<Arc<Record>>>,
    /// Numbers of the tasks whose record is damaged.
    damaged: BTreeSet<usize>,
}

impl Results {
    /// Reads what counts in a results directory: everything, or of a sample that grows the last look that is complete, the
    /// first where none is.
    pub fn load(layout: &Layout) -> Result<Self, StoreError> {
        Self::load_all(layout).map(Self::so_far)
    }

    /// Reads everything in a results directory, also what of a look is done before it is complete.
    pub fn load_all(layout: &Layout) -> Result<Self, StoreError> {
        Self::load_known(layout, &Arc::new(Manifest::read(layout)?))
    }

    /// Reads everything as [`Self::load_all`] does, for whoever has read the manifest.
    pub fn load_known(layout: &Layout, manifest: &Arc<Manifest>) -> Result<Self, StoreError> {
        let (results, damage) = Self::inspect(layout, manifest)?;
        if damage.is_empty() { Ok(results) } else { Err(StoreError::Damaged(damage)) }
    }

    /// Reads everything, and says which files cannot be used. Another machine's newest records may not show yet where a
    /// network's file system remembers folders for some seconds.
    pub fn inspect(
        layout: &Layout,
        manifest: &Arc<Manifest>,
    ) -> Result<(Self, Vec<Damage>), StoreError> {
        let plan = manifest.identity.tasks();
        let sha256 = manifest.sha256();
        let packed = Packed::of(layout)?;
        let read = |task: &Task| match &packed {
            Some(packed) => packed.record(task, &sha256),
            None => Record::read(layout, task, &sha256),
        };
        let read: Vec<_> = plan.par_iter().map(read).collect();
        let (mut records, mut damage, mut damaged) = (Vec::new(), Vec::new(), BTreeSet::new());
        for (task, record) in plan.iter().zip(read) {
            let record = or_damage(record, &mut damage)?;
            if record.is_none() {
                damaged.insert(task.task);
            }
            records.push(record.flatten().map(Arc::new));
        }
        let of_another = damage.iter().filter(|found| found.reason == OTHER_MANIFEST).count();
        if of_another > 0 && records.iter().all(Option::is_none) {
            let reason = format!(
                "it is not the manifest of the records beside it, {of_another} of which are whole and of another one"
            );
            let path = layout.manifest();
            let damage = vec![Damage { path, reason, remedy: Remedy::Begin }];
            return Ok((Self::without_records(manifest, plan), damage));
        }
        let design = or_damage(read_design(layout, manifest), &mut damage)?.flatten();
        let dropped = or_damage(read_dropped(layout, &manifest.identity), &mut damage)?;
        let results = Self {
            design,
            dropped: dropped.unwrap_or_default(),
            records,
            damaged,
            ..Self::without_records(manifest, plan)
        };
        Ok((results, damage))
    }

    fn without_records(manifest: &Arc<Manifest>, plan: Vec<Task>) -> Self {
        let records = vec![None; plan.len()];
        let (manifest, sha256) = (manifest.clone(), manifest.sha256());
        let (design, dropped, damaged) = (None, Vec::new(), BTreeSet::new());
        Self { manifest, sha256, design, dropped, plan, records, damaged }
    }

    /// Returns the last look that is complete, the first where none is; everything, where the sample does not grow.
    pub fn so_far(self) -> Self {
        let Some(growth) = &self.manifest.identity.sample.growth else { return self };
        let sample = &self.manifest.identity.sample;
        let missing = self.missing().filter(|task| is_needed(sample, &self.dropped, task));
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
        let is_begun = |task: &Task| self.damaged.contains(&task.task) || begun(task.task);
        let rows = self.rows().filter(|(task, record)| record.is_some() || is_begun(task));
        let points: BTreeSet<&str> = rows.map(|(task, _)| &*task.point).collect();
        let look = self.manifest.identity.sample.first_look_with(&points).map(|(look, _)| look);
        look.and_then(|look| self.at_look(look)).unwrap_or(self)
    }

    /// Returns the tasks and records that a look has, counted from 0; `None` for a look that the sample has not.
    pub fn at_look(&self, look: usize) -> Option<Self> {
        let whole = &self.manifest.identity.sample;
        let sample = whole.at_look(look)?;
        let of_look: BTreeSet<&str> = sample.draws.iter().map(|d| d.point.as_str()).collect();
        let rows = self.plan.iter().zip(&self.records);
        let rows = rows.filter(|(task, _)| {
            of_look.contains(&*task.point) && is_needed(whole, &self.dropped, task)
        });
        let (plan, records) = rows.map(|(task, record)| (task.clone(), record.clone())).unzip();
        let mut manifest = Manifest::clone(&self.manifest);
        manifest.identity.points.retain(|p| of_look.contains(p.point.as_str()));
        manifest.identity.sample = sample;
        Some(Self { manifest: Arc::new(manifest), plan, records, ..self.clone() })
    }

    /// Returns other tasks on the same point MDPs, with what is known of their family.
    pub(crate) fn with(&self, manifest: Manifest, rows: Vec<(Task, Option<Arc<Record>>)>) -> Self {
        let (plan, records) = rows.into_iter().unzip();
        let design = self.design.clone();
        let bare = Self::without_records(&Arc::new(manifest), plan);
        Self { sha256: String::new(), design, records, ..bare }
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

    /// Returns the tasks without a record, not even a damaged one.
    pub fn missing(&self) -> impl Iterator<Item = &Task> {
        let is_missing = |(task, record): &(&Task, Option<&Record>)| {
            record.is_none() && !self.damaged.contains(&task.task)
        };
        self.rows().filter(is_missing).map(|(task, _)| task)
    }

    /// Returns the finished tasks that left a model, each with its record, as far as the files are there.
    pub fn models<'a>(
        &'a self,
        layout: &'a Layout,
    ) -> impl Iterator<Item = (&'a Task, &'a Record)> {
        self.done().filter(|(task, _)| layout.model(task.task).is_file())
    }

    /// Says which builds did the tasks; `None` unless there are several. Records from before builds were kept do not count.
    pub fn several_builds(&self) -> Option<String> {
        let mut builds: BTreeMap<&str, usize> = BTreeMap::new();
        let all = self.done().map(|(_, record)| record.summary.wall.git.as_str());
        all.filter(|git| !git.is_empty()).for_each(|git| *builds.entry(git).or_default() += 1);
        let counts = builds.iter().map(|(git, records)| format!("{records} by {git}"));
        let counts = counts.collect::<Vec<_>>().join(", ");
        (builds.len() > 1).then(|| format!("Several builds made the records: {counts}."))
    }

    /// Says what several builds mean for scores; `None` unless there are several.
    pub fn warning_of_builds(&self) -> Option<String> {
        let several = self.several_builds()?;
        Some(format!(
            "{several} Where these builds measure otherwise, scores mix both. A run in a new folder has records of one build."
        ))
    }

    /// Returns the tasks that failed.
    pub fn failed(&self) -> impl Iterator<Item = (&Task, &Record)> {
        self.done().filter(|(_, record)| record.summary.outcome == Outcome::Failed)
    }
}

/// Returns what was read; of damaged files nothing, and takes note of them.
fn or_damage<T>(
    read: Result<T, StoreError>,
    damage: &mut Vec<Damage>,
) -> Result<Option<T>, StoreError> {
    match read {
        Err(StoreError::Damaged(found)) => {
            damage.extend(found);
            Ok(None)
        }
        read => read.map(Some),
    }
}

/// Reads `design.json`, which must be what the manifest's sample was spread over.
fn read_design(layout: &Layout, manifest: &Manifest) -> Result<Option<Design>, StoreError> {
    let expected = &manifest.identity.sample.design;
    if expected.is_empty() {
        return Ok(None);
    }
    let damaged = |reason: &str| StoreError::damaged(layout.design(), reason, Remedy::Begin);
    let bytes = layout.document("design.json")?.ok_or_else(|| damaged("it is missing"))?;
    if sha256(&bytes) != *expected {
        return Err(damaged("it is not what the sample of manifest.json was spread over"));
    }
    serde_json::from_slice(&bytes).map(Some).map_err(|e| damaged(&e.to_string()))
}
