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

    proptest! {
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
