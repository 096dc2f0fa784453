//! Summaries of a method beside its score: other means, and the two regimes of the baseline apart.

use super::format;
use super::points::PointSummary;
use crate::stats::score::weighted_mean;
use crate::stats::summary::{
    Statistic, geometric_mean, mean_of_scores, ratio_of_means, scores, weighted_median,
};
use crate::stats::{Bootstrap, Design, PointMeans, PointObjectives, bootstrap_all};
use rand_chacha::ChaCha8Rng;

/// A number and its 95% interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimated {
    /// The estimate.
    pub value: f64,
    /// Its interval; `None` when the spread cannot be estimated.
    pub interval: Option<(f64, f64)>,
}

/// What else can be said of a method than its overall performance; relative to the reference, lower
/// is better.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Summaries {
    /// Mean objective divided by the reference's mean objective, both weighted by importance.
    pub ratio_of_means: Option<Estimated>,
    /// Median score, weighted by importance.
    pub median: Option<Estimated>,
    /// Geometric mean of the scores, weighted by importance.
    pub geometric_mean: Option<Estimated>,
    /// Mean score over the point MDPs that the baseline leaves at level of service E or better.
    pub up_to_e: Option<Estimated>,
    /// Mean score over the point MDPs that the baseline leaves at level of service F.
    pub at_f: Option<Estimated>,
}

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
    let known: Option<Vec<(bool, f64, f64)>> = points
        .iter()
        .map(|p| Some((p.at_f?, p.weight, p.results[baseline].as_ref()?.objective)))
        .collect();
    let known = known?;
    let share = |value: &dyn Fn(&(bool, f64, f64)) -> f64| {
        weighted_mean(known.iter().map(|k| (value(k), if k.0 { 1.0 } else { 0.0 })))
    };
    Some(Overloaded {
        points: known.iter().filter(|k| k.0).count(),
        importance: share(&|k| k.1)?,
        delay: share(&|k| k.1 * k.2)?,
    })
}

/// Returns the overall performance with its resamples, and the other summaries from the same ones.
///
/// # Arguments
///
/// * `points` — the point MDPs in the estimate and what was measured there.
/// * `rng`, `trainings` — as [`bootstrap_all`] has them.
pub(super) fn summarise(
    points: &[(&PointSummary, PointObjectives)],
    design: Design,
    rng: &mut ChaCha8Rng,
    trainings: u64,
) -> (Option<Bootstrap>, Summaries) {
    let objectives: Vec<PointObjectives> = points.iter().map(|(_, o)| o.clone()).collect();
    let regime = |at_f: bool| {
        move |means: &[PointMeans]| {
            let members = means.iter().filter(|m| points[m.point].0.at_f == Some(at_f));
            weighted_mean(members.map(|m| (m.weight, m.score)))
        }
    };
    let (up_to_e, at_f) = (regime(false), regime(true));
    let median = |means: &[PointMeans]| weighted_median(scores(means));
    let geometric = |means: &[PointMeans]| geometric_mean(scores(means));
    let statistics: [Statistic<'_>; 6] =
        [&mean_of_scores, &ratio_of_means, &median, &geometric, &up_to_e, &at_f];
    let Ok(mut all) = bootstrap_all(&objectives, design, rng, trainings, &statistics) else {
        return (None, Summaries::default());
    };
    let estimated = |b: &Option<Bootstrap>| {
        b.as_ref().map(|b| Estimated { value: b.estimate, interval: b.interval() })
    };
    // One representative of a regime says nothing of how much its point MDPs differ.
    let sampled = design != Design::Distinct { family_size: points.len() };
    let of_regime = |b: &Option<Bootstrap>, at_f: bool| {
        let members = points.iter().filter(|(p, _)| p.at_f == Some(at_f)).count();
        let alone = sampled && members < 2;
        estimated(b).map(|e| if alone { Estimated { interval: None, ..e } } else { e })
    };
    let summaries = Summaries {
        ratio_of_means: estimated(&all[1]),
        median: estimated(&all[2]),
        geometric_mean: estimated(&all[3]),
        up_to_e: of_regime(&all[4], false),
        at_f: of_regime(&all[5], true),
    };
    (all.swap_remove(0), summaries)
}

impl Summaries {
    /// Returns the summaries of the whole family, each with its name in a sentence.
    pub(super) fn named(&self) -> [(&'static str, Option<Estimated>); 3] {
        [
            ("ratio of mean delays", self.ratio_of_means),
            ("median score", self.median),
            ("geometric mean", self.geometric_mean),
        ]
    }
}
