//! Predictions of scores that have not seen what they predict, by the model that predicts best.
//!
//! The sample is cut into folds; every fold's scores are predicted by models fitted on the others, and the family's by the
//! mean of these models, but for the rows of the sample. So a sample that is the whole family leaves nothing to
//! predict. Which model is used, the same folds decide.
//!
//! Guards for few and skewed scores:
//! - predictions stay within the scores that the model was fitted on;
//! - values above 0 are also modelled as logarithms, scaled back so that the fold's weighted mean is met;
//! - a model is used only if its squared error is clearly less than that of the mean ([`GAIN`]).

use rand::SeedableRng;
use rand::seq::SliceRandom;
use rand_chacha::ChaCha8Rng;

use super::Predict;
use super::gaussian_process::{GaussianProcess, Logs, hyper_parameters};
use super::ridge::Ridge;

/// Folds; fewer where there are fewer scores.
const FOLDS: usize = 10;

/// Penalties of ridge regressions, in rows.
const PENALTIES: [f64; 3] = [1.0, 10.0, 100.0];

/// Share of the mean's squared error that a model must be below to be used.
const GAIN: f64 = 0.9;

/// Fewest scores for which a model is tried.
const FEWEST: usize = 8;

/// What is known of every point MDP of a family.
#[derive(Debug, Clone, PartialEq)]
pub struct Known {
    /// Columns with the scores of cheap methods, shape `[family, k]`.
    pub inputs: Vec<Vec<f64>>,
    /// The same with the features, shape `[family, k + d]`.
    pub all: Vec<Vec<f64>>,
}

/// Predictions by the model that was chosen.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Predictions for the sample by models that have not seen them, shape `[n]`.
    pub sample: Vec<f64>,
    /// Predictions for the family, shape `[family]`.
    pub family: Vec<f64>,
}

/// Which columns a model sees.
#[derive(Clone, Copy, PartialEq)]
enum Columns {
    Inputs,
    All,
}

/// A kind of model.
#[derive(Clone)]
enum Kind {
    Mean,
    Ridge(Columns, f64),
    Process(Logs),
}

/// What models are fitted on.
struct Sample<'a> {
    known: &'a Known,
    rows: &'a [usize],
    values: &'a [f64],
    weights: &'a [f64],
    fold: Vec<usize>,
    folds: usize,
}

/// Returns predictions of the model with the least cross-validated squared error.
///
/// # Arguments
///
/// * `known` — what is known of the family.
/// * `rows` — positions of the sample in it, shape `[n]`; `values` — its scores; `weights` — theirs.
/// * `seed` — of the folds.
pub fn cross_fit(
    known: &Known,
    rows: &[usize],
    values: &[f64],
    weights: &[f64],
    seed: u64,
) -> Prediction {
    let n = rows.len();
    let folds = FOLDS.min(n).max(1);
    let mut fold: Vec<usize> = (0..n).map(|i| i % folds).collect();
    fold.shuffle(&mut ChaCha8Rng::seed_from_u64(seed));
    let sample = Sample { known, rows, values, weights, fold, folds };
    let (mut best, worst) = sample.predicted(&Kind::Mean, false);
    if n < FEWEST || worst == 0.0 {
        return best;
    }
    let mut least = GAIN * worst;
    let positive = values.iter().all(|v| *v > 0.0);
    for logarithms in [false, true] {
        if logarithms && !positive {
            continue;
        }
        for kind in sample.kinds(logarithms) {
            let (prediction, error) = sample.predicted(&kind, logarithms);
            if error < least {
                least = error;
                best = prediction;
            }
        }
    }
    best
}

