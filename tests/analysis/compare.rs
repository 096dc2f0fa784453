//! Runs of one family in one ranking: what is the same as in one run, what is said of their differences, what is refused.

use std::fs;
use std::path::Path;

use crate::common::{run, stderr, stdout, succeed};
use crate::families::{MadeUp, equal};
use crate::made_up::{evaluations, manifest, write_results};
use tsc_family::stats::Direction;
use tsc_family::store::Layout;
use tsc_family::store::manifest::{Manifest, Task};
use tsc_family::store::record::TaskResult;

fn delay_s(task: &Task) -> f64 {
    let by_point = if task.point == "busy" { 40.0 } else { 0.0 };
    let by_method = match task.method.as_str() {
        "baseline" => 60.0,
        "actuated" => 50.0,
        "max-pressure" => 45.0,
        _ => 38.0,
    };
    by_point + by_method + 3.0 * f64::from(task.replicate)
}

/// Writes a run in which every task has the delay that `of` gives, a second less and a second more.
fn write_run(root: &Path, manifest: &Manifest, of: impl Fn(&Task) -> f64) -> Layout {
    fs::create_dir_all(root).unwrap();
    write_results(root, manifest, |task| Some(Ok(episodes(manifest, task, of(task)))))
}

/// Two episodes on the seeds of a task, as the vehicles of its point MDP have them.
fn episodes(manifest: &Manifest, task: &Task, delay_s: f64) -> TaskResult {
    let identity = &manifest.identity;
    let point = identity.points.iter().find(|p| p.point == task.point).unwrap();
    let seeds = point.evaluation_seeds(&identity.evaluation_seeds);
    let mut rows = evaluations(&[delay_s - 1.0, delay_s + 1.0]);
    rows.truncate(seeds.len());
    rows.iter_mut().zip(seeds).for_each(|(row, seed)| row.seed = seed);
    TaskResult { rows, ..TaskResult::default() }
}

fn two_runs(root: &Path, change: impl Fn(&mut Manifest), of_second: impl Fn(&Task) -> f64) {
    write_run(&root.join("one"), &manifest(&["baseline", "actuated", "max-pressure"]), delay_s);
    let mut second = manifest(&["baseline", "idqn", "max-pressure"]);
    change(&mut second);
    write_run(&root.join("two"), &second, of_second);
}

#[test]
fn two_runs_have_the_scores_of_one_run_with_all_their_methods() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    two_runs(root, |_| {}, delay_s);
    let all = manifest(&["baseline", "actuated", "max-pressure", "idqn"]);
    write_run(&root.join("all"), &all, delay_s);
    let text = succeed(root, "compare one two --out compared");
    assert!(text.starts_with("The runs differ in their methods alone.\n"), "{text}");
    let equal = "- baseline in one and two: 4 of 4 shared episodes are equal to the last digit\n";
    assert!(text.contains(equal), "{text}");
    succeed(root, "report all");
    for table in
        ["scores.csv", "summary.csv", "episodes.csv", "pairs.csv", "ranks.csv", "profiles.csv"]
    {
        let of = |folder: &str| fs::read_to_string(root.join(folder).join(table)).unwrap();
        assert_eq!(of("compared"), of("all/report"), "{table}");
    }
    let page = fs::read_to_string(root.join("compared/index.html")).unwrap();
    let place = |text: &str| page.find(text).unwrap();
    assert!(place("comparison of <strong>one, two</strong>") < place("<h1>"));
}

#[test]
fn what_differs_is_said_first_and_measured_where_methods_are_in_both() {
    let folder = tempfile::tempdir().unwrap();
    let change = |manifest: &mut Manifest| {
        let identity = &mut manifest.identity;
        identity.simulator = "SUMO 1.28.0".to_owned();
        identity.settings["signal"]["actions"] = "all-pairs".into();
        // Nobody but idqn reads it, and one run alone has that.
        identity.settings["idqn"]["learning_rate"] = 0.5.into();
        identity.settings["max_pressure"]["count"] = 2.into();
    };
    let other = |task: &Task| delay_s(task) * if task.method == "max-pressure" { 0.9 } else { 1.0 };
    two_runs(folder.path(), change, other);
    let text = succeed(folder.path(), "compare one two");
    insta::assert_snapshot!("differences", text);
    let json = succeed(folder.path(), "compare one two --json");
    assert_eq!(json.lines().count(), 6, "a line of the runs, and one per method");
}

#[test]
fn a_run_with_more_point_mdps_and_seeds_is_compared_on_those_of_the_other() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    let large = manifest(&["baseline", "actuated"]);
    write_run(&root.join("large"), &large, delay_s);
    let mut small = manifest(&["baseline", "idqn"]);
    let identity = &mut small.identity;
    identity.points.truncate(1);
    identity.evaluation_seeds.truncate(1);
    identity.sample.draws.truncate(1);
    identity.sample.draws[0].weight = 1.0;
    identity.sample.budget = 1;
    write_run(&root.join("small"), &small, delay_s);
    let text = succeed(root, "compare large small --out compared");
    let said = "- Point MDPs: 1 of the 2 of large are compared, those of small\n\
                - Evaluation seeds: 1 of the 2 of large are compared\n";
    assert!(text.contains(said), "{text}");
    let scores = fs::read_to_string(root.join("compared/scores.csv")).unwrap();
    // 49 s of actuated on the first seed, not the mean of 50 s.
    assert!(scores.lines().any(|l| l.contains("actuated") && l.contains("49")), "{scores}");
    assert!(!scores.contains("busy"), "{scores}");
}

