//! Summaries of a method beside its score: other means, and the regimes of the baseline apart.

use rand_chacha::ChaCha8Rng;

use super::estimator::{Estimate, Estimator, Sample};
use crate::stats::iqm::mean_of_sorted;
use crate::stats::profile::share_below;
use crate::stats::quantile::containing;
use crate::stats::summary::{
    geometric_mean, mean_of_scores, ratio_of_means, scores, weighted_median,
};
use crate::stats::weighted_quantile::{is_coarse, median_interval, quantile_of_sorted, sorted};
use crate::stats::{PointMeans, PointObjectives};

/// Positions of the statistics; the mean of scores is the first, and with the ratio the only mean over the family; those
/// of the regimes are the last, in their order.
const RATIO: usize = 1;
const MEDIAN: usize = 2;
const GEOMETRIC: usize = 3;
const IQM: usize = 4;
const BELOW: usize = 5;
const REGIMES: usize = 6;

/// A number and its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimated {
    /// The estimate.
    pub value: f64,
    /// Its interval; `None` when the spread cannot be estimated.
    pub interval: Option<(f64, f64)>,
}

impl Estimated {
    /// Returns it with its interval cut to what can be, as [`bounds`] has it; the value itself stays inside.
    pub(super) fn cut(self, (least, most): (f64, f64)) -> Self {
        let (least, most) = (least.min(self.value), most.max(self.value));
        let cut = |(low, high): (f64, f64)| (low.max(least), high.min(most));
        Self { interval: self.interval.map(cut), ..self }
    }
}

/// Returns what scores can be at least and at most: not below 0 where nothing that was measured is, as of delays.
///
/// # Arguments
///
/// * `most` — the most that the domain allows; infinite where it does not say.
pub(super) fn bounds(most: f64, mut measured: impl Iterator<Item = f64>) -> (f64, f64) {
    (if measured.all(|value| value >= 0.0) { 0.0 } else { f64::NEG_INFINITY }, most)
}

/// What else can be said of a method than its overall performance; relative to the reference.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Summaries {
    /// Mean objective divided by the reference's mean objective, both weighted by importance.
    pub ratio_of_means: Option<Estimated>,
    /// Median score, weighted by importance.
    pub median: Option<Estimated>,
    /// Geometric mean of the scores, weighted by importance.
    pub geometric_mean: Option<Estimated>,
    /// Interquartile mean of the scores, weighted by importance.
    pub interquartile_mean: Option<Estimated>,
    /// Mean score over the point MDPs of every regime, in the order of [`super::Measures::regimes`].
    pub by_regime: Vec<Option<Estimated>>,
}

