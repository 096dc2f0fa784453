//! What every method achieved on every point MDP: replicates averaged, seeds paired with those of what scores are divided by;
//! and the evaluation episodes behind that.

use std::collections::{BTreeMap, HashMap};

use rayon::prelude::*;

use super::estimator::{Chosen, estimator_of};
use super::measures::Measures;
use super::reference::Reference;
use crate::sample::{Design, Draw, Sampling};
use crate::stats::PointObjectives;
use crate::stats::score::{mean, weighted_mean};
use crate::stats::summary::weighted_median;
use crate::store::manifest::{Identity, PointRow, Task};
use crate::store::record::{Metrics, Outcome, Record, Row, means};
use crate::store::results::Results;

/// Objective by evaluation seed, each once and in order.
type BySeed = Vec<(u64, f64)>;

/// One point MDP under all methods.
#[derive(Debug, Clone, PartialEq)]
pub struct PointSummary {
    /// Position among the chosen point MDPs.
    pub index: usize,
    /// The point MDP.
    pub row: PointRow,
    /// Weight of its scores in the estimates.
    pub weight: f64,
    /// Position of its regime in [`Measures::regimes`], by what the baseline achieves there, whatever
    /// scores are divided by; `None` when that is not known.
    pub regime: Option<usize>,
    /// What each method achieved, in the order of the manifest; `None` without a record.
    pub results: Vec<Option<PointResult>>,
}

/// What a method achieved on a point MDP: means over its replicates.
#[derive(Debug, Clone, PartialEq)]
pub struct PointResult {
    /// Mean objective.
    pub objective: f64,
    /// Mean of every metric that all replicates have.
    pub metrics: Metrics,
    /// The score; `None` where what it is divided by has no record or an objective of 0. Without a reference
    /// it is the objective.
    pub score: Option<f64>,
    /// What the interval is computed from; there when the score is.
    pub objectives: Option<PointObjectives>,
    /// Objectives of every replicate, shape `[replicates, seeds]`, where [`Self::objectives`] has only their mean: of what
    /// scores are divided by.
    pub replicates: Option<Vec<Vec<f64>>>,
}

impl PointResult {
    /// Returns the objectives of every replicate, shape `[replicates, seeds]`; empty without a score.
    pub fn runs(&self) -> &[Vec<f64>] {
        let method = || self.objectives.as_ref().map(|o| &o.method);
        self.replicates.as_ref().or_else(method).map_or(&[], Vec::as_slice)
    }
}

/// One task.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskScore {
    /// Position of the method in the manifest.
    pub method: usize,
    /// Position of the point MDP among the chosen point MDPs.
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
    /// Wall-clock time, seconds.
    pub wall_s: Option<f64>,
    /// Whether tuning kept what it started from; `None` where nothing was tuned.
    pub kept_start: Option<bool>,
}

