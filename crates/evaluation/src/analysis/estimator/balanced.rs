//! Balanced samples: Hajek's estimator, and the spread between neighbours.
//!
//! The estimate is the mean score weighted by importance over the probability to be drawn. The interval comes from
//! [`local_means`]: in a sample that is spread over features, point MDPs differ from what might have been drawn
//! instead as they differ from their neighbours.
//!
//! Source: as in [`super::neighbours`].

use super::contract::{Chosen, Sample};
use super::neighbours::local_means;
use crate::stats::{PointObjectives, Resampling};

/// Neighbours in a local mean; with fewer, intervals of 20 to 40 skewed scores are too narrow.
pub(super) const NEIGHBOURS: usize = 6;

/// Returns how the choice of a balanced sample is drawn anew.
pub(super) fn resampling(sample: Sample<'_>, scores: &[PointObjectives]) -> Resampling {
    let answered = sample.answered(scores.len());
    let probability = |c: &Chosen| sample.fixed(c.inclusion.unwrap_or(1.0) * answered);
    let inclusion: Vec<f64> = sample.points.iter().map(probability).collect();
    if inclusion.iter().all(|pi| *pi >= 1.0) {
        return Resampling::whole();
    }
    let weights: Vec<f64> = scores.iter().map(|p| p.weight).collect();
    let contrasts = local_means(sample.points, &weights, &inclusion, NEIGHBOURS);
    Resampling::of(contrasts, scores.len() as f64 - 1.0)
}
