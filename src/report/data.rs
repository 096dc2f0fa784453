//! What a report says, computed from a results directory: one summary per method, one row per task.
//!
//! A point MDP enters a method's estimate when both the method and the baseline have a record of it
//! and the baseline's objective is above 0. Weights are renormalised over these point MDPs, and every
//! summary counts what it lacks.

use std::collections::{BTreeMap, BTreeSet};

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::points::{PointResult, PointSummary, summarise_points};
use super::ranking::{Common, Estimate, common, rank};
use super::training::{Training, trainings};
use crate::sample::Sampling;
use crate::seed::derive;
use crate::stats::score::weighted_mean;
use crate::stats::{Bootstrap, Design, bootstrap};
use crate::store::manifest::Manifest;
use crate::store::record::{Metrics, Outcome};
use crate::store::results::Results;

/// Everything that a report says.
#[derive(Debug, Clone, PartialEq)]
pub struct ReportData {
    /// What the run was.
    pub manifest: Manifest,
    /// One summary per method, best first, methods without an estimate last.
    pub methods: Vec<MethodSummary>,
    /// One row per task, in the order of the plan.
    pub rows: Vec<ScoreRow>,
    /// The chosen point MDPs, in the order of the family.
    pub points: Vec<PointSummary>,
    /// By how much the best method is ahead of the second best.
    pub lead: Option<Lead>,
    /// All methods on the point MDPs that all finished; there when some method is not ranked.
    pub common: Option<Common>,
    /// One entry per task of a learner, in the order of the plan.
    pub trainings: Vec<Training>,
}

/// One method over all its point MDPs.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodSummary {
    /// Name of the method.
    pub method: String,
    /// Position in the manifest's list of methods.
    pub index: usize,
    /// Whether it is what scores are divided by.
    pub is_baseline: bool,
    /// Place by overall performance, from 1.
    pub rank: Option<usize>,
    /// Overall performance; 1 is the baseline, lower is better.
    pub overall: Option<f64>,
    /// 95% interval of the overall performance.
    pub interval: Option<(f64, f64)>,
    /// Importance-weighted mean of the objective (for traffic the delay per vehicle, seconds).
    pub objective: Option<f64>,
    /// Importance-weighted means of the other metrics.
    pub metrics: Metrics,
    /// The point MDP with the highest score, and that score.
    pub worst: Option<(String, f64)>,
    /// Point MDPs in the estimate.
    pub points: usize,
    /// Tasks that failed.
    pub failed: usize,
    /// Tasks without a record.
    pub missing: usize,
    /// Point MDPs that the method finished but the baseline did not, or where the baseline's
    /// objective is 0.
    pub without_baseline: usize,
}

/// One task.
#[derive(Debug, Clone, PartialEq)]
pub struct ScoreRow {
    /// Name of the method.
    pub method: String,
    /// Position of the point MDP in [`ReportData::points`].
    pub point: usize,
    /// Which of several independent trainings.
    pub replicate: u32,
    /// How the task ended; `None` when it has no record.
    pub outcome: Option<Outcome>,
    /// Why it failed.
    pub reason: Option<String>,
    /// Means over the evaluation episodes.
    pub metrics: Metrics,
    /// The baseline's objective on the same seeds.
    pub baseline: Option<f64>,
    /// The score.
    pub score: Option<f64>,
}

/// The distance between the two best methods on the same point MDPs.
#[derive(Debug, Clone, PartialEq)]
pub struct Lead {
    /// The second best method.
    pub runner_up: String,
    /// Its overall performance minus the best one's.
    pub difference: f64,
    /// 95% interval of the difference, paired by point MDP and seed.
    pub interval: (f64, f64),
}

/// A method as `--json` prints it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JsonRow {
    /// Name of the method.
    pub method: String,
    /// Overall performance.
    pub overall: Option<f64>,
    /// Lower end of the 95% interval.
    pub overall_low: Option<f64>,
    /// Upper end of the 95% interval.
    pub overall_high: Option<f64>,
    /// Importance-weighted mean of the objective.
    pub delay_s: Option<f64>,
    /// Point MDPs in the estimate.
    pub points: usize,
    /// Tasks that failed.
    pub failed: usize,
}

impl ReportData {
    /// Computes everything that a report says.
    pub fn new(results: &Results) -> Self {
        let (points, rows) = summarise_points(results);
        let estimates = rank(&results.manifest, &points, &rows);
        let common = common(&results.manifest, &estimates, &points, &rows);
        let trainings = trainings(results, &points, &rows);
        let lead = lead(&estimates, &points);
        let methods = estimates.into_iter().map(|(summary, _)| summary).collect();
        let manifest = results.manifest.clone();
        Self { manifest, methods, rows, points, lead, common, trainings }
    }

    /// Returns the best of the ranked methods.
    pub fn best(&self) -> Option<&MethodSummary> {
        self.methods.first().filter(|m| m.rank.is_some())
    }

    /// Returns the summaries as `--json` prints them, best first.
    pub fn json_rows(&self) -> Vec<JsonRow> {
        let row = |m: &MethodSummary| JsonRow {
            method: m.method.clone(),
            overall: m.overall,
            overall_low: m.interval.map(|i| i.0),
            overall_high: m.interval.map(|i| i.1),
            delay_s: m.objective,
            points: m.points,
            failed: m.failed,
        };
        self.methods.iter().map(row).collect()
    }

