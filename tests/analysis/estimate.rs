//! `tsc-family estimate`: estimators on a family that is known as a whole.

use std::path::Path;

use clap::ValueEnum;

use crate::common::{run, stderr, stdout, succeed};
use crate::made_up::{ended, equal_points, manifest, write_results};
use tsc_family::sample::design::{Input, Measure};
use tsc_family::stats::{Direction, PointObjectives};
use tsc_family::store::manifest::Manifest;
use tsc_family::study::{Cell, Kind, Recorded, RecordedMethod, StudyPlan, study};

const SIZE: usize = 120;

/// Scores that follow the first feature, with a little that follows nothing.
fn score(i: usize) -> f64 {
    0.4 + 0.02 * (i % 30) as f64 + 0.05 * ((i * 7919 % 13) as f64 / 13.0)
}

fn recorded() -> Recorded {
    let feature =
        |name: &str| tsc_family::family::Feature { name: name.into(), unit: String::new() };
    let total: f64 = (0..SIZE).map(|i| 1.0 + (i % 4) as f64).sum();
    let points = (0..SIZE).map(|i| tsc_family::family::PointMdp {
        id: format!("p{i:03}"),
        title: format!("p{i:03}"),
        features: vec![(i % 30) as f64, (i % 4) as f64],
        importance: (1.0 + (i % 4) as f64) / total,
        instances: 1,
    });
    let features = vec![feature("load"), feature("kind")];
    let family = tsc_family::family::MdpFamily::new("made-up", features, points.collect(), "here");
    let family = family.unwrap();
    let number = |id: &str| id[1..].parse::<usize>().unwrap();
    let scores: Vec<f64> = family.points.iter().map(|p| score(number(&p.id))).collect();
    let objectives = scores.iter().map(|s| PointObjectives {
        weight: 1.0,
        draws: 1,
        method: vec![vec![s * 20.0]],
        baseline: vec![20.0],
    });
    // What a cheap method achieves differs from it by little.
    let cheap = scores.iter().enumerate().map(|(i, s)| 1.1 * s + 0.002 * (i % 5) as f64);
    let input = Input { method: "cheap".into(), measure: Measure::Score };
    Recorded {
        direction: Direction::Lower,
        methods: vec![RecordedMethod {
            name: "learner".into(),
            learns: true,
            objectives: objectives.collect(),
            cost_s: vec![Some(3600.0); SIZE],
            scores: scores.clone(),
        }],
        lacking: Vec::new(),
        inputs: vec![(input, cheap.collect())],
        family,
    }
}

fn plan(budgets: &[usize], repeats: usize, kinds: &[Kind]) -> StudyPlan {
    let (budgets, kinds) = (budgets.to_vec(), kinds.to_vec());
    StudyPlan { budgets, repeats, kinds, seed: 3, resamples: 200 }
}

fn studied(plan: &StudyPlan) -> Vec<Cell> {
    study(&recorded(), plan, &|_| {}).unwrap()
}

#[test]
fn balanced_samples_are_unbiased_and_their_intervals_cover_what_they_promise() {
    let kinds = [Kind::M1, Kind::Balanced];
    let cells = studied(&plan(&[20, 40], 300, &kinds));
    for cell in &cells {
        let bias = (cell.mean - cell.truth).abs();
        assert!(bias < 0.2 * cell.deviation + 0.001, "{:?} {bias}", cell.kind);
        let covered = cell.coverage.unwrap();
        assert!((0.85..=1.0).contains(&covered), "{:?} at {}: {covered}", cell.kind, cell.budget);
        let hours = cell.cpu_hours.unwrap();
        let all = (hours - cell.budget as f64).abs() < 1e-9;
        assert!(if cell.kind == Kind::M1 { hours < cell.budget as f64 } else { all });
    }
    let error = |kind: Kind, budget: usize| {
        cells.iter().find(|c| c.kind == kind && c.budget == budget).unwrap().error
    };
    for budget in [20, 40] {
        assert!(error(Kind::Balanced, budget) < 0.6 * error(Kind::M1, budget));
    }
}

#[test]
fn a_sample_of_everything_misses_nothing_but_draws_with_replacement_do() {
    for cell in studied(&plan(&[SIZE], 3, Kind::value_variants())) {
        assert_eq!(cell.error < 1e-9, cell.kind != Kind::M1, "{:?} {}", cell.kind, cell.error);
        let plain = [Kind::M2, Kind::M3, Kind::Balanced].contains(&cell.kind);
        assert!(cell.error == 0.0 || !plain, "{:?} {}", cell.kind, cell.error);
    }
}

