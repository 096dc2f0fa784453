//! The paper's cases 1 to 3 on the command line: what is written, and what is refused.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::common::{run, stderr, stdout, succeed};
use crate::families::{MadeUp, equal};
use tsc_family::stats::Direction;

/// Thirty waters; on the six largest `dive` swims nowhere, and `stroke` not far.
fn swimmers() -> MadeUp<'static> {
    let distances: Vec<[f64; 2]> =
        (0..30).map(|i| if i < 24 { [5.0 + f64::from(i), 9.0] } else { [0.25, 0.0] }).collect();
    let values: Vec<&[f64]> = distances.iter().map(|d| &d[..]).collect();
    MadeUp {
        objective: "distance_m",
        direction: Direction::Higher,
        baseline: "",
        methods: &["stroke", "dive"],
        points: equal(&values),
    }
}

fn table(folder: &Path) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(folder.join("river/sensitivity/cases.csv")).unwrap();
    reader.deserialize().map(Result::unwrap).collect()
}

#[test]
fn a_case_is_another_truth_that_samples_are_held_against() {
    let folder = tempfile::tempdir().unwrap();
    swimmers().write(&folder.path().join("river"));
    let args = "sensitivity river --failure distance_m<0.5 --cases --budgets 10,30 --repeats 40";
    let text = succeed(folder.path(), args);
    for case in ["Case 1: failures get low", "Case 2: failures get high", "Case 3: importance is"] {
        assert!(text.contains(case), "{text}");
    }
    let rows = table(folder.path());
    assert_eq!(rows.len(), 3 * 4 * 2 * 2, "cases, estimators, budgets, methods");
    let number = |row: &BTreeMap<String, String>, name: &str| row[name].parse::<f64>().unwrap();
    let dive: Vec<_> = rows.iter().filter(|r| r["method"] == "dive").collect();
    let of = |case: &str| dive.iter().find(|r| r["case"] == case).unwrap();
    // Failures have 0.6 of 24.6 parts, then 60 of 84; `dive` has 9 wherever it does not fail.
    for (case, failures) in [("1", 0.6 / 24.6), ("2", 60.0 / 84.0)] {
        assert!((number(of(case), "failures") - failures).abs() < 1e-9);
        assert!((number(of(case), "overall") - 9.0 * (1.0 - failures)).abs() < 1e-9);
    }
    for row in &rows {
        let whole = row["budget"] == "30" && row["estimator"] != "m1";
        let error = number(row, "error");
        assert!(!whole || error < 1e-9, "all point MDPs are the family: {row:?}");
        let (mean, overall) = (number(row, "mean"), number(row, "overall"));
        let off = (mean - overall).powi(2) + number(row, "deviation").powi(2);
        assert!((error - off.sqrt()).abs() < 1e-9, "{row:?}");
    }
    let page = fs::read_to_string(folder.path().join("river/sensitivity/index.html")).unwrap();
    assert!(page.contains("id=\"cases\"") && page.contains("--cases"));
    let before = fs::read(folder.path().join("river/sensitivity/cases.csv")).unwrap();
    succeed(folder.path(), args);
    assert_eq!(before, fs::read(folder.path().join("river/sensitivity/cases.csv")).unwrap());
    succeed(folder.path(), "sensitivity river");
    assert!(!folder.path().join("river/sensitivity/cases.csv").exists());
}

#[test]
fn without_a_failure_only_random_importance_is_left() {
    let folder = tempfile::tempdir().unwrap();
    swimmers().write(&folder.path().join("river"));
    let args = "sensitivity river --cases --budgets 5 --repeats 3 --estimators m1 --json";
    let output = run(folder.path(), args);
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stderr(&output).contains("cases 1 and 2 are left out"), "{}", stderr(&output));
    let cases: Vec<String> = table(folder.path()).iter().map(|r| r["case"].clone()).collect();
    assert_eq!(cases, ["3", "3"]);
    let lines = stdout(&output).lines().filter(|l| l.contains("\"event\":\"case\"")).count();
    assert_eq!(lines, 2);
}

#[test]
fn what_cannot_be_studied_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    swimmers().write(&folder.path().join("river"));
    let mut lacking = swimmers();
    lacking.points[0].3 = vec![None, Some(1.0)];
    lacking.points[1].3 = vec![Some(1.0), None];
    lacking.write(&folder.path().join("lacking"));
    let mut sampled = swimmers().manifest();
    sampled.identity.sample.family_size = 90;
    swimmers().write_with(&folder.path().join("sampled"), &sampled);
    let cases = [
        "river --budgets 5",
        "river --repeats 5",
        "river --estimators m1",
        "river --failure-odds 5",
        "river --cases --budgets 31",
        "river --cases --budgets 0",
        "river --cases --failure-odds 1",
        "river --cases --estimators m7",
        "lacking --cases",
        "sampled --cases",
    ];
    let said: String = cases
        .iter()
        .map(|args| {
            let output = run(folder.path(), &format!("sensitivity {args}"));
            assert_eq!(output.status.code(), Some(2), "{args}: {}", stderr(&output));
            format!("sensitivity {args}\n  {}", stderr(&output))
        })
        .collect();
    insta::assert_snapshot!("refused", said);
}
