//! The statistics of a method's summaries, computed together: those that need scores in order sort them once.

use crate::stats::PointMeans;
use crate::stats::iqm::mean_of_sorted;
use crate::stats::profile::share_below;
use crate::stats::summary::{Statistics, geometric_mean, mean_of_scores, ratio_of_means, scores};
use crate::stats::weighted_quantile::{quantile_of_sorted, sorted};

/// Positions of the statistics; the mean of scores is the first, and with the ratio the only mean over the family; those
/// of the regimes are the last, in their order.
pub(super) const RATIO: usize = 1;
pub(super) const MEDIAN: usize = 2;
pub(super) const GEOMETRIC: usize = 3;
pub(super) const IQM: usize = 4;
pub(super) const BELOW: usize = 5;
pub(super) const REGIMES: usize = 6;

/// The statistics of a method's summaries.
pub(super) struct SummaryStatistics<'a> {
    /// The median over all that was measured, around which the share below it tells the spread.
    pub(super) middle: Option<f64>,
    /// The regime of every point MDP.
    pub(super) regime_of: &'a [Option<usize>],
    /// Number of regimes.
    pub(super) regimes: usize,
}

impl Statistics for SummaryStatistics<'_> {
    fn values(&self, points: &[PointMeans], values: &mut Vec<Option<f64>>) {
        let in_order = sorted(scores(points));
        values.extend([
            mean_of_scores(points),
            ratio_of_means(points),
            quantile_of_sorted(&in_order, 0.5),
            geometric_mean(scores(points)),
            mean_of_sorted(&in_order),
            self.middle.and_then(|middle| share_below(scores(points), middle)),
        ]);
        let mut sums = vec![(0.0, 0.0); self.regimes];
        for point in points {
            // Of a point MDP that a model predicts it is not known.
            let regime = self.regime_of.get(point.point).copied().flatten();
            if let Some((top, bottom)) = regime.and_then(|regime| sums.get_mut(regime)) {
                *top += point.weight * point.score;
                *bottom += point.weight;
            }
        }
        values.extend(sums.into_iter().map(|(top, bottom)| (bottom > 0.0).then(|| top / bottom)));
    }

    fn means(&self) -> usize {
        RATIO + 1
    }
}
