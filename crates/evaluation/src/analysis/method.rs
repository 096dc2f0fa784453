//! One method over all its point MDPs, and the ranking. What a method lacks may be what is hard, so it is not ranked against
//! methods that have it.
//!
//! A point MDP enters a method's estimate when both the method and what scores are divided by have a
//! record of it and the objective of the latter is above 0. Weights are renormalised over these point MDPs, and
//! every summary counts what it lacks.

use std::collections::{BTreeMap, BTreeSet};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use super::choice::{choice, look_of, weights};
use super::estimator::{Chosen, Estimate, Estimator, Sample, estimator_of};
use super::points::{EpisodeSummary, Evidence, PointResult, PointSummary, TaskScore};
use super::summaries::{Summaries, summarise};
use crate::stats::PointObjectives;
use crate::stats::bootstrap::RESAMPLES;
use crate::stats::score::weighted_mean;
use crate::store::record::{Metrics, Outcome};
use basics::seed::derive;

/// One method over all its point MDPs.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodSummary {
    /// Name of the method.
    pub method: String,
    /// Position in the manifest's list of methods.
    pub index: usize,
    /// Whether it is what scores are divided by.
    pub is_reference: bool,
    /// Place by overall performance, from 1.
    pub rank: Option<usize>,
    /// Overall performance; 1 is what scores are divided by.
    pub overall: Option<f64>,
    /// Interval of the overall performance.
    pub interval: Option<(f64, f64)>,
    /// Other summaries of its scores and objectives.
    pub summaries: Summaries,
    /// Its evaluation episodes on the point MDPs in the estimate.
    pub episodes: EpisodeSummary,
    /// Importance-weighted mean of the objective.
    pub objective: Option<f64>,
    /// Importance-weighted means of the other metrics.
    pub metrics: Metrics,
    /// The point MDP with the worst score, and that score.
    pub worst: Option<(String, f64)>,
    /// Point MDPs in the estimate.
    pub points: usize,
    /// Tasks on these point MDPs that failed or have no record: replicates without which the score is a mean over the others.
    pub left_out: usize,
    /// Tasks on these point MDPs.
    pub replicates: usize,
    /// Tasks that failed.
    pub failed: usize,
    /// Tasks without a record.
    pub missing: usize,
    /// Point MDPs that the method finished but the reference did not, or where the reference's
    /// objective is 0.
    pub without_reference: usize,
    /// Point MDPs on which tuning improved on nothing in any replicate, and all that were tuned; `None` for a method that does
    /// not tune itself.
    pub tuning: Option<(usize, usize)>,
}

/// A method with its estimate, from which differences are taken.
pub(super) type Summarised = (MethodSummary, Option<Estimate>);

/// Summarises a method over the point MDPs that count.
fn summarise_method(evidence: Evidence<'_>, index: usize) -> Summarised {
    let Evidence { identity, reference, points, tasks, .. } = evidence;
    let method = identity.methods[index].clone();
    let finished: Vec<(&PointSummary, &PointResult)> =
        points.iter().filter_map(|p| Some((p, p.results[index].as_ref()?))).collect();
    let scored: Vec<_> = finished.iter().filter(|(_, r)| r.score.is_some()).copied().collect();
    let counted: Vec<&PointSummary> = scored.iter().map(|(p, _)| *p).collect();
    let weights = weights(identity, &counted);
    let (estimate, summaries) = estimate(evidence, index, &scored, &weights);
    let weighted = || weights.iter().copied().zip(&scored);
    let objective = weighted_mean(weighted().map(|(w, (_, r))| (w, r.objective)));
    let own_tasks = || tasks.iter().filter(|r| r.method == index);
    let worst = scored
        .iter()
        .filter_map(|(p, r)| Some((p.row.point.clone(), r.score?)))
        .max_by(|a, b| identity.direction.compare(a.1, b.1));
    let in_estimate: BTreeSet<usize> = counted.iter().map(|p| p.index).collect();
    let replicates = || own_tasks().filter(|r| in_estimate.contains(&r.point));
    let weight_of = weighted().map(|(w, (p, _))| (p.index, w)).collect();
    let summary = MethodSummary {
        is_reference: Some(index) == reference.index,
        index,
        rank: None,
        overall: estimate.as_ref().map(|e| e.value),
        interval: estimate.as_ref().and_then(|e| e.interval),
        summaries,
        episodes: EpisodeSummary::of_method(evidence, index, &weight_of),
        objective,
        metrics: weighted_metrics(&scored, &weights),
        worst,
        points: scored.len(),
        left_out: replicates().filter(|r| r.outcome != Some(Outcome::Ok)).count(),
        replicates: replicates().count(),
        failed: own_tasks().filter(|r| r.outcome == Some(Outcome::Failed)).count(),
        missing: own_tasks().filter(|r| r.outcome.is_none()).count(),
        without_reference: finished.len() - scored.len(),
        tuning: tuning(own_tasks()),
        method,
    };
    (summary, estimate)
}

/// Returns what became of the tuning of a method; `None` where none of its tasks was tuned.
fn tuning<'a>(tasks: impl Iterator<Item = &'a TaskScore>) -> Option<(usize, usize)> {
    let mut kept: BTreeMap<usize, bool> = BTreeMap::new();
    for (point, kept_start) in tasks.filter_map(|task| Some((task.point, task.kept_start?))) {
        *kept.entry(point).or_insert(true) &= kept_start;
    }
    (!kept.is_empty()).then(|| (kept.values().filter(|kept| **kept).count(), kept.len()))
}

