//! What `run --dry-run` says: the planned tasks and about how long they take.

use std::fmt::Write;
use std::time::Duration;

use super::output::duration;
use crate::control::fixed_time::FixedTime;
use crate::eval::plan::{Draft, Request};
use crate::units::SECONDS_PER_HOUR;

/// Processor time that SUMO takes per vehicle of an isolated intersection, seconds; measured on
/// the Salt Lake City family, see `benches/README.md`.
const SECONDS_PER_VEHICLE: f64 = 4e-4;

/// Processor time of an episode without vehicles, seconds.
const SECONDS_PER_EPISODE: f64 = 0.05;

/// Approaches of a six-feature point MDP.
const APPROACHES: f64 = 4.0;

/// Returns how many episodes a task of a method runs at most.
pub(super) fn episodes(request: &Request, method: &str) -> u32 {
    let training = if method == FixedTime::NAME {
        request.scenario.scenario.fixed_time.simulations
    } else {
        0
    };
    training + request.evaluation_seeds
}

/// Returns the plan in words.
pub(super) fn estimate(request: &Request, draft: &Draft, jobs: usize) -> String {
    let sample = &draft.sample;
    let mut text = format!(
        "{} of {} point MDPs ({}, seed {}), {} methods, {} tasks",
        sample.draws.len(),
        sample.family_size,
        serde_json::to_value(sample.sampling).expect("a name is plain data").as_str().unwrap_or(""),
        sample.seed,
        draft.methods.len(),
        sample.draws.len() * draft.methods.len(),
    );
    let per_point: u32 = draft.methods.iter().map(|m| episodes(request, m)).sum();
    let inflow = draft.family.features.iter().position(|f| f.name == "inflow_vph");
    let hours = request.scenario.scenario.demand.horizon_s / SECONDS_PER_HOUR;
    let mut seconds = 0.0;
    for draw in &sample.draws {
        let vehicles = draft
            .family
            .position(&draw.point)
            .zip(inflow)
            .map_or(0.0, |(p, f)| draft.family.points[p].features[f] * APPROACHES * hours);
        seconds += f64::from(per_point) * (SECONDS_PER_EPISODE + vehicles * SECONDS_PER_VEHICLE);
        write!(text, "\n{:40} weight {:.4}", draw.point, draw.weight)
            .expect("writing to a string cannot fail");
    }
    let episodes = sample.draws.len() as u64 * u64::from(per_point);
    write!(text, "\n{episodes} episodes at most").expect("writing to a string cannot fail");
    if inflow.is_some() {
        let time = duration(Duration::from_secs_f64(seconds / jobs as f64));
        write!(text, ", roughly {time} with {jobs} workers")
            .expect("writing to a string cannot fail");
    }
    text
}
