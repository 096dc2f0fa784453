//! The share of the family beyond many thresholds at once, as performance profiles and their bands need it.

use std::cmp::Ordering;

use super::summary::Statistics;
use super::{Direction, PointMeans};

/// The shares of the weight with a score better than each of some thresholds, as [`super::profile::share_beyond`] has them.
#[derive(Debug, Clone, PartialEq)]
pub struct SharesBeyond {
    thresholds: Vec<f64>,
    direction: Direction,
}

impl SharesBeyond {
    /// Returns the statistics of these thresholds, which are in ascending order.
    pub fn new(thresholds: &[f64], direction: Direction) -> Self {
        Self { thresholds: thresholds.to_vec(), direction }
    }
}

impl Statistics for SharesBeyond {
    fn values(&self, points: &[PointMeans], values: &mut Vec<Option<f64>>) {
        let bottom = points.iter().fold(0.0, |sum, point| sum + point.weight);
        let mut tops = vec![0.0; self.thresholds.len()];
        let lower = self.direction.is_lower();
        for PointMeans { weight, score, .. } in points {
            // A score is better than all thresholds from one on, or than all before one.
            let from = |t: &f64| score.partial_cmp(t) != Some(Ordering::Less);
            let better = match lower {
                true => self.thresholds.partition_point(from)..tops.len(),
                false => 0..self.thresholds.partition_point(|t| score > t),
            };
            tops[better].iter_mut().for_each(|top| *top += weight);
        }
        values.extend(tops.into_iter().map(|top| (bottom > 0.0).then(|| top / bottom)));
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
            thresholds in prop::collection::btree_set(-7i8..14, 0..20),
            higher in any::<bool>(),
        ) {
            let thresholds: Vec<f64> = thresholds.iter().map(|t| f64::from(*t) / 2.0).collect();
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
