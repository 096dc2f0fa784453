//! Performance profiles: the share of the family on which a method's score is better than a threshold.
//!
//! Where less is better, a profile rises from 0 to 1 with the threshold, where more is better it falls from 1 to 0; either
//! way the higher curve is the better one. Its value at a threshold is the chance that a point MDP drawn by importance
//! has a better score.
//!
//! Source: R. Agarwal et al., "Deep reinforcement learning at the edge of the statistical precipice", NeurIPS 2021;
//! their library rliable 1.2.0, `library.create_performance_profile` with `use_score_distribution=False`, which
//! counts mean scores per task; E. Dolan and J. More, "Benchmarking optimization software with performance
//! profiles", Mathematical Programming 91 (2002).
//!
//! Deviations: point MDPs count by importance, and less may be better ([`Direction`]); rliable's tasks weigh the same
//! and its scores are better when they are higher. A score that equals the threshold is not better, in both.

use super::Direction;
use super::score::weighted_mean;

/// Returns the share of the weight with a value better than a threshold; `None` when the weights sum to 0.
///
/// # Examples
///
/// ```
/// # use tsc_family_evaluation::stats::{Direction, profile::share_beyond};
/// let scores = [(0.5, 0.8), (0.3, 1.0), (0.2, 1.4)];
/// assert_eq!(share_beyond(scores, 1.0, Direction::Lower), Some(0.5));
/// assert_eq!(share_beyond(scores, 1.0, Direction::Higher), Some(0.2));
/// ```
pub fn share_beyond(
    pairs: impl IntoIterator<Item = (f64, f64)>,
    threshold: f64,
    direction: Direction,
) -> Option<f64> {
    let better = |value| f64::from(u8::from(direction.is_worse(threshold, value)));
    weighted_mean(pairs.into_iter().map(|(w, value)| (w, better(value))))
}

/// By how much the shares of one summation may be off from those of another: far above what rounding makes of a million
/// point MDPs, far below what one of them weighs.
const SUMMATION: f64 = 1e-9;

/// Most additions for the shares of a pair of profiles that are summed exactly; families of up to 3000 stay below it.
const ADDITIONS: usize = 20_000_000;

/// Returns the thresholds at which two profiles may be furthest apart, either way, in ascending order, and both profiles
/// there as [`share_beyond`] has them.
///
/// All values of both are looked at, in one pass over what is sorted; shares are summed in the order of the point MDPs
/// only where those of the pass leave open which threshold it is. Where profiles are furthest apart at so many thresholds
/// that this would be more than `ADDITIONS`, it is the last ones where the first is ahead, the first ones where it is behind.
pub fn extremes(
    a: &[(f64, f64)],
    b: &[(f64, f64)],
    direction: Direction,
) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let at = thresholds(a.iter().chain(b).map(|p| p.1), usize::MAX);
    let (of_a, of_b) = (beyond_each(a, &at, direction), beyond_each(b, &at, direction));
    let distances: Vec<f64> = of_a.iter().zip(&of_b).map(|(a, b)| a - b).collect();
    let most = distances.iter().copied().fold(f64::NEG_INFINITY, f64::max) - SUMMATION;
    let least = distances.iter().copied().fold(f64::INFINITY, f64::min) + SUMMATION;
    let count = ADDITIONS / (a.len() + b.len()).max(1) / 2 + 1;
    let ahead = (0..at.len()).rev().filter(|i| distances[*i] >= most).take(count);
    let behind = (0..at.len()).filter(|i| distances[*i] <= least).take(count);
    let mut found: Vec<usize> = ahead.chain(behind).collect();
    found.sort_unstable();
    found.dedup();
    let at: Vec<f64> = found.into_iter().map(|i| at[i]).collect();
    let exact = |scores: &[(f64, f64)]| -> Vec<f64> {
        at.iter().filter_map(|t| share_beyond(scores.iter().copied(), *t, direction)).collect()
    };
    let (a, b) = (exact(a), exact(b));
    (at, a, b)
}

/// Returns the share of the weight with a value better than each of some thresholds in ascending order, but for rounding.
fn beyond_each(pairs: &[(f64, f64)], thresholds: &[f64], direction: Direction) -> Vec<f64> {
    let mut sorted = pairs.to_vec();
    sorted.sort_by(|a, b| a.1.total_cmp(&b.1));
    let total: f64 = sorted.iter().map(|p| p.0).sum();
    let mut rest = sorted.iter().peekable();
    let mut passed = 0.0;
    let below = thresholds.iter().map(|threshold| {
        let passes = |value: f64| match direction {
            Direction::Lower => value.total_cmp(threshold).is_lt(),
            Direction::Higher => value.total_cmp(threshold).is_le(),
        };
        while let Some((weight, _)) = rest.next_if(|p| passes(p.1)) {
            passed += weight;
        }
        match direction {
            Direction::Lower => passed / total,
            Direction::Higher => (total - passed) / total,
        }
    });
    below.collect()
}

