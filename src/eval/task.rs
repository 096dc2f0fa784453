//! One task: train a method where it needs training, then evaluate it on the held-out seeds.

use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::control::registry::create;
use crate::control::{ControlError, Controller, EpisodeOutcome, Trainer};
use crate::env::episode::{EpisodeError, EpisodeMetrics, run_episode};
use crate::env::{SignalEnv, World};
use crate::error::{EvalError, FileError, SimError, StoreError};
use crate::family::scenario::Scenario;
use crate::hash::sha256_file;
use crate::network::demand::DemandSpec;
use crate::seed;
use crate::sim::Sim;
use crate::store::manifest::{Manifest, PointRow, Task};
use crate::store::record::{Metrics, Row, RowKind, TaskResult, Wall};

use super::plan::{GENERATED, control_settings, scenario_files};
use super::pool::Progress;

/// Where a task works.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Workplace {
    /// Folder of the generated networks.
    pub networks: PathBuf,
    /// Folder for files of the running episode.
    pub scratch: PathBuf,
}

/// Does one task and returns what it brought forth.
///
/// # Arguments
///
/// * `progress` — called after every episode.
///
/// # Errors
///
/// [`EvalError`] when a file has changed since the plan, the simulation or the method fails.
pub fn execute<S: Sim>(
    sim: S,
    manifest: &Manifest,
    task: &Task,
    workplace: &Workplace,
    progress: &mut dyn FnMut(&Progress),
) -> Result<TaskResult, EvalError> {
    let start = Instant::now();
    let identity = &manifest.identity;
    let scenario: Scenario = serde_json::from_value(identity.settings.clone()).map_err(|e| {
        StoreError::Malformed { path: "manifest.json".into(), reason: format!("settings: {e}") }
    })?;
    let point = identity.points.iter().find(|p| p.point == task.point).ok_or_else(|| {
        let reason = format!("task {} is on {}, which it does not have", task.task, task.point);
        StoreError::Malformed { path: "manifest.json".into(), reason }
    })?;
    let imported = point.environment != GENERATED;
    let world = world(point, &workplace.networks)?;
    let env = SignalEnv::new(
        sim,
        world,
        scenario.signal.clone(),
        scenario.simulation.clone(),
        workplace.scratch.clone(),
    );
    let mut controller = create(&task.method, &control_settings(&scenario, imported), task.seed)?;
    let (task_seed, point) = (task.seed, task.point.clone());
    let mut lab = Lab { env, task_seed, point, rows: Vec::new(), progress };
    controller.train(&mut lab)?;
    for (k, &seed) in identity.evaluation_seeds.iter().enumerate() {
        let metrics = lab.run(controller.as_mut(), seed)?;
        lab.record(RowKind::Evaluation, k as u32, seed, &metrics);
    }
    Ok(TaskResult {
        rows: lab.rows,
        training: Metrics::new(),
        details: controller.details(),
        wall: Wall {
            wall_s: start.elapsed().as_secs_f64(),
            simulator_s: lab.env.simulator_time().as_secs_f64(),
            attempts: 1,
        },
    })
}

/// Returns the world of a point MDP after checking that its files are those of the plan.
fn world(point: &PointRow, networks: &Path) -> Result<World, EvalError> {
    if point.environment != GENERATED {
        let config = PathBuf::from(&point.environment);
        let world = World::from_sumocfg(&config)?;
        for (name, file) in scenario_files(&config)? {
            check(&file, point.sha256.get(&name))?;
        }
        return Ok(world);
    }
    let folder = networks.join(&point.point);
    for (name, sha256) in &point.sha256 {
        check(&folder.join(name), Some(sha256))?;
    }
    let demand = DemandSpec::read(&folder.join(format!("{}.demand.json", point.point)))?;
    let mut world = World::from_sumocfg(&folder.join(format!("{}.sumocfg", point.point)))?;
    world.routes = Some(Box::new(move |seed, path| demand.write_routes(seed, path).map(drop)));
    Ok(world)
}

