//! Every episode of a run, and what the evaluation episodes of a method have in common: how far they
//! lie apart, how many vehicles had not arrived at the end, and how many episodes ended in gridlock.
//!
//! An evaluation episode ends in **gridlock** when the share of its vehicles that never entered or had
//! not arrived
//! - exceeds the baseline's on the same point MDP and seed by more than 5 percentage points, or
//! - is above one half, whatever the baseline's is: where the baseline itself is oversaturated, there
//!   is no room for more.
//!
//! The first threshold is from the 163 point MDPs of Salt Lake City with five seeds: tuned fixed time
//! is never more than 0.9 points above the baseline, actuated control in 98.4% of its episodes less
//! than 2 (the others are beyond capacity under both), and max pressure has no episode between 2.3 and
//! 9.5. Every episode with three times the baseline's delay is beyond 17. By Little's law an excess of 5 points at the end of an hour is a queue that grew by a
//! twentieth of the demand, which delays the mean vehicle by a minute and a half more.

use std::collections::BTreeMap;

use super::points::PointSummary;
use super::reference::Reference;
use crate::stats::score::{mean, weighted_mean};
use crate::stats::summary::weighted_median;
use crate::store::record::{Metrics, Record, Row, RowKind};
use crate::store::results::Results;

/// Share of the vehicles, above the baseline's on the same seed, from which on an episode ends in
/// gridlock; the module says why.
pub(super) const GRIDLOCK_EXCESS: f64 = 0.05;

/// Share of the vehicles above which an episode ends in gridlock whatever the baseline does: more of
/// them are left than have arrived.
pub(super) const GRIDLOCK_SHARE: f64 = 0.5;

/// One episode.
#[derive(Debug, Clone, PartialEq)]
pub struct Episode {
    /// Position of the method in the manifest.
    pub method: usize,
    /// Position of the point MDP in [`super::ReportData::points`].
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
    /// Share of the vehicles that never entered or had not arrived.
    pub unfinished: Option<f64>,
    /// Whether it ended in gridlock; of evaluations only, `None` when that is not known.
    pub gridlocked: Option<bool>,
}

/// The evaluation episodes of a method or of one of its trainings. Shares and medians weigh point MDPs
/// as the score does and the episodes of a point MDP equally.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EpisodeSummary {
    /// Number of evaluation episodes.
    pub episodes: usize,
    /// Share of the episodes that ended in gridlock; `None` when that is not known of some.
    pub gridlocked: Option<f64>,
    /// Share of the vehicles that never entered or had not arrived; `None` when some episode does not
    /// say.
    pub unfinished: Option<f64>,
    /// Median of the episodes' objectives.
    pub median: Option<f64>,
    /// Largest objective of an episode.
    pub worst: Option<f64>,
    /// Median of the objective relative to the reference's on the same seed.
    pub median_relative: Option<f64>,
    /// Largest objective relative to the reference's on the same seed.
    pub worst_relative: Option<f64>,
}

/// Objectives and shares by point MDP and seed.
type BySeed = BTreeMap<(usize, u64), f64>;

/// Returns the episodes of all records, in the order of the plan.
pub(super) fn episodes(results: &Results, reference: &Reference) -> Vec<Episode> {
    let identity = &results.manifest.identity;
    let objective = identity.objective.as_str();
    let points: BTreeMap<&str, usize> =
        identity.points.iter().enumerate().map(|(i, p)| (p.point.as_str(), i)).collect();
    let by_seed = |method: &str, value: &dyn Fn(&Metrics) -> Option<f64>| -> BySeed {
        let records = results.records.values().filter(|r| r.summary.method == method);
        let mut values: BTreeMap<(usize, u64), Vec<f64>> = BTreeMap::new();
        for record in records {
            let Some(point) = points.get(record.summary.point.as_str()) else { continue };
            for row in record.evaluations() {
                if let Some(value) = value(&row.metrics) {
                    values.entry((*point, row.seed)).or_default().push(value);
                }
            }
        }
        values.into_iter().filter_map(|(key, values)| Some((key, mean(&values)?))).collect()
    };
    let of_reference = by_seed(&reference.name, &|m| m.get(objective).copied());
    let left = by_seed(&identity.baseline, &unfinished);
    let mut episodes = Vec::new();
    for task in &results.plan {
        let method = identity.methods.iter().position(|m| *m == task.method);
        let (Some(method), Some(point), Some(record)) =
            (method, points.get(task.point.as_str()), results.records.get(&task.task))
        else {
            continue;
        };
        let new = |row| episode(record, row, objective, &of_reference, &left, (method, *point));
        episodes.extend(record.rows.iter().map(new));
    }
    episodes
}