/// Returns the weighted share below a value, of what equals it half; `None` when the weights sum to 0.
pub fn share_below(pairs: impl IntoIterator<Item = (f64, f64)>, value: f64) -> Option<f64> {
    let below = |other: f64| match other == value {
        true => 0.5,
        false => f64::from(u8::from(other < value)),
    };
    weighted_mean(pairs.into_iter().map(|(w, other)| (w, below(other))))
}

/// Returns the profile as steps: every value once, in ascending order, with the share that is better than any
/// threshold just beyond it (above it where less is better, below it where more is).
pub fn steps(pairs: impl IntoIterator<Item = (f64, f64)>, direction: Direction) -> Vec<(f64, f64)> {
    let mut sorted: Vec<(f64, f64)> = pairs.into_iter().filter(|(w, _)| *w > 0.0).collect();
    sorted.sort_by(|a, b| direction.compare(a.1, b.1));
    let total: f64 = sorted.iter().map(|p| p.0).sum();
    let mut steps: Vec<(f64, f64)> = Vec::with_capacity(sorted.len());
    let mut reached = 0.0;
    for (weight, value) in sorted {
        reached += weight;
        match steps.last_mut() {
            Some(last) if last.0 == value => last.1 = reached / total,
            _ => steps.push((value, reached / total)),
        }
    }
    steps.sort_by(|a, b| a.0.total_cmp(&b.0));
    steps
}

/// Returns at most so many thresholds in ascending order, at which profiles of these values change: all of the values,
/// or their quantiles.
pub fn thresholds(values: impl IntoIterator<Item = f64>, most: usize) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.into_iter().collect();
    sorted.sort_by(f64::total_cmp);
    sorted.dedup();
    let n = sorted.len();
    if n <= most.max(1) || most < 2 {
        return sorted;
    }
    (0..most).map(|i| sorted[i * (n - 1) / (most - 1)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn steps_add_up_equal_values_and_end_at_one() {
        let pairs = [(1.0, 2.0), (2.0, 1.0), (1.0, 2.0)];
        assert_eq!(steps(pairs, Direction::Lower), [(1.0, 0.5), (2.0, 1.0)]);
        assert_eq!(steps(pairs, Direction::Higher), [(1.0, 1.0), (2.0, 0.5)]);
        assert_eq!(steps([], Direction::Lower), []);
    }

    #[test]
    fn a_score_that_equals_the_threshold_is_not_better_and_counts_half_below() {
        let pairs = [(1.0, 2.0), (1.0, 3.0)];
        assert_eq!(share_beyond(pairs, 2.0, Direction::Lower), Some(0.0));
        assert_eq!(share_beyond(pairs, 3.0, Direction::Higher), Some(0.0));
        assert_eq!(share_below(pairs, 2.0), Some(0.25));
        assert_eq!((share_beyond([], 2.0, Direction::Lower), share_below([], 2.0)), (None, None));
    }

    #[test]
    fn thresholds_are_values_and_keep_both_ends() {
        assert_eq!(thresholds([3.0, 1.0, 3.0], 9), [1.0, 3.0]);
        let many = thresholds((0..1000).map(f64::from), 5);
        assert_eq!(many, [0.0, 249.0, 499.0, 749.0, 999.0]);
    }

    fn family() -> impl Strategy<Value = Vec<(f64, f64)>> {
        prop::collection::vec((0.01f64..1.0, (0u8..30).prop_map(f64::from)), 1..40)
    }

    proptest! {
        #[test]
        fn extremes_are_those_of_all_thresholds(a in family(), b in family(), higher in any::<bool>()) {
            let direction = if higher { Direction::Higher } else { Direction::Lower };
            let ends = |at: &[f64], a: &[f64], b: &[f64]| {
                let distances = || at.iter().zip(a.iter().zip(b).map(|(a, b)| a - b));
                let most = distances().max_by(|x, y| x.1.total_cmp(&y.1));
                let least = distances().min_by(|x, y| x.1.total_cmp(&y.1));
                (most.map(|d| (*d.0, d.1)), least.map(|d| (*d.0, d.1)))
            };
            let all = thresholds(a.iter().chain(&b).map(|p| p.1), usize::MAX);
            let profile = |of: &[(f64, f64)]| -> Vec<f64> {
                all.iter().filter_map(|t| share_beyond(of.iter().copied(), *t, direction)).collect()
            };
            let (at, of_a, of_b) = extremes(&a, &b, direction);
            prop_assert!(at.len() <= all.len());
            prop_assert_eq!(ends(&at, &of_a, &of_b), ends(&all, &profile(&a), &profile(&b)));
        }

        #[test]
        fn a_profile_follows_its_steps(
            pairs in prop::collection::vec((0.01f64..1.0, (0u8..20).prop_map(f64::from)), 1..30),
            threshold in 0.0f64..20.0,
        ) {
            let share = share_beyond(pairs.iter().copied(), threshold, Direction::Lower).unwrap();
            let steps = steps(pairs, Direction::Lower);
            let reached = steps.iter().rev().find(|s| s.0 < threshold).map_or(0.0, |s| s.1);
            prop_assert!((share - reached).abs() < 1e-9);
        }
    }
}
