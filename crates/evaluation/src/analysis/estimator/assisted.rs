//! M4, model-assisted: balanced samples, with a model of the scores that knows what cheap methods achieve everywhere.
//!
//! With `T` a mean over point MDPs, `U` the family with predicted scores, `s` the sample with observed and with predicted
//! ones, the estimate is `T(U) + T(s, observed) - T(s, predicted)`: what the model says of the family, and what the sample
//! says the model is wrong by. A model that predicts nothing leaves Hajek's estimator, but for what the means of folds
//! differ by; one that is biased leaves the estimate unbiased, because every prediction in the sample comes from a model
//! that has not seen it.
//!
//! What is no mean (median, interquartile and geometric mean, shares below a score) is that of the balanced sample: the
//! distribution of predictions is narrower than that of scores, and what a model is wrong by on average says nothing of
//! it. So are regimes, which a prediction does not have.
//!
//! The interval is that of [`Estimator::Balanced`] over what the model is wrong by, and calibrated: the same sample and the
//! same models say something of every method whose scores are known everywhere, each estimated as if only the others
//! were; where such an interval does not hold what is known, all intervals are widened until it would
//! ([`super::calibration`]). A sample that missed what is extreme shows it there.
//!
//! A method whose own scores are known everywhere is predicted by them; then all statistics of the family are known.
//!
//! Source: C.-E. Särndal, B. Swensson and J. Wretman, "Model Assisted Survey Sampling", 1992, section 6 (difference
//! estimator); V. Chernozhukov et al., "Double/debiased machine learning", The Econometrics Journal 21 (2018)
//! (cross-fitting).

use rand_chacha::ChaCha8Rng;

use super::balanced::resampling;
use super::calibration::widening;
use super::contract::{Estimate, Estimator, Sample, estimates};
use crate::model::{Known, Prediction, cross_fit};
use crate::sample::{Design, Measure};
use crate::stats::summary::Statistics;
use crate::stats::{PointMeans, PointObjectives, StatsError, means};

/// Seed of the folds of the cross-validation.
const FOLD_SEED: u64 = 0;

/// Returns the estimates of [`Estimator::Assisted`].
pub(super) fn estimate_all(
    sample: Sample<'_>,
    scores: &[PointObjectives],
    statistics: &dyn Statistics,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Option<Estimate>>, StatsError> {
    let observed = means(scores)?;
    let rows: Option<Vec<usize>> = sample.points.iter().map(|c| c.row).collect();
    let (Some(design), Some(rows)) = (sample.design, rows) else {
        return Estimator::Balanced.estimate_all(sample, scores, statistics, rng);
    };
    let predicted = predict(design, sample.name, &rows, &observed);
    let family = family(design, &predicted.family);
    let mut of_family = Vec::new();
    statistics.values(&family, &mut of_family);
    let is_known = design.input(sample.name, Measure::Score).is_some();
    let modelled = if is_known { of_family.len() } else { statistics.means() };
    of_family[modelled..].fill(None);
    let corrected = Corrected { statistics, of_family, predicted: &predicted.sample };
    let resampling = resampling(sample, scores);
    let mut all = estimates(sample, scores, &resampling, &corrected, rng)?;
    if sample.resamples == 0 {
        return Ok(all);
    }
    // Of a method that is known everywhere there is nothing that a sample could miss.
    let widen = match is_known {
        true => 1.0,
        false => widening(design, sample.name, &rows, &observed, &resampling),
    };
    for estimate in all.iter_mut().take(modelled).flatten() {
        let value = estimate.value;
        estimate.resamples.iter_mut().for_each(|r| *r = value + widen * (*r - value));
        estimate.interval = estimate.about(sample.alpha);
    }
    Ok(all)
}

/// Statistics of the family with predicted scores, and what the sample says they are wrong by.
struct Corrected<'a> {
    statistics: &'a dyn Statistics,
    /// Of the family with predicted scores; `None` for those that are the sample's own.
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

    fn means(&self) -> usize {
        self.statistics.means()
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
        return Prediction { sample, family: own };
    }
    let scores: Vec<f64> = observed.iter().map(|m| m.score).collect();
    let weights: Vec<f64> = observed.iter().map(|m| m.weight).collect();
    modelled(design, rows, &scores, &weights)
}

