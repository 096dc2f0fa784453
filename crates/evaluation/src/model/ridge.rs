//! Ridge regression: a linear function of standardised columns, with a penalty on its slopes.

use nalgebra::{DMatrix, DVector};

use super::{Predict, Scaling};

/// A fitted ridge regression.
pub(super) struct Ridge {
    scaling: Scaling,
    slopes: DVector<f64>,
    mean: f64,
}

impl Ridge {
    /// Fits `mean + slopes * standardised columns`.
    ///
    /// # Arguments
    ///
    /// * `rows` — shape `[n, d]`; `values` — shape `[n]`.
    /// * `penalty` — on the sum of squared slopes, in units of rows: 1 is as much as one row says.
    pub(super) fn fit(rows: &[&[f64]], values: &[f64], penalty: f64) -> Self {
        let scaling = Scaling::of(rows);
        let d = scaling.0.len();
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let scaled: Vec<f64> = rows.iter().flat_map(|row| scaling.apply(row)).collect();
        let x = DMatrix::from_row_slice(rows.len(), d, &scaled);
        let y = DVector::from_iterator(values.len(), values.iter().map(|v| v - mean));
        let normal = x.transpose() * &x + DMatrix::identity(d, d) * penalty;
        let right = x.transpose() * y;
        let slopes = match normal.cholesky() {
            Some(cholesky) => cholesky.solve(&right),
            None => DVector::zeros(d),
        };
        Self { scaling, slopes, mean }
    }
}

impl Predict for Ridge {
    fn predict(&self, row: &[f64]) -> f64 {
        let scaled = self.scaling.apply(row);
        self.mean + scaled.iter().zip(self.slopes.iter()).map(|(x, b)| x * b).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_function_is_found_and_a_penalty_flattens_it() {
        let rows: Vec<Vec<f64>> =
            (0..12).map(|i| vec![f64::from(i), f64::from(i * i % 5)]).collect();
        let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
        let values: Vec<f64> = rows.iter().map(|r| 3.0 + 2.0 * r[0] - r[1]).collect();
        let steep = Ridge::fit(&rows, &values, 1e-9);
        assert!((steep.predict(&[20.0, 1.0]) - 42.0).abs() < 1e-5);
        let flat = Ridge::fit(&rows, &values, 1e9);
        let mean = values.iter().sum::<f64>() / 12.0;
        assert!((flat.predict(&[20.0, 1.0]) - mean).abs() < 1e-5);
    }

    #[test]
    fn columns_that_never_vary_or_repeat_do_no_harm() {
        let rows: Vec<Vec<f64>> = (0..6).map(|i| vec![7.0, f64::from(i), f64::from(i)]).collect();
        let rows: Vec<&[f64]> = rows.iter().map(Vec::as_slice).collect();
        let values: Vec<f64> = rows.iter().map(|r| r[1]).collect();
        let fit = Ridge::fit(&rows, &values, 1e-3);
        assert!((fit.predict(&[7.0, 2.0, 2.0]) - 2.0).abs() < 1e-2);
    }
}