#[test]
fn the_same_plan_gives_the_same_cells_on_one_thread_and_on_four() {
    let plan = plan(&[15], 8, Kind::value_variants());
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| studied(&plan))
    };
    assert_eq!(on(1), on(4));
}

/// A run of a family of twelve; delays rise with the inflow.
fn twelve() -> Manifest {
    let mut manifest = manifest(&["baseline", "steady", "nervous"]);
    equal_points(&mut manifest, 12, |i| (format!("p{i:02}"), vec![2.0, 100.0 * i as f64]));
    manifest
}

fn write_twelve(root: &Path, manifest: &Manifest, without: &str) {
    std::fs::create_dir_all(root).unwrap();
    write_results(root, manifest, |task| {
        let i: f64 = task.point[1..].parse().unwrap();
        let factor = match task.method.as_str() {
            "baseline" => 1.0,
            "steady" => 0.5 + 0.01 * i,
            _ => 0.4 + 0.05 * i,
        };
        let delay = factor * (20.0 + i);
        ended(&[delay, 1.02 * delay]).filter(|_| task.method != without || task.point != "p03")
    });
}

fn fails(folder: &Path, args: &str) -> String {
    let output = run(folder, &format!("estimate {args}"));
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    stderr(&output)
}

#[test]
fn the_command_writes_a_table() {
    let dir = tempfile::tempdir().unwrap();
    write_twelve(&dir.path().join("all"), &twelve(), "");
    let table = succeed(dir.path(), "estimate all --repeats 20");
    for expected in ["N = 10", "Bayesian quadrature", "steady", "nervous"] {
        assert!(table.contains(expected), "{table}");
    }
    let csv = std::fs::read_to_string(dir.path().join("all/estimate/errors.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 2 * 6);
    let json = "estimate all --repeats 20 --json --budgets 3,5 --estimators m3";
    assert_eq!(succeed(dir.path(), json).lines().count(), 2 * 2);
}

#[test]
fn what_has_no_truth_or_another_family_is_refused_with_the_way_out() {
    let dir = tempfile::tempdir().unwrap();
    write_twelve(&dir.path().join("all"), &twelve(), "");
    let mut part = twelve();
    part.identity.sample.family_size = 40;
    write_twelve(&dir.path().join("part"), &part, "");
    let mut other = twelve();
    other.identity.points[4].point = "p77".into();
    other.identity.sample.draws[4].point = "p77".into();
    write_twelve(&dir.path().join("other"), &other, "");
    std::fs::create_dir(dir.path().join("empty")).unwrap();
    let e = fails(dir.path(), "part");
    assert!(
        e.contains("part has 12 of the 40 point MDPs of smoke") && e.contains("--budget all"),
        "{e}"
    );
    let e = fails(dir.path(), "all --assist other");
    assert!(e.contains("other has another family than all"), "{e}");
    assert!(fails(dir.path(), "all --budgets 13").contains("give budgets from 1 to 12"));
    assert!(fails(dir.path(), "all --estimators m1 --assist all").contains("has no effect"));
    fails(dir.path(), "empty");
}

#[test]
fn what_assists_may_be_of_other_settings_which_is_said() {
    let dir = tempfile::tempdir().unwrap();
    let with = |name: &str, settings: serde_json::Value| {
        let mut made = twelve();
        made.identity.settings = settings;
        write_twelve(&dir.path().join(name), &made, "");
    };
    let of = |yellow: u32, rate: f64| {
        serde_json::json!({
            "signal": {"yellow_time_s": yellow, "all_red_s": 1},
            "idqn": {"learning_rate": rate},
        })
    };
    with("all", of(3, 0.1));
    with("same", of(3, 0.2));
    with("other", of(4, 0.1));
    let said = |args: &str| {
        let args = format!("estimate {args} --estimators bq --budgets 5 --repeats 2");
        stderr(&run(dir.path(), &args))
    };
    let told = "other was computed with other settings (signal.yellow_time_s is 4 there and 3 now)";
    assert!(said("all --assist other").contains(told));
    // How a method learns that was not run says nothing.
    assert!(!said("all --assist same").contains("warning"));
}

#[test]
fn a_method_that_lacks_scores_is_left_out_and_named() {
    let dir = tempfile::tempdir().unwrap();
    write_twelve(&dir.path().join("all"), &twelve(), "nervous");
    let output = run(dir.path(), "estimate all --repeats 5");
    assert!(!stdout(&output).contains("nervous"));
    let said = "nervous is left out: it has no score on 1 of the point MDPs";
    assert!(stderr(&output).contains(said), "{output:?}");
}
