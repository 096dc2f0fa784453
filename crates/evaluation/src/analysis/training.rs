//! How learners were trained: one entry per training, one summary per learner.
//!
//! A learner is a method whose training episodes have a return, or that diverged, or of which its author said that it learns
//! and which has trained: what the training of somebody's own learner writes is up to them. Every objective is
//! divided by the mean one on the point MDP of what scores are divided by, if anything, so that trainings compare
//! and two common ways of reporting, the best episode of training and its last ones, stand beside the score.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::choice::weights;
use super::episodes::EpisodeSummary;
use super::evidence::Evidence;
use super::method::MethodSummary;
use super::points::PointSummary;
use crate::stats::Direction;
use crate::stats::quantile::median;
use crate::stats::score::{mean, weighted_mean};
use crate::store::figures::{DEAD, LAST_PREFIX, POLICY_ROW, RESTARTS, VALIDATION_EPISODES};
use crate::store::manifest::{Identity, Task};
use crate::store::record::{Outcome, Record, Row};
use crate::store::results::Results;

/// Metric of a training episode that only learners have; not all learners of somebody's own.
pub const RETURN: &str = "return";

/// Metric of the training episodes in which a learner updated its network.
pub const LOSS: &str = "loss";

/// Metric of a row of training that is not an episode: steps of training so far.
const STEPS: &str = "steps";

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
    /// Row of training, from 1, after which the evaluated policy was taken; `None` where nothing chose among policies and
    /// the last one was evaluated.
    pub policy_row: Option<u32>,
    /// Score of the last policy, on the evaluation seeds; `None` where nothing chose among policies.
    pub last_policy: Option<f64>,
    /// How often it started again because the network was dead; `None` where that is not known or was not allowed.
    pub restarts: Option<u32>,
    /// Whether it ended with a dead network; `None` where that is not known.
    pub is_dead: Option<bool>,
    /// Its evaluation episodes.
    pub evaluations: EpisodeSummary,
    /// Objective in the best training episode, relative to the reference.
    pub best_episode: Option<f64>,
    /// Mean objective in the last ten training episodes, relative to the reference.
    pub last_episodes: Option<f64>,
    /// Objective of every training episode, relative to the reference; empty without a reference.
    pub curve: Vec<Option<f64>>,
    /// Return of every training episode; `None` where there is none.
    pub returns: Vec<Option<f64>>,
    /// Loss of every training episode; `None` where nothing was updated.
    pub losses: Vec<Option<f64>>,
    /// Number of training episodes.
    pub episodes: usize,
    /// Number of training steps, where a row of training is not an episode; `None` where it is one.
    pub steps: Option<u64>,
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
    /// Trainings whose policy was chosen by validation.
    pub validated: usize,
    /// Those of them of which another policy than the last one was evaluated.
    pub replaced: usize,
    /// Overall performance if the last policies counted; `None` where nothing chose among policies.
    pub last_policy: Option<f64>,
    /// Trainings that started again because the network was dead.
    pub restarted: usize,
    /// Trainings that ended with a dead network.
    pub dead: usize,
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
    /// Whether another policy than the last one was evaluated.
    pub fn is_replaced(&self) -> bool {
        self.policy_row.is_some_and(|row| (row as usize) < self.episodes)
    }

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
    (identity, points): (&Identity, &[PointSummary]),
    shares: usize,
    (direction, relative): (Direction, bool),
) -> LearnerSummary<'a> {
    let all = || trainings.iter().copied();
    let weighted = |value: &dyn Fn(&TrainingSummary) -> Option<f64>| {
        weighted_by_point(all(), (identity, points), value)
    };
    let count = |f: &dyn Fn(&TrainingSummary) -> bool| all().filter(|t| f(t)).count();
    let scores: Vec<f64> = all().filter_map(|t| t.score).collect();
    let walls: Vec<f64> =
        all().filter(|t| t.outcome == Some(Outcome::Ok)).filter_map(|t| t.wall_s).collect();
    // Of a training that ended before its first validation the last policy was evaluated.
    let last_policy =
        |t: &TrainingSummary| t.last_policy.or_else(|| t.score.filter(|_| t.policy_row.is_none()));
    let validated = count(&|t| t.policy_row.is_some());
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
        validated,
        replaced: count(&TrainingSummary::is_replaced),
        last_policy: if validated > 0 { weighted(&last_policy) } else { None },
        restarted: count(&|t| t.restarts.is_some_and(|n| n > 0)),
        dead: count(&|t| t.is_dead == Some(true)),
        best_episode: weighted(&|t| t.best_episode),
        last_episodes: weighted(&|t| t.last_episodes),
        worse: relative.then(|| count(&|t| t.score.is_some_and(|s| direction.is_worse(s, 1.0)))),
        with_share: (0..shares).map(with_share).collect(),
        median: median(&scores),
        worst: direction.worst(scores.iter().copied()),
        wall_s: median(&walls),
    }
}

