//! How learners were trained: one entry per training, one summary per learner.
//!
//! A learner is a method whose training episodes have a return, or that diverged. Every objective is
//! divided by the mean one on the point MDP of what scores are divided by, if anything, so that trainings compare
//! and two common ways of reporting, the best episode of training and its last ones, stand beside the score.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::episodes::{Episode, EpisodeSummary};
use super::evidence::Evidence;
use super::method::MethodSummary;
use super::points::PointSummary;
use crate::stats::Direction;
use crate::stats::quantile::median;
use crate::stats::score::{mean, weighted_mean};
use crate::store::record::{Metrics, Outcome, Record, RowKind};
use crate::store::results::Results;

/// Metric of a training episode that only learners have.
pub const RETURN: &str = "return";

/// Metric of the training episodes in which a learner updated its network.
pub const LOSS: &str = "loss";

/// Training episodes whose mean is reported beside the best one.
pub const LAST_EPISODES: usize = 10;

/// How the reason of a training that diverged begins.
const DIVERGED: &str = "training diverged";

/// One training: a learner on a point MDP, once.
#[derive(Debug, Clone, PartialEq)]
pub struct TrainingSummary {
    /// Name of the method.
    pub method: String,
    /// Position of the point MDP among the chosen point MDPs.
    pub point: usize,
    /// Which of several independent trainings.
    pub replicate: u32,
    /// How it ended; `None` when it has no record.
    pub outcome: Option<Outcome>,
    /// Whether it failed because it diverged.
    pub diverged: bool,
    /// Score of what was learned, on the evaluation seeds.
    pub score: Option<f64>,
    /// Its evaluation episodes.
    pub evaluations: EpisodeSummary,
    /// Objective in the best training episode, relative to the reference.
    pub best_episode: Option<f64>,
    /// Mean objective in the last ten training episodes, relative to the reference.
    pub last_episodes: Option<f64>,
    /// Objective of every training episode, relative to the reference; empty without a reference.
    pub curve: Vec<f64>,
    /// Return of every training episode; `None` where there is none.
    pub returns: Vec<Option<f64>>,
    /// Loss of every training episode; `None` where nothing was updated.
    pub losses: Vec<Option<f64>>,
    /// Number of training episodes.
    pub episodes: usize,
    /// Wall-clock time of training and evaluation, seconds.
    pub wall_s: Option<f64>,
}

/// A learner over all its trainings.
#[derive(Debug, Clone, PartialEq)]
pub struct LearnerSummary<'a> {
    /// The method.
    pub method: &'a MethodSummary,
    /// Trainings planned.
    pub planned: usize,
    /// Trainings with a score.
    pub scored: usize,
    /// Trainings that failed.
    pub failed: usize,
    /// Trainings that failed because they diverged.
    pub diverged: usize,
    /// Most training episodes.
    pub episodes: usize,
    /// Overall performance if the best training episode counted.
    pub best_episode: Option<f64>,
    /// Overall performance if the last ten training episodes counted.
    pub last_episodes: Option<f64>,
    /// Trainings that ended worse than the reference; `None` without one.
    pub worse: Option<usize>,
    /// Trainings with a share above 0, in the order of [`super::Measures::shares`]; `None` when that is not
    /// known of some.
    pub with_share: Vec<Option<usize>>,
    /// Median score over trainings, each counting once.
    pub median: Option<f64>,
    /// Worst score of a training.
    pub worst: Option<f64>,
    /// Median wall-clock time of a task, seconds.
    pub wall_s: Option<f64>,
}

impl TrainingSummary {
    /// Returns whether one of its evaluation episodes or more has a share above 0; `None` when that is not
    /// known.
    pub fn has_share(&self, share: usize) -> Option<bool> {
        let of_episodes = self.evaluations.shares.get(share).copied().flatten();
        of_episodes.map(|share| share > 0.0)
    }
}

/// Returns the summary of a learner.
///
/// # Arguments
///
/// * `shares` — how many the domain measures.
/// * `direction`, `relative` — of scores: which are better, and whether 1 is what they are divided by.
pub(super) fn learner<'a>(
    method: &'a MethodSummary,
    trainings: &[&TrainingSummary],
    points: &[PointSummary],
    shares: usize,
    (direction, relative): (Direction, bool),
) -> LearnerSummary<'a> {
    let all = || trainings.iter().copied();
    let count = |f: &dyn Fn(&TrainingSummary) -> bool| all().filter(|t| f(t)).count();
    let scores: Vec<f64> = all().filter_map(|t| t.score).collect();
    let walls: Vec<f64> =
        all().filter(|t| t.outcome == Some(Outcome::Ok)).filter_map(|t| t.wall_s).collect();
    let with_share = |i: usize| {
        let known = all().filter(|t| t.score.is_some()).map(|t| t.has_share(i));
        known.map(|has| has.map(usize::from)).sum()
    };
    LearnerSummary {
        method,
        planned: trainings.len(),
        scored: scores.len(),
        failed: count(&|t| t.outcome == Some(Outcome::Failed)),
        diverged: count(&|t| t.diverged),
        episodes: all().map(|t| t.episodes).max().unwrap_or(0),
        best_episode: weighted(all(), points, |t| t.best_episode),
        last_episodes: weighted(all(), points, |t| t.last_episodes),
        worse: relative.then(|| count(&|t| t.score.is_some_and(|s| direction.is_worse(s, 1.0)))),
        with_share: (0..shares).map(with_share).collect(),
        median: median(&scores),
        worst: direction.worst(scores.iter().copied()),
        wall_s: median(&walls),
    }
}