/// Returns the overall performance with its resamples, and the other summaries from the same ones.
pub(super) fn summarise(
    (regime_of, objectives): (&[Option<usize>], &[PointObjectives]),
    estimator: Estimator,
    sample: Sample<'_>,
    (regimes, relative, most): (usize, bool, f64),
    rng: &mut ChaCha8Rng,
) -> (Option<Estimate>, Summaries) {
    let whole: Vec<PointMeans> =
        objectives.iter().enumerate().filter_map(|(i, o)| o.means(i).ok()).collect();
    let middle = weighted_median(scores(&whole));
    let coarse = is_coarse(whole.iter().map(|m| m.weight));
    // Computed together: those that need scores in order sort them once.
    let values = |points: &[PointMeans], values: &mut Vec<Option<f64>>| {
        let in_order = sorted(scores(points));
        values.extend([
            mean_of_scores(points),
            ratio_of_means(points),
            quantile_of_sorted(&in_order, 0.5),
            geometric_mean(scores(points)),
            mean_of_sorted(&in_order),
            middle.and_then(|middle| share_below(scores(points), middle)),
        ]);
        let mut sums = vec![(0.0, 0.0); regimes];
        for point in points {
            // Of a point MDP that a model predicts it is not known.
            let regime = regime_of.get(point.point).copied().flatten();
            if let Some((top, bottom)) = regime.and_then(|regime| sums.get_mut(regime)) {
                *top += point.weight * point.score;
                *bottom += point.weight;
            }
        }
        values.extend(sums.into_iter().map(|(top, bottom)| (bottom > 0.0).then(|| top / bottom)));
    };
    let Ok(mut all) = estimator.estimate_all(sample, objectives, &(RATIO + 1, values), rng) else {
        return (None, Summaries { by_regime: vec![None; regimes], ..Summaries::default() });
    };
    let bounds = bounds(most, whole.iter().map(|m| m.method));
    let possible = |e: Estimated| e.cut(bounds);
    let estimated = |e: &Option<Estimate>| {
        e.as_ref().map(|e| possible(Estimated { value: e.value, interval: e.interval }))
    };
    let mean = |e: &Option<Estimate>| e.as_ref().map(|e| possible(shifted(e, false)));
    // One representative of a regime says nothing of how much its point MDPs differ.
    let sampled = !estimator.is_known(sample, objectives.len());
    let alone =
        |regime: usize| sampled && regime_of.iter().filter(|r| **r == Some(regime)).count() < 2;
    let in_regime = |regime: usize| {
        let e = mean(&all[REGIMES + regime])?;
        Some(if alone(regime) { Estimated { interval: None, ..e } } else { e })
    };
    let summaries = Summaries {
        by_regime: (0..regimes).map(in_regime).collect(),
        ratio_of_means: estimated(&all[RATIO]).filter(|_| relative),
        median: estimated(&all[MEDIAN]).map(|e| Estimated {
            interval: around_median(e, middle, &whole, estimated(&all[BELOW])),
            ..e
        }),
        geometric_mean: mean(&all[GEOMETRIC]).filter(|_| relative),
        interquartile_mean: all[IQM].as_ref().map(|e| possible(shifted(e, coarse))),
    };
    let score = estimated(&all[0]).and_then(|e| e.interval);
    (all.swap_remove(0).map(|e| Estimate { interval: score, ..e }), summaries)
}

fn around_median(
    median: Estimated,
    middle: Option<f64>,
    whole: &[PointMeans],
    below: Option<Estimated>,
) -> Option<(f64, f64)> {
    let weights = whole.iter().map(|m| m.weight);
    if Some(median.value) != middle || is_coarse(weights) {
        return median.interval.map(|interval| containing(interval, median.value));
    }
    let (low, high) = below?.interval?;
    median_interval(whole.iter().map(|m| (m.weight, m.score)), (high - low) / 2.0)
}

