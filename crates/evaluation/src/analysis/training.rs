//! How learners were trained: one entry per training, one summary per learner.
//!
//! A learner is a method whose training episodes have a return, or that diverged, or of which its author said that it learns
//! and which has trained: what the training of somebody's own learner writes is up to them. Every objective is
//! divided by the mean one on the point MDP of what scores are divided by, if anything, so that trainings compare
//! and two common ways of reporting, the best episode of training and its last ones, stand beside the score.

use std::collections::{BTreeMap, BTreeSet, HashMap};

use super::choice::weights;
use super::method::MethodSummary;
use super::points::{EpisodeSummary, Evidence, PointSummary};
use crate::stats::Direction;
use crate::stats::quantile::median;
use crate::stats::score::{mean, weighted_mean};
use crate::store::figures::{DEAD, LAST_PREFIX, POLICY_ROW, RESTARTS, RETURN, VALIDATION_EPISODES};
use crate::store::manifest::{Identity, Task};
use crate::store::record::{Outcome, Record, Row, RowKind, Trained};
use crate::store::results::Results;

/// Metric of the training episodes in which a learner updated its network.
pub const LOSS: &str = "loss";

/// Episodes of the trailing mean of a curve.
pub const SMOOTHED_OVER: usize = 5;

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
    /// Objective by row of training, relative to the reference: its mean over validation seeds where there was
    /// validation, else the trailing mean of the episodes; `None` in rows that have none. Empty without a reference.
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
    /// Median score over trainings, each counting once.
    pub median: Option<f64>,
    /// Worst score of a training.
    pub worst: Option<f64>,
    /// Median wall-clock time of a task, seconds.
    pub wall_s: Option<f64>,
}

impl TrainingSummary {
    /// Whether another policy than the last one was evaluated.
    fn is_replaced(&self) -> bool {
        self.policy_row.is_some_and(|row| (row as usize) < self.episodes)
    }
}

pub(super) fn learner<'a>(
    method: &'a MethodSummary,
    trainings: &[&TrainingSummary],
    (identity, points): (&Identity, &[PointSummary]),
    direction: Direction,
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
    LearnerSummary {
        method,
        planned: trainings.len(),
        scored: scores.len(),
        failed: count(&|t| t.outcome == Some(Outcome::Failed)),
        episodes: all().map(|t| t.episodes).max().unwrap_or(0),
        validated,
        replaced: count(&TrainingSummary::is_replaced),
        last_policy: if validated > 0 { weighted(&last_policy) } else { None },
        restarted: count(&|t| t.restarts.is_some_and(|n| n > 0)),
        dead: count(&|t| t.is_dead == Some(true)),
        best_episode: weighted(&|t| t.best_episode),
        last_episodes: weighted(&|t| t.last_episodes),
        median: median(&scores),
        worst: direction.worst(scores.iter().copied()),
        wall_s: median(&walls),
    }
}

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
            let trained = record.map(|record| record.trained(objective, identity.direction));
            let figure = |name: &str| -> Vec<Option<f64>> {
                let mut values = vec![None; trained.map_or(0, |t| t.rows)];
                for row in &rows {
                    if let Some(value) = values.get_mut(row.episode as usize) {
                        *value = row.metrics.get(name).copied();
                    }
                }
                values
            };
            let relative = |value: Option<f64>| value.zip(unit).map(|(value, unit)| value / unit);
            let of_record = |name: &str| record.and_then(|r| r.summary.metrics.get(name).copied());
            // A training may end before its first validation is due: then its last policy is evaluated.
            let is_validated = of_record(VALIDATION_EPISODES).is_some_and(|n| n > 0.0);
            let of_choice = |name: &str| of_record(name).filter(|_| is_validated);
            let last_policy = of_choice(&format!("{LAST_PREFIX}{objective}"));
            let evaluations = EpisodeSummary::of(
                evidence,
                &evidence.episodes[at],
                &HashMap::from([(row.point, evidence.points[row.point].weight)]),
            );
            TrainingSummary {
                method: task.method.to_string(),
                point: row.point,
                replicate: task.replicate,
                outcome: row.outcome,
                diverged: row.reason.as_deref().is_some_and(|r| r.starts_with(DIVERGED)),
                score: row.score,
                best_episode: relative(trained.and_then(|t| t.best)),
                last_episodes: relative(trained.and_then(|t| t.last)),
                policy_row: of_choice(POLICY_ROW).map(|row| row as u32),
                last_policy: relative(last_policy),
                restarts: of_record(RESTARTS).map(|n| n as u32),
                is_dead: of_record(DEAD).map(|dead| dead > 0.0),
                evaluations,
                curve: record
                    .zip(unit)
                    .map_or_else(Vec::new, |(record, unit)| curve(record, objective, unit)),
                returns: figure(RETURN),
                losses: figure(LOSS),
                episodes: trained.map_or(0, |t| t.rows),
                steps: trained.and_then(|t| t.steps).map(|steps| steps as u64),
                wall_s: record.map(|r| r.summary.wall.wall_s),
            }
        })
        .collect()
}