fn check(path: &Path, sha256: Option<&String>) -> Result<(), EvalError> {
    let altered = |what| Err(EvalError::Altered { path: path.to_path_buf(), what });
    if !path.exists() {
        return altered("was deleted");
    }
    if Some(&sha256_file(path)?) != sha256 {
        return altered("was altered");
    }
    Ok(())
}

/// Runs training episodes and keeps a row of each.
struct Lab<'a, S> {
    env: SignalEnv<S>,
    task_seed: u64,
    point: String,
    rows: Vec<Row>,
    progress: &'a mut dyn FnMut(&Progress),
}

impl<S: Sim> Lab<'_, S> {
    fn run(
        &mut self,
        controller: &mut dyn Controller,
        seed: u64,
    ) -> Result<EpisodeMetrics, EpisodeError> {
        run_episode(&mut self.env, controller, seed::at_point(seed, &self.point))
    }

    fn record(&mut self, kind: RowKind, episode: u32, seed: u64, metrics: &EpisodeMetrics) {
        self.rows.push(Row { kind, episode, seed, metrics: named(metrics) });
        let episodes = self.rows.len() as u32;
        (self.progress)(&Progress { episodes, delay_s: metrics.delay_s() });
    }
}

impl<S: Sim> Trainer for Lab<'_, S> {
    fn episode(
        &mut self,
        controller: &mut dyn Controller,
        seed: u32,
    ) -> Result<EpisodeOutcome, ControlError> {
        let episode = self.rows.len() as u32;
        let seed = seed::training(self.task_seed, seed);
        let metrics = self.run(controller, seed).map_err(|e| ControlError::Episode(Box::new(e)))?;
        self.record(RowKind::Training, episode, seed, &metrics);
        Ok(metrics.outcome())
    }

    fn decisions_per_episode(&self) -> u32 {
        self.env.decisions_per_episode()
    }
}

/// Returns the metrics of an episode by name.
fn named(metrics: &EpisodeMetrics) -> Metrics {
    let trips = &metrics.trips;
    [
        ("delay_s", metrics.delay_s()),
        ("waiting_s", metrics.waiting_s()),
        ("queue_veh", metrics.queue_veh),
        ("max_queue_veh", metrics.max_queue_veh),
        ("vehicles_veh", f64::from(trips.vehicles)),
        ("throughput_veh", f64::from(trips.arrived)),
        ("unfinished_veh", f64::from(trips.running + trips.undeparted)),
        ("undeparted_veh", f64::from(trips.undeparted)),
        ("teleports", f64::from(metrics.counts.teleports)),
        ("collisions", f64::from(metrics.counts.collisions)),
    ]
    .into_iter()
    .map(|(name, value)| (name.to_owned(), value))
    .collect()
}

/// Returns whether an error concerns the machine and not the task: it would make other tasks fail
/// too, so that the run is better stopped than filled with failed records.
pub fn stops_run(error: &EvalError) -> bool {
    matches!(
        error,
        EvalError::Sim(SimError::Io(_))
            | EvalError::Store(_)
            | EvalError::Io(_)
            | EvalError::Altered { .. }
    ) || has_file_error(error)
}

/// Whether a file operation is at the bottom of an error, as when a training episode cannot write
/// its vehicles.
fn has_file_error(error: &(dyn std::error::Error + 'static)) -> bool {
    let mut next = Some(error);
    while let Some(error) = next {
        let episode = matches!(error.downcast_ref(), Some(EpisodeError::Sim(SimError::Io(_))));
        if episode || error.is::<FileError>() {
            return true;
        }
        next = error.source();
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disk_error_in_a_training_episode_stops_the_run() {
        let file = FileError::at("write", Path::new("x"))(std::io::Error::other("full"));
        let episode = EpisodeError::Sim(SimError::Io(file));
        assert!(stops_run(&EvalError::Control(ControlError::Episode(Box::new(episode)))));
        let sumo = EpisodeError::Sim(SimError::NotRunning);
        assert!(!stops_run(&EvalError::Control(ControlError::Episode(Box::new(sumo)))));
    }

    #[test]
    fn networks_are_built_with_the_program_that_environments_look_for() {
        assert_eq!(crate::network::phases::PHASES_PROGRAM, crate::env::derive::PHASES_PROGRAM);
    }
}
