//! Where a controller is trained and evaluated: an environment, and a row of every episode.

use std::time::Instant;

use crate::files::FileError;
use crate::nn::archive::Archive;
use crate::run::error::EvalError;
use crate::seed;
use crate::store::manifest::Task;
use crate::store::opaque::Opaque;
use crate::store::record::{Metrics, Row, RowKind, Wall, mean_metrics};
use crate::traffic::control::{ControlError, Controller, EpisodeOutcome, Trainer};
use crate::traffic::env::SignalEnv;
use crate::traffic::env::episode::{EpisodeError, EpisodeMetrics, run_episode};
use crate::traffic::env::signal_env::Running;
use crate::traffic::program::{ProgramKind, ProgramPhase, SignalProgram};
use crate::traffic::sim::error::SimError;
use crate::traffic::sim::{self, Sim};

use super::checkpoint::Keeper;
use super::pool::Progress;

/// What is heard of a task while it goes on.
#[derive(Debug, Clone, PartialEq)]
pub enum News {
    /// An episode is over.
    Episode(Progress),
    /// Something that people should know.
    Note(String),
}

/// Runs a task's episodes and keeps a row of each.
pub(super) struct Lab<'a, S> {
    env: SignalEnv<S>,
    task: &'a Task,
    keeper: Keeper,
    news: &'a mut dyn FnMut(News),
    start: Instant,
    attempt: u32,
    /// Time that earlier attempts took up to the checkpoint.
    earlier: Wall,
    resumed: bool,
    pub(super) rows: Vec<Row>,
}

impl<'a, S: Sim> Lab<'a, S> {
    pub(super) fn new(
        env: SignalEnv<S>,
        task: &'a Task,
        attempt: u32,
        keeper: Keeper,
        news: &'a mut dyn FnMut(News),
    ) -> Self {
        let (start, earlier) = (Instant::now(), Wall::default());
        Self { env, task, keeper, news, start, attempt, earlier, resumed: false, rows: Vec::new() }
    }

    /// Removes a checkpoint that the learner could not use, so that another attempt starts from the
    /// beginning.
    ///
    /// # Errors
    ///
    /// [`FileError`] when it cannot be removed.
    pub(super) fn forget(&self) -> Result<(), FileError> {
        if self.resumed { self.keeper.remove() } else { Ok(()) }
    }

    /// Evaluates a controller.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when the simulation or the controller fails.
    pub(super) fn evaluate(
        &mut self,
        controller: &mut dyn Controller,
        seeds: &[u64],
    ) -> Result<(), EvalError> {
        let before = self.rows.len();
        let news = &mut *self.news;
        let mut done = 0;
        let rows = held_out(&mut self.env, controller, seeds, &mut |row| {
            done += 1;
            progress(before + done, row).into_iter().for_each(&mut *news);
        })?;
        self.rows.extend(rows);
        Ok(())
    }

    /// Returns the mean delay of another controller on these seeds, seconds, of which no row is kept;
    /// `None` without seeds.
    ///
    /// # Errors
    ///
    /// [`EvalError`] when the simulation or the controller fails.
    pub(super) fn delay_of(
        &mut self,
        controller: &mut dyn Controller,
        seeds: &[u64],
    ) -> Result<Option<f64>, EvalError> {
        let rows = held_out(&mut self.env, controller, seeds, &mut |_| {})?;
        Ok(mean_metrics(&rows).get("delay_s").copied())
    }

    /// Returns the programs that the signals ran in the last episode; none where a controller decides.
    pub(super) fn programs(&self) -> Opaque {
        let programs: Vec<SignalProgram> =
            self.env.programs().unwrap_or_default().into_iter().map(kept).collect();
        if programs.is_empty() { Opaque::default() } else { Opaque::of(&programs) }
    }

