//! The rows of a task: those of its training, which can go on from a checkpoint, and those of its
//! evaluation.

use std::time::Instant;

use super::checkpoint::Keeper;
use super::domain::{Course, Trial};
use super::fault::{CheckpointError, TrialError};
use super::progress::{News, Progress};
use super::stop::Stop;
use crate::files::FileError;
use crate::machine;
use crate::nn::archive::Archive;
use crate::seed;
use crate::store::manifest::{GIT, Task};
use crate::store::record::{Metrics, Row, RowKind};
use crate::store::wall::Wall;

/// Keeps the rows of a task, and where its training stands.
pub(super) struct TaskCourse<'a> {
    task: &'a Task,
    /// Name of the metric that progress shows.
    objective: &'a str,
    keeper: Keeper,
    stop: Stop,
    news: &'a mut dyn FnMut(News),
    start: Instant,
    attempt: u32,
    /// Time that earlier attempts took up to the checkpoint.
    earlier: Wall,
    resumed: bool,
    pub(super) rows: Vec<Row>,
}

impl<'a> TaskCourse<'a> {
    /// Returns the course of a task's `attempt`-th attempt.
    pub(super) fn new(
        task: &'a Task,
        objective: &'a str,
        attempt: u32,
        keeper: Keeper,
        stop: Stop,
        news: &'a mut dyn FnMut(News),
    ) -> Self {
        let (start, earlier) = (Instant::now(), Wall::default());
        let rows = Vec::new();
        Self { task, objective, keeper, stop, news, start, attempt, earlier, resumed: false, rows }
    }

    /// Removes a checkpoint that the method could not use, so that another attempt starts from the
    /// beginning.
    ///
    /// # Errors
    ///
    /// [`FileError`] when it cannot be removed.
    pub(super) fn forget(&self) -> Result<(), FileError> {
        if self.resumed { self.keeper.remove() } else { Ok(()) }
    }

    /// Evaluates a trial and keeps a row of every episode.
    ///
    /// # Errors
    ///
    /// [`TrialError`] when an episode fails.
    pub(super) fn evaluate(
        &mut self,
        trial: &mut dyn Trial,
        seeds: &[u64],
    ) -> Result<(), TrialError> {
        self.stop.keeps(false);
        let (before, objective) = (self.rows.len(), self.objective);
        let news = &mut *self.news;
        let mut done = 0;
        let rows = held_out(trial, seeds, &mut |row| {
            done += 1;
            progress(before + done, row, objective).into_iter().for_each(&mut *news);
        })?;
        self.rows.extend(rows);
        Ok(())
    }

    /// Returns the time that the task has taken so far.
    pub(super) fn wall(&self, simulator_s: f64) -> Wall {
        Wall {
            wall_s: self.earlier.wall_s + self.start.elapsed().as_secs_f64(),
            simulator_s: self.earlier.simulator_s + simulator_s,
            attempts: self.attempt,
            peak_memory_mb: machine::peak_memory_mb(),
            git: GIT.to_owned(),
            ..Wall::default()
        }
    }
}

impl Course for TaskCourse<'_> {
    fn seed(&self, index: u32) -> u64 {
        seed::training(self.task.seed, index)
    }

    fn episode(&mut self, seed: u64, metrics: Metrics) {
        let episode = self.rows.len() as u32;
        let row = Row { kind: RowKind::Training, episode, seed, metrics };
        progress(self.rows.len() + 1, &row, self.objective).into_iter().for_each(&mut *self.news);
        self.rows.push(row);
    }

    fn saved(&mut self) -> Option<Archive> {
        self.stop.keeps(true);
        match self.keeper.restore() {
            Ok(None) => None,
            Ok(Some((state, kept))) => {
                self.earlier.wall_s = kept.wall_s;
                self.earlier.simulator_s = kept.simulator_s;
                self.rows = kept.rows;
                self.resumed = true;
                let episodes = self.rows.len();
                (self.news)(News::Note(format!("training continues after episode {episodes}")));
                let last = self.rows.last().and_then(|row| progress(episodes, row, self.objective));
                last.into_iter().for_each(&mut *self.news);
                Some(state)
            }
            Err(reason) => {
                (self.news)(News::Note(reason));
                None
            }
        }
    }

    fn checkpoint(
        &mut self,
        state: &dyn Fn() -> Archive,
        simulator_s: f64,
    ) -> Result<(), CheckpointError> {
        let stops = self.stop.is_asked();
        if stops || self.keeper.is_due() {
            let wall = self.wall(simulator_s);
            self.keeper.keep(state(), &self.rows, wall.wall_s, wall.simulator_s)?;
        }
        if stops { Err(CheckpointError::Stopped) } else { Ok(()) }
    }
}

/// Runs one evaluation episode per seed and returns a row of each.
///
/// # Arguments
///
/// * `seeds` — as the episodes get them.
/// * `done` — called with the row of every episode.
///
/// # Errors
///
/// [`TrialError`] when an episode fails.
pub fn held_out(
    trial: &mut dyn Trial,
    seeds: &[u64],
    done: &mut dyn FnMut(&Row),
) -> Result<Vec<Row>, TrialError> {
    let mut rows = Vec::with_capacity(seeds.len());
    for (k, &seed) in seeds.iter().enumerate() {
        let metrics = trial.episode(seed)?;
        let row = Row { kind: RowKind::Evaluation, episode: k as u32, seed, metrics };
        done(&row);
        rows.push(row);
    }
    Ok(rows)
}

/// Returns the news of an episode; a row from a checkpoint might lack its objective.
fn progress(episodes: usize, row: &Row, objective: &str) -> Option<News> {
    let objective = row.metrics.get(objective).copied()?;
    Some(News::Episode(Progress { episodes: episodes as u32, objective }))
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use crate::run::testing::{Counting, planned};
    use crate::store::Layout;

    #[test]
    fn a_row_has_the_seed_that_its_episode_had() {
        let dir = tempfile::tempdir().unwrap();
        let (manifest, tasks) = planned(2);
        let task = tasks.iter().find(|t| t.method == "learner").unwrap();
        let keeper = Keeper::new(&Layout::new(dir.path()), "", task, Duration::MAX);
        let mut news = |_| {};
        let mut course = TaskCourse::new(task, "score", 1, keeper, Stop::default(), &mut news);
        let mut trial = Counting::of(2);
        trial.train(&mut course).unwrap();
        let point = manifest.identity.points.iter().find(|p| p.point == task.point).unwrap();
        let seeds = point.evaluation_seeds(&manifest.identity.evaluation_seeds);
        course.evaluate(&mut trial, &seeds).unwrap();
        let rows: Vec<u64> = course.rows.iter().map(|r| r.seed).collect();
        assert_eq!((rows.len(), &rows), (4, &trial.seeds));
        assert_eq!(rows[2..], seeds);
    }
}
