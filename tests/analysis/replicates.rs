//! Estimates from several independent trainings of a method: they average over them, and the
//! interval covers their spread.

use crate::made_up::{ended, manifest, write_results};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use tsc_family::analysis::Analysis;
use tsc_family::stats::{Bootstrap, PointObjectives, Resampling, bootstrap};
use tsc_family::store::results::Results;

const SEEDS: usize = 4;

/// A bootstrap of a whole family, so that only seeds and trainings are drawn anew.
fn whole(points: &[PointObjectives], trainings: u64) -> Bootstrap {
    bootstrap(points, &Resampling::whole(), &ChaCha8Rng::seed_from_u64(0), trainings).unwrap()
}

fn width(points: &[PointObjectives]) -> f64 {
    let (low, high) = whole(points, 0).interval().unwrap();
    high - low
}

/// A point MDP where every training has one delay on all seeds.
fn steady(weight: f64, trainings: &[f64]) -> PointObjectives {
    let method = trainings.iter().map(|delay| vec![*delay; SEEDS]).collect();
    PointObjectives { weight, draws: 1, method, baseline: vec![10.0; SEEDS] }
}

fn points(trainings: std::ops::Range<usize>) -> impl Strategy<Value = Vec<PointObjectives>> {
    let seeds = || prop::collection::vec(1.0f64..99.0, SEEDS);
    let point = (0.01f64..1.0, prop::collection::vec(seeds(), trainings), seeds());
    let point = point.prop_map(|(weight, method, baseline)| PointObjectives {
        weight,
        draws: 1,
        method,
        baseline,
    });
    prop::collection::vec(point, 1..6)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn trainings_that_are_all_the_same_change_nothing(points in points(1..2), times in 2usize..6) {
        let mut repeated = points.clone();
        for p in &mut repeated {
            p.method = vec![p.method[0].clone(); times];
        }
        let (once, many) = (whole(&points, 0), whole(&repeated, 0));
        prop_assert!((once.estimate - many.estimate).abs() < 1e-9);
        for (a, b) in once.resamples.iter().zip(&many.resamples) {
            prop_assert!((a - b).abs() < 1e-9);
        }
    }

    #[test]
    fn the_interval_grows_with_the_spread_between_trainings(
        spreads in prop::collection::vec((0.01f64..1.0, prop::collection::vec(-4.0f64..4.0, 2..5)), 1..6),
        factor in 1.1f64..5.0,
    ) {
        let points = |factor: f64| -> Vec<PointObjectives> {
            let delays = |d: &[f64]| d.iter().map(|d| 30.0 + factor * d).collect::<Vec<_>>();
            spreads.iter().map(|(weight, d)| steady(*weight, &delays(d))).collect()
        };
        let (narrow, wide) = (width(&points(1.0)), width(&points(factor)));
        prop_assert!((wide - factor * narrow).abs() < 1e-9);
    }
}

#[test]
fn what_scores_are_divided_by_leaves_how_often_a_training_is_better_as_it_is() {
    let dir = tempfile::tempdir().unwrap();
    let mut manifest = manifest(&["baseline", "fixed-time", "idqn"]);
    (manifest.identity.replicates, manifest.identity.replicated) = (2, vec!["idqn".to_owned()]);
    let layout = write_results(dir.path(), &manifest, |task| {
        ended(match (task.method.as_str(), task.replicate) {
            ("baseline", _) => &[100.0, 101.0],
            ("fixed-time", _) => &[25.0, 26.0],
            (_, 0) => &[10.0, 11.0],
            _ => &[30.0, 29.0],
        })
    });
    let results = Results::load(&layout).unwrap();
    let usual = Analysis::new(&results, &());
    let against = Analysis::against(&results, "idqn", &()).unwrap();
    let of = |data: &Analysis| {
        let names: Vec<&str> = data.methods.iter().map(|m| m.method.as_str()).collect();
        assert_eq!(names, ["idqn", "fixed-time", "baseline"]);
        data.comparison.pairs.iter().map(|pair| pair.improvement).collect::<Vec<_>>()
    };
    assert_eq!(of(&usual), of(&against));
    assert_eq!(of(&against)[0].value, 0.5);
    assert_eq!(against.methods[0].interval, Some((1.0, 1.0)));
}

#[test]
fn the_trainings_of_two_methods_have_nothing_in_common() {
    let points: Vec<_> = (0..10).map(|_| steady(1.0, &[5.0, 10.0, 15.0])).collect();
    let (low, high) = whole(&points, 0).difference(&whole(&points, 1)).interval().unwrap();
    let expected = width(&points) * 2.0f64.sqrt();
    assert!((high - low) / expected > 0.9 && (high - low) / expected < 1.1, "{low} to {high}");
}

#[test]
fn the_spread_between_trainings_is_covered_about_95_times_of_100() {
    const RUNS: usize = 200;
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut uniform = move || rng.random_range(-1.0..1.0);
    let mut covered = 0;
    for _ in 0..RUNS {
        let family: Vec<_> = (0..20)
            .map(|_| {
                let baseline: Vec<f64> = (0..SEEDS).map(|_| 20.0 + uniform()).collect();
                let mut training = || {
                    let luck = 5.0 * uniform();
                    baseline.iter().map(|b| 0.8 * b + luck + 0.2 * uniform()).collect()
                };
                let method = (0..3).map(|_| training()).collect();
                PointObjectives { weight: 1.0, draws: 1, method, baseline }
            })
            .collect();
        let (low, high) = whole(&family, 0).interval().unwrap();
        covered += usize::from(low <= 0.8 && 0.8 <= high);
    }
    assert!((180..=198).contains(&covered), "{covered} of {RUNS}");
}
