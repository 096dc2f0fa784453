//! M1: independent draws by importance, with replacement.
//!
//! The estimate is the mean score over draws. Deviation: the paper prints a plain sum; a mean is meant.
//! The interval is design-based: that of a mean of independent draws ([`Resampling::draws`]).

use rand_chacha::ChaCha8Rng;

use super::contract::{Estimate, Estimator, Sample};
use super::weighted::estimates;
use crate::stats::summary::Statistics;
use crate::stats::{PointObjectives, Resampling, StatsError};

/// The estimator of M1.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WithReplacement;

impl Estimator for WithReplacement {
    fn name(&self) -> &'static str {
        "M1"
    }

    fn assumptions(&self) -> &'static str {
        "Draws are independent and by importance."
    }

    fn draws(&self, count: u32) -> u32 {
        count
    }

    fn is_whole(&self, _: usize, _: usize) -> bool {
        false
    }

    fn estimate_all(
        &self,
        sample: Sample<'_>,
        scores: &[PointObjectives],
        statistics: &dyn Statistics,
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<Option<Estimate>>, StatsError> {
        let resampling = Resampling::draws(scores);
        estimates(sample, scores, &resampling, statistics, rng)
    }
}