fn curve(record: &Record, objective: &str, unit: f64) -> Vec<Option<f64>> {
    let value = |row: &&Row| row.metrics.get(objective).map(|value| value / unit);
    let mut values = Vec::new();
    let mut put = |row: usize, value: Option<f64>| {
        values.resize(values.len().max(row), None);
        values[row - 1] = value;
    };
    let validation: Vec<&Row> =
        record.rows.iter().filter(|row| row.kind == RowKind::Validation).collect();
    // Of the last ones more seeds may have been tried later.
    let of_each = validation.iter().take_while(|row| row.episode == validation[0].episode);
    let seeds: BTreeSet<u64> = of_each.map(|row| row.seed).collect();
    let mut by_row: BTreeMap<u32, Vec<f64>> = BTreeMap::new();
    for row in validation.into_iter().filter(|row| seeds.contains(&row.seed)) {
        by_row.entry(row.episode).or_default().extend(value(&row));
    }
    by_row.iter().for_each(|(row, values)| put(*row as usize, mean(values)));
    if by_row.is_empty() {
        let rows = record.training().filter_map(|row| Some((row.episode, value(&row)?)));
        let rows: Vec<(u32, f64)> = rows.collect();
        for (at, (row, _)) in rows.iter().enumerate() {
            let last = rows[(at + 1).saturating_sub(SMOOTHED_OVER)..=at].iter();
            put(*row as usize + 1, mean(&last.map(|(_, value)| *value).collect::<Vec<_>>()));
        }
    }
    values
}

/// Returns the methods that tune or learn: those with an episode of training, and those that diverged.
pub(super) fn trained(results: &Results) -> BTreeSet<String> {
    with_a_record(results, |_, record, trained| has_learned(record, trained) || trained.rows > 0)
}

pub(super) fn learned(results: &Results) -> BTreeSet<String> {
    let identity = &results.manifest.identity;
    let says_so = |method: &str| identity.controller(method).is_some_and(|own| own.learns);
    with_a_record(results, |task, record, trained| {
        has_learned(record, trained) || (says_so(&task.method) && trained.rows > 0)
    })
}

fn with_a_record(
    results: &Results,
    is_such: impl Fn(&Task, &Record, Trained) -> bool,
) -> BTreeSet<String> {
    let Identity { objective, direction, .. } = &results.manifest.identity;
    let done = results
        .done()
        .filter(|(task, record)| is_such(task, record, record.trained(objective, *direction)));
    let methods: BTreeSet<&str> = done.map(|(task, _)| &*task.method).collect();
    methods.into_iter().map(str::to_owned).collect()
}

/// Whether a record alone shows that its method learns.
fn has_learned(record: &Record, trained: Trained) -> bool {
    let diverged = record.summary.reason.as_ref().is_some_and(|r| r.starts_with(DIVERGED));
    diverged || trained.learns
}
