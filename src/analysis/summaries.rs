//! Summaries of a method beside its score: other means, and the regimes of the baseline apart.

use rand_chacha::ChaCha8Rng;

use super::estimator::{Estimate, Estimator, Sample};
use super::points::PointSummary;
use crate::stats::score::weighted_mean;
use crate::stats::summary::{
    Statistic, geometric_mean, mean_of_scores, ratio_of_means, scores, weighted_median,
};
use crate::stats::{PointMeans, PointObjectives};

/// A number and its 95% interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimated {
    /// The estimate.
    pub value: f64,
    /// Its interval; `None` when the spread cannot be estimated.
    pub interval: Option<(f64, f64)>,
}

/// What else can be said of a method than its overall performance; relative to the reference.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Summaries {
    /// Mean objective divided by the reference's mean objective, both weighted by importance.
    pub ratio_of_means: Option<Estimated>,
    /// Median score, weighted by importance.
    pub median: Option<Estimated>,
    /// Geometric mean of the scores, weighted by importance.
    pub geometric_mean: Option<Estimated>,
    /// Mean score over the point MDPs of every regime, in the order of [`super::Measures::regimes`].
    pub by_regime: Vec<Option<Estimated>>,
}

/// Returns the overall performance with its resamples, and the other summaries from the same ones.
///
/// # Arguments
///
/// * `points` — the point MDPs in the estimate and what was measured there.
/// * `regimes` — number of regimes.
/// * `relative` — whether scores are divided by a reference; ratios and geometric means of others say nothing.
pub(super) fn summarise(
    points: &[(&PointSummary, PointObjectives)],
    estimator: &dyn Estimator,
    sample: Sample<'_>,
    (regimes, relative): (usize, bool),
    rng: &mut ChaCha8Rng,
) -> (Option<Estimate>, Summaries) {
    let objectives: Vec<PointObjectives> = points.iter().map(|(_, o)| o.clone()).collect();
    // Of a point MDP that a model predicts it is not known.
    let regime_of = |point: usize| points.get(point)?.0.regime;
    let of_regime = |regime: usize| {
        move |means: &[PointMeans]| {
            let members = means.iter().filter(|m| regime_of(m.point) == Some(regime));
            weighted_mean(members.map(|m| (m.weight, m.score)))
        }
    };
    let of_regimes: Vec<_> = (0..regimes).map(of_regime).collect();
    let median = |means: &[PointMeans]| weighted_median(scores(means));
    let geometric = |means: &[PointMeans]| geometric_mean(scores(means));
    let mut statistics: Vec<Statistic<'_>> =
        vec![&mean_of_scores, &ratio_of_means, &median, &geometric];
    statistics.extend(of_regimes.iter().map(|of_regime| of_regime as Statistic<'_>));
    let Ok(mut all) = estimator.estimate_all(sample, &objectives, &statistics, rng) else {
        return (None, Summaries { by_regime: vec![None; regimes], ..Summaries::default() });
    };
    let estimated = |e: &Option<Estimate>| {
        e.as_ref().map(|e| Estimated { value: e.value, interval: e.interval })
    };
    // One representative of a regime says nothing of how much its point MDPs differ.
    let sampled = !estimator.is_whole(sample.family_size, points.len());
    let alone = |regime: usize| {
        sampled && points.iter().filter(|(p, _)| p.regime == Some(regime)).count() < 2
    };
    let in_regime = |regime: usize| {
        let e = estimated(&all[4 + regime])?;
        Some(if alone(regime) { Estimated { interval: None, ..e } } else { e })
    };
    let summaries = Summaries {
        by_regime: (0..regimes).map(in_regime).collect(),
        ratio_of_means: estimated(&all[1]).filter(|_| relative),
        median: estimated(&all[2]),
        geometric_mean: estimated(&all[3]).filter(|_| relative),
    };
    (all.swap_remove(0), summaries)
}
