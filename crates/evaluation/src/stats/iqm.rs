//! The interquartile mean: the mean without the best and the worst quarter.
//!
//! It ignores extremes as the median does, and unlike the median it moves with every score in the middle half.
//!
//! Source: R. Agarwal et al., "Deep reinforcement learning at the edge of the statistical precipice", NeurIPS 2021;
//! their library rliable 1.2.0, `metrics.aggregate_iqm`, which is `scipy.stats.trim_mean` of a quarter.
//!
//! Deviation: scores have weights. Of `n` scores scipy cuts `floor(n / 4)` from either end; here `floor(n / 4) / n` of
//! the weight is cut from either end, and the score across which a cut goes counts with the part of its weight that
//! is inside. With equal weights no cut goes across a score, so that the value is rliable's.
//!
//! Deviation: rliable pools runs and tasks. Here a task, a point MDP, has one score, that of all its runs (a ratio of
//! means); it is rliable's value for a matrix of one run.

use super::score::weighted_mean;
use super::weighted_quantile::sorted;

/// The share that is cut from either end is one in so many scores.
const ONE_IN: usize = 4;

/// Returns the interquartile mean of pairs `(weight, value)`; `None` when the weights sum to 0. Of fewer than four
/// values it is their mean.
///
/// # Examples
///
/// ```
/// # use tsc_family_evaluation::stats::iqm::interquartile_mean;
/// // Half of the weight is cut, half of it from the heavy value.
/// let scores = [(1.0, 9.0), (2.0, 3.0), (1.0, 5.0), (4.0, 1.0)];
/// assert_eq!(interquartile_mean(scores), Some((2.0 * 1.0 + 2.0 * 3.0) / 4.0));
/// ```
pub fn interquartile_mean(pairs: impl IntoIterator<Item = (f64, f64)>) -> Option<f64> {
    mean_of_sorted(&sorted(pairs))
}

/// Returns [`interquartile_mean`] of what [`sorted`] gives.
pub fn mean_of_sorted(sorted: &[(f64, f64)]) -> Option<f64> {
    let n = sorted.len();
    let total: f64 = sorted.iter().map(|p| p.0).sum();
    let cut = total * (n / ONE_IN) as f64 / n.max(1) as f64;
    let mut below = 0.0;
    let inside = sorted.iter().copied().map(|(weight, value)| {
        let start = f64::max(below, cut);
        below += weight;
        ((below.min(total - cut) - start).max(0.0), value)
    });
    weighted_mean(inside)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn of(values: &[f64]) -> f64 {
        interquartile_mean(values.iter().map(|v| (0.1, *v))).unwrap()
    }

    #[test]
    fn a_quarter_is_cut_from_either_end_rounded_down() {
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        close(of(&[1.0, 2.0, 4.0, 99.0]), 3.0);
        close(of(&[99.0, 1.0, 2.0, 3.0, 4.0]), 3.0);
        close(of(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 99.0]), 4.0);
        close(of(&[1.0, 2.0, 9.0]), 4.0);
    }

    #[test]
    fn a_score_across_a_cut_counts_with_the_weight_inside() {
        // An eighth of the weight is below 2, so that half of 2's weight is cut.
        let pairs = [(1.0, 1.0), (2.0, 2.0), (3.0, 3.0), (2.0, 50.0)];
        assert_eq!(interquartile_mean(pairs), Some((2.0 + 3.0 * 3.0) / 4.0));
        assert_eq!(interquartile_mean([]), None);
        assert_eq!(interquartile_mean([(0.0, 1.0)]), None);
    }

    fn weighted() -> impl Strategy<Value = Vec<(f64, f64)>> {
        prop::collection::vec((0.01f64..1.0, -50.0f64..50.0), 1..60)
    }

    proptest! {

        #[test]
        fn neither_order_nor_scale_of_the_weights_matters(
            pairs in weighted(), by in 0usize..60, scale in 0.1f64..9.0,
        ) {
            let mut other = pairs.clone();
            other.rotate_left(by % pairs.len());
            other.iter_mut().for_each(|p| p.0 *= scale);
            let (a, b) = (interquartile_mean(pairs).unwrap(), interquartile_mean(other).unwrap());
            prop_assert!((a - b).abs() < 1e-9);
        }
    }
}
