//! `tsc-family run` and `report` end to end, with SUMO, on the smoke scenario.

use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::common::{program, stderr};
use crate::folder::Folder;
use serde_json::Value;

const SMOKE: &str =
    "run smoke --eval-seeds 2 --methods max-pressure,actuated --set demand.horizon_s=600 --out out";

fn lines(text: &str, event: &str) -> Vec<Value> {
    let lines = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap());
    lines.filter(|line| line["event"] == event).collect()
}

fn begun_by(folder: &Folder, build: &str) {
    let mut manifest = folder.json("out/manifest.json");
    manifest["provenance"]["git"] = build.into();
    folder.write("out/manifest.json", &manifest.to_string());
}

#[test]
fn a_run_is_told_in_lines_repaired_by_repeating_it_and_reported_against_others() {
    let folder = Folder::new();
    let text = folder.run(&format!("{SMOKE} --json"));
    let methods = lines(&text, "method");
    assert_eq!((lines(&text, "task").len(), methods.len(), text.lines().count()), (6, 3, 9));
    let baseline = methods.iter().find(|line| line["method"] == "baseline").unwrap();
    assert_eq!(baseline["overall"], 1.0);
    for field in
        "overall_low overall_high delay_s points failed against ratio_of_means median".split(' ')
    {
        assert!(baseline.get(field).is_some(), "{field}");
    }
    let again = folder.run(&format!("{SMOKE} --json"));
    assert_eq!(again.lines().count(), 3, "nothing is done twice: {again}");
    assert_eq!(folder.rows("out/report/scores.csv").len(), 6);

    let lock = fs::File::options().write(true).open(folder.join("out/lock.json")).unwrap();
    lock.lock().unwrap();
    assert!(folder.says(5, SMOKE).contains("in use by another run"));
    drop(lock);

    // A record that was cut off is named, and its task alone is repeated once it is deleted.
    let before = folder.records("out");
    let record = folder.read("out/done/000/2.jsonl");
    folder.write("out/done/000/2.jsonl", &record[..record.len() / 2]);
    for args in ["report out", SMOKE] {
        assert!(folder.says(2, args).contains("done/000/2.jsonl"));
    }
    fs::remove_file(folder.join("out/done/000/2.jsonl")).unwrap();
    begun_by(&folder, "1234567");
    let said = folder.says(0, SMOKE);
    assert!(said.contains("this run was begun by the build 1234567 and goes on with"), "{said}");
    assert_eq!(before, folder.records("out"));

    let text = folder.run(&format!("{SMOKE} --against actuated"));
    assert!(text.contains("Scores against actuated, not against the baseline:"), "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 100), "{text}");
    assert!(!folder.read("out/report/against-actuated/summary.csv").contains(",baseline,"));
    folder.refuses(&[("report out --against idqn", "there is no method `idqn`")]);
}

#[test]
fn records_depend_neither_on_the_number_of_workers_nor_on_a_kill() {
    let folder = Folder::new();
    let long = "run smoke --eval-seeds 4 --methods fixed-time,max-pressure,actuated --set demand.horizon_s=300 --quiet";
    folder.run(&format!("{long} --out whole --jobs 1"));
    let args = shlex::split(&format!("{long} --out killed --jobs 3")).unwrap();
    let mut child = program(folder.path()).args(args).stderr(Stdio::null()).spawn().unwrap();
    let done = folder.join("killed/done/000");
    let start = Instant::now();
    while fs::read_dir(&done).map_or(0, Iterator::count) < 2 {
        assert!(start.elapsed() < Duration::from_secs(60), "no task was finished in a minute");
        sleep(Duration::from_millis(5));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let killed = fs::read_dir(&done).unwrap().count();
    assert!(killed < 8, "it was over before it was killed, and nothing is shown");
    folder.run(&format!("{long} --out killed --jobs 3"));
    let whole = folder.records("whole");
    assert_eq!(whole.len(), 8);
    assert_eq!(whole, folder.records("killed"));
}

#[test]
fn an_altered_network_is_refused_until_it_is_built_again() {
    let folder = Folder::after("build-networks smoke --quiet");
    let net = "networks/smoke/busy/busy.net.xml";
    let text = folder.read(net);
    folder.write(net, &text.replacen("speed=\"", "speed=\"1", 1));
    assert!(folder.says(2, SMOKE).contains("busy.net.xml: was altered"));
    fs::remove_file(folder.join(net)).unwrap();
    assert!(folder.says(2, SMOKE).contains("busy.net.xml: was deleted"));
    folder.run("build-networks smoke --force --quiet");
    assert_eq!(folder.read(net), text);
}

#[test]
fn settings_are_part_of_what_a_run_is_and_replicates_are_averaged() {
    let folder = Folder::new();
    let short = "run smoke --eval-seeds 1 --methods fixed-time,max-pressure --replicates 2 \
                 --set demand.horizon_s=300 --out out";
    let text = folder.run(&format!("{short} --set fixed_time.simulations=8 --json"));
    let settings = &folder.json("out/manifest.json")["identity"]["settings"];
    assert_eq!(settings["demand"]["horizon_s"], 300.0);
    let expected = "out holds another run: fixed_time.simulations is 8 there and 9 now; give";
    let said = folder.says(5, &format!("{short} --set fixed_time.simulations=9"));
    assert!(said.contains(expected), "{said}");
    let rows = folder.rows("out/report/scores.csv");
    assert_eq!(rows.len(), 2 * (1 + 2 + 1));
    let tuned = rows.iter().filter(|row| row["method"] == "fixed-time");
    let number = |text: &str| text.parse::<f64>().unwrap();
    let mean: f64 = tuned.map(|row| number(&row["importance"]) * number(&row["score"]) / 2.0).sum();
    let methods = lines(&text, "method");
    let line = methods.iter().find(|line| line["method"] == "fixed-time").unwrap();
    assert!((line["overall"].as_f64().unwrap() - mean).abs() < 1e-9, "{line} {mean}");
}

#[test]
fn a_sumo_scenario_is_a_point_mdp_too_and_needs_a_signal() {
    let folder = Folder::after("build-networks smoke --quiet");
    let methods = "--methods program,max-pressure --eval-seeds 1 --json";
    let text = folder.run(&format!("run --sumocfg networks/smoke/busy/busy.sumocfg {methods}"));
    let program = lines(&text, "method");
    let program = program.iter().find(|line| line["method"] == "program").unwrap();
    assert!(program["overall"].as_f64().unwrap() > 0.0);
    let nodes = "<nodes><node id=\"a\" x=\"0\" y=\"0\"/><node id=\"b\" x=\"99\" y=\"0\"/></nodes>";
    folder.write("n.nod.xml", nodes);
    folder.write("n.edg.xml", "<edges><edge id=\"e\" from=\"a\" to=\"b\"/></edges>");
    netconvert(folder.path(), "-n n.nod.xml -e n.edg.xml -o n.net.xml -X never");
    folder.write("n.sumocfg", "<c><net-file value=\"n.net.xml\"/><end value=\"60\"/></c>");
    folder.refuses(&[("run --sumocfg n.sumocfg --out out", "it has no traffic signal")]);
}

pub(crate) fn netconvert(folder: &Path, args: &str) {
    let mut command = Command::new("netconvert");
    let output = command.current_dir(folder).args(args.split(' ')).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
}

#[test]
fn a_dry_run_lists_the_plan_and_writes_nothing() {
    let folder = Folder::new();
    insta::assert_snapshot!("dry_run", folder.run("run --budget 4 --jobs 2 --dry-run"));
    let text = folder.run("run smoke --replicates 3 --dry-run");
    assert!(text.starts_with("2 of 2 point MDPs (all, seed 0), 5 methods, 14 tasks\n"), "{text}");
    // Tuning of fixed-time takes 8 episodes in this scenario, evaluation 5.
    assert!(text.contains(&format!("{} episodes at most", 2 * (3 * (8 + 5) + 4 * 5))), "{text}");
    assert!(folder.names("").is_empty());
}

#[test]
fn doctor_finds_nothing_wrong() {
    let findings: Value = serde_json::from_str(&Folder::new().run("doctor --json")).unwrap();
    assert_eq!(findings["problems"], Value::Array(vec![]));
    assert!(findings["sumo_version"].as_str().unwrap().starts_with("SUMO 1."));
}
