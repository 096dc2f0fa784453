//! The share of the family beyond many thresholds at once, as performance profiles and their bands need it.

use pulp::{Arch, Simd, WithSimd};

use super::profile::key;
use super::summary::Statistics;
use super::{Direction, PointMeans};

/// Registers of thresholds whose shares are summed at once.
const AT_ONCE: usize = 8;

/// The shares of the weight with a score better than each of some thresholds, as [`super::profile::share_beyond`] has them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SharesBeyond {
    /// The thresholds, in numbers that compare as they do; reversed where more is better.
    keys: Vec<i64>,
    direction: Direction,
}

impl SharesBeyond {
    /// Returns the statistics of these thresholds, in their order.
    pub fn new(thresholds: &[f64], direction: Direction) -> Self {
        let keys = thresholds.iter().map(|t| directed(*t, direction)).collect();
        Self { keys, direction }
    }
}

/// Returns a number that is less for better values.
fn directed(value: f64, direction: Direction) -> i64 {
    match direction {
        Direction::Lower => key(value),
        Direction::Higher => !key(value),
    }
}

impl Statistics for SharesBeyond {
    fn values(&self, points: &[PointMeans], values: &mut Vec<Option<f64>>) {
        let of = |p: &PointMeans| (directed(p.score, self.direction), p.weight);
        let scores: Vec<(i64, f64)> = points.iter().map(of).collect();
        let bottom = scores.iter().fold(0.0, |sum, (_, weight)| sum + weight);
        let tops = Arch::new().dispatch(Shares { scores: &scores, keys: &self.keys });
        values.extend(tops.into_iter().map(|top| (bottom > 0.0).then(|| top / bottom)));
    }
}

/// The weight of the scores below each key, summed in their order.
struct Shares<'a> {
    scores: &'a [(i64, f64)],
    keys: &'a [i64],
}

impl WithSimd for Shares<'_> {
    type Output = Vec<f64>;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Vec<f64> {
        let mut keys = self.keys.to_vec();
        // Nothing is below the least number.
        keys.resize(keys.len().next_multiple_of(AT_ONCE * S::F64_LANES), i64::MIN);
        let mut tops = vec![0.0; keys.len()];
        let own = S::as_mut_simd_f64s(&mut tops).0.as_chunks_mut::<AT_ONCE>().0;
        let none = simd.splat_f64s(0.0);
        for (tops, keys) in own.iter_mut().zip(S::as_simd_i64s(&keys).0.as_chunks::<AT_ONCE>().0) {
            let mut sums = [none; AT_ONCE];
            for (score, weight) in self.scores {
                let (score, weight) = (simd.splat_i64s(*score), simd.splat_f64s(*weight));
                for (sum, key) in sums.iter_mut().zip(keys) {
                    let is_below = simd.less_than_i64s(score, *key);
                    *sum = simd.add_f64s(*sum, simd.select_f64s(is_below, weight, none));
                }
            }
            *tops = sums;
        }
        tops.truncate(self.keys.len());
        tops
    }
}

#[cfg(test)]
mod tests {
    use super::super::profile::share_beyond;
    use super::super::summary::scores;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn shares_are_those_of_one_threshold_after_the_other(
            pairs in prop::collection::vec((0.01f64..1.0, (-3i8..6).prop_map(f64::from)), 0..60),
            thresholds in prop::collection::vec((-7i8..14).prop_map(|t| f64::from(t) / 2.0), 0..40),
            higher in any::<bool>(),
        ) {
            let direction = if higher { Direction::Higher } else { Direction::Lower };
            let point = |(weight, score): &(f64, f64)| PointMeans {
                point: 0, weight: *weight, method: 0.0, baseline: 0.0, score: *score,
            };
            let points: Vec<PointMeans> = pairs.iter().map(point).collect();
            let mut values = Vec::new();
            SharesBeyond::new(&thresholds, direction).values(&points, &mut values);
            let each = thresholds.iter().map(|t| share_beyond(scores(&points), *t, direction));
            prop_assert_eq!(values, each.collect::<Vec<_>>());
        }
    }
}
