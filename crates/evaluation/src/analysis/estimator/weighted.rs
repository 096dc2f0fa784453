//! Statistics of weighted point MDPs, resampled as a design says: what M1, M2, M3, balanced samples and whole families
//! have in common.

use rand_chacha::ChaCha8Rng;

use super::contract::{Estimate, Sample};
use crate::stats::summary::Statistics;
use crate::stats::{PointObjectives, Resampling, StatsError, bootstrap_all, stretch};

/// Returns the statistics with their intervals.
///
/// # Arguments
///
/// * `sample` — what counts here: the method, the number of resamples, and alpha.
pub(super) fn estimates(
    sample: Sample<'_>,
    scores: &[PointObjectives],
    resampling: &Resampling,
    statistics: &dyn Statistics,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Option<Estimate>>, StatsError> {
    let count = (sample.method, sample.resamples);
    let all = bootstrap_all(scores, resampling, rng, count, statistics)?;
    // Of a sample, the choice of point MDPs makes most of the variance, and has its own degrees of freedom.
    let stretch = if resampling.draws_points() { 1.0 } else { stretch(scores) };
    let spread = (sample.alpha, stretch);
    let (means, others) = (Estimate::of_mean, Estimate::of);
    let estimate =
        |(i, b)| Some(if i < statistics.means() { means(b?, spread) } else { others(b?, spread) });
    Ok(all.into_iter().enumerate().map(estimate).collect())
}
