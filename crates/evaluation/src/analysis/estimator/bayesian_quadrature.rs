//! Bayesian quadrature: the weights with the least expected error under a Gaussian process, and what it leaves unknown.
//!
//! The process knows features and the scores of cheap methods ([`crate::sample::quadrature`]). It gives weights to
//! whatever point MDPs have a score, so that missing ones only leave more unknown. The estimate is the weighted mean of the
//! scores that were seen: no score is predicted.
//!
//! The interval comes from the same process. Its size is the method's own: how far its scores are from what the process
//! says of each by the others. How rough the method is, beside what the process says, is weighed by the likelihood of its
//! scores. Then it is widened by [`WIDENING`]: processes that suit known methods are too sure of others.
//!
//! Source: as in [`crate::sample::quadrature`]; C. Rasmussen and Z. Ghahramani, "Bayesian Monte Carlo", NIPS 15 (2002).

use rand_chacha::ChaCha8Rng;

use super::contract::{Estimate, Estimator, Sample, estimates};
use crate::sample::quadrature::{Quadrature, Rule};
use crate::stats::summary::Statistics;
use crate::stats::{PointObjectives, Resampling, StatsError, means};

/// By how much intervals are wider than the process says.
const WIDENING: f64 = 1.5;

/// Returns the estimates of [`Estimator::BayesianQuadrature`].
pub(super) fn estimate_all(
    sample: Sample<'_>,
    scores: &[PointObjectives],
    statistics: &dyn Statistics,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Option<Estimate>>, StatsError> {
    if Estimator::Whole.is_known(sample, scores.len()) {
        return Estimator::Whole.estimate_all(sample, scores, statistics, rng);
    }
    let rows: Option<Vec<usize>> = sample.points.iter().map(|c| c.row).collect();
    let (Some(quadrature), Some(rows)) = (sample.design.and_then(Quadrature::of), rows) else {
        // Without what is known of the family, the chosen ones are taken for a random part of it.
        return Estimator::Whole.estimate_all(sample, scores, statistics, rng);
    };
    let rule = quadrature.rule(&rows, sample.learned_once);
    let weighed: Vec<PointObjectives> = (scores.iter().zip(&rule.weights))
        .map(|(p, weight)| PointObjectives { weight: *weight, ..p.clone() })
        .collect();
    let observed: Vec<f64> = means(scores)?.iter().map(|m| m.score).collect();
    let resampling = resampling(&rule, &observed);
    estimates(sample, &weighed, &resampling, statistics, rng)
}

fn resampling(rule: &Rule, scores: &[f64]) -> Resampling {
    let innovations = rule.innovations();
    let mean: f64 = rule.weights.iter().zip(scores).map(|(w, y)| w * y).sum();
    let said =
        |row: &Vec<f64>| row.iter().zip(scores).map(|(a, y)| a * (y - mean)).sum::<f64>().powi(2);
    let smooth = innovations.iter().map(said).sum::<f64>().sqrt();
    let widen = WIDENING * if smooth > 0.0 { rule.standard_error(scores) / smooth } else { 1.0 };
    let contrast = |row: Vec<f64>| row.into_iter().map(|a| widen * a).enumerate().collect();
    Resampling::of(innovations.into_iter().map(contrast).collect(), scores.len() as f64 - 1.0)
}
