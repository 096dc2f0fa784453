//! A Gaussian process with a squared exponential kernel, one length scale per column (automatic relevance) and noise.
//!
//! `k(x, x') = s^2 exp(-sum_j (x_j - x'_j)^2 / (2 l_j^2)) + e^2 [x = x']` over standardised columns and values. The
//! logarithms of `s`, `l_j` and `e` maximise the marginal likelihood times a prior, by L-BFGS with exact gradients.
//!
//! Deviation: the prior, normal in the logarithms (length scales around the square root of the number of columns, noise
//! around a third of the values' deviation), which the textbook leaves out: 20 scores do not decide ten length scales.
//!
//! Source: C. Rasmussen and C. Williams, "Gaussian Processes for Machine Learning", 2006, sections 2.2 and 5.4.

use argmin::core::{CostFunction, Error, Executor, Gradient};
use argmin::solver::linesearch::MoreThuenteLineSearch;
use argmin::solver::quasinewton::LBFGS;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::{Predict, Scaling, standard};

/// Most iterations of the search for the hyper-parameters; more change predictions little.
const ITERATIONS: u64 = 20;

/// Pairs of steps and gradients that the search keeps.
pub(super) const MEMORY: usize = 7;

/// Standard deviation of the prior of every logarithm.
pub(super) const PRIOR_SD: f64 = 1.0;

/// Added to the diagonal, relative to the variance of the values, so that it can be factorised.
pub(super) const JITTER: f64 = 1e-8;

/// Logarithms of the hyper-parameters: of `s`, of `e`, and of every length scale.
pub(super) type Logs = Vec<f64>;

/// A fitted process.
pub(super) struct GaussianProcess {
    scaling: Scaling,
    rows: Vec<Vec<f64>>,
    weights: DVector<f64>,
    logs: Logs,
    mean: f64,
    sd: f64,
}

/// Standardised rows and values, and per column the squared differences of all pairs `j < i`.
struct Data {
    rows: Vec<Vec<f64>>,
    values: DVector<f64>,
    squares: Vec<Vec<f64>>,
}

impl Data {
    fn of(rows: &[&[f64]], values: &[f64]) -> (Self, Scaling, f64, f64) {
        let scaling = Scaling::of(rows);
        let (mean, sd) = standard(values.iter().copied());
        let scaled: Vec<Vec<f64>> = rows.iter().map(|row| scaling.apply(row)).collect();
        let pairs = |c: usize| {
            let of = |i: usize| (0..i).map(move |j| (i, j));
            let scaled = &scaled;
            (0..scaled.len()).flat_map(of).map(move |(i, j)| (scaled[i][c] - scaled[j][c]).powi(2))
        };
        let squares = (0..scaling.0.len()).map(|c| pairs(c).collect()).collect();
        let values = DVector::from_iterator(values.len(), values.iter().map(|v| (v - mean) / sd));
        (Self { rows: scaled, values, squares }, scaling, mean, sd)
    }

    /// Returns the kernel between all rows without noise.
    fn kernel(&self, logs: &[f64]) -> DMatrix<f64> {
        let n = self.rows.len();
        let mut sums = vec![0.0; n * n.saturating_sub(1) / 2];
        for (squares, l) in self.squares.iter().zip(&logs[2..]) {
            let scale = (-2.0 * l).exp();
            sums.iter_mut().zip(squares).for_each(|(sum, s)| *sum += s * scale);
        }
        let mut kernel = DMatrix::from_element(n, n, (2.0 * logs[0]).exp());
        for (pair, sum) in pairs(n).zip(sums) {
            let k = (2.0 * logs[0] - 0.5 * sum).exp();
            (kernel[pair], kernel[(pair.1, pair.0)]) = (k, k);
        }
        kernel
    }

    fn factorised(&self, logs: &[f64]) -> Option<(DMatrix<f64>, Cholesky<f64, Dyn>)> {
        let kernel = self.kernel(logs);
        let mut noisy = kernel.clone();
        let noise = (2.0 * logs[1]).exp() + JITTER;
        (0..noisy.nrows()).for_each(|i| noisy[(i, i)] += noise);
        Some((kernel, noisy.cholesky()?))
    }
}

/// Returns the pairs `j < i` in the order of [`Data::squares`].
pub(super) fn pairs(n: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..n).flat_map(|i| (0..i).map(move |j| (i, j)))
}

/// Means of the prior of the logarithms.
fn prior(columns: usize) -> Logs {
    [vec![0.0, prior_noise()], vec![prior_length(columns); columns]].concat()
}

/// Mean of the prior of the logarithm of the noise's deviation, in deviations of the values.
pub(super) fn prior_noise() -> f64 {
    (1.0f64 / 3.0).ln()
}

/// Mean of the prior of the logarithm of a length scale.
pub(super) fn prior_length(columns: usize) -> f64 {
    0.5 * (columns.max(1) as f64).ln()
}

fn kernel(a: &[f64], b: &[f64], logs: &[f64]) -> f64 {
    let scaled = a.iter().zip(b).zip(&logs[2..]);
    let squares: f64 = scaled.map(|((x, y), l)| ((x - y) * (-l).exp()).powi(2)).sum();
    (2.0 * logs[0] - 0.5 * squares).exp()
}

/// What the search minimises: the negative logarithm of likelihood and prior.
struct Objective<'a> {
    data: &'a Data,
    prior: Logs,
}

