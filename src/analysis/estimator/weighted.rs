//! Statistics of weighted point MDPs, resampled as a design says: what M1, M2, M3, balanced samples and whole families
//! have in common.

use rand_chacha::ChaCha8Rng;

use super::contract::Estimate;
use crate::stats::summary::Statistics;
use crate::stats::{PointObjectives, Resampling, StatsError, bootstrap_all};

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
    statistics: &dyn Statistics,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Option<Estimate>>, StatsError> {
    let all = bootstrap_all(scores, resampling, rng, (method, count), statistics)?;
    Ok(all.into_iter().map(|bootstrap| bootstrap.map(Estimate::from)).collect())
}
