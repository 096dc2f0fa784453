//! Summaries of a family beside the mean of scores, which is one number of a heavy tail.
//!
//! Definition 1 of Jayawardana et al. weighs every point MDP by how often it occurs, whatever its
//! delay: halving 10 s counts as much as halving 500 s. The others are not better
//! summaries: they answer other questions. Where they disagree on a method, few point MDPs decide:
//!
//! - [`ratio_of_means`]: how much less delay there is in total. Long delays dominate.
//! - [`weighted_median`]: what happens at the typical intersection. Extreme ones do not count.
//! - [`super::iqm::interquartile_mean`]: the mean of the middle half, which is the median's question with less noise.
//! - [`geometric_mean`]: the typical factor. Half and double cancel, so that it does not depend on
//!   which of two methods is divided by the other.
//!
//! Source of the geometric mean of ratios: P. Fleming and J. Wallace, "How not to lie with
//! statistics: the correct way to summarize benchmark results", Communications of the ACM 29 (1986).

use super::PointMeans;
use super::score::weighted_mean;
use super::weighted_quantile::weighted_quantile;

/// A statistic over point MDPs; `None` where it is undefined.
pub type Statistic<'a> = &'a dyn Fn(&[PointMeans]) -> Option<f64>;

/// Several statistics over the same point MDPs, computed together where they have work in common.
pub trait Statistics {
    /// Appends the values in their order, `None` where one is undefined; always equally many.
    fn values(&self, points: &[PointMeans], values: &mut Vec<Option<f64>>);

    /// Returns how many of the values, from the first, are weighted means over point MDPs or ratios of such: what
    /// predictions of scores are wrong by there is what each of them is wrong by, on average.
    fn means(&self) -> usize {
        0
    }
}

/// A function that appends the values, with how many of them are means.
impl<F: Fn(&[PointMeans], &mut Vec<Option<f64>>)> Statistics for (usize, F) {
    fn values(&self, points: &[PointMeans], values: &mut Vec<Option<f64>>) {
        self.1(points, values);
    }

    fn means(&self) -> usize {
        self.0
    }
}

/// The mean of scores alone.
pub fn only_mean() -> impl Statistics {
    (1, |points: &[PointMeans], values: &mut Vec<_>| values.push(mean_of_scores(points)))
}

impl Statistics for &[Statistic<'_>] {
    fn values(&self, points: &[PointMeans], values: &mut Vec<Option<f64>>) {
        values.extend(self.iter().map(|statistic| statistic(points)));
    }
}

impl<const N: usize> Statistics for [Statistic<'_>; N] {
    fn values(&self, points: &[PointMeans], values: &mut Vec<Option<f64>>) {
        (&self[..]).values(points, values);
    }
}

/// Returns the weighted mean of scores (Definition 1); `None` when the weights sum to 0.
pub fn mean_of_scores(points: &[PointMeans]) -> Option<f64> {
    weighted_mean(points.iter().map(|p| (p.weight, p.score)))
}

/// Returns the weighted mean objective of the method divided by that of the baseline; `None` when
/// the weights sum to 0 or the baseline's mean is 0.
///
/// It is the mean of scores weighted by importance and by the baseline's objective.
pub fn ratio_of_means(points: &[PointMeans]) -> Option<f64> {
    let top = weighted_mean(points.iter().map(|p| (p.weight, p.method)))?;
    let bottom = weighted_mean(points.iter().map(|p| (p.weight, p.baseline)))?;
    (bottom > 0.0).then(|| top / bottom)
}

/// Returns the median of pairs `(weight, value)`: half of the weight lies at or below it. Between two
/// values that halve the weight exactly it is their mean. `None` when the weights sum to 0.
pub fn weighted_median(pairs: impl IntoIterator<Item = (f64, f64)>) -> Option<f64> {
    weighted_quantile(pairs, 0.5)
}

/// Returns the geometric mean of pairs `(weight, value)` with values that are not negative; `None`
/// when the weights sum to 0.
pub fn geometric_mean(pairs: impl IntoIterator<Item = (f64, f64)>) -> Option<f64> {
    weighted_mean(pairs.into_iter().map(|(w, x)| (w, x.ln()))).map(f64::exp)
}

/// Returns the pairs of weight and score.
pub fn scores(points: &[PointMeans]) -> impl Iterator<Item = (f64, f64)> {
    points.iter().map(|p| (p.weight, p.score))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point(weight: f64, method: f64, baseline: f64) -> PointMeans {
        PointMeans { point: 0, weight, method, baseline, score: method / baseline }
    }

    #[test]
    fn summaries_of_a_heavy_tail_disagree() {
        // Better at four of five intersections, worse at the one that has nearly all delay.
        let points: Vec<_> = (0..5)
            .map(|i| if i < 4 { point(0.2, 10.0, 20.0) } else { point(0.2, 800.0, 400.0) })
            .collect();
        assert!((mean_of_scores(&points).unwrap() - 0.8).abs() < 1e-12);
        assert!((ratio_of_means(&points).unwrap() - 840.0 / 480.0).abs() < 1e-12);
        assert_eq!(weighted_median(scores(&points)), Some(0.5));
        assert!((geometric_mean(scores(&points)).unwrap() - 2f64.powf(-0.6)).abs() < 1e-12);
    }

    #[test]
    fn a_family_without_weight_or_delay_has_no_summary() {
        assert_eq!(ratio_of_means(&[]), None);
        assert_eq!(ratio_of_means(&[point(1.0, 5.0, 0.0)]), None);
        assert_eq!(geometric_mean([]), None);
    }

    fn family() -> impl Strategy<Value = Vec<PointMeans>> {
        let one = (0.01f64..1.0, 0.1f64..900.0, 0.1f64..900.0);
        prop::collection::vec(one.prop_map(|(w, m, b)| point(w, m, b)), 1..40)
    }

    fn all(points: &[PointMeans]) -> [f64; 4] {
        [
            mean_of_scores(points).unwrap(),
            ratio_of_means(points).unwrap(),
            weighted_median(scores(points)).unwrap(),
            geometric_mean(scores(points)).unwrap(),
        ]
    }

    proptest! {

        #[test]
        fn the_geometric_mean_and_the_ratio_turn_round_with_the_methods(points in family()) {
            let turned: Vec<_> = points.iter().map(|p| point(p.weight, p.baseline, p.method)).collect();
            let ([_, ratio, _, geometric], [_, other, _, back]) = (all(&points), all(&turned));
            prop_assert!((ratio * other - 1.0).abs() < 1e-9);
            prop_assert!((geometric * back - 1.0).abs() < 1e-9);
        }

        #[test]
        fn the_ratio_weighs_scores_by_the_delay_under_the_baseline(points in family()) {
            let expected = weighted_mean(points.iter().map(|p| (p.weight * p.baseline, p.score)));
            prop_assert!((ratio_of_means(&points).unwrap() - expected.unwrap()).abs() < 1e-9);
        }
    }
}