    /// Returns the methods with an estimate that lack point MDPs which others have.
    pub fn unranked(&self) -> impl Iterator<Item = &MethodSummary> {
        self.methods.iter().filter(|m| m.overall.is_some() && m.rank.is_none())
    }

    /// Returns the methods of which some point MDP has results of only a part of its replicates.
    pub fn partly_replicated(&self) -> BTreeSet<&str> {
        let done = |row: &&ScoreRow| row.outcome == Some(Outcome::Ok);
        let finished: BTreeSet<(&str, usize)> =
            self.rows.iter().filter(done).map(|r| (r.method.as_str(), r.point)).collect();
        let partial = |r: &&ScoreRow| !done(r) && finished.contains(&(r.method.as_str(), r.point));
        self.rows.iter().filter(partial).map(|r| r.method.as_str()).collect()
    }

    /// Returns the number of tasks without a record.
    pub fn missing(&self) -> usize {
        self.rows.iter().filter(|r| r.outcome.is_none()).count()
    }

    /// Returns the failed tasks.
    pub fn failed(&self) -> impl Iterator<Item = &ScoreRow> {
        self.rows.iter().filter(|r| r.outcome == Some(Outcome::Failed))
    }

    /// Returns the name of the sampling as on the command line.
    pub fn sampling(&self) -> &'static str {
        match self.manifest.identity.sample.sampling {
            Sampling::KMeans => "k-means",
            Sampling::WithReplacement => "with-replacement",
            Sampling::WithoutReplacement => "without-replacement",
            Sampling::All => "all",
        }
    }

    /// Returns what a method achieved on every point MDP in its estimate, with the point MDP.
    pub fn results_of(&self, method: usize) -> impl Iterator<Item = (&PointSummary, &PointResult)> {
        self.points.iter().filter_map(move |p| {
            let result = p.results[method].as_ref()?;
            result.score.map(|_| (p, result))
        })
    }
}

/// Summarises a method over some point MDPs; its tasks are counted over all of them.
pub(super) fn summarise_method(
    manifest: &Manifest,
    index: usize,
    points: &[PointSummary],
    rows: &[ScoreRow],
) -> Estimate {
    let identity = &manifest.identity;
    let method = identity.methods[index].clone();
    let finished: Vec<(&PointSummary, &PointResult)> =
        points.iter().filter_map(|p| Some((p, p.results[index].as_ref()?))).collect();
    let scored: Vec<_> = finished.iter().filter(|(_, r)| r.score.is_some()).copied().collect();
    let estimate = estimate(manifest, index, &scored);
    let tasks = || rows.iter().filter(|r| r.method == method);
    let worst = scored
        .iter()
        .filter_map(|(p, r)| Some((p.row.point.clone(), r.score?)))
        .max_by(|a, b| a.1.total_cmp(&b.1));
    let summary = MethodSummary {
        is_baseline: method == identity.baseline,
        index,
        rank: None,
        overall: estimate.as_ref().map(|e| e.estimate),
        interval: estimate.as_ref().and_then(Bootstrap::interval),
        objective: weighted_mean(scored.iter().map(|(p, r)| (p.weight, r.objective))),
        metrics: weighted_metrics(&scored),
        worst,
        points: scored.len(),
        failed: tasks().filter(|r| r.outcome == Some(Outcome::Failed)).count(),
        missing: tasks().filter(|r| r.outcome.is_none()).count(),
        without_baseline: finished.len() - scored.len(),
        method,
    };
    (summary, estimate)
}

/// Resamples with the same generator for every method, so that differences are paired.
fn estimate(
    manifest: &Manifest,
    index: usize,
    scored: &[(&PointSummary, &PointResult)],
) -> Option<Bootstrap> {
    let identity = &manifest.identity;
    let objectives: Vec<_> = scored.iter().filter_map(|(_, r)| r.objectives.clone()).collect();
    let design = match identity.sample.sampling {
        Sampling::WithReplacement => Design::WithReplacement,
        Sampling::KMeans | Sampling::WithoutReplacement | Sampling::All => {
            Design::Distinct { family_size: identity.sample.family_size }
        }
    };
    let mut rng = ChaCha8Rng::seed_from_u64(derive(identity.base_seed, &["report", "bootstrap"]));
    bootstrap(&objectives, design, &mut rng, index as u64).ok()
}

/// Returns the weighted means of every metric that all point MDPs have.
fn weighted_metrics(scored: &[(&PointSummary, &PointResult)]) -> Metrics {
    let Some((_, first)) = scored.first() else { return Metrics::new() };
    let mean = |name: &String| {
        let values: Option<Vec<_>> =
            scored.iter().map(|(p, r)| Some((p.weight, *r.metrics.get(name)?))).collect();
        Some((name.clone(), weighted_mean(values?)?))
    };
    first.metrics.keys().filter_map(mean).collect::<BTreeMap<_, _>>()
}

/// Compares the two best methods when they were evaluated on the same point MDPs.
fn lead(estimates: &[Estimate], points: &[PointSummary]) -> Option<Lead> {
    let [(best, Some(first)), (second, Some(other)), ..] = estimates else { return None };
    let scored = |p: &PointSummary, m: &MethodSummary| {
        p.results[m.index].as_ref().is_some_and(|r| r.score.is_some())
    };
    if points.iter().any(|p| scored(p, best) != scored(p, second)) {
        return None;
    }
    let difference = first.difference(other);
    let interval = difference.interval()?;
    let runner_up = second.method.clone();
    Some(Lead { runner_up, difference: difference.estimate, interval })
}