impl Sample<'_> {
    /// Returns the models that are tried.
    fn kinds(&self, logarithms: bool) -> Vec<Kind> {
        let has = |c: Columns| self.matrix(c).first().is_some_and(|row| !row.is_empty());
        let mut kinds = Vec::new();
        for columns in [Columns::Inputs, Columns::All].into_iter().filter(|c| has(*c)) {
            kinds.extend(PENALTIES.map(|penalty| Kind::Ridge(columns, penalty)));
        }
        if has(Columns::All) {
            let rows: Vec<&[f64]> = self.rows.iter().map(|r| &self.known.all[*r][..]).collect();
            let values = transformed(self.values, logarithms);
            kinds.push(Kind::Process(hyper_parameters(&rows, &values)));
        }
        kinds
    }

    fn matrix(&self, columns: Columns) -> &[Vec<f64>] {
        match columns {
            Columns::Inputs => &self.known.inputs,
            Columns::All => &self.known.all,
        }
    }

    /// Returns cross-fitted predictions and their weighted squared error.
    fn predicted(&self, kind: &Kind, logarithms: bool) -> (Prediction, f64) {
        let size = self.known.all.len();
        let mut family = vec![0.0; size];
        let mut sample = vec![0.0; self.rows.len()];
        for fold in 0..self.folds {
            let fitted = self.of_fold(kind, logarithms, fold);
            for (sum, value) in family.iter_mut().zip(&fitted) {
                *sum += value / self.folds as f64;
            }
            for i in (0..sample.len()).filter(|i| self.fold[*i] == fold) {
                sample[i] = fitted[self.rows[i]];
            }
        }
        // What is predicted in the sample has not been seen by its model; so is the family's of the same rows.
        self.rows.iter().zip(&sample).for_each(|(row, value)| family[*row] = *value);
        let off: Vec<f64> = self.values.iter().zip(&sample).map(|(y, m)| y - m).collect();
        let total: f64 = self.weights.iter().sum();
        let mean = off.iter().zip(self.weights).map(|(e, w)| e * w).sum::<f64>() / total;
        let squares = off.iter().zip(self.weights).map(|(e, w)| w * (e - mean).powi(2));
        let error = squares.sum();
        (Prediction { sample, family }, error)
    }

    /// Returns predictions for the family by a model that has not seen a fold.
    fn of_fold(&self, kind: &Kind, logarithms: bool, fold: usize) -> Vec<f64> {
        // With one fold there is nothing to hold back.
        let train: Vec<usize> =
            (0..self.rows.len()).filter(|i| self.folds == 1 || self.fold[*i] != fold).collect();
        let of = |values: &[f64]| -> Vec<f64> { train.iter().map(|i| values[*i]).collect() };
        let (raw, weights) = (of(self.values), of(self.weights));
        let total: f64 = weights.iter().sum();
        let mean = raw.iter().zip(&weights).map(|(y, w)| y * w).sum::<f64>() / total;
        let values = transformed(&raw, logarithms);
        let fit = |columns: Columns| -> Vec<&[f64]> {
            train.iter().map(|i| &self.matrix(columns)[self.rows[*i]][..]).collect()
        };
        let (columns, model): (Columns, Box<dyn Predict>) = match kind {
            Kind::Mean => return vec![mean; self.known.all.len()],
            Kind::Ridge(columns, penalty) => {
                (*columns, Box::new(Ridge::fit(&fit(*columns), &values, *penalty)))
            }
            Kind::Process(logs) => match GaussianProcess::fit(&fit(Columns::All), &values, logs) {
                Some(process) => (Columns::All, Box::new(process)),
                None => return vec![mean; self.known.all.len()],
            },
        };
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let within = |row: &Vec<f64>| model.predict(row).clamp(least, most);
        let mut all: Vec<f64> = self.matrix(columns).iter().map(within).collect();
        if logarithms {
            all.iter_mut().for_each(|x| *x = x.exp());
            let met = train.iter().zip(&weights).map(|(i, w)| w * all[self.rows[*i]]).sum::<f64>();
            all.iter_mut().for_each(|x| *x *= mean * total / met);
        }
        all
    }
}

fn transformed(values: &[f64], logarithms: bool) -> Vec<f64> {
    if logarithms { values.iter().map(|v| v.ln()).collect() } else { values.to_vec() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn known(n: usize, value: impl Fn(usize) -> f64) -> Known {
        let inputs: Vec<Vec<f64>> = (0..n).map(|i| vec![value(i)]).collect();
        let all = (0..n).map(|i| vec![value(i), (i * 5 % 7) as f64]).collect();
        Known { inputs, all }
    }

    /// Whether predictions are all the same, as those of the mean are outside the sample.
    fn is_level(predicted: &[f64]) -> bool {
        predicted.windows(2).all(|pair| pair[0] == pair[1])
    }

    #[test]
    fn a_score_that_follows_a_cheap_one_is_predicted() {
        let known = known(60, |i| (i % 13) as f64);
        let rows: Vec<usize> = (0..60).step_by(2).collect();
        let values: Vec<f64> = rows.iter().map(|r| 0.5 + 0.1 * known.inputs[*r][0]).collect();
        let fitted = cross_fit(&known, &rows, &values, &vec![1.0; rows.len()], 1);
        for (i, predicted) in fitted.family.iter().enumerate() {
            assert!((predicted - 0.5 - 0.1 * known.inputs[i][0]).abs() < 0.1);
        }
    }

    #[test]
    fn noise_is_left_to_the_mean() {
        let known = known(60, |i| (i * i % 17) as f64);
        let rows: Vec<usize> = (0..40).collect();
        let values: Vec<f64> = rows.iter().map(|r| (r * 7919 % 31) as f64).collect();
        let fitted = cross_fit(&known, &rows, &values, &vec![1.0; rows.len()], 1);
        assert!(is_level(&fitted.family[40..]));
    }

    #[test]
    fn predictions_stay_within_the_scores_seen() {
        let mut known = known(40, |i| i as f64);
        known.inputs[39][0] = 1e6;
        known.all[39][0] = 1e6;
        let rows: Vec<usize> = (0..30).collect();
        let values: Vec<f64> = rows.iter().map(|r| 1.0 + *r as f64).collect();
        let fitted = cross_fit(&known, &rows, &values, &vec![1.0; 30], 2);
        // The mean of the scores is 15.5.
        assert!(fitted.family[30] > 25.0 && fitted.family.iter().all(|y| *y < 40.0));
    }

    #[test]
    fn few_scores_are_not_modelled_and_equal_ones_need_no_model() {
        let known = known(20, |i| i as f64);
        let values = [1.0, 2.0, 3.0];
        assert!(is_level(&cross_fit(&known, &[0, 1, 2], &values, &[1.0; 3], 0).family[3..]));
        let rows: Vec<usize> = (0..12).collect();
        let fitted = cross_fit(&known, &rows, &[2.0; 12], &[1.0; 12], 0);
        assert!(fitted.family.iter().all(|y| (y - 2.0).abs() < 1e-12));
    }
}