/// Returns the mean over point MDPs, with their weights, of the mean over replicates.
fn weighted_by_point<'a>(
    trainings: impl Iterator<Item = &'a TrainingSummary>,
    (identity, points): (&Identity, &[PointSummary]),
    value: &dyn Fn(&TrainingSummary) -> Option<f64>,
) -> Option<f64> {
    let mut by_point: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
    for training in trainings {
        if let Some(value) = value(training) {
            by_point.entry(training.point).or_default().push(value);
        }
    }
    let of_values: Vec<&PointSummary> = by_point.keys().map(|p| &points[*p]).collect();
    let weights = weights(identity, &of_values);
    let weighted = weights.into_iter().zip(by_point.values());
    weighted_mean(weighted.filter_map(|(weight, values)| Some((weight, mean(values)?))))
}

/// Returns the trainings, one per task of a learner.
pub(super) fn trainings(results: &Results, evidence: Evidence<'_>) -> Vec<TrainingSummary> {
    let identity = evidence.identity;
    let learners = learned(results);
    let objective = identity.objective.as_str();
    let tasks = results.rows().zip(evidence.tasks).enumerate();
    let of_learners = tasks.filter(|(_, ((task, _), _))| learners.contains(&task.method));
    of_learners
        .map(|(at, ((task, record), row))| {
            let of_reference = evidence
                .reference
                .index
                .and_then(|r| evidence.points[row.point].results[r].as_ref());
            let unit = match evidence.reference.is_none() {
                true => Some(1.0),
                false => of_reference.map(|r| r.objective).filter(|unit| *unit > 0.0),
            };
            let rows: Vec<&Row> = record.into_iter().flat_map(Record::training).collect();
            let figure = |name: &str| -> Vec<Option<f64>> {
                rows.iter().map(|row| row.metrics.get(name).copied()).collect()
            };
            let in_training: Vec<f64> = figure(objective).into_iter().flatten().collect();
            let last = &in_training[in_training.len().saturating_sub(LAST_EPISODES)..];
            let best = identity.direction.best(in_training.iter().copied());
            let of_record = |name: &str| record.and_then(|r| r.summary.metrics.get(name).copied());
            // A training may end before its first validation is due: then its last policy is evaluated.
            let is_validated = of_record(VALIDATION_EPISODES).is_some_and(|n| n > 0.0);
            let of_choice = |name: &str| of_record(name).filter(|_| is_validated);
            let last_policy = of_choice(&format!("{LAST_PREFIX}{objective}"));
            let evaluations = EpisodeSummary::of(
                &evidence.episodes.of_task[at],
                evidence.episodes.shares,
                &HashMap::from([(row.point, evidence.points[row.point].weight)]),
                identity.direction,
            );
            TrainingSummary {
                method: task.method.to_string(),
                point: row.point,
                replicate: task.replicate,
                outcome: row.outcome,
                diverged: row.reason.as_deref().is_some_and(|r| r.starts_with(DIVERGED)),
                score: row.score,
                best_episode: best.zip(unit).map(|(best, unit)| best / unit),
                last_episodes: mean(last).zip(unit).map(|(last, unit)| last / unit),
                policy_row: of_choice(POLICY_ROW).map(|row| row as u32),
                last_policy: last_policy.zip(unit).map(|(last, unit)| last / unit),
                restarts: of_record(RESTARTS).map(|n| n as u32),
                is_dead: of_record(DEAD).map(|dead| dead > 0.0),
                evaluations,
                curve: unit.map_or_else(Vec::new, |unit| {
                    in_training.iter().map(|value| Some(value / unit)).collect()
                }),
                returns: figure(RETURN),
                losses: figure(LOSS),
                episodes: rows.len(),
                steps: figure(STEPS).last().copied().flatten().map(|steps| steps as u64),
                wall_s: record.map(|r| r.summary.wall.wall_s),
            }
        })
        .collect()
}

/// Returns the methods that tune or learn: those with an episode of training, and those that diverged.
pub(super) fn trained(results: &Results) -> BTreeSet<String> {
    with_a_record(results, |_, record| has_learned(record) || has_trained(record))
}

/// Returns the methods that learn.
pub(super) fn learned(results: &Results) -> BTreeSet<String> {
    let identity = &results.manifest.identity;
    let says_so = |method: &str| identity.controller(method).is_some_and(|own| own.learns);
    with_a_record(results, |task, record| {
        has_learned(record) || (says_so(&task.method) && has_trained(record))
    })
}

/// Returns the methods of which some task with its record is such.
fn with_a_record(results: &Results, is_such: impl Fn(&Task, &Record) -> bool) -> BTreeSet<String> {
    let done = results.done().filter(|(task, record)| is_such(task, record));
    let methods: BTreeSet<&str> = done.map(|(task, _)| &*task.method).collect();
    methods.into_iter().map(str::to_owned).collect()
}

/// Whether a record has an episode of training.
fn has_trained(record: &Record) -> bool {
    record.training().next().is_some()
}

/// Whether a record alone shows that its method learns.
fn has_learned(record: &Record) -> bool {
    let diverged = record.summary.reason.as_ref().is_some_and(|r| r.starts_with(DIVERGED));
    diverged || record.training().any(|row| row.metrics.contains_key(RETURN))
}
