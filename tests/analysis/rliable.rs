//! Interquartile mean, probability of improvement and performance profiles against rliable's, on the same numbers.
//!
//! `scripts/rliable.sh --write` wrote the stored ones, with rliable 1.2.0 and `scripts/rliable_reference.py`; CI runs
//! `scripts/rliable.sh`, which computes them again and gives this test others in `RLIABLE_REFERENCE`.

use std::{env, fs};

use serde::Deserialize;
use tsc_family::stats::Direction;
use tsc_family::stats::improvement::share_better;
use tsc_family::stats::iqm::interquartile_mean;
use tsc_family::stats::profile::share_beyond;
use tsc_family::stats::score::weighted_mean;

/// Largest difference, of rounding.
const TOLERANCE: f64 = 1e-12;

/// Scores of two methods, shape `[runs, tasks]`, higher is better, and what rliable says of them.
#[derive(Deserialize)]
struct Case {
    x: Vec<Vec<f64>>,
    y: Vec<Vec<f64>>,
    mean_scores: Vec<f64>,
    aggregate_iqm: f64,
    aggregate_iqm_of_runs: f64,
    probability_of_improvement: f64,
    taus: Vec<f64>,
    profile: Vec<f64>,
    profile_of_runs: Vec<f64>,
}

fn cases() -> Vec<Case> {
    let path = env::var("RLIABLE_REFERENCE").unwrap_or("tests/rliable/reference.json".into());
    let cases: Vec<Case> = serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    assert!(cases.len() >= 8 && cases.iter().any(|case| case.mean_scores.len() % 4 != 0));
    cases
}

fn close(ours: f64, theirs: f64) {
    assert!((ours - theirs).abs() <= TOLERANCE, "ours {ours}, rliable's {theirs}");
}

/// Equal weights that do not sum to 1.
fn weighted(values: &[f64]) -> impl Iterator<Item = (f64, f64)> + '_ {
    values.iter().map(|value| (0.3, *value))
}

fn negative(values: &[f64]) -> Vec<f64> {
    values.iter().map(|value| -value).collect()
}

/// Runs per task instead of tasks per run.
fn by_task(scores: &[Vec<f64>]) -> Vec<Vec<f64>> {
    (0..scores[0].len()).map(|task| scores.iter().map(|run| run[task]).collect()).collect()
}

#[test]
fn with_equal_weights_the_interquartile_mean_is_rliable_s() {
    for case in cases() {
        close(interquartile_mean(weighted(&case.mean_scores)).unwrap(), case.aggregate_iqm);
        close(interquartile_mean(weighted(&case.x.concat())).unwrap(), case.aggregate_iqm_of_runs);
    }
}

#[test]
fn with_equal_weights_the_probability_of_improvement_is_rliable_s() {
    for case in cases() {
        let (x, y) = (by_task(&case.x), by_task(&case.y));
        let p = |direction| {
            let of_task = |(x, y): (&Vec<f64>, &Vec<f64>)| share_better(x, y, direction).unwrap();
            weighted_mean(x.iter().zip(&y).map(|task| (0.3, of_task(task)))).unwrap()
        };
        close(p(Direction::Higher), case.probability_of_improvement);
        close(p(Direction::Lower), 1.0 - case.probability_of_improvement);
    }
}

#[test]
fn with_equal_weights_a_profile_is_rliable_s_in_either_direction() {
    for case in cases() {
        for (scores, profile) in
            [(&case.mean_scores, &case.profile), (&case.x.concat(), &case.profile_of_runs)]
        {
            for (tau, theirs) in case.taus.iter().zip(profile) {
                let ours = share_beyond(weighted(scores), *tau, Direction::Higher).unwrap();
                close(ours, *theirs);
                let turned = negative(scores);
                let ours = share_beyond(weighted(&turned), -tau, Direction::Lower).unwrap();
                close(ours, *theirs);
            }
        }
    }
}

#[test]
fn a_task_of_double_weight_counts_as_two() {
    for case in cases() {
        let double = |i: usize| if i.is_multiple_of(3) { 2 } else { 1 };
        let scores = || case.mean_scores.iter().copied().enumerate();
        let weights = || scores().map(|(i, score)| (f64::from(double(i)), score));
        let twice = || scores().flat_map(|(i, score)| vec![(0.3, score); double(i) as usize]);
        for tau in &case.taus {
            let share = |of: Vec<(f64, f64)>| share_beyond(of, *tau, Direction::Higher).unwrap();
            close(share(weights().collect()), share(twice().collect()));
        }
    }
}