    /// Returns the time that the task has taken so far.
    pub(super) fn wall(&self) -> Wall {
        Wall {
            wall_s: self.earlier.wall_s + self.start.elapsed().as_secs_f64(),
            simulator_s: self.earlier.simulator_s + self.env.simulator_time().as_secs_f64(),
            attempts: self.attempt,
        }
    }
}

impl<S: Sim> Trainer for Lab<'_, S> {
    fn episode(
        &mut self,
        controller: &mut dyn Controller,
        seed: u32,
    ) -> Result<EpisodeOutcome, ControlError> {
        let episode = self.rows.len() as u32;
        let seed = seed::training(self.task.seed, seed);
        let metrics = run_episode(&mut self.env, controller, seed).map_err(|e| match e {
            EpisodeError::Control(e) => e,
            sim @ EpisodeError::Sim(_) => ControlError::Episode(Box::new(sim)),
        })?;
        let failed = |e: SimError| ControlError::Episode(Box::new(EpisodeError::Sim(e)));
        let outcome = metrics.outcome().ok_or_else(|| failed(SimError::NoVehicles(seed)))?;
        let metrics = named(&metrics, seed).map_err(failed)?;
        let mut row = Row { kind: RowKind::Training, episode, seed, metrics };
        // JSON has no infinities; a figure that is no number is left out.
        for (name, value) in controller.figures().into_iter().filter(|(_, v)| v.is_finite()) {
            row.metrics.entry(name).or_insert(value);
        }
        progress(self.rows.len() + 1, &row).into_iter().for_each(&mut *self.news);
        self.rows.push(row);
        Ok(outcome)
    }

    fn decisions_per_episode(&self) -> u32 {
        self.env.decisions_per_episode()
    }

    fn saved(&mut self) -> Option<Archive> {
        match self.keeper.restore() {
            Ok(None) => None,
            Ok(Some((state, kept))) => {
                self.earlier.wall_s = kept.wall_s;
                self.earlier.simulator_s = kept.simulator_s;
                self.rows = kept.rows;
                self.resumed = true;
                let episodes = self.rows.len();
                (self.news)(News::Note(format!("training goes on after episode {episodes}")));
                let last = self.rows.last().and_then(|row| progress(episodes, row));
                last.into_iter().for_each(&mut *self.news);
                Some(state)
            }
            Err(reason) => {
                (self.news)(News::Note(reason));
                None
            }
        }
    }

    fn checkpoint(&mut self, state: &dyn Fn() -> Archive) -> Result<(), ControlError> {
        if self.keeper.is_due() {
            let wall = self.wall();
            self.keeper.keep(state(), &self.rows, wall.wall_s, wall.simulator_s)?;
        }
        Ok(())
    }
}

/// Runs one evaluation episode per seed and returns a row of each.
///
/// # Arguments
///
/// * `seeds` — as vehicles and simulator get them.
/// * `done` — called with the row of every episode.
///
/// # Errors
///
/// [`EvalError`] when the simulation or the controller fails.
pub fn held_out<S: Sim>(
    env: &mut SignalEnv<S>,
    controller: &mut dyn Controller,
    seeds: &[u64],
    done: &mut dyn FnMut(&Row),
) -> Result<Vec<Row>, EvalError> {
    let mut rows = Vec::with_capacity(seeds.len());
    for (k, &seed) in seeds.iter().enumerate() {
        let metrics = run_episode(env, controller, seed)?;
        let metrics = named(&metrics, seed)?;
        let row = Row { kind: RowKind::Evaluation, episode: k as u32, seed, metrics };
        done(&row);
        rows.push(row);
    }
    Ok(rows)
}

/// Returns the news of an episode; a row from a checkpoint might lack its delay.
fn progress(episodes: usize, row: &Row) -> Option<News> {
    let delay_s = row.metrics.get("delay_s").copied()?;
    Some(News::Episode(Progress { episodes: episodes as u32, delay_s }))
}

