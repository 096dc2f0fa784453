//! The y axis of learning curves: logarithmic for what is relative, else linear.

use super::format;
use super::svg::nice_step;
use super::whole::Report;

/// Smallest ratio on the axis, which has no 0.
const LEAST: f64 = 0.01;

/// Space above and below the curves, decades, or as a share of their range.
const PAD_DECADES: f64 = 0.04;
const PAD: f64 = 0.06;

/// What the y axis of learning curves has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scale {
    /// Ratios, their logarithms apart; 1 is what they are relative to.
    Ratio,
    /// Values themselves.
    Value,
}

impl Scale {
    /// Returns the scale of a report.
    pub(super) fn of(data: &Report) -> Self {
        if data.reference.is_none() { Self::Value } else { Self::Ratio }
    }

    /// Returns where a value is on the axis.
    pub(super) fn at(self, value: f64) -> f64 {
        match self {
            Self::Ratio => value.max(LEAST).log10(),
            Self::Value => value,
        }
    }

    /// Returns the range of the axis; that of ratios always contains 1.
    pub(super) fn range<'a>(self, values: impl Iterator<Item = &'a f64>) -> (f64, f64) {
        let start = match self {
            Self::Ratio => (0.0, 0.0),
            Self::Value => (f64::INFINITY, f64::NEG_INFINITY),
        };
        let ends = |(a, b): (f64, f64), v: f64| (a.min(v), b.max(v));
        let (low, high) = values.map(|v| self.at(*v)).fold(start, ends);
        match self {
            Self::Ratio => (low - PAD_DECADES, high + PAD_DECADES),
            Self::Value => padded(low, high),
        }
    }

    /// Returns where the axis is marked, and with what.
    pub(super) fn marks(self, low: f64, high: f64) -> Vec<(f64, String)> {
        match self {
            Self::Ratio => {
                ticks(low, high).into_iter().map(|t| (t.log10(), format::feature(t))).collect()
            }
            Self::Value => linear_marks(low, high),
        }
    }
}

/// Returns a range with space at both ends; values that never move still get an axis around them.
pub(super) fn padded(low: f64, high: f64) -> (f64, f64) {
    let pad = if high > low { PAD * (high - low) } else { low.abs().max(1.0) * PAD };
    (low - pad, high + pad)
}

/// Returns round numbers between two values, and what is written there.
pub(super) fn linear_marks(low: f64, high: f64) -> Vec<(f64, String)> {
    let step = nice_step(high - low, 4.0);
    let (from, to) = ((low / step).ceil() as i64, (high / step).floor() as i64);
    (from..=to).map(|k| (k as f64 * step, number(k as f64 * step))).collect()
}

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

/// Returns a number that fits beside an axis: two significant decimals, powers of 10 where it is tiny
/// or huge.
pub(super) fn number(value: f64) -> String {
    match value.abs() {
        v if v == 0.0 || (0.01..1e5).contains(&v) => format::feature(value),
        _ => format!("{value:.0e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_fewer_on_a_longer_axis() {
        let labels =
            |low, high| ticks(low, high).into_iter().map(format::feature).collect::<Vec<_>>();
        assert_eq!(labels(-0.35, 0.2), ["0.5", "0.7", "1", "1.5"]);
        assert_eq!(labels(-0.5, 1.0), ["0.5", "1", "2", "5", "10"]);
        assert_eq!(labels(-0.5, 2.1), ["1", "10", "100"]);
    }

    #[test]
    fn the_axis_of_ratios_contains_1() {
        let (low, high) = Scale::Ratio.range([5.0, 10.0].iter());
        assert!(low < 0.0 && high > 1.0);
    }

    #[test]
    fn labels_of_an_axis_are_short() {
        let labels = [-1400.0, 0.0, 0.5, 0.002, 2e6].map(number);
        assert_eq!(labels, ["-1400", "0", "0.5", "2e-3", "2e6"]);
    }

    #[test]
    fn the_axis_of_values_holds_them_without_0() {
        assert_eq!(Scale::Value.range([10.0, 20.0].iter()), (9.4, 20.6));
        assert_eq!(Scale::Value.range([-5.0, -5.0].iter()), (-5.3, -4.7));
    }
}
