//! What a report says about methods that learn, and about results that are not complete.

use std::fs;
use std::path::Path;

use crate::made_up::{Ending, evaluations, manifest, reported, well_formed, well_linked, words};
use tsc_family::analysis::{Analysis, NoMeasures};
use tsc_family::report::{self, Report, text};
use tsc_family::store::Layout;
use tsc_family::store::manifest::{Manifest, Task};
use tsc_family::store::own::{OwnKind, OwnMethod};
use tsc_family::store::record::{Metrics, Row, RowKind, TaskResult};
use tsc_family::store::results::Results;
use tsc_family::store::wall::Wall;

/// Delays under the baseline on `quiet` and `busy`, seconds.
const BASELINE: [f64; 2] = [20.0, 50.0];

/// Training episodes of every training.
const EPISODES: u32 = 12;

/// A training that ends with a score; its delay falls from twice the baseline's to the baseline's.
fn learned(task: &Task, score: f64) -> Ending {
    trained(task, score, "return")
}

/// A tuning or training whose episodes have a figure of this name.
fn trained(task: &Task, score: f64, figure: &str) -> Ending {
    let unit = BASELINE[usize::from(task.point == "busy")];
    let training = |episode: u32| Row {
        kind: RowKind::Training,
        episode,
        seed: u64::from(episode),
        metrics: named(&[
            ("delay_s", unit * (2.0 - f64::from(episode + 1) / f64::from(EPISODES))),
            (figure, -3.0),
        ]),
    };
    let mut rows: Vec<Row> = (0..EPISODES).map(training).collect();
    rows.extend(evaluations(&[score * unit, score * unit]));
    let best = [("resco_best_delay_s", unit), ("resco_last_ten_delay_s", 1.375 * unit)];
    let wall = Wall { wall_s: 90.0, simulator_s: 80.0, attempts: 1, ..Wall::default() };
    Ok(TaskResult { rows, training: named(&best), wall, ..TaskResult::default() })
}

fn named(metrics: &[(&str, f64)]) -> Metrics {
    metrics.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
}

/// An ending with this many more unfinished vehicles, of 1000, on one of the evaluation seeds.
fn left_behind(ending: Ending, seed: usize, vehicles: f64) -> Ending {
    ending.map(|mut result| {
        let mut rows = result.rows.iter_mut().filter(|r| r.kind == RowKind::Evaluation);
        let metrics = &mut rows.nth(seed).unwrap().metrics;
        metrics.insert("unfinished_veh".to_owned(), metrics["unfinished_veh"] + vehicles);
        result
    })
}

fn untrained(task: &Task, score: f64) -> Ending {
    let delay_s = score * BASELINE[usize::from(task.point == "busy")];
    Ok(TaskResult { rows: evaluations(&[delay_s, delay_s]), ..TaskResult::default() })
}

fn replicated(methods: &[&str], learners: &[&str]) -> Manifest {
    let mut manifest = manifest(methods);
    manifest.identity.replicates = 2;
    manifest.identity.replicated = learners.iter().map(|m| (*m).to_owned()).collect();
    manifest
}

/// A tuned method, a learner that gridlocks once, and one that diverges once.
fn two_learners(root: &Path) -> Layout {
    let methods = ["baseline", "fixed-time", "idqn", "mplight-star"];
    let manifest = replicated(&methods, &["idqn", "mplight-star"]);
    crate::made_up::write_results(root, &manifest, |task| {
        Some(match (task.method.as_str(), task.point.as_str(), task.replicate) {
            ("fixed-time", ..) => trained(task, 0.5, "cycle_s"),
            ("idqn", "busy", 1) => left_behind(learned(task, 3.5), 1, 90.0),
            ("idqn", ..) => learned(task, 0.75),
            ("mplight-star", "busy", 1) => {
                Err("training diverged in episode 4: the loss is NaN; try a smaller learning rate")
            }
            ("mplight-star", ..) => learned(task, 1.25),
            _ => untrained(task, 1.0),
        })
    })
}

fn data_of(layout: &Layout) -> Report {
    reported(layout)
}

fn file_of(layout: &Layout, file: &str) -> String {
    report::write(layout, &reported(layout)).unwrap();
    fs::read_to_string(layout.report().join(file)).unwrap()
}

#[test]
fn the_words_about_training_are_these() {
    let dir = tempfile::tempdir().unwrap();
    let page = file_of(&two_learners(dir.path()), "index.html");
    well_linked(&page);
    let page = words(&page);
    let (_, section) = page.split_once("\nTraining\n[drawing]").unwrap();
    insta::assert_snapshot!(section.split_once("\nLevel of service\n").unwrap().0);
}

