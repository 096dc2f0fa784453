//! What every method achieved on every point MDP: replicates averaged, seeds paired with those of
//! what scores are divided by.

use std::collections::HashMap;
use std::fmt;
use std::ops::Deref;
use std::sync::Arc;

use rayon::prelude::*;

use super::estimator::estimator_of;
use super::measures::Measures;
use super::reference::Reference;
use crate::sample::Draw;
use crate::stats::PointObjectives;
use crate::stats::score::mean;
use crate::store::kept::Kept;
use crate::store::manifest::{Manifest, PointRow};
use crate::store::record::{Metrics, Outcome};
use crate::store::results::Results;

/// Objective by evaluation seed, each once and in order.
type BySeed = Vec<(u64, f64)>;

/// One point MDP under all methods.
#[derive(Debug, Clone, PartialEq)]
pub struct PointSummary {
    /// Position among the chosen point MDPs.
    pub index: usize,
    /// The point MDP.
    pub row: RowOf,
    /// Weight of its scores in the estimates.
    pub weight: f64,
    /// Position of its regime in [`Measures::regimes`], by what the baseline achieves there, whatever
    /// scores are divided by; `None` when that is not known.
    pub regime: Option<usize>,
    /// What each method achieved, in the order of the manifest; `None` without a record.
    pub results: Vec<Option<PointResult>>,
}

/// A point MDP as its manifest keeps it, which nobody copies: of a large family that is a tenth of the memory.
#[derive(Clone)]
pub struct RowOf {
    manifest: Arc<Manifest>,
    index: usize,
}

impl Deref for RowOf {
    type Target = PointRow;

    fn deref(&self) -> &PointRow {
        &self.manifest.identity.points[self.index]
    }
}

impl fmt::Debug for RowOf {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (**self).fmt(f)
    }
}

impl PartialEq for RowOf {
    fn eq(&self, other: &Self) -> bool {
        **self == **other
    }
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
    /// Position of the method in the manifest.
    pub method: usize,
    /// Position of the point MDP among the chosen point MDPs.
    pub point: usize,
    /// Which of several independent trainings.
    pub replicate: u32,
    /// How the task ended; `None` when it has no record.
    pub outcome: Option<Outcome>,
    /// Why it failed.
    pub reason: Option<Box<str>>,
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
    let manifest = &results.manifest;
    let identity = &manifest.identity;
    let position: HashMap<&str, usize> =
        identity.points.iter().enumerate().map(|(i, p)| (p.point.as_str(), i)).collect();
    let cells = Cells::of(results, &position);
    let baseline = identity.methods.iter().position(|m| *m == identity.baseline);
    let objective = identity.objective.as_str();
    let estimator = estimator_of(&identity.sample);
    let of_reference: Vec<BySeed> = (0..identity.points.len())
        .into_par_iter()
        .map(|point| match reference.is_none() {
            true => ones(&cells, (identity.methods.len(), point), objective),
            false => {
                let cell = reference.index.map(|method| cells.records(method, point));
                mean_by_seed(&cell.unwrap_or_default(), objective)
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
            let achieved: Vec<Option<PointResult>> = (0..identity.methods.len())
                .map(|method| {
                    let cell = cells.records(method, point);
                    let own = Some(method) == reference.index;
                    let mut result = summarise_cell(&cell, &of_reference[point], objective, own)?;
                    if let (Some(o), Some(draw)) = (&mut result.objectives, draw) {
                        (o.weight, o.draws) = (draw.weight, estimator.draws(draw.count));
                    }
                    Some(result)
                })
                .collect();
            let of_baseline = baseline.and_then(|b| achieved[b].as_ref());
            let regime = of_baseline.and_then(|r| measures.regime(objective, &r.metrics));
            let weight = draw.map_or(0.0, |d| d.weight);
            let row = RowOf { manifest: manifest.clone(), index: point };
            PointSummary { index: point, row, weight, regime, results: achieved }
        })
        .collect();
    let rows = (0..results.plan().len()).into_par_iter().map(|at| {
        let (task, record) = (&results.plan()[at], results.record(at));
        let (method, point) = cells.place[at];
        let scored = record.and_then(|r| score_of(r, &of_reference[point], objective));
        TaskScore {
            method,
            point,
            replicate: task.replicate,
            outcome: record.map(|r| r.outcome),
            reason: record.and_then(|r| r.reason()).map(Box::from),
            metrics: record.map_or_else(Metrics::new, |r| r.metrics.clone()),
            reference: scored.map(|s| s.0).filter(|_| !reference.is_none()),
            score: scored.map(|s| s.1),
            wall_s: record.map(|r| r.wall_s),
            kept_start: (record.filter(|r| r.outcome == Outcome::Ok))
                .and_then(Kept::details)
                .and_then(|details| measures.kept_start(details)),
        }
    });
    let rows = rows.collect();
    (points, rows)
}

/// Which tasks are of a method and a point MDP.
struct Cells<'a> {
    results: &'a Results,
    methods: usize,
    /// Method and point MDP of every task.
    place: Vec<(usize, usize)>,
    /// Where the tasks of every cell begin in [`Self::tasks`], point MDP by point MDP.
    begin: Vec<u32>,
    /// Positions of tasks in the plan, cell by cell.
    tasks: Vec<u32>,
}

