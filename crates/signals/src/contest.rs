//! A saved model against the baseline, on any point MDP or SUMO scenario.

use std::path::Path;

use super::control::baseline;
use super::controllers::create;
use super::env::World;
use super::environment::environment;
use super::error::TrafficError;
use super::input_files::InputFiles;
use super::model::SignalModel;
use super::settings::Scenario;
use super::sim::Sim;
use super::trial::{DELAY, SignalTrial};
use basics::seed;
use evaluation::run::RunError;
use evaluation::run::plan::evaluation_seeds;
use evaluation::run::task_run::held_out;
use evaluation::store::record::{Metrics, Row, mean_metrics};

/// Where a model is evaluated.
#[derive(Debug)]
pub struct Arena {
    /// Id of the point MDP.
    pub point: String,
    /// Hash of what it is, see [`super::content`].
    pub content: String,
    /// What is simulated.
    pub world: World,
    /// Whether it is somebody's SUMO scenario, whose baseline is another.
    pub imported: bool,
}

impl Arena {
    /// Returns the seeds that so many evaluation episodes of a run have here.
    pub fn evaluation_seeds(&self, base: u64, count: u32) -> Vec<u64> {
        let seeds = evaluation_seeds(base, count);
        seeds.into_iter().map(|seed| seed::at_point(seed, &self.content)).collect()
    }
}

/// What came of a method.
#[derive(Debug, Clone, PartialEq)]
pub struct Standing {
    /// Name of the method.
    pub method: String,
    /// Means over the episodes.
    pub metrics: Metrics,
    /// Mean delay divided by the baseline's; `None` when the baseline's is 0, and without seeds.
    pub score: Option<f64>,
}

/// Evaluates a model and the baseline on the same seeds; returns the baseline first.
///
/// # Arguments
///
/// * `scenario` — with the model's settings, see [`SignalModel::scenario`].
/// * `seeds` — of the evaluation episodes, as vehicles and simulator get them.
/// * `scratch` — a folder for the files of the running episode.
/// * `done` — called with the row of every episode.
///
/// # Errors
///
/// [`RunError::Model`] when the model does not fit the signals, and whatever makes an episode fail.
pub fn contest<S: Sim>(
    sim: S,
    model: &SignalModel,
    scenario: &Scenario,
    arena: Arena,
    seeds: &[u64],
    scratch: &Path,
    done: &mut dyn FnMut(&Row),
) -> Result<[Standing; 2], TrafficError> {
    let card = &model.saved.card;
    let untuned = create(baseline::METHOD.name, scenario, arena.imported, card.seed)?;
    let controller = model.controller(scenario, arena.imported)?;
    let env = environment(sim, arena.world, scenario, scratch);
    let mut trial = SignalTrial::new(env, controller, InputFiles::default());
    // The model first: if it does not fit, nobody waits for the baseline.
    let rows = held_out(&mut trial, seeds, done).map_err(|e| model.explain(e, &arena.point))?;
    trial.controller = untuned;
    let yardstick = held_out(&mut trial, seeds, done).map_err(RunError::from)?;
    let delay = |metrics: &Metrics| metrics.get(DELAY).copied();
    let yardstick = mean_metrics(&yardstick);
    let denominator = delay(&yardstick).filter(|d| *d > 0.0);
    let standing = |method: &str, metrics: Metrics| Standing {
        method: method.to_owned(),
        score: delay(&metrics).zip(denominator).map(|(delay, baseline)| delay / baseline),
        metrics,
    };
    Ok([standing(baseline::METHOD.name, yardstick), standing(&card.method, mean_metrics(&rows))])
}
