//! Methods on a sample: what is drawn anew is the same for all, and nothing is taken for more certain than it is.

use std::path::Path;

use crate::dropped::{delays, growing};
use crate::made_up::{SEEDS, ended, equal_points, evaluations, manifest, write_results};
use tsc_family::analysis::Analysis;
use tsc_family::sample::{Sampling, Until};
use tsc_family::store::Layout;
use tsc_family::store::manifest::{Manifest, Task};
use tsc_family::store::record::{Metrics, Row, RowKind, TaskResult};
use tsc_family::store::results::Results;

const FAMILY: usize = 164;

const CHOSEN: usize = 20;

/// Balanced samples of point MDPs with these probabilities to be drawn, called `p0`, `p1`, ...
fn balanced(methods: &[&str], inclusion: &[f64]) -> Manifest {
    let mut manifest = manifest(methods);
    let of = |i: usize| (format!("p{i}"), vec![2.0, 100.0 * i as f64]);
    equal_points(&mut manifest, inclusion.len(), of);
    let identity = &mut manifest.identity;
    identity.evaluation_seeds = SEEDS.to_vec();
    identity.points.iter_mut().for_each(|p| p.importance = 1.0 / FAMILY as f64);
    let sample = &mut identity.sample;
    (sample.sampling, sample.family_size) = (Sampling::Balanced, FAMILY);
    sample.draws.iter_mut().zip(inclusion).for_each(|(draw, pi)| draw.inclusion = Some(*pi));
    manifest
}

fn number(task: &Task) -> usize {
    task.point[1..].parse().unwrap()
}

/// A delay that differs between point MDPs and follows no feature, seconds.
fn scattered(number: usize) -> f64 {
    20.0 + (number * 37 % 71) as f64
}

/// A task with the same delay on all seeds; a learner has an episode of training before.
fn steady(delay_s: f64, learns: bool) -> TaskResult {
    let mut rows = evaluations(&[delay_s; SEEDS.len()]);
    if learns {
        let metrics = Metrics::from([("return".to_owned(), -1.0)]);
        rows.insert(0, Row { kind: RowKind::Training, episode: 0, seed: 7, metrics });
    }
    TaskResult { rows, ..TaskResult::default() }
}

fn analysed(layout: &Layout) -> Analysis {
    Analysis::new(&Results::load(layout).unwrap(), &())
}

#[test]
fn a_learner_that_is_better_everywhere_is_surely_first_although_every_sample_has_a_point_mdp() {
    let dir = tempfile::tempdir().unwrap();
    let mut inclusion = [0.12; CHOSEN];
    inclusion[4] = 1.0;
    let manifest = balanced(&["baseline", "max-pressure", "idqn"], &inclusion);
    let layout = write_results(dir.path(), &manifest, |task| {
        let level = scattered(number(task));
        Some(Ok(match task.method.as_str() {
            "baseline" => steady(100.0, false),
            "max-pressure" => steady(level, false),
            _ => steady(level - 1.0 - (number(task) % 3) as f64, true),
        }))
    });
    let data = analysed(&layout);
    assert_eq!(data.methods[0].method, "idqn");
    let ranks = data.comparison.ranks.unwrap();
    assert!(ranks[0][0] > 0.97, "{ranks:?}");
}

#[test]
fn on_the_point_mdps_that_all_finished_intervals_are_those_of_a_method_that_has_just_these() {
    let dir = tempfile::tempdir().unwrap();
    let manifest = balanced(&["baseline", "max-pressure", "actuated"], &[0.95; CHOSEN]);
    let layout = write_results(dir.path(), &manifest, |task| {
        let level = scattered(number(task));
        match task.method.as_str() {
            "baseline" => Some(Ok(steady(100.0, false))),
            "max-pressure" => Some(Ok(steady(level, false))),
            _ => number(task).is_multiple_of(2).then(|| Ok(steady(level + 5.0, false))),
        }
    });
    let data = analysed(&layout);
    let (points, common) = data.common.unwrap();
    assert_eq!(points, CHOSEN / 2);
    let interval = |methods: &[tsc_family::analysis::MethodSummary]| {
        methods.iter().find(|m| m.method == "actuated").unwrap().interval.unwrap()
    };
    assert_eq!(interval(&common), interval(&data.methods));
}

/// Whether a run that grows has enough after its first look, where the baseline may have no delay on a point MDP.
fn is_enough(root: &Path, until: &Until, has_delay: bool) -> bool {
    let layout = write_results(root, &growing(until.clone()), |task| {
        let delays = match has_delay || task.point != "p2" {
            true => delays(task),
            false => [0.0; 2],
        };
        ended(&delays).filter(|_| task.point.as_str() < "p4")
    });
    analysed(&layout).standing().unwrap().is_enough
}

#[test]
fn a_run_that_grows_stops_although_the_baseline_has_no_delay_on_a_point_mdp() {
    let until = Until::FirstPlace(["fixed-time", "ippo"].map(str::to_owned).to_vec());
    for has_delay in [true, false] {
        let dir = tempfile::tempdir().unwrap();
        assert!(is_enough(dir.path(), &until, has_delay), "{has_delay}");
    }
}
