//! Ranks across families: what is printed, what is exact, what is refused.

use std::fs;
use std::path::Path;

use crate::common::{run, stderr, stdout, succeed};
use crate::families::{MadeUp, equal};
use tsc_family::stats::Direction;

fn swimmers(values: &[&[f64]]) -> MadeUp<'static> {
    MadeUp {
        objective: "distance_m",
        direction: Direction::Higher,
        baseline: "",
        methods: &["drift", "stroke", "dive"],
        points: equal(values),
    }
}

/// Seconds, relative to those of `walk`.
fn runners() -> MadeUp<'static> {
    MadeUp {
        objective: "time_s",
        direction: Direction::Lower,
        baseline: "walk",
        methods: &["walk", "dive", "stroke", "sprint"],
        points: equal(&[&[100.0, 50.0, 60.0, 20.0], &[200.0, 160.0, 40.0, 50.0]]),
    }
}

fn written(folder: &Path) {
    swimmers(&[&[1.0, 2.0, 3.0], &[1.0, 3.0, 2.0]]).write(&folder.join("river"));
    swimmers(&[&[0.0, 0.0, 1.0], &[5.0, 4.0, 1.0], &[1.0, 2.0, 2.0]]).write(&folder.join("lake"));
    runners().write(&folder.join("track"));
}

#[test]
fn every_combination_counts_and_ties_share() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    let text = succeed(folder.path(), "across river lake --csv a.csv");
    insta::assert_snapshot!("table", text);
    // Six sums: (1,2,4) (6,6,4) (2,4,5) (1,3,3) (6,7,3) (2,5,4) of drift, stroke, dive.
    let csv = fs::read_to_string(folder.path().join("a.csv")).unwrap();
    let of = |method: &str| {
        let row = csv.lines().find(|l| l.starts_with(method)).unwrap();
        row.split(',').skip(3).take(3).map(|c| c.parse::<f64>().unwrap() * 12.0).collect::<Vec<_>>()
    };
    let near = |found: Vec<f64>, expected: [f64; 3]| {
        assert!(found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
    };
    near(of("drift"), [1.0, 3.0, 8.0]);
    near(of("stroke"), [6.0, 6.0, 0.0]);
    near(of("dive"), [5.0, 3.0, 4.0]);
    insta::assert_snapshot!("csv", csv);
    let json = succeed(folder.path(), "across river lake --json");
    assert_eq!(json.lines().count(), 3);
    let first: serde_json::Value = serde_json::from_str(json.lines().next().unwrap()).unwrap();
    assert_eq!(first["combinations"], 6);
}

#[test]
fn families_of_other_objectives_are_brought_together_on_request() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    let refused = run(folder.path(), "across river track");
    assert_eq!(refused.status.code(), Some(2));
    insta::assert_snapshot!("not_on_one_scale", stderr(&refused));
    let output = run(folder.path(), "across river track --scale range");
    assert!(output.status.success(), "{}", stderr(&output));
    insta::assert_snapshot!("by_range", format!("{}\n{}", stdout(&output), stderr(&output)));
}

#[test]
fn what_some_methods_lack_is_left_out_and_said() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    let mut lake = swimmers(&[&[0.0, 0.0, 1.0], &[5.0, 4.0, 1.0], &[1.0, 2.0, 2.0]]);
    lake.points[1].3[2] = None;
    fs::remove_dir_all(folder.path().join("lake")).unwrap();
    lake.write(&folder.path().join("lake"));
    let output = run(folder.path(), "across river lake");
    assert!(stdout(&output).starts_with("4 combinations"), "{}", stdout(&output));
    insta::assert_snapshot!("lacking", stderr(&output));
}

#[test]
fn unusable_input_is_refused_with_its_place_and_a_way_out() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    let root = folder.path();
    fs::create_dir(root.join("empty")).unwrap();
    let mut none = swimmers(&[&[1.0, 2.0, 3.0], &[1.0, 2.0, 3.0]]);
    (none.points[0].1, none.points[1].1) = (0.25, 0.75);
    (none.points[0].3[0], none.points[1].3[1]) = (None, None);
    none.write(&root.join("none"));
    let cases = ["river", "river empty", "river river", "river none", "river lake --methods drift"];
    let said: String = cases
        .iter()
        .map(|args| {
            let output = run(root, &format!("across {args}"));
            assert_eq!(output.status.code(), Some(2), "{args}: {}", stderr(&output));
            format!("across {args}\n  {}", stderr(&output))
        })
        .collect();
    insta::assert_snapshot!("refused", said);
}

#[test]
fn a_sample_is_said_not_to_be_its_family() {
    let folder = tempfile::tempdir().unwrap();
    written(folder.path());
    let part = swimmers(&[&[1.0, 2.0, 3.0], &[1.0, 3.0, 2.0]]);
    let mut manifest = part.manifest();
    manifest.identity.sample.family_size = 9;
    part.write_with(&folder.path().join("part"), &manifest);
    let output = run(folder.path(), "across part lake");
    let said = stderr(&output);
    assert!(said.contains("part: 2 of 9 point MDPs were evaluated"), "{said}");
    assert!(!said.contains("lake:"), "{said}");
}