impl CostFunction for Objective<'_> {
    type Param = Logs;
    type Output = f64;

    fn cost(&self, logs: &Logs) -> Result<f64, Error> {
        let Some((_, cholesky)) = self.data.factorised(logs) else { return Ok(f64::INFINITY) };
        let weights = cholesky.solve(&self.data.values);
        let half_determinant: f64 = cholesky.l_dirty().diagonal().iter().map(|d| d.ln()).sum();
        let off: f64 =
            logs.iter().zip(&self.prior).map(|(x, m)| ((x - m) / PRIOR_SD).powi(2)).sum();
        Ok(0.5 * self.data.values.dot(&weights) + half_determinant + 0.5 * off)
    }
}

impl Gradient for Objective<'_> {
    type Param = Logs;
    type Gradient = Logs;

    fn gradient(&self, logs: &Logs) -> Result<Logs, Error> {
        let mut gradient: Logs =
            (logs.iter().zip(&self.prior)).map(|(x, m)| (x - m) / PRIOR_SD.powi(2)).collect();
        let Some((kernel, cholesky)) = self.data.factorised(logs) else { return Ok(gradient) };
        let weights = cholesky.solve(&self.data.values);
        // Half the trace of (K^-1 - w w') dK, for every logarithm.
        let inner = cholesky.inverse() - &weights * weights.transpose();
        let n = self.data.rows.len();
        for i in 0..n {
            gradient[0] += inner[(i, i)] * kernel[(i, i)];
            gradient[1] += inner[(i, i)] * (2.0 * logs[1]).exp();
        }
        let along: Vec<f64> = pairs(n).map(|pair| inner[pair] * kernel[pair]).collect();
        gradient[0] += 2.0 * along.iter().sum::<f64>();
        for (c, log) in logs[2..].iter().enumerate() {
            let sum: f64 = along.iter().zip(&self.data.squares[c]).map(|(a, s)| a * s).sum();
            gradient[2 + c] += sum * (-2.0 * log).exp();
        }
        Ok(gradient)
    }
}

/// Returns the hyper-parameters that suit rows and values best.
pub(super) fn hyper_parameters(rows: &[&[f64]], values: &[f64]) -> Logs {
    let (data, ..) = Data::of(rows, values);
    let start = prior(data.rows.first().map_or(0, Vec::len));
    let objective = Objective { data: &data, prior: start.clone() };
    let search = LBFGS::new(MoreThuenteLineSearch::new(), MEMORY);
    let begin = start.clone();
    let run = Executor::new(objective, search)
        .configure(|state| state.param(begin).max_iters(ITERATIONS))
        .run();
    // A search that breaks off leaves the prior, with which the process is still one.
    let found = run.ok().and_then(|run| run.state.best_param);
    found.filter(|logs| logs.iter().all(|x| x.is_finite())).unwrap_or(start)
}

impl GaussianProcess {
    /// Fits a process with given hyper-parameters; `None` where the kernel cannot be factorised.
    pub(super) fn fit(rows: &[&[f64]], values: &[f64], logs: &Logs) -> Option<Self> {
        let (data, scaling, mean, sd) = Data::of(rows, values);
        let weights = data.factorised(logs)?.1.solve(&data.values);
        Some(Self { scaling, rows: data.rows, weights, logs: logs.clone(), mean, sd })
    }
}

impl Predict for GaussianProcess {
    fn predict(&self, row: &[f64]) -> f64 {
        let row = self.scaling.apply(row);
        let pairs = self.rows.iter().zip(self.weights.iter());
        self.mean + self.sd * pairs.map(|(x, w)| w * kernel(x, &row, &self.logs)).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave() -> (Vec<Vec<f64>>, Vec<f64>) {
        let rows: Vec<Vec<f64>> =
            (0..25).map(|i| vec![f64::from(i) / 4.0, f64::from(i * 7 % 11)]).collect();
        let values = rows.iter().map(|r| r[0].sin() + 4.0).collect();
        (rows, values)
    }

    #[test]
    fn a_curve_is_followed_and_the_column_without_effect_found() {
        let (rows, values) = wave();
        let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
        let logs = hyper_parameters(&rows, &values);
        assert!(logs[3] > logs[2] + 0.5, "the second column says nothing: {logs:?}");
        let process = GaussianProcess::fit(&rows, &values, &logs).unwrap();
        for x in [0.6, 2.1, 4.9] {
            let off = process.predict(&[x, 3.0]) - (x.sin() + 4.0);
            assert!(off.abs() < 0.1, "{x}: {off}");
        }
    }

    #[test]
    fn the_gradient_is_that_of_the_cost() {
        let (rows, values) = wave();
        let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
        let (data, ..) = Data::of(&rows, &values);
        let objective = Objective { data: &data, prior: prior(2) };
        let at = vec![0.2, -0.7, 0.1, 0.4];
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

    #[test]
    fn equal_values_are_predicted_as_they_are() {
        let rows: Vec<Vec<f64>> = (0..5).map(|i| vec![f64::from(i)]).collect();
        let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
        let logs = hyper_parameters(&rows, &[2.0; 5]);
        let process = GaussianProcess::fit(&rows, &[2.0; 5], &logs).unwrap();
        assert!((process.predict(&[9.0]) - 2.0).abs() < 1e-9);
    }
}