/// Returns the point MDPs in the order of the manifest and the tasks in the order of the plan.
pub(super) fn summarise_points(
    results: &Results,
    reference: &Reference,
    measures: &dyn Measures,
) -> (Vec<PointSummary>, Vec<TaskScore>) {
    let identity = &results.manifest.identity;
    let position: HashMap<&str, usize> =
        identity.points.iter().enumerate().map(|(i, p)| (p.point.as_str(), i)).collect();
    let place = |task: &Task| {
        let method = identity.methods.iter().position(|m| *m == task.method);
        let point = position.get(&*task.point).copied();
        method.zip(point).expect("a plan follows from its manifest")
    };
    let places: Vec<(usize, usize)> = results.plan().iter().map(place).collect();
    // By point MDP and method the successful records, replicates in order.
    let mut cells = vec![vec![Vec::new(); identity.methods.len()]; identity.points.len()];
    for ((method, point), (_, record)) in places.iter().zip(results.rows()) {
        cells[*point][*method].extend(record.filter(|r| r.summary.outcome == Outcome::Ok));
    }
    let baseline = identity.methods.iter().position(|m| *m == identity.baseline);
    let objective = identity.objective.as_str();
    let estimator = estimator_of(&identity.sample);
    let of_reference: Vec<BySeed> = cells
        .par_iter()
        .map(|cells| match reference.is_none() {
            true => ones(cells, objective),
            false => mean_by_seed(reference.index.map_or(&[], |method| &cells[method]), objective),
        })
        .collect();
    let draws: HashMap<&str, &Draw> =
        identity.sample.draws.iter().map(|d| (d.point.as_str(), d)).collect();
    let points = identity
        .points
        .par_iter()
        .enumerate()
        .map(|(point, row)| {
            let draw = draws.get(row.point.as_str());
            let achieved: Vec<Option<PointResult>> = (0..identity.methods.len())
                .map(|method| {
                    let cell = &cells[point][method];
                    let own = Some(method) == reference.index;
                    let mut result = summarise_cell(cell, &of_reference[point], objective, own)?;
                    if let (Some(o), Some(draw)) = (&mut result.objectives, draw) {
                        (o.weight, o.draws) = (draw.weight, estimator.draws(draw.count));
                    }
                    Some(result)
                })
                .collect();
            let of_baseline = baseline.and_then(|b| achieved[b].as_ref());
            let regime = of_baseline.and_then(|r| measures.regime(objective, &r.metrics));
            let weight = draw.map_or(0.0, |d| d.weight);
            PointSummary { index: point, row: row.clone(), weight, regime, results: achieved }
        })
        .collect();
    let rows = (0..results.plan().len()).into_par_iter().map(|at| {
        let (task, record) = (&results.plan()[at], results.record(at));
        let (method, point) = places[at];
        let scored = record.and_then(|r| score_of(r, &of_reference[point], objective));
        TaskScore {
            method,
            point,
            replicate: task.replicate,
            outcome: record.map(|r| r.summary.outcome),
            reason: record.and_then(|r| r.summary.reason.clone()),
            metrics: record.map_or_else(Metrics::new, |r| r.summary.metrics.clone()),
            reference: scored.map(|s| s.0).filter(|_| !reference.is_none()),
            score: scored.map(|s| s.1),
            wall_s: record.map(|r| r.summary.wall.wall_s),
            kept_start: (record.filter(|r| r.summary.outcome == Outcome::Ok))
                .map(|r| &r.summary.details)
                .and_then(|details| measures.kept_start(details)),
        }
    });
    let rows = rows.collect();
    (points, rows)
}

fn ones(cells: &[Vec<&Record>], objective: &str) -> BySeed {
    let seeds = cells.iter().flatten().flat_map(|r| by_seed(r, objective)).map(|(seed, _)| seed);
    each_once(seeds.map(|seed| (seed, 1.0)).collect())
}

fn by_seed(record: &Record, objective: &str) -> BySeed {
    let of = |row: &Row| Some((row.seed, *row.metrics.get(objective)?));
    each_once(record.evaluations().filter_map(of).collect())
}

fn each_once(mut values: BySeed) -> BySeed {
    if !values.is_sorted_by(|a, b| a.0 < b.0) {
        values.reverse();
        values.sort_by_key(|v| v.0);
        values.dedup_by_key(|v| v.0);
    }
    values
}

fn value_of(values: &BySeed, seed: u64) -> Option<f64> {
    values.binary_search_by_key(&seed, |v| v.0).ok().map(|at| values[at].1)
}

fn mean_by_seed(records: &[&Record], objective: &str) -> BySeed {
    if let [record] = records {
        return by_seed(record, objective);
    }
    let mut values: BySeed = records.iter().flat_map(|r| by_seed(r, objective)).collect();
    values.sort_by_key(|v| v.0);
    let of_seed = |same: &[(u64, f64)]| {
        let values: Vec<f64> = same.iter().map(|v| v.1).collect();
        Some((same[0].0, mean(&values)?))
    };
    values.chunk_by(|a, b| a.0 == b.0).filter_map(of_seed).collect()
}