/// Returns predicted scores of a method that is not among the inputs of the design.
///
/// # Arguments
///
/// * `rows` — positions of the sample in the design; `scores`, `weights` — of the sample.
pub(super) fn modelled(
    design: &Design,
    rows: &[usize],
    scores: &[f64],
    weights: &[f64],
) -> Prediction {
    let known = Known { inputs: design.transformed_inputs(), all: design.coordinates() };
    cross_fit(&known, rows, scores, weights, FOLD_SEED)
}

#[cfg(test)]
mod tests {
    use rand::SeedableRng;

    use super::super::contract::Chosen;
    use super::*;
    use crate::analysis::statistics::{GEOMETRIC, IQM, MEDIAN, SummaryStatistics};
    use crate::sample::design::{DesignPoint, Input};
    use crate::stats::summary::{scores, weighted_median};

    const FAMILY: usize = 60;

    /// A family of which the scores of `cheap` are known.
    fn design() -> Design {
        let input = |method: &str, measure| Input { method: method.to_owned(), measure };
        let point = |i: usize| DesignPoint {
            point: format!("p{i}"),
            importance: 1.0 / FAMILY as f64,
            describing: vec![i as f64],
            inputs: vec![0.5 + (i * 7919 % 31) as f64 / 100.0, 10.0],
        };
        Design {
            inputs: vec![input("cheap", Measure::Score), input("baseline", Measure::Objective)],
            points: (0..FAMILY).map(point).collect(),
            process: None,
        }
    }

    /// What estimators say of scores on a third of the family.
    fn estimated(estimator: Estimator, name: &str, score: impl Fn(usize) -> f64) -> Vec<Estimate> {
        let design = design();
        let rows: Vec<usize> = (0..FAMILY).step_by(3).collect();
        let chosen: Vec<Chosen> = (rows.iter())
            .map(|row| Chosen {
                count: 1,
                inclusion: Some(1.0 / 3.0),
                importance: 1.0 / FAMILY as f64,
                row: Some(*row),
                at: vec![*row as f64],
            })
            .collect();
        let objectives: Vec<PointObjectives> = (rows.iter())
            .map(|row| PointObjectives {
                weight: 1.0 / rows.len() as f64,
                draws: 1,
                method: vec![vec![10.0 * score(*row); 2]],
                baseline: vec![10.0; 2],
            })
            .collect();
        let sample = Sample {
            family_size: FAMILY,
            chosen: rows.len(),
            method: 0,
            name,
            learned_once: false,
            points: &chosen,
            design: Some(&design),
            resamples: 200,
            alpha: 0.05,
        };
        let statistics =
            SummaryStatistics { middle: None, regime_of: &vec![None; rows.len()], regimes: 0 };
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let all = estimator.estimate_all(sample, &objectives, &statistics, &mut rng).unwrap();
        // Shares below the median are not asked for.
        all.into_iter().flatten().collect()
    }

    /// A score that nothing predicts, and once what a training that collapsed has.
    fn unforeseen(row: usize) -> f64 {
        if row == 30 { 45.0 } else { 0.4 + (row * 37 % 11) as f64 / 100.0 }
    }

    #[test]
    fn what_is_no_mean_is_that_of_the_sample_and_not_of_predictions() {
        let (assisted, balanced) = (
            estimated(Estimator::Assisted, "learner", unforeseen),
            estimated(Estimator::Balanced, "learner", unforeseen),
        );
        for statistic in [MEDIAN, GEOMETRIC, IQM] {
            assert_eq!(assisted[statistic], balanced[statistic]);
        }
        assert!((assisted[0].value / balanced[0].value - 1.0).abs() < 0.1, "{}", assisted[0].value);
    }

    #[test]
    fn of_a_method_that_is_known_everywhere_every_statistic_is_the_family_s() {
        let design = design();
        let known = design.input("cheap", Measure::Score).unwrap();
        let family = family(&design, &known);
        let assisted = estimated(Estimator::Assisted, "cheap", |row| known[row]);
        let mean = known.iter().sum::<f64>() / FAMILY as f64;
        assert!((assisted[0].value - mean).abs() < 1e-12);
        let median = weighted_median(scores(&family)).unwrap();
        assert!((assisted[MEDIAN].value - median).abs() < 1e-12);
    }
}
