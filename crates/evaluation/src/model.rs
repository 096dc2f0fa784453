//! Length scales of a squared exponential kernel that suit several complete curves at once.
//!
//! A curve is what one method scored everywhere. All curves share the length scales and the noise; each has a mean and an
//! amplitude of its own. A curve that is itself a column is left out of the columns while it is explained. So the length
//! scales say how fast scores change along every column for methods like these, and suit one that is not known yet.
//!
//! The logarithms maximise the marginal likelihood times a prior, by L-BFGS with exact gradients. Deviation: the prior,
//! normal in the logarithms (length scales around the square root of the number of columns, noise around a third of the
//! values' deviation), which the textbook leaves out: few curves do not decide ten length scales.
//!
//! Source: C. Rasmussen and C. Williams, "Gaussian Processes for Machine Learning", 2006, section 5.4; the amplitude is
//! maximised in closed form.

use argmin::core::{CostFunction, Error, Executor, Gradient};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// Pairs of steps and gradients that the search keeps.
const MEMORY: usize = 7;

/// Standard deviation of the prior of every logarithm.
const PRIOR_SD: f64 = 1.0;

/// Added to the diagonal, relative to the variance of the values, so that it can be factorised.
const JITTER: f64 = 1e-8;

/// Most iterations of the search; more change the length scales little.
const ITERATIONS: u64 = 25;

/// What one method scored everywhere.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Its values, shape `[n]`.
    pub values: Vec<f64>,
    /// The column that it is; `None` where it is none.
    pub column: Option<usize>,
}

/// How fast curves change.
#[derive(Debug, Clone, PartialEq)]
pub struct LengthScales {
    /// Length scale of every group of columns, in standard deviations of a column.
    pub lengths: Vec<f64>,
    /// Variance of the noise in proportion to that of the kernel.
    pub noise: f64,
}

/// Returns the length scales that suit curves best; those of the prior without a curve.
///
/// # Arguments
///
/// * `columns` — shape `[d, n]`, standardised.
/// * `groups` — shape `[d]`; columns of a group share a length scale. Groups are numbered from 0.
/// * `curves` — what is to be explained.
pub fn length_scales(columns: &[Vec<f64>], groups: &[usize], curves: &[Curve]) -> LengthScales {
    let count = groups.iter().max().map_or(0, |last| last + 1);
    let start: Vec<f64> =
        std::iter::once(prior_noise()).chain(vec![prior_length(columns.len()); count]).collect();
    let of = |logs: &[f64]| LengthScales {
        lengths: logs[1..].iter().map(|l| libm::exp(*l)).collect(),
        noise: libm::exp(2.0 * logs[0]),
    };
    let differs = |c: &&Curve| c.values.iter().any(|v| *v != c.values[0]);
    let curves: Vec<&Curve> = curves.iter().filter(differs).collect();
    if curves.is_empty() || count == 0 {
        return of(&start);
    }
    let objective = Objective::new(columns, groups, &curves, start.clone());
    let search = LBFGS::new(MoreThuenteLineSearch::new(), MEMORY);
    let begin = start.clone();
    let run = Executor::new(objective, search)
        .configure(|state| state.param(begin).max_iters(ITERATIONS))
        .run();
    // A search that breaks off leaves the prior, which is one too.
    let found = run.ok().and_then(|run| run.state.best_param);
    of(&found.filter(|logs| logs.iter().all(|x| x.is_finite())).unwrap_or(start))
}

/// A curve with the squared differences of the columns that explain it.
struct Explained {
    values: DVector<f64>,
    /// By group, of all pairs `j < i`.
    squares: Vec<Vec<f64>>,
}

/// The negative logarithm of likelihood and prior, as a function of the logarithms of the noise's deviation and of every
/// length scale.
struct Objective {
    curves: Vec<Explained>,
    prior: Vec<f64>,
}

/// What a curve is explained with at some logarithms.
struct Fit {
    kernel: DMatrix<f64>,
    cholesky: Cholesky<f64, Dyn>,
    weights: DVector<f64>,
    /// The amplitude's variance, at its best.
    amplitude: f64,
}

impl Objective {
    fn new(columns: &[Vec<f64>], groups: &[usize], curves: &[&Curve], prior: Vec<f64>) -> Self {
        let n = columns.first().map_or(0, Vec::len);
        let explained = |curve: &&Curve| {
            let mut squares = vec![vec![0.0; n * n.saturating_sub(1) / 2]; prior.len() - 1];
            for (c, column) in columns.iter().enumerate().filter(|(c, _)| Some(*c) != curve.column)
            {
                for (sum, (i, j)) in squares[groups[c]].iter_mut().zip(pairs(n)) {
                    *sum += (column[i] - column[j]).powi(2);
                }
            }
            let (mean, sd) = standard(curve.values.iter().copied());
            let values = curve.values.iter().map(|v| (v - mean) / sd);
            Explained { values: DVector::from_iterator(n, values), squares }
        };
        Self { curves: curves.iter().map(explained).collect(), prior }
    }

    fn fit(curve: &Explained, logs: &[f64]) -> Option<Fit> {
        let n = curve.values.len();
        let mut sums = vec![0.0; n * n.saturating_sub(1) / 2];
        for (squares, l) in curve.squares.iter().zip(&logs[1..]) {
            let scale = libm::exp(-2.0 * l);
            sums.iter_mut().zip(squares).for_each(|(sum, s)| *sum += s * scale);
        }
        let mut kernel = DMatrix::identity(n, n);
        for (pair, sum) in pairs(n).zip(sums) {
            let k = libm::exp(-0.5 * sum);
            (kernel[pair], kernel[(pair.1, pair.0)]) = (k, k);
        }
        let mut noisy = kernel.clone();
        let noise = libm::exp(2.0 * logs[0]) + JITTER;
        (0..n).for_each(|i| noisy[(i, i)] += noise);
        let cholesky = noisy.cholesky()?;
        let weights = cholesky.solve(&curve.values);
        let amplitude = curve.values.dot(&weights) / n as f64;
        (amplitude > 0.0).then_some(Fit { kernel, cholesky, weights, amplitude })
    }
}