fn score_of(record: &Record, reference: &BySeed, objective: &str) -> Option<(f64, f64)> {
    let values = by_seed(record, objective);
    let (method, reference): (Vec<f64>, Vec<f64>) =
        values.iter().filter_map(|(seed, v)| Some((*v, value_of(reference, *seed)?))).unzip();
    Some((mean(&reference)?, crate::stats::score(&method, &reference).ok()?))
}

fn summarise_cell(
    records: &[&Record],
    reference: &BySeed,
    objective: &str,
    is_reference: bool,
) -> Option<PointResult> {
    let values: Vec<f64> =
        records.iter().filter_map(|r| r.summary.metrics.get(objective).copied()).collect();
    let all: Vec<BySeed> = records.iter().map(|r| by_seed(r, objective)).collect();
    let seeds: Vec<u64> = reference
        .iter()
        .map(|v| v.0)
        .filter(|seed| all.iter().all(|own| value_of(own, *seed).is_some()))
        .collect();
    let on_seeds = |values: &BySeed| -> Vec<f64> {
        seeds.iter().filter_map(|seed| value_of(values, *seed)).collect()
    };
    // It is its own measure: 1 by definition, however many replicates it has.
    let replicates: Vec<Vec<f64>> = all.iter().map(on_seeds).collect();
    let (method, replicates) = match is_reference {
        true => (vec![on_seeds(reference)], Some(replicates).filter(|r| r.len() > 1)),
        false => (replicates, None),
    };
    let objectives =
        PointObjectives { weight: 0.0, draws: 1, method, baseline: on_seeds(reference) };
    let score = objectives.score().ok();
    Some(PointResult {
        objective: mean(&values)?,
        metrics: means(records.iter().map(|r| &r.summary.metrics)),
        score,
        objectives: score.map(|_| objectives),
        replicates,
    })
}

#[derive(Debug, Clone)]
pub(super) struct Episode {
    method: usize,
    point: usize,
    objective: Option<f64>,
    /// Objective relative to the reference's on the same seed.
    relative: Option<f64>,
    /// What the domain measures, in the order of [`Measures::shares`].
    shares: Vec<Option<f64>>,
}

/// The evaluation episodes of a method or of one of its trainings. Shares and medians weigh point MDPs
/// as the score does and the episodes of a point MDP equally.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EpisodeSummary {
    /// Number of evaluation episodes.
    pub episodes: usize,
    /// Means of what the domain measures, in the order of [`Measures::shares`]; `None` when some episode
    /// does not say.
    pub shares: Vec<Option<f64>>,
    /// Median of the episodes' objectives.
    pub median: Option<f64>,
    /// Worst objective of an episode.
    pub worst: Option<f64>,
    /// Median of the objective relative to the reference's on the same seed.
    pub median_relative: Option<f64>,
    /// Worst objective relative to the reference's on the same seed.
    pub worst_relative: Option<f64>,
}

/// Returns the evaluation episodes of every task, in the order of the plan.
pub(super) fn episodes(
    results: &Results,
    tasks: &[TaskScore],
    reference: &Reference,
    measures: &dyn Measures,
) -> Vec<Vec<Episode>> {
    let identity = &results.manifest.identity;
    let baseline = identity.methods.iter().position(|m| *m == identity.baseline);
    let rows: Vec<_> = tasks.iter().zip(results.rows().map(|(_, record)| record)).collect();
    // Tasks of one point MDP follow one another.
    let of_point = |rows: &[(&TaskScore, Option<&Record>)]| -> Vec<Vec<Episode>> {
        let by_seed = |method: Option<usize>| {
            let mut found: BTreeMap<u64, Vec<&Metrics>> = BTreeMap::new();
            let own = rows.iter().filter(|(task, _)| Some(task.method) == method);
            for row in own.filter_map(|(_, record)| *record).flat_map(Record::evaluations) {
                found.entry(row.seed).or_default().push(&row.metrics);
            }
            found.into_iter().map(|(seed, all)| (seed, means(all))).collect::<BTreeMap<_, _>>()
        };
        let of_reference = by_seed(reference.index);
        let other = (baseline != reference.index).then(|| by_seed(baseline));
        let of_baseline = other.as_ref().unwrap_or(&of_reference);
        let of_task = |(task, record): &(&TaskScore, Option<&Record>)| {
            let episode = |row: &Row| {
                let objective = row.metrics.get(&identity.objective).copied();
                let unit = of_reference.get(&row.seed).and_then(|m| m.get(&identity.objective));
                let unit = unit.filter(|unit| **unit > 0.0);
                Episode {
                    method: task.method,
                    point: task.point,
                    objective,
                    relative: objective.zip(unit).map(|(value, unit)| value / unit),
                    shares: measures.shares_of(&row.metrics, of_baseline.get(&row.seed)),
                }
            };
            record.iter().flat_map(|record| record.evaluations()).map(episode).collect()
        };
        rows.iter().map(of_task).collect()
    };
    let parts: Vec<_> = rows.chunk_by(|a, b| a.0.point == b.0.point).collect();
    parts.into_par_iter().flat_map_iter(of_point).collect()
}