impl<'a> Cells<'a> {
    fn of(results: &'a Results, position: &HashMap<&str, usize>) -> Self {
        let identity = &results.manifest.identity;
        let methods = identity.methods.len();
        let of_method = |name: &str| identity.methods.iter().position(|m| *m == *name);
        let place = results.plan().iter().map(|task| {
            let point = position.get(&*task.point).copied();
            of_method(&task.method).zip(point).expect("a plan follows from its manifest")
        });
        let place: Vec<(usize, usize)> = place.collect();
        let mut begin = vec![0; identity.points.len() * methods + 1];
        let cell = |(method, point): (usize, usize)| point * methods + method;
        place.iter().for_each(|at| begin[cell(*at) + 1] += 1);
        for i in 1..begin.len() {
            begin[i] += begin[i - 1];
        }
        let mut next = begin.clone();
        let mut tasks = vec![0; place.len()];
        for (task, at) in place.iter().enumerate() {
            let next = &mut next[cell(*at)];
            tasks[*next as usize] = task as u32;
            *next += 1;
        }
        Self { results, methods, place, begin, tasks }
    }

    /// Returns the successful records of a method on a point MDP, replicates in order.
    fn records(&self, method: usize, point: usize) -> Vec<&'a Kept> {
        let cell = point * self.methods + method;
        let tasks = &self.tasks[self.begin[cell] as usize..self.begin[cell + 1] as usize];
        let records = tasks.iter().filter_map(|task| self.results.record(*task as usize));
        records.filter(|record| record.outcome == Outcome::Ok).collect()
    }
}

/// Returns 1 for every seed that some method has on a point MDP: dividing by it leaves the objective.
fn ones(cells: &Cells<'_>, (methods, point): (usize, usize), objective: &str) -> BySeed {
    let here = (0..methods).flat_map(|method| cells.records(method, point));
    let seeds = here.flat_map(|r| by_seed(r, objective)).map(|(seed, _)| seed);
    each_once(seeds.map(|seed| (seed, 1.0)).collect())
}

fn by_seed(record: &Kept, objective: &str) -> BySeed {
    let rows = &record.evaluations;
    let pairs = rows.seeds().iter().zip(rows.values(objective));
    each_once(pairs.filter_map(|(seed, value)| Some((*seed, value?))).collect())
}

/// Returns what is in no order by seed; of several of one seed the last.
fn each_once(mut values: BySeed) -> BySeed {
    if !values.is_sorted_by(|a, b| a.0 < b.0) {
        values.reverse();
        values.sort_by_key(|v| v.0);
        values.dedup_by_key(|v| v.0);
    }
    values
}

/// Returns the value of a seed.
fn value_of(values: &BySeed, seed: u64) -> Option<f64> {
    values.binary_search_by_key(&seed, |v| v.0).ok().map(|at| values[at].1)
}

/// Returns the objective per seed, averaged over the records that have the seed.
fn mean_by_seed(records: &[&Kept], objective: &str) -> BySeed {
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

/// Returns the reference's mean and the score of one record on the seeds that both have.
fn score_of(record: &Kept, reference: &BySeed, objective: &str) -> Option<(f64, f64)> {
    let values = by_seed(record, objective);
    let (method, reference): (Vec<f64>, Vec<f64>) =
        values.iter().filter_map(|(seed, v)| Some((*v, value_of(reference, *seed)?))).unzip();
    Some((mean(&reference)?, crate::stats::score(&method, &reference).ok()?))
}

fn summarise_cell(
    records: &[&Kept],
    reference: &BySeed,
    objective: &str,
    is_reference: bool,
) -> Option<PointResult> {
    let values: Vec<f64> =
        records.iter().filter_map(|r| r.metrics.get(objective).copied()).collect();
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

fn mean_metrics(records: &[&Kept]) -> Metrics {
    let Some(first) = records.first() else { return Metrics::new() };
    if records.len() == 1 {
        return first.metrics.clone();
    }
    let value = |name: &String| {
        let values: Option<Vec<f64>> =
            records.iter().map(|r| r.metrics.get(name).copied()).collect();
        Some((name.clone(), mean(&values?)?))
    };
    first.metrics.keys().filter_map(value).collect()
}