/// Returns the mean over point MDPs, with their weights, of the mean over replicates.
fn weighted<'a>(
    trainings: impl Iterator<Item = &'a TrainingSummary>,
    points: &[PointSummary],
    value: impl Fn(&TrainingSummary) -> Option<f64>,
) -> Option<f64> {
    let mut by_point: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for training in trainings {
        if let Some(value) = value(training) {
            by_point.entry(training.point).or_default().push(value);
        }
    }
    weighted_mean(
        by_point.iter().filter_map(|(p, values)| Some((points[*p].weight, mean(values)?))),
    )
}

/// Returns the trainings, one per task of a learner.
pub(super) fn trainings(results: &Results, evidence: Evidence<'_>) -> Vec<TrainingSummary> {
    let identity = evidence.identity;
    let shares = evidence.measures.shares().len();
    let learners: BTreeSet<&str> = results
        .records
        .values()
        .filter(|r| learned(r))
        .map(|r| r.summary.method.as_str())
        .collect();
    let objective = identity.objective.as_str();
    let judged = (objective, identity.direction);
    let mut evaluations: BTreeMap<(&str, usize, u32), Vec<&Episode>> = BTreeMap::new();
    for episode in evidence.episodes.iter().filter(|e| e.kind == RowKind::Evaluation) {
        let method = identity.methods[episode.method].as_str();
        let key = (method, episode.point, episode.replicate);
        evaluations.entry(key).or_default().push(episode);
    }
    let tasks = results.plan.iter().zip(evidence.tasks);
    let of_learners = tasks.filter(|(task, _)| learners.contains(task.method.as_str()));
    of_learners
        .map(|(task, row)| {
            let of_reference = evidence
                .reference
                .index
                .and_then(|r| evidence.points[row.point].results[r].as_ref());
            let unit = match evidence.reference.is_none() {
                true => Some(1.0),
                false => of_reference.map(|r| r.objective).filter(|unit| *unit > 0.0),
            };
            let record = results.records.get(&task.task);
            let in_training: Vec<f64> =
                record.map_or_else(Vec::new, |record| curve(record, objective).collect());
            let last = &in_training[in_training.len().saturating_sub(LAST_EPISODES)..];
            let best = identity.direction.best(in_training.iter().copied());
            let figure = |name: &str| -> Vec<Option<f64>> {
                let rows = record.into_iter().flat_map(training_rows);
                rows.map(|metrics| metrics.get(name).copied()).collect()
            };
            let key = (task.method.as_str(), row.point, task.replicate);
            let own = evaluations.get(&key).into_iter().flatten().copied();
            let evaluations = EpisodeSummary::of(
                own,
                &HashMap::from([(row.point, evidence.points[row.point].weight)]),
                judged,
                shares,
            );
            TrainingSummary {
                method: task.method.clone(),
                point: row.point,
                replicate: task.replicate,
                outcome: row.outcome,
                diverged: row.reason.as_deref().is_some_and(|r| r.starts_with(DIVERGED)),
                score: row.score,
                best_episode: best.zip(unit).map(|(best, unit)| best / unit),
                last_episodes: mean(last).zip(unit).map(|(last, unit)| last / unit),
                evaluations,
                curve: unit.map_or_else(Vec::new, |unit| {
                    in_training.iter().map(|value| value / unit).collect()
                }),
                returns: figure(RETURN),
                losses: figure(LOSS),
                episodes: record.map_or(0, |r| training_rows(r).count()),
                wall_s: record.map(|r| r.summary.wall.wall_s),
            }
        })
        .collect()
}

/// Returns the methods that tune or learn: those with an episode of training, and those that diverged.
pub(super) fn trained(results: &Results) -> BTreeSet<String> {
    let trains = |r: &&Record| learned(r) || training_rows(r).next().is_some();
    results.records.values().filter(trains).map(|r| r.summary.method.clone()).collect()
}

fn training_rows(record: &Record) -> impl Iterator<Item = &Metrics> {
    record.rows.iter().filter(|r| r.kind == RowKind::Training).map(|r| &r.metrics)
}

fn learned(record: &Record) -> bool {
    let diverged = record.summary.reason.as_deref().is_some_and(|r| r.starts_with(DIVERGED));
    diverged || training_rows(record).any(|metrics| metrics.contains_key(RETURN))
}

/// Returns the objective of every training episode.
fn curve<'a>(record: &'a Record, objective: &'a str) -> impl Iterator<Item = f64> + 'a {
    training_rows(record).filter_map(move |metrics| metrics.get(objective).copied())
}
