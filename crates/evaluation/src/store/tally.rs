//! How far a run is.

use super::Layout;
use super::builds::Builds;
use super::manifest::Task;
use super::record::Outcome;
use super::results::read_records;
use crate::store::error::StoreError;

/// What there is of a run.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Tally {
    /// By task, whether it has a record; a damaged one is one.
    pub done: Vec<bool>,
    /// Tasks with a record that says that they failed, and why.
    pub failed: Vec<(usize, String)>,
    /// Tasks with a checkpoint and no record.
    pub begun: Vec<usize>,
    /// Which builds made the records.
    pub builds: Builds,
}

impl Tally {
    /// Looks at the records of a results directory. Another machine's newest records may not show yet where a network's
    /// file system remembers folders for some seconds.
    ///
    /// # Errors
    ///
    /// [`StoreError`] when a record cannot be read.
    pub fn of(layout: &Layout, tasks: &[Task], sha256: &str) -> Result<Self, StoreError> {
        let mut done = vec![false; tasks.len()];
        let (mut failed, mut builds) = (Vec::new(), Builds::default());
        let damaged = read_records(layout, tasks, sha256, &|r| r.summary, &mut |task, summary| {
            let Some(summary) = summary else { return };
            done[task] = true;
            builds.add(&summary.wall);
            if summary.outcome == Outcome::Failed {
                failed.push((task, summary.reason.unwrap_or_default()));
            }
        })?;
        damaged.iter().for_each(|record| done[record.task] = true);
        let begun = (0..tasks.len()).filter(|t| !done[*t] && layout.checkpoint(*t).exists());
        let begun = begun.collect();
        Ok(Self { done, failed, begun, builds })
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::store::record::{Record, TaskResult};
    use crate::store::wall::Wall;

    #[test]
    fn records_checkpoints_and_failures_are_counted_and_strangers_are_not() {
        let dir = tempfile::tempdir().unwrap();
        let layout = Layout::new(dir.path());
        let task = |task: usize| Task {
            task,
            method: "m".into(),
            point: "p".into(),
            replicate: 0,
            seed: 1,
        };
        let tasks: Vec<Task> = (0..1002).map(task).collect();
        let tally = |tasks| Tally::of(&layout, tasks, "abc").unwrap();
        assert_eq!(tally(&tasks[..2]).done, [false, false]);
        let wall = |git: &str| Wall { git: git.into(), ..Wall::default() };
        let failed = |t: &Task| Record::failed(t, "abc", "it fell".into(), wall("b"));
        let result = TaskResult { wall: wall("a"), ..TaskResult::default() };
        Record::finished(&tasks[0], "abc", result).commit(&layout).unwrap();
        failed(&tasks[1001]).commit(&layout).unwrap();
        failed(&tasks[3]).commit(&layout).unwrap();
        fs::write(layout.record(4), "damaged").unwrap();
        for (task, text) in [(2, "x"), (0, "x"), (5000, "x")] {
            fs::create_dir_all(layout.checkpoint(task).parent().unwrap()).unwrap();
            fs::write(layout.checkpoint(task), text).unwrap();
        }
        fs::write(dir.path().join("done/000/7.jsonl.part"), "").unwrap();
        let tally = tally(&tasks);
        let missing = tally.done.iter().filter(|done| !**done).count();
        let failed = [3, 1001].map(|task| (task, "it fell".to_owned()));
        assert_eq!((missing, tally.failed, tally.begun), (998, failed.to_vec(), vec![2]));
        assert_eq!(
            tally.builds.several().unwrap(),
            "Several builds made the records: 1 by a, 2 by b."
        );
    }
}
