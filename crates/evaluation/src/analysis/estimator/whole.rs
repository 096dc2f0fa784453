//! The whole family: every point MDP with its importance.
//!
//! Only the noise of seeds and trainings remains. Where results are missing, those that are there are taken for a random
//! part of the family.

use rand_chacha::ChaCha8Rng;

use super::contract::{Estimate, Estimator, Sample, one_by_one};
use super::weighted::estimates;
use crate::stats::summary::Statistics;
use crate::stats::{PointObjectives, Resampling, StatsError, bootstrap_each, stretch};

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

    fn estimate_each(
        &self,
        sample: Sample<'_>,
        scores: &[&[PointObjectives]],
        rng: &ChaCha8Rng,
    ) -> Vec<Result<Estimate, StatsError>> {
        let missing = |scores: &&[PointObjectives]| scores.len() != sample.family_size;
        if scores.iter().any(missing) {
            return one_by_one(self, sample, scores, rng);
        }
        let count = (sample.method, sample.resamples);
        let all = bootstrap_each(scores, &Resampling::whole(), rng, count);
        let of = |(b, scores): (Result<_, _>, &&[PointObjectives])| {
            b.map(|b| Estimate::of_mean(b, (sample.alpha, stretch(scores))))
        };
        all.into_iter().zip(scores).map(of).collect()
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
