//! How far a training has come, kept on disk so that a killed one goes on from there.
//!
//! A checkpoint has the tensors of the learner's own archive; its card lies on the file's card beside
//! what the task has to add, so that the learner gets back exactly what it gave. It is used only by the build, manifest
//! and task that it was written by: anything else could end in a record that cannot be repeated.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::stats::Direction;
use crate::store::figures::ABOVE_BASELINE;
use crate::store::manifest::{GIT, Task};
use crate::store::record::{Metrics, Row};
use crate::store::{Layout, remove_checkpoint};
use basics::files::FileError;
use basics::files::replace;
use learners::nn::archive::{Archive, ArchiveError};

/// Version of checkpoints and models; a change of their form raises it.
pub const FORMAT_VERSION: u32 = 3;

/// Wall time between two checkpoints, seconds: little is lost, and writing costs nothing beside it.
pub const CHECKPOINT_EVERY_S: u64 = 60;

/// Share of the objective that validation adds for every point MDP where it is worse than the baseline's.
const ABOVE_COSTS: f64 = 0.01;

/// Where the card says what a file is.
pub(super) const KIND: &str = "kind";

/// [`KIND`] of a checkpoint.
pub(super) const CHECKPOINT: &str = "checkpoint";

/// Where the card keeps the learner's own card.
pub(super) const LEARNER: &str = "learner";

/// Where the card keeps what the task adds to a checkpoint.
const TASK: &str = "task";

/// What the names of the tensors of the `i`-th candidate begin with.
fn candidate_prefix(i: usize) -> String {
    format!("candidate{i}.")
}

/// Which training a checkpoint belongs to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Stamp {
    format_version: u32,
    tsc_family: String,
    git: String,
    manifest: String,
    task: usize,
}

/// A policy that may be evaluated in place of the last one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Candidate {
    /// Rows of training after which it was taken.
    pub(super) row: u32,
    /// Its mean objective in validation.
    pub(super) objective: f64,
    /// The policy; it lies beside the card.
    #[serde(skip)]
    pub(super) model: Archive,
}

/// What validation has found so far, and how often training has started again.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub(super) struct Validated {
    /// Episodes of validation; when training is over, those of evaluation follow.
    pub(super) rows: Vec<Row>,
    /// The best policies so far, in the order in which they were met.
    pub(super) candidates: Vec<Candidate>,
    /// Times that training has started again.
    pub(super) restarts: u32,
    /// Episodes of the attempts that were given up.
    pub(super) discarded: u32,
    /// Whether the network is dead and training goes on all the same.
    pub(super) is_dead: bool,
    /// The row whose policy is evaluated; `None` for the last one.
    #[serde(skip)]
    pub(super) chosen: Option<u32>,
}

/// Returns what an episode of validation says of a policy: the objective, and 1% of it for each of several point MDPs where it
/// is worse than the baseline's.
pub(super) fn judged(metrics: &Metrics, objective: &str) -> Option<f64> {
    let above = metrics.get(ABOVE_BASELINE).unwrap_or(&0.0);
    metrics.get(objective).map(|value| value + ABOVE_COSTS * above * value.abs())
}

impl Validated {
    /// Returns how many validations there have been since the best one, the first of several.
    pub(super) fn since_best(&self, objective: &str, direction: Direction) -> usize {
        let of_row = |rows: &[Row]| self.of(rows[0].episode, objective);
        let means: Vec<f64> =
            self.rows.chunk_by(|a, b| a.episode == b.episode).filter_map(of_row).collect();
        let best = direction.best(means.iter().copied());
        means.iter().skip_while(|mean| Some(**mean) != best).count().saturating_sub(1)
    }

    /// Returns the mean objective of the validation after a row.
    pub(super) fn of(&self, row: u32, objective: &str) -> Option<f64> {
        let values = self.rows.iter().filter(|r| r.episode == row);
        let values: Vec<f64> = values.filter_map(|r| judged(&r.metrics, objective)).collect();
        (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
    }

    /// Takes in a policy, and lets the worst go where there are more than `most`; of equal ones the latest.
    pub(super) fn keep(&mut self, candidate: Candidate, most: u32, direction: Direction) {
        self.candidates.push(candidate);
        if self.candidates.len() > most as usize {
            let objective = |i: &usize| self.candidates[*i].objective;
            // Of equal ones `max_by` gives the last.
            let worst = (0..self.candidates.len())
                .max_by(|a, b| direction.compare(objective(a), objective(b)));
            self.candidates.remove(worst.expect("one was added"));
        }
    }
}

/// What a checkpoint holds beside the learner's state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Kept {
    #[serde(flatten)]
    stamp: Stamp,
    /// Training episodes so far.
    pub(super) rows: Vec<Row>,
    /// What validation has found so far.
    pub(super) validated: Validated,
    /// Wall-clock time of the task so far, seconds.
    pub(super) wall_s: f64,
    /// Wall-clock time within the simulator so far, seconds.
    pub(super) simulator_s: f64,
}