/// Returns the metrics of the episode of a seed by name.
///
/// # Errors
///
/// [`SimError::NoVehicles`]: without vehicles there is nothing to judge, and a delay of 0 would be the
/// best one.
fn named(metrics: &EpisodeMetrics, seed: u64) -> Result<Metrics, SimError> {
    let trips = &metrics.trips;
    let (Some(delay_s), Some(waiting_s)) = (metrics.delay_s(), metrics.waiting_s()) else {
        return Err(SimError::NoVehicles(seed));
    };
    let named = [
        ("delay_s", delay_s),
        ("waiting_s", waiting_s),
        ("queue_veh", metrics.queue_veh),
        ("max_queue_veh", metrics.max_queue_veh),
        ("vehicles_veh", f64::from(trips.vehicles)),
        ("throughput_veh", f64::from(trips.arrived)),
        ("unfinished_veh", f64::from(trips.running + trips.undeparted)),
        ("undeparted_veh", f64::from(trips.undeparted)),
        ("teleports", f64::from(metrics.counts.teleports)),
        ("collisions", f64::from(metrics.counts.collisions)),
    ];
    Ok(named.into_iter().map(|(name, value)| (name.to_owned(), value)).collect())
}

/// Returns a program as records keep it.
fn kept(running: Running) -> SignalProgram {
    let kind = match running.program.kind {
        sim::ProgramKind::Static => ProgramKind::Static,
        sim::ProgramKind::Actuated => ProgramKind::Actuated,
        sim::ProgramKind::Other => ProgramKind::Other,
    };
    let phase = |p: sim::ProgramPhase| {
        let varies =
            kind != ProgramKind::Static && (p.min_s, p.max_s) != (p.duration_s, p.duration_s);
        // JSON has no infinities.
        let bound = |s: f64| Some(s).filter(|s| varies && s.is_finite());
        let (min_s, max_s) = (bound(p.min_s), bound(p.max_s));
        ProgramPhase { state: p.state, duration_s: p.duration_s, min_s, max_s }
    };
    let phases = running.program.phases.into_iter().map(phase).collect();
    SignalProgram { signal: running.signal, own: running.own, kind, phases }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::rc::Rc;
    use std::time::Duration;

    use super::*;
    use crate::run::plan::tests::planned;
    use crate::run::testing::Learner;
    use crate::store::Layout;
    use crate::traffic::env::testing::{env, env_of, minute};

    #[test]
    fn an_episode_without_vehicles_is_an_error_and_no_delay_of_0() {
        let dir = tempfile::tempdir().unwrap();
        let mut env = env(vec![], dir.path());
        let e = held_out(&mut env, &mut Learner::of(0), &[7], &mut |_| {}).unwrap_err();
        assert!(e.to_string().starts_with("no vehicle is to depart in the episode of seed 7, so"));
    }

    #[test]
    fn a_row_has_the_seed_that_its_vehicles_had() {
        let dir = tempfile::tempdir().unwrap();
        let got = Rc::new(RefCell::new(Vec::new()));
        let writer = Rc::clone(&got);
        let routes = Box::new(move |seed, _: &std::path::Path| {
            writer.borrow_mut().push(seed);
            Ok(())
        });
        let (manifest, tasks) = planned(&["fixed-time"]);
        let point = &manifest.identity.points[0];
        let layout = Layout::new(dir.path());
        let keeper = Keeper::new(&layout, "", &tasks[1], Duration::MAX);
        let (env, mut news) = (env_of(minute(Some(routes)), vec![(1.0, 0)], dir.path()), |_| {});
        let mut lab = Lab::new(env, &tasks[1], 1, keeper, &mut news);
        let mut learner = Learner::of(2);
        learner.train(&mut lab).unwrap();
        let seeds = point.evaluation_seeds(&manifest.identity.evaluation_seeds);
        lab.evaluate(&mut learner, &seeds).unwrap();
        let rows: Vec<u64> = lab.rows.iter().map(|r| r.seed).collect();
        assert_eq!((rows.len(), &rows), (4, &*got.borrow()));
        assert_eq!(rows[2..], seeds);
    }
}