#[test]
fn a_learner_of_somebody_s_own_learns_whatever_its_training_writes() {
    let of = |figure: &str| {
        let dir = tempfile::tempdir().unwrap();
        let mut manifest = manifest(&["baseline", "mine"]);
        let own = OwnMethod::new("mine", OwnKind::Python, "mine.py:Mine".to_owned());
        manifest.identity.controllers = vec![OwnMethod { learns: true, ..own }];
        let layout = crate::made_up::write_results(dir.path(), &manifest, |task| {
            let score = if task.point == "busy" { 0.5 } else { 0.75 };
            Some(match task.method.as_str() {
                "mine" => trained(task, score, figure),
                _ => untrained(task, 1.0),
            })
        });
        let data = Analysis::new(&Results::load(&layout).unwrap(), &NoMeasures);
        assert_eq!(data.trainings.len(), 2);
        data.methods.iter().find(|m| m.method == "mine").unwrap().interval.unwrap()
    };
    let (low, high) = of("return");
    assert!(high - low > 0.01, "{low} {high}");
    assert_eq!(of("loss"), (low, high));
}

#[test]
fn training_csv_has_a_row_per_training() {
    let dir = tempfile::tempdir().unwrap();
    insta::assert_snapshot!(file_of(&two_learners(dir.path()), "training.csv"));
}

#[test]
fn a_learner_is_reported_by_evaluation_and_as_resco_does() {
    let dir = tempfile::tempdir().unwrap();
    let data = data_of(&two_learners(dir.path()));
    let learners = data.learners();
    let names: Vec<_> = learners.iter().map(|l| l.method.method.as_str()).collect();
    assert_eq!(names, ["idqn", "mplight-star"], "what only tunes is no learner");
    let idqn = &learners[0];
    // Weights are 3 to 1, replicates average first.
    assert_eq!(idqn.method.overall, Some(0.75 * 0.75 + 0.25 * (0.75 + 3.5) / 2.0));
    assert_eq!((idqn.best_episode, idqn.last_episodes), (Some(1.0), Some(1.375)));
    assert_eq!(
        (idqn.planned, idqn.scored, idqn.worse, idqn.with_share[1]),
        (4, 4, Some(1), Some(1))
    );
    assert_eq!((idqn.median, idqn.worst), (Some(0.75), Some(3.5)));
    assert_eq!(idqn.wall_s, Some(90.0));
    let star = &learners[1];
    assert_eq!((star.planned, star.scored, star.failed, star.diverged), (4, 3, 1, 1));
}

/// The ending of a training of which validation chose the policy after row 8.
fn validated(task: &Task, score: f64, last: f64, more: &[(&str, f64)]) -> Ending {
    let unit = BASELINE[usize::from(task.point == "busy")];
    learned(task, score).map(|mut result| {
        let row = if score == last { f64::from(EPISODES) } else { 8.0 };
        result.training.extend(named(&[("policy_row", row), ("last_delay_s", last * unit)]));
        result.training.extend(named(&[("validation_episodes", 4.0)]));
        result.training.extend(named(more));
        result
    })
}

#[test]
fn what_validation_chose_is_ranked_and_the_last_policy_stands_beside_it() {
    let dir = tempfile::tempdir().unwrap();
    let manifest = manifest(&["baseline", "idqn", "ippo", "mplight"]);
    let layout = crate::made_up::write_results(dir.path(), &manifest, |task| {
        Some(match (task.method.as_str(), task.point.as_str()) {
            ("idqn", "busy") => validated(task, 0.5, 4.5, &[("restarts", 0.0), ("dead", 0.0)]),
            ("idqn", _) => validated(task, 0.5, 0.5, &[("restarts", 2.0), ("dead", 0.0)]),
            ("mplight", _) => validated(task, 0.75, 0.75, &[("restarts", 3.0), ("dead", 1.0)]),
            // It ended before its first validation.
            ("ippo", _) => validated(task, 0.9, 0.9, &[("validation_episodes", 0.0)]),
            _ => untrained(task, 1.0),
        })
    });
    let data = data_of(&layout);
    let idqn = &data.learners()[0];
    assert_eq!((idqn.method.method.as_str(), idqn.method.overall), ("idqn", Some(0.5)));
    assert_eq!(idqn.last_policy, Some(0.75 * 0.5 + 0.25 * 4.5));
    assert_eq!((idqn.validated, idqn.replaced, idqn.restarted, idqn.dead), (2, 1, 1, 0));
    let said = text::notes(&data);
    for expected in [
        "idqn is ranked by the policies that validation chose (0.50). The last policies score 1.50; validation replaced \
         them in 1 of 2 trainings.",
        "mplight is ranked by the last policy of each training: in none of 2 trainings did validation find a better one.",
        "ippo is ranked by the last policy of each training; validation did not choose among policies.",
        "1 of 2 trainings of idqn started again from another seed, because the network was dead.",
        "2 of 2 trainings of mplight ended with a dead network, which acts the same whatever it sees.",
    ] {
        assert!(said.iter().any(|s| s == expected), "{expected}\n{said:#?}");
    }
    let csv = file_of(&layout, "training.csv");
    let row = |start: &str| csv.lines().find(|line| line.starts_with(start)).unwrap().to_owned();
    assert!(row("idqn,busy").starts_with("idqn,busy,0,ok,12,0.5,8,4.5,0,false,"), "{csv}");
    assert!(row("ippo,busy").starts_with("ippo,busy,0,ok,12,0.9,,,,,"), "{csv}");
    let page = words(&file_of(&layout, "index.html"));
    assert!(page.contains("Which policies?"), "{page}");
}

