//! What every curve of training has: how it is smoothed, its band, the marks of a logarithmic axis.

/// Episodes of the trailing mean.
pub(super) const SMOOTHED_OVER: usize = 5;

/// Trainings below which the band is their whole range.
pub(super) const FEW_TRAININGS: usize = 5;

/// Quantiles of the band.
pub(super) const BAND: (f64, f64) = (0.1, 0.9);

/// Returns round numbers between two powers of 10, the fewer the further these are apart.
pub(super) fn ticks(low: f64, high: f64) -> Vec<f64> {
    let steps: &[f64] = match high - low {
        span if span < 0.8 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 7.0],
        span if span < 2.0 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let decades = low.floor() as i32..=high.ceil() as i32;
    let all = decades.flat_map(|d| steps.iter().map(move |s| s * 10f64.powi(d)));
    all.filter(|t| (low..=high).contains(&t.log10())).collect()
}

#[cfg(test)]
mod tests {
    use super::super::format;
    use super::*;

    #[test]
    fn ticks_are_fewer_on_a_longer_axis() {
        let labels =
            |low, high| ticks(low, high).into_iter().map(format::feature).collect::<Vec<_>>();
        assert_eq!(labels(-0.35, 0.2), ["0.5", "0.7", "1", "1.5"]);
        assert_eq!(labels(-0.5, 1.0), ["0.5", "1", "2", "5", "10"]);
        assert_eq!(labels(-0.5, 2.1), ["1", "10", "100"]);
    }
}