impl EpisodeSummary {
    /// Summarises evaluation episodes of a method; point MDPs without a weight do not count.
    pub(super) fn of_method(
        evidence: Evidence<'_>,
        method: usize,
        weights: &HashMap<usize, f64>,
    ) -> Self {
        let all = evidence.episodes.iter().flatten();
        Self::of(evidence, all.filter(|episode| episode.method == method), weights)
    }

    /// Summarises evaluation episodes; point MDPs without a weight do not count.
    pub(super) fn of<'a>(
        evidence: Evidence<'_>,
        episodes: impl IntoIterator<Item = &'a Episode>,
        weights: &HashMap<usize, f64>,
    ) -> Self {
        let direction = evidence.identity.direction;
        let counted: Vec<&Episode> =
            episodes.into_iter().filter(|e| weights.contains_key(&e.point)).collect();
        let mut per_point: HashMap<usize, f64> = HashMap::new();
        for e in &counted {
            *per_point.entry(e.point).or_insert(0.0) += 1.0;
        }
        let weighted = |value: &dyn Fn(&Episode) -> Option<f64>| -> Option<Vec<(f64, f64)>> {
            let weight = |e: &Episode| weights[&e.point] / per_point[&e.point];
            counted.iter().map(|e| Some((weight(e), value(e)?))).collect()
        };
        let worst = |pairs: &[(f64, f64)]| direction.worst(pairs.iter().map(|p| p.1));
        let objectives = weighted(&|e| e.objective).unwrap_or_default();
        let relative = weighted(&|e| e.relative).unwrap_or_default();
        let share = |i: usize| weighted(&|e| e.shares[i]).and_then(weighted_mean);
        Self {
            episodes: counted.len(),
            shares: (0..evidence.measures.shares().len()).map(share).collect(),
            median: weighted_median(objectives.iter().copied()),
            worst: worst(&objectives),
            median_relative: weighted_median(relative.iter().copied()),
            worst_relative: worst(&relative),
        }
    }
}

/// What methods are summarised from; all of a run, or the part of it that some methods have in common.
#[derive(Clone, Copy)]
pub(super) struct Evidence<'a> {
    pub(super) identity: &'a Identity,
    pub(super) reference: &'a Reference,
    pub(super) measures: &'a dyn Measures,
    /// The point MDPs that count.
    pub(super) points: &'a [PointSummary],
    /// How these came to be in the sample, in their order.
    pub(super) chosen: &'a [Chosen],
    /// The tasks that count.
    pub(super) tasks: &'a [TaskScore],
    /// All evaluation episodes, by task.
    pub(super) episodes: &'a [Vec<Episode>],
    /// The most that a score can be; infinite where that is not known.
    pub(super) most: f64,
    /// Of every method, whether it learned, once on each point MDP.
    pub(super) learned_once: &'a [bool],
    /// What is known of the whole family.
    pub(super) design: Option<&'a Design>,
}

impl<'a> Evidence<'a> {
    /// Returns what says how alike point MDPs are, for the estimator that takes it.
    pub(super) fn given(&self) -> Option<&'a Design> {
        self.design.filter(|_| self.identity.sample.sampling == Sampling::BayesianQuadrature)
    }
}