/// Returns the checkpoint of a task as that of its place in a larger run; `None` where the run has none that could be used.
pub(super) fn moved(layout: &Layout, from: (&str, usize), to: (&str, usize)) -> Option<Vec<u8>> {
    let path = layout.checkpoint(from.1);
    if !path.exists() {
        return None;
    }
    let mut archive = Archive::read(&path).ok()?;
    let mut kept: Kept = archive.get(TASK).ok()?;
    if (kept.stamp.manifest.as_str(), kept.stamp.task) != from {
        return None;
    }
    (kept.stamp.manifest, kept.stamp.task) = (to.0.to_owned(), to.1);
    archive.put(TASK, kept);
    Some(archive.to_bytes())
}

/// Keeps the checkpoint of one task.
#[derive(Debug)]
pub(super) struct Keeper {
    layout: Layout,
    stamp: Stamp,
    every: Duration,
    last: Instant,
}

impl Keeper {
    /// Returns the keeper of a task's checkpoint, which it writes at most once per `every`.
    pub(super) fn new(layout: &Layout, manifest: &str, task: &Task, every: Duration) -> Self {
        let stamp = Stamp {
            format_version: FORMAT_VERSION,
            tsc_family: env!("CARGO_PKG_VERSION").to_owned(),
            git: GIT.to_owned(),
            manifest: manifest.to_owned(),
            task: task.task,
        };
        Self { layout: layout.clone(), stamp, every, last: Instant::now() }
    }

    fn path(&self) -> PathBuf {
        self.layout.checkpoint(self.stamp.task)
    }

    /// Whether it is time for another checkpoint.
    pub(super) fn is_due(&self) -> bool {
        self.last.elapsed() >= self.every
    }

    /// Writes a checkpoint over the last one.
    pub(super) fn keep(
        &mut self,
        mut state: Archive,
        rows: &[Row],
        validated: &Validated,
        wall_s: f64,
        simulator_s: f64,
    ) -> Result<(), FileError> {
        let card = std::mem::take(&mut state.card);
        state.put(LEARNER, card);
        state.put(KIND, CHECKPOINT);
        let stamp = self.stamp.clone();
        for (i, candidate) in validated.candidates.iter().enumerate() {
            state.nest(&candidate_prefix(i), &candidate.model);
        }
        let (rows, validated) = (rows.to_vec(), validated.clone());
        state.put(TASK, Kept { stamp, rows, validated, wall_s, simulator_s });
        let root = self.layout.root();
        replace(root, &self.path(), &self.layout.tmp(), &state.to_bytes())?;
        self.last = Instant::now();
        Ok(())
    }

    /// Returns the learner's state and the task's part of the checkpoint; `None` without one.
    pub(super) fn restore(&self) -> Result<Option<(Archive, Kept)>, String> {
        let path = self.path();
        if !path.exists() {
            return Ok(None);
        }
        let unusable = |reason: String| {
            format!("{} is not used: {reason}; training starts from the beginning", path.display())
        };
        let mut archive = Archive::read(&path).map_err(|e| match e {
            ArchiveError::Foreign { reason, .. } => unusable(reason),
            other => unusable(other.to_string()),
        })?;
        let mut kept: Kept = (archive.get::<String>(KIND).ok())
            .filter(|kind| kind == CHECKPOINT)
            .and_then(|_| archive.get(TASK).ok())
            .ok_or_else(|| unusable("it is not a checkpoint of this version".into()))?;
        if kept.stamp != self.stamp {
            return Err(unusable("another build, manifest or task wrote it".to_owned()));
        }
        for (i, candidate) in kept.validated.candidates.iter_mut().enumerate() {
            let model = archive.take_nested(&candidate_prefix(i));
            candidate.model = model.map_err(|e| unusable(e.to_string()))?;
        }
        archive.card = archive.get(LEARNER).map_err(|e| unusable(e.to_string()))?;
        Ok(Some((archive, kept)))
    }

