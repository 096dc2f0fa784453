//! How much work a run is, in words.

use std::fmt::Write;
use std::time::Duration;

use super::output::duration;
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
    let (mut all_s, mut longest_s, mut is_informed) = (0.0, 0.0_f64, false);
    let efforts = Efforts::of_request(request)?;
    for draw in &sample.draws {
        for method in &draft.methods {
            let effort = efforts.task(method, &draw.point)?;
            episodes += replicates(method) * u64::from(effort.episodes());
            all_s += replicates(method) as f64 * effort.whole_seconds();
            longest_s = longest_s.max(effort.whole_seconds());
            is_informed |= effort.is_informed;
        }
        write!(text, "\n{:40} weight {:.4}", draw.point, draw.weight)
            .expect("writing to a string cannot fail");
    }
    write!(text, "\n{episodes} episodes at most").expect("writing to a string cannot fail");
    if is_informed {
        let time_s = (all_s / jobs.min(processors).max(1) as f64).max(longest_s);
        let time = duration(Duration::from_secs_f64(time_s));
        write!(text, ", about {time} with {}", format::count(jobs, "worker"))
            .expect("writing to a string cannot fail");
    }
    Ok(text)
}
