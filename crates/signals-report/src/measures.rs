//! What is measured of traffic beside the objective: the level of service that the baseline leaves a point MDP at,
//! how many vehicles had not arrived at the end of an episode, and how many episodes ended in gridlock.
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

use super::level_of_service::{DELAY, letter};
use evaluation::analysis::{Measures, Regime, Share};
use evaluation::store::record::Metrics;
use signals::control::fixed_time::kept_start;

/// Share of the vehicles, above the baseline's on the same seed, from which on an episode ends in
/// gridlock; the module says why.
pub(super) const GRIDLOCK_EXCESS: f64 = 0.05;

/// Share of the vehicles above which an episode ends in gridlock whatever the baseline does: more of
/// them are left than have arrived.
pub(super) const GRIDLOCK_SHARE: f64 = 0.5;

/// Position among the regimes of the point MDPs that the baseline leaves at level of service F.
pub(super) const AT_F: usize = 1;

const VEHICLES: &str = "vehicles_veh";
const LEFT: &str = "unfinished_veh";

/// The regimes.
const REGIMES: [Regime; 2] = [
    Regime {
        name: "up_to_e",
        short: "to E",
        heading: ["Score where the", "baseline is at A to E"],
    },
    Regime { name: "at_f", short: "at F", heading: ["Score where the", "baseline is at F"] },
];

/// Position among the shares of the vehicles that had not arrived.
pub(super) const UNFINISHED: usize = 0;

/// The shares.
const SHARES: [Share; 2] = [
    Share {
        name: "unfinished_share",
        event: None,
        short: "unfinished",
        heading: ["Unfinished", "of the vehicles"],
    },
    Share {
        name: "gridlock_share",
        event: Some("gridlocked"),
        short: "gridlock",
        heading: ["Gridlocked", "of the episodes"],
    },
];

/// What is measured of traffic beside the objective.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TrafficMeasures {
    /// Whether vehicles pass several signals: their delay is then no level of service of an intersection.
    pub several_signals: bool,
}

impl Measures for TrafficMeasures {
    fn kept_start(&self, details: &BTreeMap<String, String>) -> Option<bool> {
        kept_start(details)
    }

    fn regimes(&self, objective: &str) -> &'static [Regime] {
        if objective == DELAY && !self.several_signals { &REGIMES } else { &[] }
    }

    fn regime(&self, objective: &str, baseline: &Metrics) -> Option<usize> {
        let has_levels = !self.regimes(objective).is_empty();
        let delay_s = baseline.get(DELAY).filter(|_| has_levels)?;
        Some(if letter(*delay_s) == 'F' { AT_F } else { 0 })
    }

    fn shares(&self) -> &'static [Share] {
        &SHARES
    }

    fn shares_of(&self, metrics: &Metrics, baseline: Option<&Metrics>) -> Vec<Option<f64>> {
        let share = unfinished(metrics);
        let gridlocked = share.and_then(|share| gridlocked(share, baseline.and_then(unfinished)));
        vec![share, gridlocked.map(|g| if g { 1.0 } else { 0.0 })]
    }
}

/// Returns the share of the vehicles that never entered or had not arrived; `None` when it was not
/// recorded or there were no vehicles.
fn unfinished(metrics: &Metrics) -> Option<f64> {
    let vehicles = metrics.get(VEHICLES).filter(|n| **n > 0.0)?;
    Some(metrics.get(LEFT)? / vehicles)
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