#[test]
fn a_training_without_validation_counts_among_last_policies_by_its_score() {
    let dir = tempfile::tempdir().unwrap();
    let layout =
        crate::made_up::write_results(dir.path(), &manifest(&["baseline", "idqn"]), |task| {
            Some(match (task.method.as_str(), task.point.as_str()) {
                ("idqn", "busy") => validated(task, 0.5, 4.5, &[]),
                ("idqn", _) => validated(task, 0.25, 0.25, &[("validation_episodes", 0.0)]),
                _ => untrained(task, 1.0),
            })
        });
    let data = data_of(&layout);
    let idqn = &data.learners()[0];
    assert_eq!((idqn.validated, idqn.last_policy), (1, Some(0.75 * 0.25 + 0.25 * 4.5)));
}

#[test]
fn a_learner_that_only_diverged_is_still_in_the_table() {
    let dir = tempfile::tempdir().unwrap();
    let layout =
        crate::made_up::write_results(dir.path(), &manifest(&["baseline", "ippo"]), |task| {
            Some(match task.method.as_str() {
                "ippo" => Err("training diverged in episode 0: the return is inf; try"),
                _ => untrained(task, 1.0),
            })
        });
    let page = words(&file_of(&layout, "index.html"));
    assert!(page.contains("| 0 of 2 | 2 2 |"), "{page}");
    assert!(!layout.report().join("learning.svg").exists());
}

#[test]
fn learning_curves_are_drawn_for_learners_only() {
    let dir = tempfile::tempdir().unwrap();
    let layout = two_learners(dir.path());
    let drawing = file_of(&layout, "learning.svg");
    well_formed(&drawing);
    // The first value is one episode's, the last the mean of five.
    let said = "idqn from 1.92 to 1.17 of the baseline; mplight-star from 1.92 to 1.17 of the";
    assert!(drawing.contains(said), "{drawing}");
    assert!(!drawing.contains("fixed-time"));
    for x in drawing.split(" x=\"").skip(1).filter_map(|rest| rest.split('"').next()) {
        assert!((0.0..=900.0).contains(&x.parse::<f64>().unwrap()), "{x}");
    }
}

#[test]
fn without_a_learner_there_is_nothing_about_training() {
    let dir = tempfile::tempdir().unwrap();
    let manifest = manifest(&["baseline", "fixed-time"]);
    let layout = crate::made_up::write_results(dir.path(), &manifest, |task| {
        Some(match task.method.as_str() {
            "fixed-time" => trained(task, 0.5, "cycle_s"),
            _ => untrained(task, 1.0),
        })
    });
    assert!(!file_of(&layout, "index.html").contains("raining</h2>"));
    for file in ["learning.svg", "training.csv"] {
        assert!(!layout.report().join(file).exists(), "{file}");
    }
}

#[test]
fn a_method_that_lacks_points_is_compared_where_all_have_results() {
    let dir = tempfile::tempdir().unwrap();
    let manifest = manifest(&["baseline", "fixed-time", "idqn", "ippo"]);
    let layout = crate::made_up::write_results(dir.path(), &manifest, |task| {
        match (task.method.as_str(), task.point.as_str()) {
            ("fixed-time", "quiet") => Some(untrained(task, 0.75)),
            ("fixed-time", _) => Some(untrained(task, 0.5)),
            ("idqn", "quiet") => Some(learned(task, 0.6)),
            ("idqn" | "ippo", _) => None,
            _ => Some(untrained(task, 1.0)),
        }
    });
    let data = data_of(&layout);
    insta::assert_snapshot!(format!("{}\n{}", text::table(&data), text::notes(&data).join("\n")));
    let page = words(&file_of(&layout, "index.html"));
    let said = "Methods without results on some point MDPs are not ranked. On the 1 point MDP that all methods finished, the order is: idqn 0.60, fixed-time 0.75, baseline 1.00.";
    assert!(page.contains(said), "{page}");
    assert!(page.contains("1 | idqn | 0.60 |"), "{page}");
}

