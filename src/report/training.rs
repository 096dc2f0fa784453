//! How learners were trained: one entry per training, one summary per learner.
//!
//! A learner is a method whose training episodes have a return, or that diverged. Every delay is
//! divided by the mean delay on the point MDP of what scores are divided by, so that trainings compare
//! and RESCO's two ways of reporting stand beside the score.

use std::collections::{BTreeMap, BTreeSet};

use super::data::{MethodSummary, ReportData, Study};
use super::episodes::{Episode, EpisodeSummary};
use crate::stats::quantile::median;
use crate::stats::score::{mean, weighted_mean};
use crate::store::record::{Metrics, Outcome, Record, RowKind};
use crate::store::results::Results;

/// Metric of a training episode that only learners have.
pub(super) const RETURN: &str = "return";

/// Metric of the training episodes in which a learner updated its network.
pub(super) const LOSS: &str = "loss";

/// How the reason of a training that diverged begins.
const DIVERGED: &str = "training diverged";

/// One training: a learner on a point MDP, once.
#[derive(Debug, Clone, PartialEq)]
pub struct Training {
    /// Name of the method.
    pub method: String,
    /// Position of the point MDP in [`ReportData::points`].
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
    /// Delay in the best training episode, relative to the reference.
    pub resco_best: Option<f64>,
    /// Mean delay in the last ten training episodes, relative to the reference.
    pub resco_last_ten: Option<f64>,
    /// Whether one of its evaluation episodes or more ended in gridlock; `None` when that is not
    /// known.
    pub gridlocked: Option<bool>,
    /// Delay of every training episode, relative to the reference; empty without a reference.
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
    pub best: Option<f64>,
    /// Overall performance if the last ten training episodes counted.
    pub last_ten: Option<f64>,
    /// Trainings that ended worse than the reference.
    pub worse: usize,
    /// Trainings of which an evaluation episode ended in gridlock; `None` when that is not known of
    /// some.
    pub gridlocked: Option<usize>,
    /// Median score over trainings, each counting once.
    pub median: Option<f64>,
    /// Highest score of a training.
    pub worst: Option<f64>,
    /// Median wall-clock time of a task, seconds.
    pub wall_s: Option<f64>,
}

impl ReportData {
    /// Returns a summary per learner, in the order of the ranking.
    pub fn learners(&self) -> Vec<LearnerSummary<'_>> {
        let has_trainings =
            |m: &&MethodSummary| self.trainings.iter().any(|t| t.method == m.method);
        self.methods.iter().filter(has_trainings).map(|m| self.learner(m)).collect()
    }

    /// Returns the trainings of a method.
    pub fn trainings_of<'a>(&'a self, method: &'a str) -> impl Iterator<Item = &'a Training> {
        self.trainings.iter().filter(move |t| t.method == method)
    }

    fn learner<'a>(&'a self, method: &'a MethodSummary) -> LearnerSummary<'a> {
        let trainings = || self.trainings_of(&method.method);
        let count = |f: &dyn Fn(&Training) -> bool| trainings().filter(|t| f(t)).count();
        let scores: Vec<f64> = trainings().filter_map(|t| t.score).collect();
        let walls: Vec<f64> = trainings()
            .filter(|t| t.outcome == Some(Outcome::Ok))
            .filter_map(|t| t.wall_s)
            .collect();
        LearnerSummary {
            method,
            planned: trainings().count(),
            scored: scores.len(),
            failed: count(&|t| t.outcome == Some(Outcome::Failed)),
            diverged: count(&|t| t.diverged),
            episodes: trainings().map(|t| t.episodes).max().unwrap_or(0),
            best: self.weighted(trainings(), |t| t.resco_best),
            last_ten: self.weighted(trainings(), |t| t.resco_last_ten),
            worse: count(&|t| t.score > Some(1.0)),
            gridlocked: trainings()
                .filter(|t| t.score.is_some())
                .map(|t| t.gridlocked.map(usize::from))
                .sum(),
            median: median(&scores),
            worst: scores.iter().copied().reduce(f64::max),
            wall_s: median(&walls),
        }
    }

    /// Returns the mean over point MDPs, with their weights, of the mean over replicates.
    pub(super) fn weighted<'a>(
        &self,
        trainings: impl Iterator<Item = &'a Training>,
        value: impl Fn(&Training) -> Option<f64>,
    ) -> Option<f64> {
        let mut by_point: BTreeMap<usize, Vec<f64>> = BTreeMap::new();
        for training in trainings {
            if let Some(value) = value(training) {
                by_point.entry(training.point).or_default().push(value);
            }
        }
        weighted_mean(
            by_point.iter().filter_map(|(p, values)| Some((self.points[*p].weight, mean(values)?))),
        )
    }
}

/// Returns the trainings, one per task of a learner.
pub(super) fn trainings(results: &Results, study: Study<'_>) -> Vec<Training> {
    let identity = &results.manifest.identity;
    let learners: BTreeSet<&str> = results
        .records
        .values()
        .filter(|r| learned(r))
        .map(|r| r.summary.method.as_str())
        .collect();
    let objective = identity.objective.as_str();
    let mut evaluations: BTreeMap<(&str, usize, u32), Vec<&Episode>> = BTreeMap::new();
    for episode in study.episodes.iter().filter(|e| e.kind == RowKind::Evaluation) {
        let method = identity.methods[episode.method].as_str();
        let key = (method, episode.point, episode.replicate);
        evaluations.entry(key).or_default().push(episode);
    }
    let tasks = results.plan.iter().zip(study.rows);
    let of_learners = tasks.filter(|(task, _)| learners.contains(task.method.as_str()));
    of_learners
        .map(|(task, row)| {
            let of_reference =
                study.reference.index.and_then(|r| study.points[row.point].results[r].as_ref());
            let unit = of_reference.map(|r| r.objective).filter(|delay| *delay > 0.0);
            let record = results.records.get(&task.task);
            let relative = |name: &str| Some(row.metrics.get(name)? / unit?);
            let figure = |name: &str| -> Vec<Option<f64>> {
                let rows = record.into_iter().flat_map(training_rows);
                rows.map(|metrics| metrics.get(name).copied()).collect()
            };
            let key = (task.method.as_str(), row.point, task.replicate);
            let own = evaluations.get(&key).into_iter().flatten().copied();
            let evaluations =
                EpisodeSummary::of(own, std::slice::from_ref(&study.points[row.point]), objective);
            Training {
                method: task.method.clone(),
                point: row.point,
                replicate: task.replicate,
                outcome: row.outcome,
                diverged: row.reason.as_deref().is_some_and(|r| r.starts_with(DIVERGED)),
                score: row.score,
                resco_best: relative(&format!("resco_best_{objective}")),
                resco_last_ten: relative(&format!("resco_last_ten_{objective}")),
                gridlocked: evaluations.gridlocked.map(|share| share > 0.0),
                evaluations,
                curve: record.zip(unit).map_or_else(Vec::new, |(r, unit)| {
                    curve(r, objective).map(|delay| delay / unit).collect()
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
