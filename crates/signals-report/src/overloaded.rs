//! The part of a family that the baseline leaves at level of service F.

use super::measures::AT_F;
use evaluation::analysis::PointSummary;
use evaluation::report::format;
use evaluation::stats::score::weighted_mean;

/// The point MDPs that the baseline leaves at level of service F.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overloaded {
    /// How many they are.
    pub points: usize,
    /// Their share of the weight.
    pub importance: f64,
    /// Their share of the mean delay under the baseline.
    pub delay: f64,
}

impl Overloaded {
    /// Returns how many point MDPs are at level F, and what they weigh.
    pub(super) fn in_words(&self) -> String {
        match self.points {
            0 => "no point MDP is at level of service F".to_owned(),
            n => format!(
                "{} {} at level of service F, with {} of the importance and {} of the delay",
                format::count(n, "point MDP"),
                if n == 1 { "is" } else { "are" },
                format::percent(self.importance),
                format::percent(self.delay)
            ),
        }
    }
}

/// Returns which part of the family the baseline leaves at F; `None` when that is not known of some
/// point MDP. `baseline` is its position among the methods.
pub(super) fn overloaded(points: &[PointSummary], baseline: usize) -> Option<Overloaded> {
    let of = |p: &PointSummary| {
        Some((p.regime? == AT_F, p.weight, p.results[baseline].as_ref()?.objective))
    };
    let known = points.iter().map(of).collect::<Option<Vec<(bool, f64, f64)>>>()?;
    let share = |value: &dyn Fn(&(bool, f64, f64)) -> f64| {
        weighted_mean(known.iter().map(|k| (value(k), if k.0 { 1.0 } else { 0.0 })))
    };
    Some(Overloaded {
        points: known.iter().filter(|k| k.0).count(),
        importance: share(&|k| k.1)?,
        delay: share(&|k| k.1 * k.2)?,
    })
}
