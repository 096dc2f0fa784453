//! Plans as files, and estimates that cheap methods assist.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::made_up::{evaluations, manifest, reported, words, write_results};
use tsc_family::analysis::Analysis;
use tsc_family::analysis::estimator::Estimator;
use tsc_family::report;
use tsc_family::sample::plan_file::PlanFile;
use tsc_family::sample::{Design, Draw, Sampling, choose_over};
use tsc_family::store::manifest::Manifest;
use tsc_family::store::record::TaskResult;
use tsc_family::store::results::Results;
use tsc_family::study::Recorded;

fn command(folder: &Path, args: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_tsc-family"));
    command.current_dir(folder).args(args.split_whitespace()).output().unwrap()
}

fn succeed(folder: &Path, args: &str) -> String {
    let output = command(folder, args);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    String::from_utf8(output.stdout).unwrap()
}

fn fails(folder: &Path, args: &str) -> String {
    let output = command(folder, args);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    String::from_utf8(output.stderr).unwrap()
}

#[test]
fn a_plan_is_what_run_evaluates() {
    let dir = tempfile::tempdir().unwrap();
    let planned = succeed(dir.path(), "plan cartpole --budget 5 --seed 3 --out p.json");
    let lines: Vec<&str> = planned.lines().collect();
    assert_eq!(lines[0], "5 of 576 point MDPs of cartpole");
    let listed = succeed(dir.path(), "run cartpole --plan p.json --dry-run");
    for line in &lines[1..] {
        let point = line.split_whitespace().next().unwrap();
        assert!(listed.contains(point), "{listed}");
    }
    let set = "--preset tuned --set training.validation_seeds=3";
    let told = command(dir.path(), &format!("plan cartpole --budget 2 {set} --out r.json"));
    let told = String::from_utf8(told.stderr).unwrap();
    let expected = format!("run it: tsc-family run cartpole {set} --plan r.json --methods ...");
    assert!(told.contains(&expected), "{told}");
    let repeated = succeed(dir.path(), "plan cartpole --budget 5 --seed 3 --out q.json");
    assert_eq!(planned, repeated);
    assert_eq!(
        fs::read(dir.path().join("p.json")).unwrap(),
        fs::read(dir.path().join("q.json")).unwrap()
    );
}

#[test]
fn hours_bound_how_many_point_mdps_are_planned() {
    let dir = tempfile::tempdir().unwrap();
    let of = |hours: &str| {
        let text = succeed(
            dir.path(),
            &format!("plan --hours {hours} --methods idqn --jobs 2 --out p.json"),
        );
        text.split_whitespace().next().unwrap().parse::<usize>().unwrap()
    };
    let (few, many) = (of("0.5"), of("2"));
    assert!(0 < few && 2 * few < many && many < 164, "{few} {many}");
    assert!(fails(dir.path(), "plan --hours 0.001 --methods idqn").contains("give more hours"));
    assert!(fails(dir.path(), "plan --hours 1").contains("--hours needs --methods"));
    assert!(fails(dir.path(), "plan --hours -1 --methods idqn").contains("--hours"));
}

#[test]
fn plans_that_do_not_fit_are_refused_with_the_file_and_the_way_out() {
    let dir = tempfile::tempdir().unwrap();
    succeed(dir.path(), "plan cartpole --budget 4 --out p.json");
    let e = fails(dir.path(), "run smoke --plan p.json --dry-run");
    assert!(e.contains("p.json: it is for another family than smoke"), "{e}");
    let text = fs::read_to_string(dir.path().join("p.json")).unwrap();
    fs::write(dir.path().join("p.json"), text.replacen("\"weight\": 0.25", "\"weight\": 0.75", 1))
        .unwrap();
    let e = fails(dir.path(), "run cartpole --plan p.json --dry-run");
    assert!(e.contains("it was altered") && e.contains("write it anew"), "{e}");
    fs::write(dir.path().join("p.json"), "budget = 4").unwrap();
    assert!(fails(dir.path(), "run cartpole --plan p.json").contains("it is no plan"));
    assert!(fails(dir.path(), "run cartpole --plan nowhere.json").contains("nowhere.json"));
    assert!(
        fails(dir.path(), "plan cartpole --budget 577").contains("give a budget from 1 to 576")
    );
    fails(dir.path(), "plan cartpole --budget 4 --assist nowhere");
    assert!(fails(dir.path(), "run cartpole --assist x").contains("give a --budget"));
}

/// Point MDPs of the made-up family.
const SIZE: usize = 40;

fn forty(methods: &[&str]) -> Manifest {
    let mut manifest = manifest(methods);
    let identity = &mut manifest.identity;
    let pattern = identity.points[0].clone();
    identity.points = (0..SIZE)
        .map(|i| {
            let mut point = pattern.clone();
            point.point = format!("p{i:02}");
            point.features = vec![2.0, 50.0 * (i * 7 % SIZE) as f64];
            point.importance = 1.0 / SIZE as f64;
            point
        })
        .collect();
    let weight = 1.0 / SIZE as f64;
    let draw = |id: &String| Draw { point: id.clone(), weight, count: 1, inclusion: None };
    let ids: Vec<String> = identity.points.iter().map(|p| p.point.clone()).collect();
    identity.sample.draws = ids.iter().map(draw).collect();
    (identity.sample.budget, identity.sample.family_size) = (SIZE, SIZE);
    manifest
}

