//! A histogram with a last bin for everything beyond the limit, so that one extreme value (a
//! gridlock scores 50) does not squeeze the rest into a corner.

/// Limits to choose from, each with its bin width; both dimensionless scores.
const SCALES: [(f64, f64); 5] = [(1.5, 0.05), (2.0, 0.05), (3.0, 0.1), (5.0, 0.1), (10.0, 0.25)];

/// Largest share of the values that may lie beyond the limit before a wider scale is chosen.
const MAX_SHARE_OVER: f64 = 0.05;

/// Most bins of a histogram that shows the whole range of its values.
const MAX_BINS: f64 = 40.0;

/// Counts per bin of equal width from a start to a limit, and the number of values beyond.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
    /// Lower end of the first bin.
    pub start: f64,
    /// Width of a bin.
    pub width: f64,
    /// Upper end of the last bin.
    pub limit: f64,
    /// Values per bin; a bin holds its lower end but not its upper end.
    pub counts: Vec<usize>,
    /// Values at the limit or beyond.
    pub over: usize,
}

impl Histogram {
    /// Returns the limit and bin width for values that share an axis: the smallest of 1.5, 2, 3, 5
    /// and 10 beyond which lie at most 5% of the values below 10. Values of 10 and more fit no axis
    /// and do not count.
    pub fn scale(values: &[f64]) -> (f64, f64) {
        let last = SCALES[SCALES.len() - 1];
        let over = |limit: f64| values.iter().filter(|v| **v >= limit && **v < last.0).count();
        let allowed = MAX_SHARE_OVER * over(0.0) as f64;
        SCALES.into_iter().find(|(limit, _)| over(*limit) as f64 <= allowed).unwrap_or(last)
    }

    /// Returns start, limit and bin width for values of any sign that share an axis: at most 40 bins of a round
    /// width that hold them all.
    pub fn range(values: &[f64]) -> (f64, f64, f64) {
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if least > most {
            return (0.0, 1.0, 0.1);
        }
        let span = if most > least { most - least } else { most.abs().max(1.0) };
        let raw = span / MAX_BINS;
        let power = 10f64.powf(raw.log10().floor());
        let steps = [1.0, 2.0, 5.0, 10.0];
        let width = power * steps.into_iter().find(|s| s * power >= raw * 0.999).unwrap_or(10.0);
        let bin = |value: f64| (value / width + 1e-9).floor();
        (bin(least) * width, (bin(most) + 1.0) * width, width)
    }

    /// Counts values that are not negative.
    pub fn new(values: &[f64], (limit, width): (f64, f64)) -> Self {
        Self::within(values, (0.0, limit, width))
    }

    /// Counts values that are not below the start.
    pub fn within(values: &[f64], (start, limit, width): (f64, f64, f64)) -> Self {
        let bins = ((limit - start) / width).round() as usize;
        let mut histogram = Self { start, width, limit, counts: vec![0; bins], over: 0 };
        for value in values {
            // A value like 0.15 / 0.05 = 2.9999999999999996 belongs to bin 3.
            let bin = ((value - start) / width + 1e-9).floor() as usize;
            match histogram.counts.get_mut(bin) {
                Some(count) => *count += 1,
                None => histogram.over += 1,
            }
        }
        histogram
    }

    /// Returns the largest count, the one beyond the limit included.
    pub fn peak(&self) -> usize {
        self.counts.iter().copied().max().unwrap_or(0).max(self.over)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_range_holds_all_values_of_any_sign() {
        let values = [-3.0, -1.0, 0.5, 1.0];
        let h = Histogram::within(&values, Histogram::range(&values));
        assert_eq!((h.start, h.limit, h.width), (-3.0, 1.1, 0.1));
        assert_eq!((h.counts.iter().sum::<usize>(), h.over, h.counts[0]), (4, 0, 1));
        let equal = Histogram::within(&[1.0, 1.0], Histogram::range(&[1.0, 1.0]));
        assert_eq!((equal.peak(), equal.over), (2, 0));
        assert_eq!(Histogram::within(&[], Histogram::range(&[])).peak(), 0);
    }

    #[test]
    fn the_scale_grows_until_few_values_lie_beyond() {
        let mut values = vec![0.7; 99];
        values.push(52.0);
        assert_eq!(Histogram::scale(&values).0, 1.5);
        assert_eq!(Histogram::scale(&[0.7, 1.7]).0, 2.0);
        assert_eq!(Histogram::scale(&[0.7, 7.0]).0, 10.0);
        assert_eq!(Histogram::scale(&[0.7, 40.0]).0, 1.5);
    }
}
