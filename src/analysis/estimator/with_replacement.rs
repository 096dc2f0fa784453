//! M1: independent draws by importance, with replacement.
//!
//! The estimate is the mean score over draws. Deviation: the paper prints a plain sum; a mean is meant.
//! The interval is the percentile bootstrap of [`crate::stats::bootstrap`] with draws drawn anew.

use rand_chacha::ChaCha8Rng;

use super::contract::{Estimate, Estimator, Sample};
use crate::stats::summary::Statistic;
use crate::stats::{Design, PointObjectives, StatsError, bootstrap_all};

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

    fn is_whole(&self, _: Sample, _: usize) -> bool {
        false
    }

    fn estimate_all(
        &self,
        sample: Sample,
        scores: &[PointObjectives],
        statistics: &[Statistic<'_>],
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<Option<Estimate>>, StatsError> {
        let all = bootstrap_all(scores, Design::WithReplacement, rng, sample.method, statistics)?;
        Ok(all.into_iter().map(|b| b.map(Estimate::from)).collect())
    }
}
