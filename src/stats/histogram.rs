//! A histogram with a last bin for everything beyond the limit, so that one extreme value (a
//! gridlock scores 50) does not squeeze the rest into a corner.

/// Limits to choose from, each with its bin width; both dimensionless scores.
const SCALES: [(f64, f64); 5] = [(1.5, 0.05), (2.0, 0.05), (3.0, 0.1), (5.0, 0.1), (10.0, 0.25)];

/// Largest share of the values that may lie beyond the limit before a wider scale is chosen.
const MAX_SHARE_OVER: f64 = 0.05;

/// Counts per bin of equal width from 0 to a limit, and the number of values beyond.
#[derive(Debug, Clone, PartialEq)]
pub struct Histogram {
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

    /// Counts values that are not negative.
    pub fn new(values: &[f64], (limit, width): (f64, f64)) -> Self {
        let bins = (limit / width).round() as usize;
        let mut histogram = Self { width, limit, counts: vec![0; bins], over: 0 };
        for value in values {
            // A value like 0.15 / 0.05 = 2.9999999999999996 belongs to bin 3.
            let bin = (value / width + 1e-9).floor() as usize;
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
    fn a_gridlock_is_counted_beyond_the_limit() {
        let h = Histogram::new(&[0.15, 0.19, 0.5, 52.0], (1.5, 0.05));
        assert_eq!((h.counts[3], h.counts[10], h.over), (2, 1, 1));
        assert_eq!(h.peak(), 2);
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
