//! How much work a run is, in words.

use std::fmt::Write;

use super::forecast::{Forecast, Job, range};
use crate::report::format;
use crate::run::effort::Efforts;
use crate::run::error::RunError;
use crate::run::plan::{Draft, Request};

/// Returns the plan in words, for so many workers on so many processors.
pub(super) fn estimate(
    request: &Request<'_>,
    draft: &Draft,
    jobs: usize,
    processors: usize,
) -> Result<String, RunError> {
    let sample = &draft.sample;
    let replicates = |method: &String| match draft.replicated.contains(method) {
        true => u64::from(request.replicates),
        false => 1,
    };
    let per_point: u64 = draft.methods.iter().map(replicates).sum();
    let tasks = sample.draws.len() as u64 * per_point;
    let mut text = format!(
        "{} of {} ({}, seed {}), {}, {}",
        sample.draws.len(),
        format::count(sample.family_size, "point MDP"),
        sample.sampling.name(),
        sample.seed,
        format::count(draft.methods.len(), "method"),
        format::count(tasks as usize, "task"),
    );
    let mut episodes = 0;
    let mut all = Vec::with_capacity(tasks as usize);
    let efforts = Efforts::of_request(request)?;
    for draw in &sample.draws {
        for method in &draft.methods {
            let effort = efforts.task(method, &draw.point)?;
            episodes += replicates(method) * u64::from(effort.episodes());
            for _ in 0..replicates(method) {
                let (task, method, point) = (all.len(), method.clone(), draw.point.clone());
                all.push(Job { task, method, point, effort });
            }
        }
        write!(text, "\n{:40} weight {:.4}", draw.point, draw.weight)
            .expect("writing to a string cannot fail");
    }
    write!(text, "\n{episodes} episodes at most").expect("writing to a string cannot fail");
    if all.iter().any(|job| job.effort.is_informed) {
        let time = range(Forecast::new(all, jobs, processors).left(0.0));
        write!(text, ", about {time} with {}", format::count(jobs, "worker"))
            .expect("writing to a string cannot fail");
    }
    Ok(text)
}