    /// Removes the checkpoint, if there is one.
    pub(super) fn remove(&self) -> Result<(), FileError> {
        remove_checkpoint(&self.layout, self.stamp.task)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::record::{Metrics, RowKind};
    use std::fs;

    fn task(task: usize) -> Task {
        Task { task, method: "m".into(), point: "p".into(), replicate: 0, seed: 1 }
    }

    fn keeper(layout: &Layout, manifest: &str, number: usize) -> Keeper {
        Keeper::new(layout, manifest, &task(number), Duration::ZERO)
    }

    fn state() -> Archive {
        let mut state = Archive::default();
        state.put("episodes", 1);
        state.put_f32("w", &[2], &[0.1, f32::NAN]);
        state
    }

    fn candidate(row: u32, objective: f64) -> Candidate {
        Candidate { row, objective, model: state() }
    }

    fn validated() -> Validated {
        let candidates = vec![candidate(5, 3.0), candidate(10, 2.0)];
        Validated { candidates, restarts: 2, discarded: 7, ..Validated::default() }
    }

    #[test]
    fn the_worst_policy_goes_when_there_are_too_many_and_of_equal_ones_the_latest() {
        let rows = |direction: Direction| {
            let mut validated = Validated::default();
            for (row, objective) in [(1, 3.0), (2, 1.0), (3, 2.0), (4, 3.0), (5, 1.0)] {
                validated.keep(candidate(row, objective), 2, direction);
            }
            let rows: Vec<u32> = validated.candidates.iter().map(|c| c.row).collect();
            (rows, direction.best(validated.candidates.iter().map(|c| c.objective)).unwrap())
        };
        assert_eq!(rows(Direction::Lower), (vec![2, 5], 1.0));
        assert_eq!(rows(Direction::Higher), (vec![1, 4], 3.0));
    }

    fn row() -> Row {
        let metrics = Metrics::from([("delay_s".to_owned(), 0.1 + 0.2)]);
        Row { kind: RowKind::Training, episode: 0, seed: (1 << 53) - 1, metrics }
    }

    /// A results directory with a checkpoint of task 3 of the manifest `abc`.
    fn kept() -> (tempfile::TempDir, Layout) {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        keeper(&layout, "abc", 3).keep(state(), &[row()], &validated(), 2.0, 1.0).unwrap();
        (dir, layout)
    }

    fn refusal(keeper: &Keeper) -> String {
        let reason = keeper.restore().unwrap_err();
        assert!(reason.contains("3.safetensors is not used: "), "{reason}");
        assert!(reason.ends_with("; training starts from the beginning"), "{reason}");
        reason
    }

    #[test]
    fn a_checkpoint_gives_back_exactly_what_was_kept() {
        let (_dir, layout) = kept();
        let (archive, kept) = keeper(&layout, "abc", 3).restore().unwrap().unwrap();
        assert_eq!(archive.to_bytes(), state().to_bytes());
        assert_eq!((kept.rows, kept.wall_s, kept.simulator_s), (vec![row()], 2.0, 1.0));
        assert_eq!(kept.validated.candidates[1].model.to_bytes(), state().to_bytes());
        let without_models = |mut validated: Validated| {
            validated.candidates.iter_mut().for_each(|c| c.model = Archive::default());
            validated
        };
        assert_eq!(without_models(kept.validated), without_models(validated()));
        assert_eq!(fs::read_dir(layout.tmp()).unwrap().count(), 0);
    }

    #[test]
    fn a_checkpoint_of_another_build_manifest_or_task_is_not_used() {
        let (_dir, layout) = kept();
        let other = "another build, manifest or task wrote it";
        assert!(refusal(&keeper(&layout, "xyz", 3)).contains(other));
        let mut build = keeper(&layout, "abc", 3);
        build.stamp.git = "0000000".into();
        assert!(refusal(&build).contains(other));
        fs::rename(layout.checkpoint(3), layout.checkpoint(4)).unwrap();
        let reason = keeper(&layout, "abc", 4).restore().unwrap_err();
        assert!(reason.contains(other), "{reason}");
    }

    #[test]
    fn a_checkpoint_goes_along_into_a_larger_run_unless_it_is_of_another() {
        let (_dir, layout) = kept();
        assert_eq!(moved(&layout, ("xyz", 3), ("new", 8)), None);
        assert_eq!(moved(&layout, ("abc", 4), ("new", 8)), None);
        let bytes = moved(&layout, ("abc", 3), ("new", 8)).unwrap();
        fs::write(layout.checkpoint(8), bytes).unwrap();
        let (archive, kept) = keeper(&layout, "new", 8).restore().unwrap().unwrap();
        assert_eq!((archive.to_bytes(), kept.rows), (state().to_bytes(), vec![row()]));
        assert_eq!(kept.validated.candidates[1].model.to_bytes(), state().to_bytes());
    }

    #[test]
    fn a_file_that_is_no_checkpoint_is_not_used() {
        let (_dir, layout) = kept();
        let path = layout.checkpoint(3);
        fs::write(&path, "hello").unwrap();
        refusal(&keeper(&layout, "abc", 3));
        state().write(&path).unwrap();
        assert!(refusal(&keeper(&layout, "abc", 3)).contains("it is not a checkpoint"));
    }
}
