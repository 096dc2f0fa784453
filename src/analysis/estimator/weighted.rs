//! Statistics of weighted point MDPs, resampled as a design says: what M1, M2, M3, balanced samples and whole families
//! have in common.

use rand_chacha::ChaCha8Rng;

use super::contract::Estimate;
use crate::stats::quantile::central_95;
use crate::stats::summary::Statistic;
use crate::stats::{PointMeans, PointObjectives, Resampling, StatsError, resample};

/// Returns the statistics with their intervals.
///
/// # Arguments
///
/// * `method` — tells the trainings of methods apart.
/// * `count` — number of resamples.
pub(super) fn estimates(
    scores: &[PointObjectives],
    resampling: &Resampling,
    (method, count): (u64, usize),
    statistics: &[Statistic<'_>],
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Option<Estimate>>, StatsError> {
    let whole = means(scores)?;
    let mut all: Vec<Option<Estimate>> =
        statistics.iter().map(|s| s(&whole).map(unresampled)).collect();
    resample(scores, resampling, rng, method, count, &mut |resample| {
        for (statistic, estimate) in statistics.iter().zip(&mut all) {
            if let (Some(estimate), Some(value)) = (estimate, resample.value(statistic)) {
                estimate.resamples.push(value);
            }
        }
    })?;
    for estimate in all.iter_mut().flatten() {
        estimate.interval = central_95(&estimate.resamples);
    }
    Ok(all)
}

/// Returns the means of every point MDP.
pub(super) fn means(scores: &[PointObjectives]) -> Result<Vec<PointMeans>, StatsError> {
    scores.iter().enumerate().map(|(i, p)| p.means(i)).collect()
}

/// Returns an estimate without an interval.
pub(super) fn unresampled(value: f64) -> Estimate {
    Estimate { value, interval: None, resamples: Vec::new() }
}
