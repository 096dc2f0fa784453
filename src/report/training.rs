//! How learners were trained: one entry per training, one summary per learner.
//!
//! A learner is a method whose training episodes have a return, or that diverged. Every delay is
//! divided by the baseline's mean delay on the point MDP, so that trainings compare and RESCO's two
//! ways of reporting stand beside the score.

use std::collections::{BTreeMap, BTreeSet};

use super::data::{MethodSummary, ReportData, ScoreRow};
use super::points::PointSummary;
use crate::stats::quantile::median;
use crate::stats::score::{mean, weighted_mean};
use crate::store::record::{Metrics, Outcome, Record, RowKind};
use crate::store::results::Results;

/// Metric of a training episode that only learners have.
const RETURN: &str = "return";

/// How the reason of a training that diverged begins.
const DIVERGED: &str = "training diverged";

/// Score above which a training ended in gridlock.
pub(super) const GRIDLOCK_SCORE: f64 = 3.0;

/// Share of vehicles that never entered, more than under the baseline, above which a training ended
/// in gridlock. Where demand is above capacity, up to half of them never enter under any method.
pub(super) const GRIDLOCK_SHARE: f64 = 0.1;

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
    /// Delay in the best training episode, relative to the baseline.
    pub resco_best: Option<f64>,
    /// Mean delay in the last ten training episodes, relative to the baseline.
    pub resco_last_ten: Option<f64>,
    /// Whether it ended in gridlock: a score above 3, or of all vehicles a tenth more than under the
    /// baseline never entered.
    pub gridlocked: bool,
    /// Delay of every training episode, relative to the baseline; empty without a baseline.
    pub curve: Vec<f64>,
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
    /// Trainings that ended worse than the baseline.
    pub worse: usize,
    /// Trainings that ended in gridlock.
    pub gridlocked: usize,
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
            gridlocked: count(&|t| t.gridlocked),
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
pub(super) fn trainings(
    results: &Results,
    points: &[PointSummary],
    rows: &[ScoreRow],
) -> Vec<Training> {
    let identity = &results.manifest.identity;
    let learners: BTreeSet<&str> = results
        .records
        .values()
        .filter(|r| learned(r))
        .map(|r| r.summary.method.as_str())
        .collect();
    let baseline = identity.methods.iter().position(|m| *m == identity.baseline);
    let objective = identity.objective.as_str();
    let tasks = results.plan.iter().zip(rows);
    let of_learners = tasks.filter(|(task, _)| learners.contains(task.method.as_str()));
    of_learners
        .map(|(task, row)| {
            let of_baseline = baseline.and_then(|b| points[row.point].results[b].as_ref());
            let unit = of_baseline.map(|b| b.objective).filter(|delay| *delay > 0.0);
            let record = results.records.get(&task.task);
            let relative = |name: &str| Some(row.metrics.get(name)? / unit?);
            let more_stuck = match (stuck(&row.metrics), of_baseline) {
                (Some(own), Some(b)) => own - stuck(&b.metrics).unwrap_or(0.0),
                _ => 0.0,
            };
            let reason = row.reason.as_deref().unwrap_or_default();
            Training {
                method: task.method.clone(),
                point: row.point,
                replicate: task.replicate,
                outcome: row.outcome,
                diverged: reason.starts_with(DIVERGED),
                score: row.score,
                resco_best: relative(&format!("resco_best_{objective}")),
                resco_last_ten: relative(&format!("resco_last_ten_{objective}")),
                gridlocked: row.score > Some(GRIDLOCK_SCORE) || more_stuck > GRIDLOCK_SHARE,
                curve: record
                    .zip(unit)
                    .map(|(r, unit)| curve(r, objective).map(|delay| delay / unit).collect())
                    .unwrap_or_default(),
                episodes: record.map_or(0, |r| training_rows(r).count()),
                wall_s: record.map(|r| r.summary.wall.wall_s),
            }
        })
        .collect()
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

/// Returns the share of vehicles that never entered.
fn stuck(metrics: &Metrics) -> Option<f64> {
    let vehicles = metrics.get("vehicles_veh").filter(|n| **n > 0.0)?;
    Some(metrics.get("undeparted_veh")? / vehicles)
}