#[test]
fn methods_that_lack_different_points_are_not_ranked_against_each_other() {
    let dir = tempfile::tempdir().unwrap();
    let layout = crate::made_up::write_results(
        dir.path(),
        &manifest(&["baseline", "a", "b"]),
        |task| match (task.method.as_str(), task.point.as_str()) {
            ("a", "busy") | ("b", "quiet") => None,
            _ => Some(untrained(task, 1.0)),
        },
    );
    let data = data_of(&layout);
    let ranks: Vec<_> = data.methods.iter().map(|m| (m.method.as_str(), m.rank)).collect();
    assert_eq!(ranks, [("baseline", Some(1)), ("a", None), ("b", None)]);
    assert_eq!(data.common, None);
    let notes = text::notes(&data).join("\n");
    assert!(notes.contains("no point MDP has results of all methods"), "{notes}");
}

#[test]
fn a_method_that_lacks_points_is_never_ranked_whatever_else_runs() {
    let of = |methods: &[&str], lacks: &[(&str, &str)], failed: bool| {
        let dir = tempfile::tempdir().unwrap();
        let layout = crate::made_up::write_results(dir.path(), &manifest(methods), |task| {
            match lacks.contains(&(task.method.as_str(), task.point.as_str())) {
                true if failed => Some(Err("SUMO ended")),
                true => None,
                false => Some(untrained(task, if task.method == "a" { 0.1 } else { 1.0 })),
            }
        });
        let data = data_of(&layout);
        let ranks: Vec<_> = data.methods.iter().map(|m| (m.method.clone(), m.rank)).collect();
        let page = words(&file_of(&layout, "index.html"));
        let csv = file_of(&layout, "summary.csv");
        let ranked = |line: &str| line.split(',').nth(1).is_some_and(|rank| !rank.is_empty());
        let in_csv = csv.lines().skip(1).filter(|line| ranked(line)).count();
        assert_eq!(in_csv, ranks.iter().filter(|(_, rank)| rank.is_some()).count(), "{csv}");
        (ranks, page, text::notes(&data).join(" "))
    };
    for failed in [true, false] {
        let (ranks, page, notes) = of(&["baseline", "a"], &[("a", "busy")], failed);
        assert_eq!(ranks, [("baseline".to_owned(), Some(1)), ("a".to_owned(), None)]);
        let headline = "Only the baseline is ranked; 1 method not, for want of point MDPs";
        assert!(page.contains(headline) && !page.contains("a: 90% less"), "{page}");
        assert!(
            notes.contains(
                "Not ranked, because they have no results on some point MDPs: a (1 of 2)."
            ),
            "{notes}"
        );
    }
    let lacks = [("baseline", "quiet"), ("a", "busy")];
    let (ranks, page, _) = of(&["baseline", "a"], &lacks, true);
    assert!(ranks.iter().all(|(_, rank)| rank.is_none()), "{ranks:?}");
    assert!(page.contains("No method is ranked: all lack point MDPs"), "{page}");
    // Where the baseline lacks a point MDP, whoever has it does not lack it; the baseline does.
    let (ranks, page, _) = of(&["baseline", "a", "b"], &[("baseline", "quiet")], true);
    let expected = [("a", Some(1)), ("b", Some(2)), ("baseline", None)];
    assert_eq!(ranks, expected.map(|(name, rank)| (name.to_owned(), rank)));
    assert!(page.contains("1 method not ranked"), "{page}");
    let lacks = [("baseline", "quiet"), ("a", "quiet"), ("b", "quiet")];
    let (ranks, page, _) = of(&["baseline", "a", "b"], &lacks, false);
    assert!(ranks.iter().all(|(_, rank)| rank.is_none()), "{ranks:?}");
    assert!(page.contains("No method is ranked: all lack point MDPs"), "{page}");
}

#[test]
fn a_point_with_only_some_replicates_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let layout = two_learners(dir.path());
    let data = data_of(&layout);
    let notes = text::notes(&data);
    let note = notes.iter().find(|n| n.starts_with("Some replicates of")).unwrap();
    let expected = "Some replicates of mplight-star (1 of 4) failed or are missing";
    assert!(note.starts_with(expected), "{note}");
    let left_out = data.methods.iter().map(|m| m.left_out);
    assert_eq!(left_out.sum::<usize>(), 1, "of no other method");
    // Beside its rank.
    let page = file_of(&layout, "index.html");
    assert_eq!(page.matches("without 1 of 4 replicates").count(), 1);
}
