//! M2: successive draws by importance, without replacement.
//!
//! The estimate is the paper's: scores weighted by importance, renormalised. Point MDPs that were drawn because they
//! are important weigh their importance once more, so that it leans to what happens at important ones.
//!
//! The interval is design-based and free of that: the same scores weighted by importance over the probability to be
//! drawn (Hajek's estimator), with the spread of a sample of fixed size. Where the paper's estimate lies outside, the
//! interval is widened to hold it.
//!
//! Source: J. Hájek, "Asymptotic theory of rejective sampling with varying probabilities from a finite population",
//! Annals of Mathematical Statistics 35 (1964).

use rand_chacha::ChaCha8Rng;

use super::contract::{Chosen, Estimate, Sample, estimates};
use crate::stats::summary::Statistics;
use crate::stats::{PointObjectives, Resampling, StatsError, means};

/// Returns the estimates of [`super::Estimator::WithoutReplacement`].
pub(super) fn estimate_all(
    sample: Sample<'_>,
    scores: &[PointObjectives],
    statistics: &dyn Statistics,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Option<Estimate>>, StatsError> {
    let answered = sample.answered(scores.len());
    let probability = |c: &Chosen| {
        // Plans from before probabilities were kept: that of a sample in proportion to importance.
        c.inclusion.unwrap_or_else(|| (c.importance * sample.chosen as f64).min(1.0))
    };
    let inclusion: Vec<f64> = sample.points.iter().map(|c| probability(c) * answered).collect();
    let unbiased: Vec<PointObjectives> = (scores.iter().zip(sample.points).zip(&inclusion))
        .map(|((p, c), pi)| PointObjectives { weight: c.importance / pi, ..p.clone() })
        .collect();
    let weights: Vec<f64> = unbiased.iter().map(|p| p.weight).collect();
    let fixed: Vec<f64> = inclusion.iter().map(|pi| sample.fixed(*pi)).collect();
    let resampling = Resampling::distinct(&weights, &fixed);
    let mut all = estimates(sample, &unbiased, &resampling, statistics, rng)?;
    let mut own = Vec::with_capacity(all.len());
    statistics.values(&means(scores)?, &mut own);
    for (value, estimate) in own.into_iter().zip(&mut all) {
        let (Some(e), Some(value)) = (estimate.as_mut(), value) else { continue };
        e.value = value;
        e.interval = e.interval.map(|(low, high)| (low.min(value), high.max(value)));
    }
    Ok(all)
}
