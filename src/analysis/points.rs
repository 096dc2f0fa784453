//! What every method achieved on every point MDP: replicates averaged, seeds paired with those of
//! what scores are divided by.

use std::collections::{BTreeMap, HashMap};

use rayon::prelude::*;

use super::estimator::estimator_of;
use super::measures::Measures;
use super::reference::Reference;
use crate::sample::Draw;
use crate::stats::PointObjectives;
use crate::stats::score::mean;
use crate::store::manifest::PointRow;
use crate::store::record::{Metrics, Outcome, Record};
use crate::store::results::Results;

/// Objective by evaluation seed.
type BySeed = BTreeMap<u64, f64>;

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
}

/// One task.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskScore {
    /// Name of the method.
    pub method: String,
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
    let records = records_by_cell(results, &position);
    let baseline = identity.methods.iter().position(|m| *m == identity.baseline);
    let objective = identity.objective.as_str();
    let estimator = estimator_of(&identity.sample);
    let of_reference: Vec<BySeed> = (0..identity.points.len())
        .into_par_iter()
        .map(|point| match reference.is_none() {
            true => ones(&records, (identity.methods.len(), point), objective),
            false => {
                let cell = reference.index.and_then(|method| records.get(&(method, point)));
                mean_by_seed(cell.map_or(&[][..], Vec::as_slice), objective)
            }
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
            let results: Vec<Option<PointResult>> = (0..identity.methods.len())
                .map(|method| {
                    let cell = records.get(&(method, point))?;
                    let own = Some(method) == reference.index;
                    let mut result = summarise_cell(cell, &of_reference[point], objective, own)?;
                    if let (Some(o), Some(draw)) = (&mut result.objectives, draw) {
                        (o.weight, o.draws) = (draw.weight, estimator.draws(draw.count));
                    }
                    Some(result)
                })
                .collect();
            let of_baseline = baseline.and_then(|b| results[b].as_ref());
            let regime = of_baseline.and_then(|r| measures.regime(objective, &r.metrics));
            let weight = draw.map_or(0.0, |d| d.weight);
            PointSummary { index: point, row: row.clone(), weight, regime, results }
        })
        .collect();
    let rows = results
        .plan
        .par_iter()
        .filter_map(|task| {
            let point = *position.get(task.point.as_str())?;
            let record = results.records.get(&task.task);
            let summary = record.map(|r| &r.summary);
            let scored = record.and_then(|r| score_of(r, &of_reference[point], objective));
            Some(TaskScore {
                method: task.method.clone(),
                point,
                replicate: task.replicate,
                outcome: summary.map(|s| s.outcome),
                reason: summary.and_then(|s| s.reason.clone()),
                metrics: summary.map_or_else(Metrics::new, |s| s.metrics.clone()),
                reference: scored.map(|s| s.0).filter(|_| !reference.is_none()),
                score: scored.map(|s| s.1),
                wall_s: summary.map(|s| s.wall.wall_s),
            })
        })
        .collect();
    (points, rows)
}

/// Returns the successful records by position of method and point MDP, replicates in order.
fn records_by_cell<'a>(
    results: &'a Results,
    position: &HashMap<&str, usize>,
) -> BTreeMap<(usize, usize), Vec<&'a Record>> {
    let methods = &results.manifest.identity.methods;
    let mut cells: BTreeMap<(usize, usize), Vec<&Record>> = BTreeMap::new();
    for record in results.records.values() {
        let s = &record.summary;
        let method = methods.iter().position(|m| *m == s.method);
        let point = position.get(s.point.as_str());
        if let (Outcome::Ok, Some(method), Some(point)) = (s.outcome, method, point) {
            cells.entry((method, *point)).or_default().push(record);
        }
    }
    cells
}

/// Returns 1 for every seed that some method has on a point MDP: dividing by it leaves the objective.
fn ones(
    records: &BTreeMap<(usize, usize), Vec<&Record>>,
    (methods, point): (usize, usize),
    objective: &str,
) -> BySeed {
    let here = (0..methods).filter_map(|method| records.get(&(method, point)));
    let seeds = here.flatten().flat_map(|r| by_seed(r, objective).into_keys());
    seeds.map(|seed| (seed, 1.0)).collect()
}

fn by_seed(record: &Record, objective: &str) -> BySeed {
    record.evaluations().filter_map(|r| Some((r.seed, *r.metrics.get(objective)?))).collect()
}

/// Returns the objective per seed, averaged over the records that have the seed.
fn mean_by_seed(records: &[&Record], objective: &str) -> BySeed {
    let mut values: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for record in records {
        for (seed, value) in by_seed(record, objective) {
            values.entry(seed).or_default().push(value);
        }
    }
    values.into_iter().filter_map(|(seed, v)| Some((seed, mean(&v)?))).collect()
}

/// Returns the reference's mean and the score of one record on the seeds that both have.
fn score_of(record: &Record, reference: &BySeed, objective: &str) -> Option<(f64, f64)> {
    let values = by_seed(record, objective);
    let (method, reference): (Vec<f64>, Vec<f64>) =
        values.iter().filter_map(|(seed, v)| Some((*v, *reference.get(seed)?))).unzip();
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
        .keys()
        .copied()
        .filter(|seed| all.iter().all(|own| own.contains_key(seed)))
        .collect();
    let on_seeds = |values: &BySeed| seeds.iter().map(|s| values[s]).collect::<Vec<f64>>();
    // It is its own measure: 1 by definition, however many replicates it has.
    let method = match is_reference {
        true => vec![on_seeds(reference)],
        false => all.iter().map(on_seeds).collect(),
    };
    let objectives =
        PointObjectives { weight: 0.0, draws: 1, method, baseline: on_seeds(reference) };
    let score = objectives.score().ok();
    Some(PointResult {
        objective: mean(&values)?,
        metrics: mean_metrics(records),
        score,
        objectives: score.map(|_| objectives),
    })
}

fn mean_metrics(records: &[&Record]) -> Metrics {
    let Some(first) = records.first() else { return Metrics::new() };
    let value = |name: &String| {
        let values: Option<Vec<f64>> =
            records.iter().map(|r| r.summary.metrics.get(name).copied()).collect();
        Some((name.clone(), mean(&values?)?))
    };
    first.summary.metrics.keys().filter_map(value).collect()
}