impl CostFunction for Objective {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, logs: &Vec<f64>) -> Result<f64, Error> {
        let off = logs.iter().zip(&self.prior).map(|(x, m)| ((x - m) / PRIOR_SD).powi(2));
        let mut cost = 0.5 * off.sum::<f64>();
        for curve in &self.curves {
            let Some(fit) = Self::fit(curve, logs) else { return Ok(f64::INFINITY) };
            let n = curve.values.len() as f64;
            let half = fit.cholesky.l_dirty().diagonal().iter().map(|d| libm::log(*d)).sum::<f64>();
            cost += 0.5 * n * libm::log(fit.amplitude) + half;
        }
        Ok(cost)
    }
}

impl Gradient for Objective {
    type Param = Vec<f64>;
    type Gradient = Vec<f64>;

    fn gradient(&self, logs: &Vec<f64>) -> Result<Vec<f64>, Error> {
        let off = logs.iter().zip(&self.prior);
        let mut gradient: Vec<f64> = off.map(|(x, m)| (x - m) / PRIOR_SD.powi(2)).collect();
        for curve in &self.curves {
            let Some(fit) = Self::fit(curve, logs) else { continue };
            let n = curve.values.len();
            let inverse = fit.cholesky.inverse();
            // Twice the derivative by an entry of the kernel.
            let by = |i: usize, j: usize| {
                inverse[(i, j)] - fit.weights[i] * fit.weights[j] / fit.amplitude
            };
            gradient[0] += (0..n).map(|i| by(i, i)).sum::<f64>() * libm::exp(2.0 * logs[0]);
            let along: Vec<f64> = pairs(n).map(|(i, j)| by(i, j) * fit.kernel[(i, j)]).collect();
            for (group, squares) in curve.squares.iter().enumerate() {
                let sum: f64 = along.iter().zip(squares).map(|(a, s)| a * s).sum();
                gradient[1 + group] += sum * libm::exp(-2.0 * logs[1 + group]);
            }
        }
        Ok(gradient)
    }
}

/// Returns mean and standard deviation of values; a deviation of 0 is 1, so that dividing by it changes nothing.
fn standard(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / n;
    let sd = (values.map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt();
    (mean, if sd > 1e-9 * mean.abs().max(1e-9) { sd } else { 1.0 })
}

fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(|i| (0..i).map(move |j| (i, j)))
}

/// Mean of the prior of the logarithm of the noise's deviation, in deviations of the values.
fn prior_noise() -> f64 {
    (1.0f64 / 3.0).ln()
}

/// Mean of the prior of the logarithm of a length scale.
fn prior_length(columns: usize) -> f64 {
    0.5 * (columns.max(1) as f64).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A column that two curves follow, one that says nothing, and the second curve as a column.
    fn known() -> (Vec<Vec<f64>>, Vec<Curve>) {
        let x: Vec<f64> = (0..40).map(|i| f64::from(i) / 12.0 - 1.6).collect();
        let noise: Vec<f64> = (0..40).map(|i| f64::from(i * 17 % 23) / 7.0 - 1.6).collect();
        let one: Vec<f64> = x.iter().map(|x| (2.0 * x).sin()).collect();
        let two: Vec<f64> = x.iter().map(|x| (1.5 * x).cos() + 3.0).collect();
        let curves = vec![
            Curve { values: one, column: None },
            Curve { values: two.clone(), column: Some(2) },
        ];
        (vec![x, noise, two], curves)
    }

    #[test]
    fn a_column_that_curves_follow_has_the_shorter_length() {
        let (columns, curves) = known();
        let found = length_scales(&columns, &[0, 1, 2], &curves);
        assert!(2.0 * found.lengths[0] < found.lengths[1], "{found:?}");
        assert!(found.noise < 0.05, "{found:?}");
    }

    #[test]
    fn without_curves_the_prior_is_left() {
        let (columns, _) = known();
        let found = length_scales(&columns, &[0, 1, 2], &[]);
        let expected = 3f64.sqrt();
        assert!(found.lengths.iter().all(|l| (l - expected).abs() < 1e-12));
        assert!((found.noise - 1.0 / 9.0).abs() < 1e-12);
        let flat = Curve { values: vec![2.0; 40], column: None };
        assert_eq!(length_scales(&columns, &[0, 1, 2], &[flat]), found);
    }

    #[test]
    fn the_gradient_is_that_of_the_cost() {
        let (columns, curves) = known();
        let curves: Vec<&Curve> = curves.iter().collect();
        let objective = Objective::new(&columns, &[0, 1, 1], &curves, vec![-1.0, 0.3, 0.3]);
        let at = vec![-0.8, 0.4, 0.1];
        let gradient = objective.gradient(&at).unwrap();
        for k in 0..at.len() {
            let moved = |by: f64| {
                let mut logs = at.clone();
                logs[k] += by;
                objective.cost(&logs).unwrap()
            };
            let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
            assert!((slope - gradient[k]).abs() < 1e-4 * slope.abs().max(1.0), "{k}");
        }
    }
}