fn episode(
    record: &Record,
    row: &Row,
    objective: &str,
    of_reference: &BySeed,
    left: &BySeed,
    (method, point): (usize, usize),
) -> Episode {
    let share = unfinished(&row.metrics);
    let (key, evaluated) = ((point, row.seed), row.kind == RowKind::Evaluation);
    let unit = of_reference.get(&key).filter(|unit| evaluated && **unit > 0.0);
    Episode {
        method,
        point,
        replicate: record.summary.replicate,
        kind: row.kind,
        episode: row.episode,
        seed: row.seed,
        relative: unit.and_then(|unit| Some(row.metrics.get(objective)? / unit)),
        unfinished: share,
        gridlocked: share
            .filter(|_| evaluated)
            .and_then(|share| gridlocked(share, left.get(&key).copied())),
        metrics: row.metrics.clone(),
    }
}

/// Returns the share of the vehicles that never entered or had not arrived; `None` when it was not
/// recorded or there were no vehicles.
fn unfinished(metrics: &Metrics) -> Option<f64> {
    let vehicles = metrics.get("vehicles_veh").filter(|n| **n > 0.0)?;
    Some(metrics.get("unfinished_veh")? / vehicles)
}

/// Returns whether an episode with this share of unfinished vehicles ended in gridlock; `None` when
/// that depends on a share of the baseline that is not known.
fn gridlocked(share: f64, of_baseline: Option<f64>) -> Option<bool> {
    match of_baseline {
        _ if share > GRIDLOCK_SHARE => Some(true),
        Some(of_baseline) => Some(share - of_baseline > GRIDLOCK_EXCESS),
        None => None,
    }
}

impl EpisodeSummary {
    /// Summarises evaluation episodes; point MDPs that are not among `points` do not count.
    pub(super) fn of<'a>(
        episodes: impl IntoIterator<Item = &'a Episode>,
        points: &[PointSummary],
        objective: &str,
    ) -> Self {
        let weights: BTreeMap<usize, f64> = points.iter().map(|p| (p.index, p.weight)).collect();
        let counted: Vec<&Episode> = episodes
            .into_iter()
            .filter(|e| e.kind == RowKind::Evaluation && weights.contains_key(&e.point))
            .collect();
        let mut per_point: BTreeMap<usize, f64> = BTreeMap::new();
        for episode in &counted {
            *per_point.entry(episode.point).or_insert(0.0) += 1.0;
        }
        let weighted = |value: &dyn Fn(&Episode) -> Option<f64>| -> Option<Vec<(f64, f64)>> {
            let pair = |e: &&Episode| Some((weights[&e.point] / per_point[&e.point], value(e)?));
            counted.iter().map(pair).collect()
        };
        let known = |value: &dyn Fn(&Episode) -> Option<f64>| weighted(value).unwrap_or_default();
        let worst = |pairs: &[(f64, f64)]| pairs.iter().map(|p| p.1).reduce(f64::max);
        let seconds = known(&|e| e.metrics.get(objective).copied());
        let relative = known(&|e| e.relative);
        let stuck = weighted(&|e| e.gridlocked.map(|g| if g { 1.0 } else { 0.0 }));
        Self {
            episodes: counted.len(),
            gridlocked: stuck.and_then(weighted_mean),
            unfinished: weighted(&|e| e.unfinished).and_then(weighted_mean),
            median: weighted_median(seconds.iter().copied()),
            worst: worst(&seconds),
            median_relative: weighted_median(relative.iter().copied()),
            worst_relative: worst(&relative),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_points_more_than_under_the_baseline_are_a_gridlock() {
        assert_eq!(gridlocked(0.09, Some(0.02)), Some(true));
        assert_eq!(gridlocked(0.06, Some(0.02)), Some(false));
    }

    #[test]
    fn where_the_baseline_is_oversaturated_more_than_half_is_a_gridlock() {
        assert_eq!(gridlocked(0.55, Some(0.60)), Some(true));
        assert_eq!(gridlocked(0.45, Some(0.60)), Some(false));
    }

    #[test]
    fn without_the_baseline_s_share_only_the_absolute_rule_decides() {
        assert_eq!(gridlocked(0.6, None), Some(true));
        assert_eq!(gridlocked(0.3, None), None);
    }

    #[test]
    fn a_record_that_does_not_say_how_many_vehicles_there_were_has_no_share() {
        let named = |pairs: &[(&str, f64)]| -> Metrics {
            pairs.iter().map(|(n, v)| ((*n).to_owned(), *v)).collect()
        };
        assert_eq!(unfinished(&named(&[("unfinished_veh", 3.0)])), None);
        assert_eq!(unfinished(&named(&[("vehicles_veh", 30.0)])), None);
        assert_eq!(unfinished(&named(&[("vehicles_veh", 0.0), ("unfinished_veh", 0.0)])), None);
        assert_eq!(
            unfinished(&named(&[("vehicles_veh", 30.0), ("unfinished_veh", 3.0)])),
            Some(0.1)
        );
    }
}
