//! `tsc-family run --until-...`: samples that grow look by look until they say enough.

use std::fs;
use std::path::Path;
use std::process::{Command, Output};

use crate::common::{stderr, stdout};
use crate::folder::Folder;
use serde_json::Value;
use tsc_family::store::Layout;
use tsc_family::store::manifest::Manifest;

const SHORT: [&str; 6] =
    ["--set", "ppo.total_steps=2048", "--set", "dqn.total_steps=2000", "--eval-seeds", "2"];

fn command(args: &[&str], dir: &Path) -> Output {
    let program = env!("CARGO_BIN_EXE_tsc-family");
    Command::new(program).args(args).current_dir(dir).output().unwrap()
}

fn run(args: &[&str], dir: &Path) -> (String, String) {
    let output = command(&[&["run", "cartpole"], args, &SHORT].concat(), dir);
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (out, err) = (text(&output.stdout), text(&output.stderr));
    assert!(output.status.success(), "{err}");
    (out, err)
}

fn refused(args: &[&str], dir: &Path) -> String {
    let output = command(&[&["run", "cartpole"], args].concat(), dir);
    assert_eq!(output.status.code(), Some(2));
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn records(out: &Path) -> usize {
    fs::read_dir(out.join("done/000")).unwrap().count()
}

fn reported(dir: &Path, out: &str) -> (Vec<Value>, String) {
    let output = command(&["report", out, "--json"], dir);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lines = String::from_utf8(output.stdout).unwrap();
    let mut lines: Vec<Value> = lines.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    lines.retain(|line| line["event"] == "method");
    (lines, String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn a_run_that_knows_enough_stops_and_says_so_again() {
    let dir = tempfile::tempdir().unwrap();
    let args = ["--budget", "16", "--looks", "12,16", "--until-decided", "--out", "r"];
    let (_, said) = run(&args, dir.path());
    assert!(said.contains("look 1 of 2, 12 point MDPs: ppo is "), "{said}");
    assert!(said.contains("that is enough"), "{said}");
    assert_eq!(records(&dir.path().join("r")), 24);
    let (_, again) = run(&args, dir.path());
    assert!(again.contains("look 1 of 2") && !again.contains("already done"), "{again}");
    assert_eq!(records(&dir.path().join("r")), 24);
    let (rows, notes) = reported(dir.path(), "r");
    assert!(rows.iter().all(|row| row["points"] == 12), "{rows:?}");
    assert!(notes.contains("After look 1 of 2, with 12 point MDPs, this is"), "{notes}");
    // Nothing is missing, and nobody promises tasks that `resume` does not do.
    let said = |args: &[&str]| {
        let output = command(args, dir.path());
        let text = format!("{}{}", stdout(&output), stderr(&output));
        (output.status.code(), text)
    };
    let (code, status) = said(&["status", "r"]);
    assert!(code == Some(0) && status.contains("look 1 of 2: 24 of 24 tasks are done"), "{status}");
    assert!(status.contains("continues if they are not enough"), "{status}");
    let (code, checked) = said(&["check", "r"]);
    assert!(code == Some(0) && checked.contains("look 1 of 2: 24 of 24 records"), "{checked}");
}

/// A run of two looks, which the first one did not end.
const GROWN: &str = "run cartpole --budget 12 --looks 4,12 --until-decided --out r --set ppo.total_steps=2048 \
    --set dqn.total_steps=2000 --eval-seeds 2";

#[test]
fn the_look_that_is_under_way_is_what_status_and_resume_are_about() {
    let dir = Folder::after(GROWN);
    let out = dir.path().join("r");
    assert_eq!(records(&out), 24);
    let code = |args: &[&str]| command(args, dir.path()).status.code();
    assert_eq!(code(&["status", "r"]), Some(0));
    let of_first: Vec<u64> = plan_of_look(&out, 0);
    let later = (0..24).find(|task| !of_first.contains(task)).unwrap();
    let record = out.join(format!("done/000/{later}.jsonl"));
    let before = fs::read(&record).unwrap();
    fs::remove_file(&record).unwrap();
    assert_eq!((code(&["status", "r"]), code(&["check", "r"])), (Some(6), Some(6)));
    assert_eq!(code(&["resume", "r"]), Some(0));
    assert_eq!((records(&out), code(&["status", "r"])), (24, Some(0)));
    let rows = |record: &[u8]| {
        String::from_utf8_lossy(record).lines().skip(1).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(rows(&fs::read(&record).unwrap()), rows(&before));
}

#[test]
fn a_look_that_was_not_begun_is_left_to_the_command_of_the_run() {
    let dir = Folder::after(GROWN);
    let args = ["--budget", "12", "--looks", "4,12", "--until-decided", "--out", "r"];
    let out = dir.path().join("r");
    let first = plan_of_look(&out, 0);
    for later in (0..24).filter(|task| !first.contains(task)) {
        fs::remove_file(out.join(format!("done/000/{later}.jsonl"))).unwrap();
    }
    let resumed = command(&["resume", "r"], dir.path());
    assert_eq!((resumed.status.code(), records(&out)), (Some(0), 8));
    let said = stderr(&resumed);
    let expected =
        "the command of the run inspects the results, and continues if they are not enough: ";
    assert!(said.contains(expected) && said.contains("--until-decided"), "{said}");
    run(&args, dir.path());
    assert_eq!(records(&out), 24);
}

#[test]
fn a_look_that_was_handed_over_is_under_way_before_it_has_a_record() {
    let dir = tempfile::tempdir().unwrap();
    let args = ["--budget", "12", "--looks", "4,12", "--until-decided", "--out", "r"];
    let hand_over = || run(&[&args[..], &["--executor", "script"]].concat(), dir.path());
    let out = dir.path().join("r");
    let resume = || command(&["resume", "r", "--executor", "local"], dir.path()).status.code();
    hand_over();
    assert_eq!((resume(), records(&out)), (Some(0), 8));
    let (_, said) = hand_over();
    assert!(said.contains("continuing to 12"), "{said}");
    let status = command(&["status", "r"], dir.path());
    assert_eq!(status.status.code(), Some(6));
    assert!(stdout(&status).contains("look 2 of 2: 8 of 24 tasks are done"), "{}", stdout(&status));
    let check = command(&["check", "r"], dir.path());
    assert_eq!(check.status.code(), Some(6));
    assert!(stdout(&check).contains("look 2 of 2: 8 of 24 records"), "{}", stdout(&check));
    assert_eq!((resume(), records(&out)), (Some(0), 24));
}

fn plan_of_look(out: &Path, look: usize) -> Vec<u64> {
    let identity = Manifest::read(&Layout::new(out)).unwrap().identity;
    let drawn = &identity.sample.growth.as_ref().unwrap().looks[look].draws;
    let has = |point: &str| drawn.iter().any(|draw| draw.point == point);
    identity.tasks_of(|_, point| has(point)).iter().map(|task| task.task as u64).collect()
}

#[test]
fn a_run_that_spends_its_budget_ends_with_the_sample_it_would_have_been_at_once() {
    let dir = tempfile::tempdir().unwrap();
    let args = ["--budget", "12", "--looks", "4,12", "--until-decided"];
    let (lines, _) = run(&[&args[..], &["--json", "--out", "grown"]].concat(), dir.path());
    run(&["--budget", "12", "-q", "--out", "whole"], dir.path());
    let looks: Vec<Value> = lines.lines().map(|l| serde_json::from_str(l).unwrap()).collect();
    let looks: Vec<&Value> = looks.iter().filter(|l| l["event"] == "look").collect();
    let of = |name: &str| looks.iter().map(|l| l[name].clone()).collect::<Vec<_>>();
    assert_eq!(
        (of("points"), of("enough")),
        (vec![4.into(), 12.into()], vec![false.into(), true.into()])
    );
    let manifest = |out: &str| -> Value {
        let text = fs::read_to_string(dir.path().join(out).join("manifest.json")).unwrap();
        serde_json::from_str(&text).unwrap()
    };
    let (grown, whole) = (manifest("grown"), manifest("whole"));
    assert_eq!(grown["identity"]["sample"]["draws"], whole["identity"]["sample"]["draws"]);
    // The estimates are the same, and intervals that were looked at twice are wider.
    let (grown, notes) = reported(dir.path(), "grown");
    let (whole, plain) = reported(dir.path(), "whole");
    assert!(notes.contains("After look 2 of 2") && !plain.contains("look"), "{notes}");
    for (a, b) in grown.iter().zip(&whole) {
        assert_eq!(a["overall"], b["overall"]);
        let width = |row: &Value| {
            let at = |end: &str| row[format!("overall_{end}")].as_f64().unwrap();
            at("high") - at("low")
        };
        assert!(width(a) > width(b), "{a} {b}");
    }
}

#[test]
fn a_look_that_is_not_complete_does_not_count_and_is_gone_on_with() {
    let dir = Folder::after(GROWN);
    let args = ["--budget", "12", "--looks", "4,12", "--until-decided", "--out", "r"];
    let out = dir.path().join("r");
    if records(&out) == 8 {
        // Decided at the first look: nothing of another one can be lost.
        return assert!(reported(dir.path(), "r").1.contains("After look 1 of 2"));
    }
    let (before, _) = reported(dir.path(), "r");
    let first = plan_of_look(&out, 0);
    let later = (0..24).find(|task| !first.contains(task)).unwrap();
    fs::remove_file(out.join(format!("done/000/{later}.jsonl"))).unwrap();
    let (rows, notes) = reported(dir.path(), "r");
    assert!(rows.iter().all(|row| row["points"] == 4), "{rows:?}");
    assert!(notes.contains("this is not reached yet; the command of the run"), "{notes}");
    let (_, said) = run(&args, dir.path());
    assert!(said.contains("continuing to 12") && said.contains("23 of 24 tasks"), "{said}");
    assert_eq!(reported(dir.path(), "r").0, before);
}

#[test]
fn what_cannot_grow_or_has_no_effect_is_refused() {
    let dir = tempfile::tempdir().unwrap();
    for (args, words) in [
        (&["--looks", "4,8", "--budget", "8"][..], "--until-decided"),
        (&["--until-decided", "--within=-1"], "expected a number from 0"),
        (&["--until-decided", "--methods", "ppo"], "it takes two methods to decide between"),
        (&["--until-decided", "--budget", "8", "--sampling", "k-means"], "needs a balanced sample"),
        (
            &["--until-decided", "--budget", "8", "--looks", "4,6"],
            "looks must ascend from 1 or more to the budget, 8",
        ),
    ] {
        let said = refused(args, dir.path());
        assert!(said.contains(words), "{args:?}: {said}");
    }
}

#[test]
fn another_rule_is_another_run() {
    let dir = tempfile::tempdir().unwrap();
    let out = ["--budget", "4", "-q", "--out", "r"];
    run(&[&out[..], &["--until-decided"]].concat(), dir.path());
    let output = command(&[&["run", "cartpole"], &out[..], &SHORT].concat(), dir.path());
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        said.contains(
            "sample.growth.until.within is [0.03,[\"ppo\",\"dqn\"]] there and not set now"
        ),
        "{said}"
    );
}

#[test]
fn what_was_evaluated_stands_for_all_intersections_when_a_run_stops_early() {
    let dir = tempfile::tempdir().unwrap();
    let args = "run --budget 12 --looks 4,12 --until-decided --methods baseline,max-pressure --eval-seeds 2 \
                --set demand.horizon_s=300 --out r -q";
    let output = command(&args.split_whitespace().collect::<Vec<_>>(), dir.path());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut table = csv::Reader::from_path(dir.path().join("r/report/intersections.csv")).unwrap();
    let at = table.headers().unwrap().iter().position(|name| name == "basis").unwrap();
    let basis: Vec<String> = table.records().map(|row| row.unwrap()[at].to_owned()).collect();
    assert_eq!(basis.len(), 282);
    assert!(!basis.iter().any(|basis| basis == "none"), "{basis:?}");
}