/// Returns an estimate of a statistic that noise shifts, with an interval that contains it.
fn shifted(e: &Estimate, coarse: bool) -> Estimated {
    let moved = if coarse { None } else { e.about(e.alpha) };
    let interval = moved.or(e.interval.map(|interval| containing(interval, e.value)));
    Estimated { value: e.value, interval }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use super::*;
    use crate::stats::bootstrap::RESAMPLES;
    use crate::stats::quantile::{ALPHA, median as plain_median};
    use crate::stats::summary::Statistic;

    const SEEDS: usize = 20;

    /// The chance of an episode to reach the most, per point MDP: two of five always do.
    fn chances(points: usize) -> Vec<f64> {
        let chance = |i: usize| if i % 5 < 2 { 1.0 } else { 0.4 + 0.6 * i as f64 / points as f64 };
        (0..points).map(chance).collect()
    }

    /// Returns per seed 1 with the chance, and 0.2 without.
    fn played(chance: f64, rng: &mut ChaCha8Rng) -> PointObjectives {
        let episode = |rng: &mut ChaCha8Rng| if rng.random::<f64>() < chance { 1.0 } else { 0.2 };
        let method = vec![(0..SEEDS).map(|_| episode(rng)).collect()];
        PointObjectives { weight: 1.0, draws: 1, method, baseline: vec![1.0; SEEDS] }
    }

    fn sample(family_size: usize, objectives: &[PointObjectives]) -> Sample<'_> {
        let chosen = objectives.len();
        Sample {
            family_size,
            chosen,
            method: 0,
            name: "m",
            learned_once: false,
            points: &[],
            design: None,
            resamples: RESAMPLES,
            alpha: ALPHA,
        }
    }

    fn summarised(objectives: &[PointObjectives], family_size: usize) -> Estimated {
        let of = (&vec![None; objectives.len()][..], objectives);
        let (sample, mut rng) = (sample(family_size, objectives), ChaCha8Rng::seed_from_u64(0));
        summarise(of, Estimator::Whole, sample, (0, false, f64::INFINITY), &mut rng)
            .1
            .median
            .unwrap()
    }

    /// Returns the median with the percentile interval of its resamples.
    fn percentile(objectives: &[PointObjectives], family_size: usize) -> Estimated {
        let median: Statistic<'_> = &|means| weighted_median(scores(means));
        let (sample, mut rng) = (sample(family_size, objectives), ChaCha8Rng::seed_from_u64(0));
        let all = Estimator::Whole.estimate_all(sample, objectives, &[median], &mut rng).unwrap();
        let e = all[0].as_ref().unwrap();
        Estimated { value: e.value, interval: e.interval }
    }

    fn within(e: Estimated, value: f64) -> bool {
        e.interval.is_some_and(|(low, high)| low <= value && value <= high)
    }

    #[test]
    fn the_interval_of_the_median_contains_it_where_many_scores_are_at_their_limit() {
        let mut rng = ChaCha8Rng::seed_from_u64(1);
        let objectives: Vec<_> = chances(400).iter().map(|c| played(*c, &mut rng)).collect();
        let (before, now) = (percentile(&objectives, 400), summarised(&objectives, 400));
        assert!(!within(before, before.value), "no such case: {before:?}");
        assert!(now.value == before.value && within(now, now.value), "{now:?}");
    }

    /// How many of 50 samples of a family of 200 have an interval that covers the family's median.
    fn covered(of_family: usize, interval: fn(&[PointObjectives], usize) -> Estimated) -> usize {
        let family = chances(200);
        let truth: Vec<f64> = family.iter().map(|chance| 0.2 + 0.8 * chance).collect();
        let truth = plain_median(&truth).unwrap();
        let mut rng = ChaCha8Rng::seed_from_u64(2);
        let covers = |_: &i32| {
            let mut left = family.clone();
            let draw = |_| {
                let chance = left.swap_remove(rng.random_range(0..left.len()));
                played(chance, &mut rng)
            };
            let drawn: Vec<PointObjectives> = (0..of_family).map(draw).collect();
            within(interval(&drawn, family.len()), truth)
        };
        (0..50).filter(covers).count()
    }

    #[test]
    fn the_interval_of_the_median_of_whole_families_covers_what_percentiles_do_not() {
        let (before, now) = (covered(200, percentile), covered(200, summarised));
        assert!(before < 38 && (43..=50).contains(&now), "{before} and {now} of 50");
    }

    /// Returns the summaries of five point MDPs drawn with replacement, one of which decides; objectives are moved by `by`.
    fn of_five(by: f64, most: f64) -> (Option<Estimate>, Summaries) {
        let drawn = |score: &f64| PointObjectives {
            weight: 1.0,
            draws: 1,
            method: vec![vec![score + by, score * 1.01 + by]],
            baseline: vec![10.0, 10.0],
        };
        let objectives: Vec<_> = [2.0, 3.0, 2.5, 2.0, 400.0].iter().map(drawn).collect();
        let of = (&vec![None; objectives.len()][..], &objectives[..]);
        let (sample, mut rng) = (sample(100, &objectives), ChaCha8Rng::seed_from_u64(0));
        summarise(of, Estimator::WithReplacement, sample, (0, true, most), &mut rng)
    }

    #[test]
    fn intervals_end_where_scores_do() {
        let (score, summaries) = of_five(0.0, 9.0);
        let ends = [
            score.unwrap().interval,
            summaries.ratio_of_means.unwrap().interval,
            summaries.interquartile_mean.unwrap().interval,
        ];
        assert!(
            ends.iter()
                .all(|e| e.is_some_and(|(low, high)| 0.0 <= low && low < high && high < 9.1)),
            "{ends:?}"
        );
        let (negative, _) = of_five(-3.0, f64::INFINITY);
        assert!(negative.unwrap().interval.unwrap().0 < 0.0);
    }

    #[test]
    fn the_interval_of_the_median_of_samples_covers_about_nine_times_of_ten() {
        let now = covered(60, summarised);
        assert!((41..=50).contains(&now), "{now} of 50");
    }
}
