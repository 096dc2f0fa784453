//! Quantiles of a sample, linearly interpolated.

/// Lower and upper quantile of a 95% interval.
const QUANTILES: (f64, f64) = (0.025, 0.975);

/// Returns the interval that holds the central 95% of the values; `None` of nothing.
pub fn central_95(values: &[f64]) -> Option<(f64, f64)> {
    if values.is_empty() {
        return None;
    }
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    Some((quantile(&sorted, QUANTILES.0), quantile(&sorted, QUANTILES.1)))
}

/// Returns the median; `None` of nothing.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    (!sorted.is_empty()).then(|| quantile(&sorted, 0.5))
}

/// Returns a quantile of sorted values; between two values it interpolates, as R's type 7 does.
///
/// # Panics
///
/// If there are no values.
pub fn quantile(sorted: &[f64], q: f64) -> f64 {
    let at = q * (sorted.len() - 1) as f64;
    let (low, high) = (sorted[at.floor() as usize], sorted[at.ceil() as usize]);
    low + (high - low) * at.fract()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_interpolate() {
        assert_eq!(quantile(&[1.0, 2.0, 4.0], 0.75), 3.0);
        assert_eq!(quantile(&[7.0], 0.975), 7.0);
    }

    #[test]
    fn the_median_of_an_even_number_lies_between_two() {
        assert_eq!(median(&[4.0, 1.0, 2.0, 9.0]), Some(3.0));
        assert_eq!(median(&[]), None);
    }

    #[test]
    fn the_central_interval_leaves_a_fortieth_on_either_side() {
        let values: Vec<f64> = (0..=40).rev().map(f64::from).collect();
        assert_eq!(central_95(&values), Some((1.0, 39.0)));
        assert_eq!(central_95(&[]), None);
    }
}
