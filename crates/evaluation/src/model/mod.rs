//! How fast scores change over what is known of point MDPs: pure functions of numbers.

mod length_scales;

pub use length_scales::{Curve, LengthScales, length_scales};

/// Returns mean and standard deviation of values; a deviation of 0 is 1, so that dividing by it changes nothing.
fn standard(values: impl Iterator<Item = f64> + Clone) -> (f64, f64) {
    let n = values.clone().count().max(1) as f64;
    let mean = values.clone().sum::<f64>() / n;
    let sd = (values.map(|x| (x - mean).powi(2)).sum::<f64>() / n).sqrt();
    (mean, if sd > 1e-9 * mean.abs().max(1e-9) { sd } else { 1.0 })
}
