//! What came of many samples: one estimator, one method, one budget.

/// Relative difference that is rounding.
const EXACT: f64 = 1e-9;

/// How far many estimates were off.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// The estimator.
    pub kind: super::Kind,
    /// Name of the method.
    pub method: String,
    /// Number of point MDPs in a sample.
    pub budget: usize,
    /// Overall performance of the whole family.
    pub truth: f64,
    /// Number of samples.
    pub repeats: usize,
    /// Mean of the estimates.
    pub mean: f64,
    /// Standard deviation of the estimates.
    pub deviation: f64,
    /// Root-mean-square error.
    pub error: f64,
    /// Share of the 95% intervals that hold the truth; `None` without intervals.
    pub coverage: Option<f64>,
    /// Mean half-width of the intervals.
    pub half_width: Option<f64>,
    /// Mean time that the tasks of a sample take, CPU-hours, those of cheap methods on all point MDPs not counted; `None`
    /// where that is not known.
    pub cpu_hours: Option<f64>,
}

/// One estimate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Trial {
    pub(super) value: f64,
    pub(super) interval: Option<(f64, f64)>,
    pub(super) cost_s: Option<f64>,
}

impl Cell {
    /// Puts trials together.
    pub(super) fn of(
        (kind, budget): (super::Kind, usize),
        method: &str,
        truth: f64,
        trials: &[Trial],
    ) -> Self {
        let n = trials.len() as f64;
        // A sample that is the whole family gives its performance but for rounding.
        let exact = |x: f64| if (x - truth).abs() <= EXACT * truth.abs() { truth } else { x };
        let trials: Vec<Trial> = (trials.iter())
            .map(|t| Trial {
                value: exact(t.value),
                interval: t.interval.map(|(low, high)| (exact(low), exact(high))),
                ..*t
            })
            .collect();
        let mean = trials.iter().map(|t| t.value).sum::<f64>() / n;
        let squares = |from: f64| trials.iter().map(|t| (t.value - from).powi(2)).sum::<f64>() / n;
        let intervals: Vec<(f64, f64)> = trials.iter().filter_map(|t| t.interval).collect();
        let share = |f: &dyn Fn(&(f64, f64)) -> f64| {
            let sum: f64 = intervals.iter().map(f).sum();
            (!intervals.is_empty()).then(|| sum / intervals.len() as f64)
        };
        let holds = |i: &(f64, f64)| f64::from(u8::from(i.0 <= truth && truth <= i.1));
        let costs: Option<Vec<f64>> = trials.iter().map(|t| t.cost_s).collect();
        Self {
            kind,
            method: method.to_owned(),
            budget,
            truth,
            repeats: trials.len(),
            mean,
            deviation: squares(mean).sqrt(),
            error: squares(truth).sqrt(),
            coverage: share(&holds),
            half_width: share(&|i| (i.1 - i.0) / 2.0),
            cpu_hours: costs.map(|c| c.iter().sum::<f64>() / n / 3600.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::Kind;

    #[test]
    fn errors_are_from_the_truth_and_deviations_from_the_mean() {
        let trial = |value: f64, half: f64| Trial {
            value,
            interval: Some((value - half, value + half)),
            cost_s: Some(1800.0),
        };
        let cell = Cell::of((Kind::M1, 2), "m", 1.0, &[trial(2.0, 1.5), trial(4.0, 1.5)]);
        assert_eq!((cell.mean, cell.deviation, cell.error), (3.0, 1.0, 5f64.sqrt()));
        assert_eq!((cell.coverage, cell.half_width), (Some(0.5), Some(1.5)));
        assert_eq!(cell.cpu_hours, Some(0.5));
    }

    #[test]
    fn what_is_not_known_of_one_trial_is_not_known_of_the_cell() {
        let trial = Trial { value: 1.0, interval: None, cost_s: None };
        let cell = Cell::of((Kind::M3, 1), "m", 1.0, &[trial]);
        assert_eq!((cell.coverage, cell.half_width, cell.cpu_hours), (None, None, None));
    }
}