/// Estimates with the same generator for every method, so that differences are paired.
fn estimate(
    evidence: Evidence<'_>,
    index: usize,
    scored: &[(&PointSummary, &PointResult)],
    weights: &[f64],
) -> (Option<Estimate>, Summaries) {
    let identity = evidence.identity;
    let of = |((p, r), weight): (&(&PointSummary, &PointResult), &f64)| {
        Some((p.regime, PointObjectives { weight: *weight, ..r.objectives.clone()? }))
    };
    let (regime_of, objectives): (Vec<Option<usize>>, Vec<PointObjectives>) =
        scored.iter().zip(weights).filter_map(of).unzip();
    let regimes = evidence.measures.regimes(&identity.objective).len();
    let relative = !evidence.reference.is_none();
    let points: Vec<&PointSummary> = scored.iter().map(|(p, _)| *p).collect();
    paired(evidence, index, &points, |estimator, sample, rng| {
        summarise(
            (&regime_of, &objectives),
            estimator,
            sample,
            (regimes, relative, evidence.most),
            rng,
        )
    })
}

/// Calls with the estimator and what that is given beside the scores of a method on these point MDPs; equally seeded for all
/// methods, so that their resamples are paired.
pub(super) fn paired<T>(
    evidence: Evidence<'_>,
    index: usize,
    points: &[&PointSummary],
    estimate: impl FnOnce(Estimator, Sample<'_>, &mut ChaCha8Rng) -> T,
) -> T {
    let identity = evidence.identity;
    let part: Vec<Chosen>;
    let chosen = match points.len() == evidence.points.len() {
        true => evidence.chosen,
        false => {
            part = choice(identity, evidence.design, points);
            &part
        }
    };
    let sample = Sample {
        family_size: identity.sample.family_size,
        chosen: look_of(identity, points).map_or(identity.points.len(), |look| look.draws.len()),
        method: index as u64,
        name: &identity.methods[index],
        learned_once: evidence.learned_once[index],
        points: chosen,
        design: evidence.given(),
        resamples: identity.sample.resamples(RESAMPLES),
        alpha: identity.sample.alpha(),
    };
    let mut rng = ChaCha8Rng::seed_from_u64(derive(identity.base_seed, &["report", "bootstrap"]));
    estimate(estimator_of(&identity.sample), sample, &mut rng)
}

fn weighted_metrics(scored: &[(&PointSummary, &PointResult)], weights: &[f64]) -> Metrics {
    let Some((_, first)) = scored.first() else { return Metrics::new() };
    let mean = |name: &String| {
        let values: Option<Vec<_>> = (scored.iter().zip(weights))
            .map(|((_, r), weight)| Some((*weight, *r.metrics.get(name)?)))
            .collect();
        Some((name.clone(), weighted_mean(values?)?))
    };
    first.metrics.keys().filter_map(mean).collect()
}

fn scored(points: &[PointSummary], method: usize) -> BTreeSet<usize> {
    let has_score =
        |p: &PointSummary| p.results[method].as_ref().is_some_and(|r| r.score.is_some());
    points.iter().enumerate().filter(|(_, p)| has_score(p)).map(|(i, _)| i).collect()
}

/// Returns the estimates of all methods, best first; those that lack point MDPs come last and without a rank, whatever
/// the others have. Where what scores are divided by lacks one, nobody has a score there, and nobody lacks it for that.
pub(super) fn rank(evidence: Evidence<'_>) -> Vec<Summarised> {
    let points = evidence.points;
    let methods = 0..evidence.identity.methods.len();
    let mut estimates: Vec<Summarised> =
        methods.into_par_iter().map(|index| summarise_method(evidence, index)).collect();
    let ranked = |m: &MethodSummary| {
        m.overall.is_some() && points.iter().all(|point| point.results[m.index].is_some())
    };
    estimates.sort_by(|(a, _), (b, _)| {
        let order = match (a.overall, b.overall) {
            (Some(a), Some(b)) => evidence.identity.direction.compare(a, b),
            (a, b) => b.is_some().cmp(&a.is_some()),
        };
        ranked(b).cmp(&ranked(a)).then(order).then(a.index.cmp(&b.index))
    });
    for (i, (summary, _)) in estimates.iter_mut().enumerate() {
        summary.rank = ranked(summary).then_some(i + 1);
    }
    estimates
}

/// Compares all methods with results where all of them have some; `None` when they are all ranked
/// anyway, or have nothing in common.
pub(super) fn on_common_points(
    evidence: Evidence<'_>,
    estimates: &[Summarised],
) -> Option<(usize, Vec<MethodSummary>)> {
    let with_results = || estimates.iter().filter(|(m, _)| m.overall.is_some());
    if with_results().all(|(m, _)| m.rank.is_some()) {
        return None;
    }
    let sets = with_results().map(|(m, _)| scored(evidence.points, m.index));
    let shared = sets.reduce(|a, b| &a & &b).filter(|shared| !shared.is_empty())?;
    let points: Vec<PointSummary> = shared.iter().map(|i| evidence.points[*i].clone()).collect();
    let tasks: Vec<TaskScore> =
        evidence.tasks.iter().filter(|r| shared.contains(&r.point)).cloned().collect();
    let chosen = choice(evidence.identity, evidence.design, &points);
    let on_shared = Evidence { points: &points, chosen: &chosen, tasks: &tasks, ..evidence };
    let methods = rank(on_shared).into_iter().map(|(m, _)| m);
    let methods = methods.filter(|m| m.overall.is_some()).collect();
    Some((points.len(), methods))
}
