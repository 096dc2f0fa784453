//! M4, model-assisted: balanced samples, with a model of the scores that knows what cheap methods achieve everywhere.
//!
//! With `T` a statistic, `U` the family with predicted scores, `s` the sample with observed and with predicted ones, the
//! estimate is `T(U) + T(s, observed) - T(s, predicted)`: what the model says of the family, and what the sample says
//! the model is wrong by. A model that predicts nothing leaves Hajek's estimator; one that is biased leaves the estimate
//! unbiased, because every prediction in the sample comes from a model that has not seen it.
//!
//! The interval is that of [`super::Balanced`] over what the model is wrong by, and calibrated: the same sample and the
//! same models say something of every method whose scores are known everywhere, each estimated as if only the others
//! were; where such an interval does not hold what is known, all intervals are widened until it would
//! ([`super::calibration`]). A sample that missed what is extreme shows it there. Statistics that need more than weights,
//! scores and objectives (regimes) are those of the balanced sample.
//!
//! A method whose own scores are known everywhere is predicted by them.
//!
//! Source: C.-E. Särndal, B. Swensson and J. Wretman, "Model Assisted Survey Sampling", 1992, section 6 (difference
//! estimator); V. Chernozhukov et al., "Double/debiased machine learning", The Econometrics Journal 21 (2018)
//! (cross-fitting).

use rand_chacha::ChaCha8Rng;

use super::balanced::{Balanced, resampling};
use super::calibration::widening;
use super::contract::{Estimate, Estimator, Sample};
use super::prediction::modelled;
use super::weighted::estimates;
use crate::model::Prediction;
use crate::sample::{Design, Measure};
use crate::stats::quantile::central;
use crate::stats::summary::Statistics;
use crate::stats::{PointMeans, PointObjectives, StatsError, means};

/// The estimator of balanced samples with the scores of cheap methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Assisted;

impl Estimator for Assisted {
    fn name(&self) -> &'static str {
        "M4"
    }

    fn assumptions(&self) -> &'static str {
        "What a model of the scores is wrong by is alike where point MDPs are alike. A few extreme scores that a small \
         sample may miss are not covered."
    }

    fn estimate_all(
        &self,
        sample: Sample<'_>,
        scores: &[PointObjectives],
        statistics: &dyn Statistics,
        rng: &mut ChaCha8Rng,
    ) -> Result<Vec<Option<Estimate>>, StatsError> {
        let observed = means(scores)?;
        let rows: Option<Vec<usize>> = sample.points.iter().map(|c| c.row).collect();
        let (Some(design), Some(rows)) = (sample.design, rows) else {
            return Balanced.estimate_all(sample, scores, statistics, rng);
        };
        let predicted = predict(design, sample.name, &rows, &observed);
        let family = family(design, &predicted.family);
        let mut of_family = Vec::new();
        statistics.values(&family, &mut of_family);
        let corrected = Corrected { statistics, of_family, predicted: &predicted.sample };
        let resampling = resampling(sample, scores);
        let mut all = estimates(sample, scores, &resampling, &corrected, rng)?;
        if sample.resamples == 0 {
            return Ok(all);
        }
        // Of a method that is known everywhere there is nothing that a sample could miss.
        let widen = match design.input(sample.name, Measure::Score) {
            Some(_) => 1.0,
            None => widening(design, sample.name, &rows, &observed, &resampling),
        };
        for estimate in all.iter_mut().flatten() {
            let value = estimate.value;
            estimate.resamples.iter_mut().for_each(|r| *r = value + widen * (*r - value));
            estimate.interval = central(&estimate.resamples, sample.alpha);
        }
        Ok(all)
    }
}

/// Statistics of the family with predicted scores, and what the sample says they are wrong by.
struct Corrected<'a> {
    statistics: &'a dyn Statistics,
    /// Of the family with predicted scores.
    of_family: Vec<Option<f64>>,
    /// Predicted scores of the sample.
    predicted: &'a [f64],
}

impl Statistics for Corrected<'_> {
    fn values(&self, points: &[PointMeans], values: &mut Vec<Option<f64>>) {
        let predicted = |m: &PointMeans| {
            let score = self.predicted[m.point];
            PointMeans { score, method: score * m.baseline, ..*m }
        };
        let points_predicted: Vec<PointMeans> = points.iter().map(predicted).collect();
        let (mut own, mut of_predicted) = (Vec::new(), Vec::new());
        self.statistics.values(points, &mut own);
        self.statistics.values(&points_predicted, &mut of_predicted);
        let pairs = own.into_iter().zip(self.of_family.iter().zip(of_predicted));
        values.extend(pairs.map(|(own, known)| match known {
            (Some(family), Some(predicted)) => own.map(|own| family + own - predicted),
            _ => own,
        }));
    }
}

/// Returns the family with predicted scores.
fn family(design: &Design, scores: &[f64]) -> Vec<PointMeans> {
    let baseline = (design.inputs.iter())
        .find(|i| i.measure == Measure::Objective)
        .and_then(|i| design.input(&i.method, Measure::Objective))
        .unwrap_or_else(|| vec![1.0; scores.len()]);
    let of =
        |((p, score), baseline): ((&crate::sample::design::DesignPoint, &f64), f64)| PointMeans {
            point: usize::MAX,
            weight: p.importance,
            method: score * baseline,
            baseline,
            score: *score,
        };
    design.points.iter().zip(scores).zip(baseline).map(of).collect()
}

/// Returns predicted scores of a method.
///
/// # Arguments
///
/// * `rows` — positions of the sample in the design.
fn predict(design: &Design, method: &str, rows: &[usize], observed: &[PointMeans]) -> Prediction {
    if let Some(own) = design.input(method, Measure::Score) {
        let sample = rows.iter().map(|r| own[*r]).collect();
        return Prediction { sample, family: own, model: "its own scores", error: 0.0 };
    }
    let scores: Vec<f64> = observed.iter().map(|m| m.score).collect();
    let weights: Vec<f64> = observed.iter().map(|m| m.weight).collect();
    modelled(design, rows, &scores, &weights)
}
