//! Quantiles of a sample, linearly interpolated.

use super::score::mean;

/// Share of intervals that may miss what they are of, where nothing else is said: they are 95% intervals.
pub const ALPHA: f64 = 0.05;

/// Returns the interval that holds the central `1 - alpha` of the values; `None` of nothing.
pub fn central(values: &[f64], alpha: f64) -> Option<(f64, f64)> {
    if values.is_empty() {
        return None;
    }
    let mut values = values.to_vec();
    let beyond = alpha / 2.0;
    Some((select(&mut values, beyond), select(&mut values, 1.0 - beyond)))
}

/// Returns the central `1 - alpha` of resamples, moved so that their mean is the estimate, and stretched from there; `None`
/// of no resamples.
///
/// For statistics that noise within point MDPs shifts, such as a share below a threshold, or a quotient with a noisy
/// denominator: resamples have that noise once more than the estimate has, and the shift between them is no spread. A
/// percentile interval could exclude the estimate; this one contains it.
pub fn central_about(
    estimate: f64,
    resamples: &[f64],
    (alpha, stretch): (f64, f64),
) -> Option<(f64, f64)> {
    let ((low, high), shift) = central(resamples, alpha).zip(shift(estimate, resamples))?;
    let moved = |end: f64| estimate + stretch * (end - shift - estimate);
    Some(containing((moved(low), moved(high)), estimate))
}

/// Share of resamples that is left out of their mean: with one degree of freedom they have none.
const TAILS: f64 = 0.01;

/// Returns by how much the mean of resamples is above the estimate, exactly 0 where all of them equal it.
pub(super) fn shift(estimate: f64, resamples: &[f64]) -> Option<f64> {
    let (low, high) = central(resamples, TAILS)?;
    let within = resamples.iter().filter(|r| (low..=high).contains(*r));
    let differences: Vec<f64> = within.map(|r| r - estimate).collect();
    mean(&differences)
}

/// Returns an interval, widened so that it contains a value.
pub fn containing((low, high): (f64, f64), value: f64) -> (f64, f64) {
    (low.min(value), high.max(value))
}

/// Returns the median; `None` of nothing.
pub fn median(values: &[f64]) -> Option<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    (!sorted.is_empty()).then(|| quantile(&sorted, 0.5))
}

fn select(values: &mut [f64], q: f64) -> f64 {
    let at = q * (values.len() - 1) as f64;
    let (_, low, above) = values.select_nth_unstable_by(at.floor() as usize, f64::total_cmp);
    let next = above.iter().copied().min_by(f64::total_cmp);
    let high = next.filter(|_| at.fract() > 0.0).unwrap_or(*low);
    *low + (high - *low) * at.fract()
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
    fn a_shift_of_the_resamples_does_not_move_the_interval_from_the_estimate() {
        let values: Vec<f64> = (0..=40).map(|i| 100.0 + f64::from(i)).collect();
        assert_eq!(central_about(7.0, &values, (ALPHA, 1.0)), Some((-12.0, 26.0)));
        assert_eq!(central_about(7.0, &values, (ALPHA, 2.0)), Some((-31.0, 45.0)));
        let mut skewed = vec![0.0; 99];
        skewed.push(10_000.0);
        // One resample in a hundred that is far off is none of the middle.
        assert_eq!(central_about(7.0, &skewed, (ALPHA, 1.0)), Some((7.0, 7.0)));
        assert_eq!(central_about(7.0, &[], (ALPHA, 1.0)), None);
    }
}
