//! The evaluation episodes of a run, and what those of a method have in common: how far they lie apart, and the shares
//! that the domain measures.

use std::collections::{BTreeMap, HashMap};

use rayon::prelude::*;

use super::measures::Measures;
use super::reference::Reference;
use crate::stats::Direction;
use crate::stats::score::weighted_mean;
use crate::stats::summary::weighted_median;
use crate::store::manifest::Task;
use crate::store::record::{Metrics, Record, Row, means};
use crate::store::results::Results;

/// One evaluation episode.
#[derive(Debug, Clone)]
pub(super) struct Episode {
    /// Position of the method in the manifest.
    method: usize,
    /// Position of the point MDP among the chosen ones.
    point: usize,
    objective: Option<f64>,
    /// Objective relative to the reference's on the same seed.
    relative: Option<f64>,
    /// What the domain measures, in the order of [`Measures::shares`].
    shares: Vec<Option<f64>>,
}

/// All evaluation episodes.
#[derive(Debug, Clone, Default)]
pub(super) struct Episodes {
    /// How many shares the domain measures.
    pub(super) shares: usize,
    /// Those of every task, in the order of the plan.
    pub(super) of_task: Vec<Vec<Episode>>,
}

impl Episodes {
    /// Returns a method's episodes, in the order of the plan.
    pub(super) fn of_method(&self, method: usize) -> impl Iterator<Item = &Episode> {
        self.of_task.iter().flatten().filter(move |episode| episode.method == method)
    }
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

/// Means of the episodes of a method by seed, on one point MDP.
type BySeed = BTreeMap<u64, Metrics>;

/// A task with its record.
type Done<'a> = (&'a Task, Option<&'a Record>);

/// Returns the evaluation episodes of all records.
pub(super) fn episodes(
    results: &Results,
    reference: &Reference,
    measures: &dyn Measures,
) -> Episodes {
    let identity = &results.manifest.identity;
    let points: HashMap<&str, usize> =
        identity.points.iter().enumerate().map(|(i, p)| (p.point.as_str(), i)).collect();
    let rows: Vec<Done<'_>> = results.rows().collect();
    // Tasks of one point MDP follow one another.
    let of_point = |rows: &[Done<'_>]| -> Vec<Vec<Episode>> {
        let point = points.get(rows[0].0.point.as_str()).copied().unwrap_or_default();
        let of_reference = by_seed(rows, &reference.name);
        let other =
            (identity.baseline != reference.name).then(|| by_seed(rows, &identity.baseline));
        let of_baseline = other.as_ref().unwrap_or(&of_reference);
        let of_task = |&(task, record): &Done<'_>| {
            let method = identity.methods.iter().position(|m| *m == task.method);
            let method = method.expect("a plan follows from its manifest");
            let episode = |row: &Row| {
                let objective = row.metrics.get(&identity.objective).copied();
                let unit = of_reference.get(&row.seed).and_then(|m| m.get(&identity.objective));
                let unit = unit.filter(|unit| **unit > 0.0);
                Episode {
                    method,
                    point,
                    objective,
                    relative: objective.zip(unit).map(|(value, unit)| value / unit),
                    shares: measures.shares_of(&row.metrics, of_baseline.get(&row.seed)),
                }
            };
            record.into_iter().flat_map(Record::evaluations).map(episode).collect()
        };
        rows.iter().map(of_task).collect()
    };
    let parts: Vec<&[Done<'_>]> = rows.chunk_by(|a, b| a.0.point == b.0.point).collect();
    let of_task = parts.into_par_iter().flat_map_iter(of_point).collect();
    Episodes { shares: measures.shares().len(), of_task }
}

fn by_seed(rows: &[Done<'_>], method: &str) -> BySeed {
    let mut found: BTreeMap<u64, Vec<&Metrics>> = BTreeMap::new();
    let own = rows.iter().filter(|(task, _)| task.method == *method);
    for row in own.filter_map(|(_, record)| *record).flat_map(Record::evaluations) {
        found.entry(row.seed).or_default().push(&row.metrics);
    }
    found.into_iter().map(|(seed, all)| (seed, means(all))).collect()
}

impl EpisodeSummary {
    /// Summarises evaluation episodes; point MDPs without a weight do not count.
    pub(super) fn of<'a>(
        episodes: impl IntoIterator<Item = &'a Episode>,
        shares: usize,
        weights: &HashMap<usize, f64>,
        direction: Direction,
    ) -> Self {
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
            shares: (0..shares).map(share).collect(),
            median: weighted_median(objectives.iter().copied()),
            worst: worst(&objectives),
            median_relative: weighted_median(relative.iter().copied()),
            worst_relative: worst(&relative),
        }
    }
}
