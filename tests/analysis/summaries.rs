//! Intervals of the summaries beside the score: they come from the draws of the score, and cover what
//! a sample, other seeds and other trainings would have said.

use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tsc_family::stats::bootstrap::RESAMPLES;
use tsc_family::stats::summary::{
    Statistic, geometric_mean, mean_of_scores, ratio_of_means, scores, weighted_median,
};
use tsc_family::stats::{
    Bootstrap, PointMeans, PointObjectives, Resampling, bootstrap, bootstrap_all,
};

fn median(points: &[PointMeans]) -> Option<f64> {
    weighted_median(scores(points))
}

fn geometric(points: &[PointMeans]) -> Option<f64> {
    geometric_mean(scores(points))
}

const ALL: [Statistic<'static>; 4] = [&mean_of_scores, &ratio_of_means, &median, &geometric];

fn resampled(
    points: &[PointObjectives],
    resampling: &Resampling,
    seed: u64,
) -> Vec<Option<Bootstrap>> {
    bootstrap_all(points, resampling, &mut ChaCha8Rng::seed_from_u64(seed), (0, RESAMPLES), &ALL)
        .unwrap()
}

/// A part of a family of this size that was drawn at random.
fn part(points: &[PointObjectives], family_size: usize) -> Resampling {
    let weights: Vec<f64> = points.iter().map(|p| p.weight).collect();
    let share = points.len() as f64 / family_size as f64;
    Resampling::distinct(&weights, &vec![share; points.len()])
}

fn point(weight: f64, method: &[f64], baseline: &[f64]) -> PointObjectives {
    let (method, baseline) = (vec![method.to_vec()], baseline.to_vec());
    PointObjectives { weight, draws: 1, method, baseline }
}

fn any_points() -> impl Strategy<Value = Vec<PointObjectives>> {
    let values = || prop::collection::vec(0.1f64..100.0, 3);
    let one = (0.01f64..1.0, 1u32..4, prop::collection::vec(values(), 1..3), values());
    let one = one.prop_map(|(weight, draws, method, baseline)| PointObjectives {
        weight,
        draws,
        method,
        baseline,
    });
    prop::collection::vec(one, 1..6)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(16))]

    #[test]
    fn the_score_s_resamples_do_not_depend_on_what_else_is_computed(points in any_points()) {
        for design in [Resampling::whole(), Resampling::draws(&points), part(&points, 50)] {
            let alone = bootstrap(&points, &design, &ChaCha8Rng::seed_from_u64(5), 0).unwrap();
            prop_assert_eq!(Some(alone), resampled(&points, &design, 5)[0].clone());
        }
    }
}

#[test]
fn trainings_that_differ_widen_the_interval_of_every_summary() {
    let steady = |luck: f64| -> Vec<PointObjectives> {
        let method = vec![vec![8.0 - luck; 4], vec![8.0; 4], vec![8.0 + luck; 4]];
        let one = PointObjectives { weight: 1.0, draws: 1, method, baseline: vec![10.0; 4] };
        vec![one; 3]
    };
    let width = |luck: f64| -> Vec<f64> {
        let all = resampled(&steady(luck), &Resampling::whole(), 0);
        all.into_iter().map(|s| s.unwrap().interval().unwrap()).map(|(a, b)| b - a).collect()
    };
    for (narrow, wide) in width(0.5).into_iter().zip(width(3.0)) {
        assert!(wide > 4.0 * narrow, "{narrow} {wide}");
    }
}

#[test]
fn a_sample_s_intervals_cover_the_family_s_summaries_about_95_times_of_100() {
    const RUNS: usize = 100;
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    // A tenth of the family is slow, and the method is worse there.
    let family: Vec<PointObjectives> = (0..200)
        .map(|i| {
            let (score, level) = if i % 10 == 0 { (1.3, 120.0) } else { (0.7, 20.0) };
            let delay = level * rng.random_range(0.7..1.3);
            point(1.0, &[delay * score * rng.random_range(0.8..1.2)], &[delay])
        })
        .collect();
    let truth: Vec<f64> = resampled(&family, &Resampling::whole(), 0)
        .into_iter()
        .map(|s| s.unwrap().estimate)
        .collect();
    let mut covered = [0; 4];
    for run in 0..RUNS {
        let mut left = family.clone();
        let sample: Vec<_> =
            (0..60).map(|_| left.swap_remove(rng.random_range(0..left.len()))).collect();
        let design = part(&sample, family.len());
        for (k, s) in resampled(&sample, &design, run as u64).into_iter().enumerate() {
            let (low, high) = s.unwrap().interval().unwrap();
            covered[k] += usize::from(low <= truth[k] && truth[k] <= high);
        }
    }
    assert!(covered.iter().all(|n| (86..=100).contains(n)), "{covered:?} of {RUNS}");
}
