//! Models that predict a score from what is known of a point MDP: ridge regression and Gaussian processes, chosen and
//! fitted without seeing what they are judged on.
//!
//! Pure functions of numbers: rows are point MDPs, columns what is known of them.

mod cross_fit;
mod gaussian_process;
mod length_scales;
mod ridge;

pub use cross_fit::{Known, Prediction, cross_fit};
pub use length_scales::{Curve, LengthScales, length_scales};

/// A fitted model.
trait Predict {
    /// Returns the prediction for a row.
    fn predict(&self, row: &[f64]) -> f64;
}

/// Returns mean and standard deviation of values; a deviation of 0 is 1, so that dividing by it changes nothing.
fn standard(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / n;
    let sd = (values.map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt();
    (mean, if sd > 1e-9 * mean.abs().max(1e-9) { sd } else { 1.0 })
}

/// Shifts and scales columns as those of some rows are.
struct Scaling(Vec<(f64, f64)>);

impl Scaling {
    fn of(rows: &[&[f64]]) -> Self {
        let columns = rows.first().map_or(0, |row| row.len());
        Self((0..columns).map(|c| standard(rows.iter().map(move |row| row[c]))).collect())
    }

    fn apply(&self, row: &[f64]) -> Vec<f64> {
        row.iter().zip(&self.0).map(|(x, (mean, sd))| (x - mean) / sd).collect()
    }
}
