//! What strangers write into names never acts on a terminal.

use std::fs;
use std::path::Path;
use std::process::Output;

use crate::common::{program, stderr, stdout, succeed};
use crate::quick::{RUN, quick_results};

/// What acts on a terminal: clears it, rings, goes back, turns around, hides.
const ACTS: &str = "\u{1b}[2J\u{7}\r\u{9b}31m\u{202e}\u{2066}\u{e0041}";

/// Runs the program with arguments as they are; what it says must be plain.
fn plain(folder: &Path, args: &[&str]) -> Output {
    let output = program(folder).args(args).output().unwrap();
    for said in [stdout(&output), stderr(&output)] {
        let acts = |c: char| {
            (c.is_control() && c != '\n' && c != '\t')
                || ['\u{202e}', '\u{2066}', '\u{e0041}'].contains(&c)
        };
        assert!(!said.contains(acts), "{args:?}: {said:?}");
    }
    output
}

#[test]
fn names_of_files_and_arguments_are_shown_plainly() {
    let folder = tempfile::tempdir().unwrap();
    let strange = format!("a{ACTS}b");
    for args in [
        vec!["list", &strange],
        vec!["report", &strange],
        vec![&strange],
        vec!["run", "smoke", "--methods", &strange],
        vec!["run", "smoke", "--budget", &strange],
        vec!["list", "--set", &strange],
        vec!["across", &strange, &strange],
        vec!["evaluate", "--model", &strange, "--point", &strange],
    ] {
        let output = plain(folder.path(), &args);
        assert_eq!(output.status.code(), Some(2), "{args:?}");
        let said = stderr(&output);
        let shown =
            ["a\\u001b[2J", "a\\u{1b}[2J", "a\\u000d"].iter().any(|shown| said.contains(shown));
        assert!(shown, "{args:?}: {said}");
    }
}

#[test]
fn names_in_tables_and_settings_are_shown_plainly() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let turned = "Main\u{202e}teertS\u{2066}";
    let table =
        "point,importance,lanes,speed_mph,length_m,inflow_vph,left_turn_lanes,right_turn_lanes\n";
    fs::write(folder.join("p.csv"), format!("{table}{turned},1,4,30,200,500,0,0\n")).unwrap();
    fs::write(folder.join("s.toml"), "family.points = \"p.csv\"").unwrap();
    let listed = stdout(&plain(folder, &["list", "s.toml"]));
    assert!(listed.contains("Main\\u202eteertS\\u2066"), "{listed}");
    let json = stdout(&plain(folder, &["list", "s.toml", "--json"]));
    let value: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(value["name"], turned, "JSON says the same");
    fs::write(folder.join("p.csv"), format!("{table}{ACTS},1,4,30,200,500,0,0\n")).unwrap();
    assert_eq!(plain(folder, &["list", "s.toml"]).status.code(), Some(2));
    fs::write(folder.join("p.csv"), format!("{table}a,{ACTS},4,30,200,500,0,0\n")).unwrap();
    assert_eq!(plain(folder, &["list", "s.toml"]).status.code(), Some(2));
    fs::write(
        folder.join("s.toml"),
        format!("family.points = \"p.csv\"\n\"{}\" = 1", "\\u001b[2J"),
    )
    .unwrap();
    assert_eq!(plain(folder, &["list", "s.toml"]).status.code(), Some(2));
    let scenario = "domain = \"\\u001b[2J\"";
    fs::write(folder.join("s.toml"), scenario).unwrap();
    assert_eq!(plain(folder, &["list", "s.toml"]).status.code(), Some(2));
}

#[test]
fn what_results_of_a_stranger_say_is_shown_plainly() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    quick_results(folder);
    let path = folder.join("results/manifest.json");
    let text = fs::read_to_string(&path).unwrap();
    let mut manifest: serde_json::Value = serde_json::from_str(&text).unwrap();
    manifest["provenance"]["command"] = ACTS.into();
    fs::write(&path, manifest.to_string()).unwrap();
    plain(folder, &["report", "results"]);
    // Another run in the folder quotes the command of the first.
    let other: Vec<&str> = RUN.split_whitespace().chain(["--seed", "7"]).collect();
    let output = plain(folder, &other);
    assert_eq!(output.status.code(), Some(5));
    fs::write(&path, &text).unwrap();
    let record = folder.join("results/done/000/1.jsonl");
    let text = fs::read_to_string(&record).unwrap();
    fs::write(&record, text.replacen("\"method\":\"ppo\"", "\"method\":\"\\u001b[2J\\u202e\"", 1))
        .unwrap();
    assert_eq!(plain(folder, &["report", "results"]).status.code(), Some(2));
    fs::write(&record, format!("{{\"{ACTS}\":1}}")).unwrap();
    assert_eq!(plain(folder, &["report", "results"]).status.code(), Some(2));
    fs::write(folder.join("results/lock.json"), ACTS).unwrap();
    fs::remove_file(&record).unwrap();
    succeed(folder, RUN);
}