#[test]
fn more_trainings_of_a_method_join_those_of_another_run() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    write_run(&root.join("one"), &manifest(&["baseline", "idqn"]), delay_s);
    let mut three = manifest(&["baseline", "idqn"]);
    (three.identity.replicates, three.identity.replicated) = (3, vec!["idqn".to_owned()]);
    write_run(&root.join("three"), &three, delay_s);
    succeed(root, "compare one three --out compared");
    succeed(root, "report three");
    let of = |folder: &str| fs::read_to_string(root.join(folder).join("summary.csv")).unwrap();
    assert_eq!(of("compared"), of("three/report"));
}

/// Thirteen of forty tasks of one's own beside a published run: its records fill no gap.
#[test]
fn what_a_run_lacks_is_not_taken_from_another_one() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    let all = manifest(&["baseline", "max-pressure"]);
    write_run(&root.join("published"), &all, delay_s);
    fs::create_dir(root.join("mine")).unwrap();
    write_results(&root.join("mine"), &all, |task| {
        let is_done = task.method == "baseline" || task.point != "busy";
        is_done.then(|| Ok(episodes(&all, task, delay_s(task))))
    });
    let text = succeed(root, "compare published mine");
    assert!(text.contains("max-pressure@published") && text.contains("1/2"), "{text}");
    let said = "- max-pressure in published and mine: 2 of 2 shared episodes are equal to the last digit; mine has 1 of 2 \
                tasks of it\n";
    assert!(text.contains(said), "{text}");
    write_run(&root.join("again"), &all, |task| match &*task.point {
        "busy" => delay_s(task) + 0.5,
        _ => delay_s(task),
    });
    let text = succeed(root, "compare published again");
    let said = "2 of 4 shared episodes are equal to the last digit; the first other one, on busy with seed";
    assert!(text.contains(said), "{text}");
}

#[test]
fn runs_that_cannot_be_compared_are_refused_with_the_place_and_a_way_out() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    two_runs(root, |_| {}, delay_s);
    let other = |name: &str, change: &dyn Fn(&mut Manifest)| {
        let mut manifest = manifest(&["baseline", "idqn"]);
        change(&mut manifest);
        write_run(&root.join(name), &manifest, delay_s);
    };
    other("preset", &|m| m.identity.settings["preset"] = "resco".into());
    other("demand", &|m| m.identity.settings["demand"]["horizon_s"] = 600.0.into());
    other("seed", &|m| (m.identity.base_seed, m.identity.evaluation_seeds) = (1, vec![7, 8]));
    other("importance", &|m| m.identity.points[0].importance = 0.5);
    other("content", &|m| m.identity.points[0].features[1] = 300.0);
    other("named", &|m| {
        m.identity.points[0].point = "calm".to_owned();
        m.identity.sample.draws[0].point = "calm".to_owned();
    });
    other("family", &|m| m.identity.sample.family_size = 9);
    let swimmer = MadeUp {
        objective: "distance_m",
        direction: Direction::Higher,
        baseline: "",
        methods: &["drift", "stroke"],
        points: equal(&[&[1.0, 2.0]]),
    };
    swimmer.write(&root.join("swimmer"));
    let cases = [
        "one", "one one", "one nowhere", "one preset", "one demand", "one seed", "one importance",
        "one content", "one named", "one family", "one swimmer",
    ];
    let said: String = cases
        .iter()
        .map(|args| {
            let output = run(root, &format!("compare {args}"));
            assert_eq!(output.status.code(), Some(2), "{args}: {}", stderr(&output));
            assert_eq!(stdout(&output), "", "{args}");
            format!("compare {args}\n  {}", stderr(&output))
        })
        .collect();
    insta::assert_snapshot!("refused", said);
    fs::create_dir(root.join("thesis")).unwrap();
    fs::write(root.join("thesis/thesis.tex"), "").unwrap();
    let output = run(root, "compare one two --out thesis");
    assert!(stderr(&output).contains("no folder that report wrote"), "{}", stderr(&output));
}

#[test]
fn of_a_folder_the_runs_are_compared_that_fit_the_first_one() {
    let folder = tempfile::tempdir().unwrap();
    let root = folder.path();
    two_runs(&root.join("city"), |_| {}, delay_s);
    let mine = manifest(&["baseline", "mine"]);
    write_run(&root.join("mine"), &mine, delay_s);
    let mut other = manifest(&["baseline", "max-pressure"]);
    other.identity.settings["preset"] = "resco".into();
    write_run(&root.join("city/resco"), &other, delay_s);
    let output = run(root, "compare mine city");
    let (text, said) = (stdout(&output), stderr(&output));
    assert!(output.status.success(), "{said}");
    for method in ["mine", "actuated", "idqn", "max-pressure"] {
        assert!(text.contains(method), "{method}: {text}");
    }
    assert!(said.contains("city/resco is left out: the preset is"), "{said}");
    assert!(text.contains("The runs differ in their methods alone."), "{text}");
    let said = stderr(&run(root, "compare city/resco city"));
    assert!(said.contains("city/one is left out: the preset is"), "{said}");
    assert!(said.contains("none of the runs in city can be compared with city/resco"), "{said}");
    // Folders alone are a leaderboard: a ranking per family, preset and sample.
    let text = succeed(root, "compare city");
    let tables: Vec<&str> = text.lines().filter(|line| line.starts_with("== ")).collect();
    assert!(tables.len() == 2 && tables[1].contains("preset resco"), "{text}");
    let said = stderr(&run(root, "compare mine nowhere"));
    assert!(said.contains("nowhere"), "{said}");
}
