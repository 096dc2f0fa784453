//! What other importance does to a ranking: what is printed and written, what is refused.

use std::fs;
use std::path::Path;

use crate::common::{run, stderr, stdout, succeed};
use crate::families::{MadeUp, equal};
use tsc_family::analysis::Analysis;
use tsc_family::analysis::sensitivity::{Question, Sensitivity};
use tsc_family::report::{Plain, Sections};
use tsc_family::stats::Direction;
use tsc_family::store::Layout;
use tsc_family::store::results::Results;

/// On small waters `dive` is best, on the large one `stroke`.
fn swimmers() -> MadeUp<'static> {
    let mut family = MadeUp {
        objective: "distance_m",
        direction: Direction::Higher,
        baseline: "",
        methods: &["drift", "stroke", "dive"],
        points: equal(&[&[1.0, 2.0, 3.0], &[1.0, 3.0, 4.0], &[1.0, 9.0, 0.5]]),
    };
    for (point, importance) in family.points.iter_mut().zip([0.5, 0.4, 0.1]) {
        point.1 = importance;
    }
    family.points[2].2 = 100.0;
    family
}

fn analysis(layout: &Layout) -> Analysis {
    Analysis::new(&Results::load(layout).unwrap(), Plain::default().measures())
}

fn question() -> Question {
    Question {
        methods: None,
        weigh_by: Vec::new(),
        concentration: 1.0,
        seed: 0,
        reported: Vec::new(),
    }
}

#[test]
fn importance_decides_the_ranking() {
    let dir = tempfile::tempdir().unwrap();
    let analysis = analysis(&swimmers().write(dir.path()));
    let question =
        Question { weigh_by: vec!["size_m".into()], reported: vec!["p2".into()], ..question() };
    let found = Sensitivity::new(&analysis, &question).unwrap();
    assert_eq!(found.board.methods, ["dive", "stroke", "drift"]);
    let near = |found: &[f64], expected: [f64; 3]| {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
    };
    let of = |name: &str| found.distributions.iter().find(|d| d.name == name).unwrap();
    near(&of("importance").overall, [1.5 + 1.6 + 0.05, 1.0 + 1.2 + 0.9, 1.0]);
    near(&of("equal").overall, [2.5, 14.0 / 3.0, 1.0]);
    // 0.5 * 1, 0.4 * 2, 0.1 * 100 of 11.3.
    near(&of("size_m").weights, [0.5 / 11.3, 0.8 / 11.3, 10.0 / 11.3]);
    // 0.13 + 0.28 + 0.44, more than 8, and 1.
    assert_eq!(of("size_m").ranks, [3.0, 1.0, 2.0]);
    assert_eq!(of("p2").ranks, [3.0, 1.0, 2.0]);
    assert_eq!(found.distributions.len(), 4 + 5);
}

#[test]
fn what_is_printed_and_written_are_these_words() {
    let folder = tempfile::tempdir().unwrap();
    swimmers().write(&folder.path().join("river"));
    let output = run(folder.path(), "sensitivity river --weigh-by size_m --reported p2");
    assert!(output.status.success(), "{}", stderr(&output));
    insta::assert_snapshot!("printed", format!("{}\n{}", stdout(&output), stderr(&output)));
    let written = folder.path().join("river/sensitivity/distributions.csv");
    insta::assert_snapshot!("csv_distributions", fs::read_to_string(written).unwrap());
    let json = succeed(folder.path(), "sensitivity river --json");
    assert_eq!(json.lines().count(), 7 * 3);
}

#[test]
fn what_methods_lack_is_said_and_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let mut river = swimmers();
    river.points[2].3[1] = None;
    river.write(&folder.path().join("river"));
    let output = run(folder.path(), "sensitivity river");
    let said = stderr(&output);
    assert!(
        said.contains(
            "of 3 point MDPs 2 are compared, on which all methods have a score; lacking: stroke 1"
        ),
        "{said}"
    );
    assert!(stdout(&output).contains("on 2 point MDPs"));
    let refused = run(folder.path(), "sensitivity river --reported p2");
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("not every method has a score on point MDP `p2`"));
}

fn odd(root: &Path) {
    swimmers().write(&root.join("river"));
    fs::create_dir(root.join("thesis")).unwrap();
    fs::write(root.join("thesis/chapter.tex"), "").unwrap();
    let mut old = swimmers().manifest();
    old.identity.schema_version = 2;
    swimmers().write_with(&root.join("old"), &old);
    let layout = swimmers().write(&root.join("nan"));
    let record = fs::read_to_string(layout.record(2)).unwrap();
    fs::write(layout.record(2), record.replace(":3.0", ":NaN")).unwrap();
    let mut twice = swimmers();
    twice.points[1].0 = "p0".into();
    twice.write(&root.join("twice"));
    let mut none = swimmers();
    none.points.iter_mut().for_each(|p| p.3 = vec![Some(1.0), None, None]);
    none.write(&root.join("none"));
    let mut sizes = swimmers();
    sizes.points[0].2 = -1.0;
    sizes.write(&root.join("sizes"));
}

#[test]
fn unusable_input_is_refused_with_its_place_and_a_way_out() {
    let folder = tempfile::tempdir().unwrap();
    odd(folder.path());
    let cases = [
        ("old", 5),
        ("nan", 2),
        ("twice", 2),
        ("none", 2),
        ("river --methods drift", 2),
        ("river --methods drift,drift", 2),
        ("river --methods drift,dove", 2),
        ("river --weigh-by siz_m", 2),
        ("sizes --weigh-by size_m", 2),
        ("river --concentration 0", 2),
        ("river --reported p9", 2),
        ("river --out thesis", 2),
    ];
    let said: String = cases
        .iter()
        .map(|(args, code)| {
            let output = run(folder.path(), &format!("sensitivity {args}"));
            assert_eq!(output.status.code(), Some(*code), "{args}: {}", stderr(&output));
            assert!(stdout(&output).is_empty(), "{args}");
            format!("sensitivity {args}\n  {}", stderr(&output))
        })
        .collect();
    insta::assert_snapshot!("refused", said);
    assert!(!folder.path().join("river/sensitivity").exists(), "nothing was written");
}

#[test]
fn every_domain_says_what_a_failure_is_in_a_metric_that_it_records() {
    let limits: Vec<String> = tsc_family::domains::domains()
        .iter()
        .map(|d| d.failure().expect("every domain says").to_string())
        .collect();
    let expected = [
        "waiting_s>20", "normalised_return<0.05", "normalised_return<0.5", "return<0.05",
        "return<-499", "steps_to_upright>199", "course_share<0.5", "return<1000",
        "steps_to_goal>4999",
    ];
    assert_eq!(limits, expected);
}
