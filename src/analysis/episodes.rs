//! Every episode of a run, and what the evaluation episodes of a method have in common: how far they
//! lie apart, and the shares that the domain measures.

use std::collections::{BTreeMap, HashMap};

use super::measures::Measures;
use super::reference::Reference;
use crate::stats::Direction;
use crate::stats::score::{mean, weighted_mean};
use crate::stats::summary::weighted_median;
use crate::store::record::{Metrics, Record, Row, RowKind};
use crate::store::results::Results;

/// One episode.
#[derive(Debug, Clone, PartialEq)]
pub struct Episode {
    /// Position of the method in the manifest.
    pub method: usize,
    /// Position of the point MDP among the chosen ones.
    pub point: usize,
    /// Which of several independent trainings.
    pub replicate: u32,
    /// What the episode was for.
    pub kind: RowKind,
    /// Number within its kind, from 0.
    pub episode: u32,
    /// Seed of the episode.
    pub seed: u64,
    /// What was measured.
    pub metrics: Metrics,
    /// Objective relative to the reference's on the same seed; of evaluations only.
    pub relative: Option<f64>,
    /// What the domain measures of an evaluation, in the order of [`Measures::shares`].
    pub shares: Vec<Option<f64>>,
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

/// Means of the episodes by point MDP and seed.
type BySeed = BTreeMap<(usize, u64), Metrics>;

/// What an episode is compared with: the same point MDP and seed under other methods.
struct Compared<'a> {
    objective: &'a str,
    measures: &'a dyn Measures,
    reference: BySeed,
    baseline: BySeed,
}

/// Returns the episodes of all records, in the order of the plan.
pub(super) fn episodes(
    results: &Results,
    reference: &Reference,
    measures: &dyn Measures,
) -> Vec<Episode> {
    let identity = &results.manifest.identity;
    let points: HashMap<&str, usize> =
        identity.points.iter().enumerate().map(|(i, p)| (p.point.as_str(), i)).collect();
    let by_seed = |method: &str| -> BySeed {
        let records = results.records.values().filter(|r| r.summary.method == method);
        let mut found: BTreeMap<(usize, u64), Vec<&Metrics>> = BTreeMap::new();
        for record in records {
            let Some(point) = points.get(record.summary.point.as_str()) else { continue };
            for row in record.evaluations() {
                found.entry((*point, row.seed)).or_default().push(&row.metrics);
            }
        }
        found.into_iter().map(|(key, all)| (key, mean_metrics(&all))).collect()
    };
    let compared = Compared {
        objective: &identity.objective,
        measures,
        reference: by_seed(&reference.name),
        baseline: by_seed(&identity.baseline),
    };
    let mut episodes = Vec::new();
    for task in &results.plan {
        let method = identity.methods.iter().position(|m| *m == task.method);
        let (Some(method), Some(point), Some(record)) =
            (method, points.get(task.point.as_str()), results.records.get(&task.task))
        else {
            continue;
        };
        let new = |row| episode(record, row, &compared, (method, *point));
        episodes.extend(record.rows.iter().map(new));
    }
    episodes
}

/// Returns the mean of every metric over the episodes that have it.
fn mean_metrics(episodes: &[&Metrics]) -> Metrics {
    let mut values: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for (name, value) in episodes.iter().copied().flatten() {
        values.entry(name).or_default().push(*value);
    }
    values.into_iter().filter_map(|(name, v)| Some((name.to_owned(), mean(&v)?))).collect()
}

fn episode(
    record: &Record,
    row: &Row,
    compared: &Compared<'_>,
    (method, point): (usize, usize),
) -> Episode {
    let (key, evaluated) = ((point, row.seed), row.kind == RowKind::Evaluation);
    let unit = compared.reference.get(&key).and_then(|m| m.get(compared.objective));
    let unit = unit.filter(|unit| evaluated && **unit > 0.0);
    let shares = match evaluated {
        true => compared.measures.shares_of(&row.metrics, compared.baseline.get(&key)),
        false => Vec::new(),
    };
    Episode {
        method,
        point,
        replicate: record.summary.replicate,
        kind: row.kind,
        episode: row.episode,
        seed: row.seed,
        relative: unit.and_then(|unit| Some(row.metrics.get(compared.objective)? / unit)),
        shares,
        metrics: row.metrics.clone(),
    }
}

impl EpisodeSummary {
    /// Summarises evaluation episodes; point MDPs without a weight do not count.
    ///
    /// # Arguments
    ///
    /// * `weights` — of point MDPs, by [`Episode::point`].
    /// * `shares` — how many the domain measures.
    pub(super) fn of<'a>(
        episodes: impl IntoIterator<Item = &'a Episode>,
        weights: &HashMap<usize, f64>,
        (objective, direction): (&str, Direction),
        shares: usize,
    ) -> Self {
        let counted: Vec<&Episode> = episodes
            .into_iter()
            .filter(|e| e.kind == RowKind::Evaluation && weights.contains_key(&e.point))
            .collect();
        let mut per_point: HashMap<usize, f64> = HashMap::new();
        for episode in &counted {
            *per_point.entry(episode.point).or_insert(0.0) += 1.0;
        }
        let weighted = |value: &dyn Fn(&Episode) -> Option<f64>| -> Option<Vec<(f64, f64)>> {
            let pair = |e: &&Episode| Some((weights[&e.point] / per_point[&e.point], value(e)?));
            counted.iter().map(pair).collect()
        };
        let known = |value: &dyn Fn(&Episode) -> Option<f64>| weighted(value).unwrap_or_default();
        let worst = |pairs: &[(f64, f64)]| direction.worst(pairs.iter().map(|p| p.1));
        let objectives = known(&|e| e.metrics.get(objective).copied());
        let relative = known(&|e| e.relative);
        let share = |i: usize| weighted(&|e| *e.shares.get(i)?).and_then(weighted_mean);
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