/// The learner is a tenth better than the cheap method, whose scores follow nothing that features tell.
fn factor(method: &str, i: usize) -> f64 {
    let cheap = 0.4 + (i * 7919 % 37) as f64 / 20.0;
    match method {
        "baseline" => 1.0,
        "cheap" => cheap,
        "odd" => 0.5 + (i * i * 31 % 17) as f64 / 15.0,
        _ => 0.9 * cheap,
    }
}

fn write(root: &Path, manifest: &Manifest) -> tsc_family::store::Layout {
    fs::create_dir_all(root).unwrap();
    write_results(root, manifest, |task| {
        let i: usize = task.point[1..].parse().unwrap();
        let delay = 30.0 * factor(&task.method, i);
        Some(Ok(TaskResult { rows: evaluations(&[delay, delay]), ..TaskResult::default() }))
    })
}

#[test]
fn a_method_that_follows_a_cheap_one_is_estimated_nearly_exactly_from_a_few() {
    let dir = tempfile::tempdir().unwrap();
    let all = write(&dir.path().join("all"), &forty(&["baseline", "cheap"]));
    let results = Results::load(&all).unwrap();
    let analysis = Analysis::new(&results, &tsc_family::analysis::NoMeasures);
    let known = Recorded::of(&analysis, "all").unwrap();
    let mut design = Design::of(&known.family);
    known.add_to(&mut design, "all").unwrap();
    let sample = choose_over(&known.family, &design, Sampling::Balanced, 12, 5).unwrap();
    let plan = PlanFile::new("smoke", sample.clone(), Some(design.clone()));
    assert_eq!(plan.check(&known.family), Ok(()));

    let mut learned = forty(&["baseline", "learner", "odd"]);
    let drawn: Vec<&str> = sample.draws.iter().map(|d| d.point.as_str()).collect();
    learned.identity.points.retain(|p| drawn.contains(&p.point.as_str()));
    learned.identity.sample = sample.clone();
    let folder = dir.path().join("learned");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("design.json"), design.to_json()).unwrap();
    let layout = write(&folder, &learned);

    let truth = (0..SIZE).map(|i| factor("learner", i)).sum::<f64>() / SIZE as f64;
    let data = reported(&layout);
    assert_eq!(data.estimator(), Estimator::Assisted);
    let learner = data.methods.iter().find(|m| m.method == "learner").unwrap();
    let (low, high) = learner.interval.unwrap();
    assert!((learner.overall.unwrap() - truth).abs() < 0.02, "{:?} {truth}", learner.overall);
    assert!(low <= truth && truth <= high && high - low < 0.15, "{low} {high} {truth}");
    // Whoever subtracts two scores finds what the page says they are apart.
    let overall = |m: usize| data.methods[m].overall.unwrap();
    for pair in &data.comparison.pairs {
        let apart = overall(pair.second) - overall(pair.first);
        assert!((pair.ahead.value - apart).abs() < 1e-9, "{apart} {pair:?}");
    }
    let (lead, next) = (data.lead.as_ref().unwrap(), &data.comparison.pairs[0]);
    assert_eq!((lead.difference, Some(lead.interval)), (next.ahead.value, next.ahead.interval));
    // What is known everywhere is estimated as it is, and no sample widens it.
    let mut again = forty(&["baseline", "cheap"]);
    again.identity.points = learned.identity.points.clone();
    again.identity.sample = sample.clone();
    let folder = dir.path().join("again");
    fs::create_dir_all(&folder).unwrap();
    fs::write(folder.join("design.json"), design.to_json()).unwrap();
    let data = reported(&write(&folder, &again));
    let cheap = data.methods.iter().find(|m| m.method == "cheap").unwrap();
    let (low, high) = cheap.interval.unwrap();
    assert!((cheap.overall.unwrap() - truth / 0.9).abs() < 1e-9 && high - low < 1e-9);
    // Without the model the same sample says much less.
    learned.identity.sample.assisted = false;
    let plain = write(&dir.path().join("plain"), &learned);
    fs::write(plain.design(), design.to_json()).unwrap();
    let data = reported(&plain);
    let learner = data.methods.iter().find(|m| m.method == "learner").unwrap();
    let (low, high) = learner.interval.unwrap();
    assert!(high - low > 0.3, "{low} {high}");

    let html =
        fs::read_to_string(report::write(&layout, &reported(&layout)).unwrap().html).unwrap();
    assert!(words(&html).contains("the scores of methods that were run on all point MDPs"));
    // A design that is not the sample's is refused.
    fs::write(layout.design(), b"{}").unwrap();
    let e = Results::load(&layout).unwrap_err().to_string();
    assert!(
        e.contains("design.json") && e.contains("restore it from a copy, or move it away"),
        "{e}"
    );
}
