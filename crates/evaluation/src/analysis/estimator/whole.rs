//! The whole family: every point MDP with its importance.
//!
//! Only the noise of seeds and trainings remains. Where results are missing, those that are there are taken for a random
//! part of the family.

use rand_chacha::ChaCha8Rng;

use super::contract::{Estimate, Estimator, Sample};
use super::weighted::estimates;
use crate::stats::summary::Statistics;
use crate::stats::{PointObjectives, Resampling, StatsError};

/// The estimator of a whole family.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Whole;

impl Estimator for Whole {
    fn name(&self) -> &'static str {
        "all"
    }

    fn assumptions(&self) -> &'static str {
        "What is missing is missing at random."
    }

    fn estimate_all(
        &self,
        sample: Sample<'_>,
        scores: &[PointObjectives],
        statistics: &dyn Statistics,
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<Option<Estimate>>, StatsError> {
        let weights: Vec<f64> = scores.iter().map(|p| p.weight).collect();
        let share = scores.len() as f64 / sample.family_size.max(1) as f64;
        let resampling = Resampling::distinct(&weights, &vec![share; scores.len()]);
        estimates(sample, scores, &resampling, statistics, rng)
    }
}
