//! What the tasks of a run are expected to cost, corrected by what those that are done have cost.

use std::collections::BTreeMap;

use rayon::prelude::*;

use crate::run::domain::Domain;
use crate::run::effort::{Efforts, Seen};
use crate::run::error::RunError;
use crate::store::Layout;
use crate::store::manifest::{Manifest, Task};
use crate::store::record::{Outcome, Record};

/// Most records that are read for it.
const READ: usize = 500;

/// Processor time of a task of which nothing is known, seconds: it gets a pack of its own.
const UNKNOWN_S: f64 = 1800.0;

/// Memory of a worker where none was measured, MB.
const MEMORY_MB: u64 = 1000;

/// Times the largest measured memory that a worker may need, and MB on top of that.
const ROOM: (f64, u64) = (1.5, 200);

/// What tasks are expected to cost.
pub struct Costs<'a> {
    efforts: Efforts<'a>,
    /// Observed over expected seconds by method.
    factors: BTreeMap<String, f64>,
    /// Memory of a worker, MB.
    pub memory_mb: u64,
}

impl<'a> Costs<'a> {
    /// Learns from the records that there are.
    ///
    /// # Arguments
    ///
    /// * `done` — tasks with a record.
    ///
    /// # Errors
    ///
    /// [`RunError`] when the settings of the manifest cannot be used. Records that are damaged are for `check` to name.
    pub fn new(
        domain: &'a dyn Domain,
        layout: &Layout,
        manifest: &'a Manifest,
        done: &[&Task],
    ) -> Result<Self, RunError> {
        let efforts = Efforts::of_run(domain, &manifest.identity)?;
        let mut costs = Self { efforts, factors: BTreeMap::new(), memory_mb: MEMORY_MB };
        let sha256 = manifest.sha256();
        let step = done.len().div_ceil(READ).max(1);
        let some: Vec<&Task> = done.iter().step_by(step).copied().collect();
        let read = some.par_iter().filter_map(|task| Record::read(layout, task, &sha256).ok()?);
        let read: Vec<Record> = read.filter(|r| r.summary.outcome == Outcome::Ok).collect();
        let mut seen: BTreeMap<String, Seen> = BTreeMap::new();
        for Record { summary, .. } in &read {
            let (expected, _) = costs.expected(&summary.method, &summary.point)?;
            let of_method = seen.entry(summary.method.clone()).or_default();
            of_method.observed_s += summary.wall.wall_s;
            of_method.expected_s += expected;
        }
        costs.factors = seen.into_iter().map(|(method, seen)| (method, seen.factor(1.0))).collect();
        let peak = read.iter().filter_map(|r| r.summary.wall.peak_memory_mb).max();
        if let Some(peak) = peak {
            costs.memory_mb = (peak as f64 * ROOM.0) as u64 + ROOM.1;
        }
        Ok(costs)
    }

    /// Returns the processor time that a task is expected to take, seconds.
    ///
    /// # Errors
    ///
    /// [`RunError::Method`] for a method that the domain has not.
    pub fn seconds(&self, task: &Task) -> Result<f64, RunError> {
        let (expected, is_informed) = self.expected(&task.method, &task.point)?;
        Ok(match self.factors.get(task.method.as_str()) {
            Some(factor) => expected * factor,
            None if is_informed => expected,
            None => UNKNOWN_S,
        })
    }

    fn expected(&self, method: &str, point: &str) -> Result<(f64, bool), RunError> {
        let effort = self.efforts.task(method, point)?;
        Ok((effort.whole_seconds(), effort.is_informed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::testing::{Counting, Toy, planned};
    use crate::store::record::TaskResult;
    use crate::store::wall::Wall;

    #[test]
    fn what_was_measured_corrects_what_is_expected() {
        let (manifest, tasks) = planned(2);
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        let toy = Toy { learner: Counting::default() };
        let learner = tasks.iter().find(|t| t.method == "learner").unwrap();
        let seconds = |done: &[&Task]| {
            let costs = Costs::new(&toy, &layout, &manifest, done).unwrap();
            (costs.seconds(learner).unwrap(), costs.memory_mb)
        };
        // Two evaluation episodes of a second.
        assert_eq!(seconds(&[]), (2.2, 1000));
        let wall = Wall { wall_s: 101.0, peak_memory_mb: Some(400), ..Wall::default() };
        let result = TaskResult { wall, ..TaskResult::default() };
        Record::finished(learner, &manifest.sha256(), result).commit(&layout).unwrap();
        let (measured, memory_mb) = seconds(&[learner]);
        assert!((measured - 2.2 * 104.0 / 5.2).abs() < 1e-9, "{measured}");
        assert_eq!(memory_mb, 800);
    }
}
