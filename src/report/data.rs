//! What a report says, computed from a results directory: one summary per method, one row per task.
//!
//! A point MDP enters a method's estimate when both the method and what scores are divided by have a
//! record of it and the objective of the latter is above 0. Weights are renormalised over these point MDPs, and every
//! summary counts what it lacks.

use std::collections::{BTreeMap, BTreeSet};

use super::ReportError;
use super::episodes::{Episode, EpisodeSummary, episodes};
use super::plans::{TaskPlan, plans};
use super::points::{PointResult, PointSummary, summarise_points};
use super::ranking::{Common, Estimate, common, rank};
use super::reference::Reference;
use super::summaries::{Overloaded, Summaries, overloaded, summarise};
use super::training::{Training, trained, trainings};
use super::winners::{Winner, winners};
use crate::sample::Sampling;
use crate::seed::derive;
use crate::stats::score::weighted_mean;
use crate::stats::{Bootstrap, Design};
use crate::store::manifest::Manifest;
use crate::store::places::Places;
use crate::store::record::{Metrics, Outcome};
use crate::store::results::Results;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

/// Everything that a report says.
#[derive(Debug, Clone, PartialEq)]
pub struct ReportData {
    /// What the run was.
    pub manifest: Manifest,
    /// What scores are divided by.
    pub reference: Reference,
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
    /// One entry per episode, in the order of the plan.
    pub episodes: Vec<Episode>,
    /// Methods that tune or learn.
    pub trained: BTreeSet<String>,
    /// The part of the family that the baseline leaves at level of service F.
    pub overloaded: Option<Overloaded>,
    /// The best method of every point MDP, in the order of [`Self::points`].
    pub winners: Vec<Option<Winner>>,
    /// What every finished task ran, in the order of the plan.
    pub plans: Vec<TaskPlan>,
    /// Where the intersections are.
    pub places: Places,
}

/// What summaries are made from.
#[derive(Clone, Copy)]
pub(super) struct Study<'a> {
    /// What the run was.
    pub(super) manifest: &'a Manifest,
    /// What scores are divided by.
    pub(super) reference: &'a Reference,
    /// The point MDPs that count.
    pub(super) points: &'a [PointSummary],
    /// The tasks that count.
    pub(super) rows: &'a [ScoreRow],
    /// All episodes.
    pub(super) episodes: &'a [Episode],
}

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
    /// Overall performance; 1 is what scores are divided by, lower is better.
    pub overall: Option<f64>,
    /// 95% interval of the overall performance.
    pub interval: Option<(f64, f64)>,
    /// Other summaries of its scores and objectives.
    pub summaries: Summaries,
    /// Its evaluation episodes on the point MDPs in the estimate.
    pub episodes: EpisodeSummary,
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
    /// Point MDPs that the method finished but the reference did not, or where the reference's
    /// objective is 0.
    pub without_reference: usize,
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
    /// The reference's objective on the same seeds.
    pub reference: Option<f64>,
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

impl ReportData {
    /// Computes everything that a report says, with scores relative to the run's baseline.
    pub fn new(results: &Results) -> Self {
        Self::relative_to(results, Reference::baseline(&results.manifest.identity))
    }

    /// Computes everything that a report says, with scores relative to another method.
    ///
    /// # Errors
    ///
    /// Those of [`Reference::against`].
    pub fn against(results: &Results, method: &str) -> Result<Self, ReportError> {
        Ok(Self::relative_to(results, Reference::against(results, method)?))
    }

    fn relative_to(results: &Results, reference: Reference) -> Self {
        let (points, rows) = summarise_points(results, &reference);
        let episodes = episodes(results, &reference);
        let manifest = results.manifest.clone();
        let study = Study {
            manifest: &manifest,
            reference: &reference,
            points: &points,
            rows: &rows,
            episodes: &episodes,
        };
        let estimates = rank(study);
        let common = common(study, &estimates);
        let trainings = trainings(results, study);
        let lead = lead(&estimates, &points);
        let methods = estimates.into_iter().map(|(summary, _)| summary).collect();
        let baseline = Reference::baseline(&manifest.identity).index;
        let overloaded = baseline.and_then(|baseline| overloaded(&points, baseline));
        let trained = trained(results);
        let winners = winners(&points, &manifest.identity);
        let plans = plans(results, &rows);
        let places = results.places.clone();
        Self {
            winners,
            plans,
            places,
            methods,
            lead,
            common,
            trainings,
            trained,
            overloaded,
            reference,
            rows,
            points,
            episodes,
            manifest,
        }
    }

    /// Returns the best of the ranked methods.
    pub fn best(&self) -> Option<&MethodSummary> {
        self.methods.first().filter(|m| m.rank.is_some())
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

/// Summarises a method over the point MDPs of a study.
pub(super) fn summarise_method(study: Study<'_>, index: usize) -> Estimate {
    let Study { manifest, reference, points, rows, episodes } = study;
    let method = manifest.identity.methods[index].clone();
    let finished: Vec<(&PointSummary, &PointResult)> =
        points.iter().filter_map(|p| Some((p, p.results[index].as_ref()?))).collect();
    let scored: Vec<_> = finished.iter().filter(|(_, r)| r.score.is_some()).copied().collect();
    let (estimate, summaries) = estimate(manifest, index, &scored);
    let tasks = || rows.iter().filter(|r| r.method == method);
    let worst = scored
        .iter()
        .filter_map(|(p, r)| Some((p.row.point.clone(), r.score?)))
        .max_by(|a, b| a.1.total_cmp(&b.1));
    let counted: Vec<PointSummary> = scored.iter().map(|(p, _)| (*p).clone()).collect();
    let own = episodes.iter().filter(|e| e.method == index);
    let summary = MethodSummary {
        is_reference: Some(index) == reference.index,
        index,
        rank: None,
        overall: estimate.as_ref().map(|e| e.estimate),
        interval: estimate.as_ref().and_then(Bootstrap::interval),
        summaries,
        episodes: EpisodeSummary::of(own, &counted, &manifest.identity.objective),
        objective: weighted_mean(scored.iter().map(|(p, r)| (p.weight, r.objective))),
        metrics: weighted_metrics(&scored),
        worst,
        points: scored.len(),
        failed: tasks().filter(|r| r.outcome == Some(Outcome::Failed)).count(),
        missing: tasks().filter(|r| r.outcome.is_none()).count(),
        without_reference: finished.len() - scored.len(),
        method,
    };
    (summary, estimate)
}

/// Resamples with the same generator for every method, so that differences are paired.
fn estimate(
    manifest: &Manifest,
    index: usize,
    scored: &[(&PointSummary, &PointResult)],
) -> (Option<Bootstrap>, Summaries) {
    let identity = &manifest.identity;
    let objectives: Vec<_> =
        scored.iter().filter_map(|(p, r)| Some((*p, r.objectives.clone()?))).collect();
    let design = match identity.sample.sampling {
        Sampling::WithReplacement => Design::WithReplacement,
        Sampling::KMeans | Sampling::WithoutReplacement | Sampling::All => {
            Design::Distinct { family_size: identity.sample.family_size }
        }
    };
    let mut rng = ChaCha8Rng::seed_from_u64(derive(identity.base_seed, &["report", "bootstrap"]));
    summarise(&objectives, design, &mut rng, index as u64)
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
