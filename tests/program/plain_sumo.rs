//! Plain `sumo` repeats recorded episodes, of networks that are built and of configurations that are
//! imported.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::common::{run, stderr, succeed};
use crate::outcomes::refused;
use serde_json::Value;
use tsc_family::traffic::sim::tripinfo;
use tsc_family::traffic::sim::tripinfo::TripTotals;

/// The rows of a task's record.
fn rows(results: &Path, task: usize) -> Vec<Value> {
    let text = fs::read_to_string(results.join(format!("done/000/{task}.jsonl"))).unwrap();
    text.lines().skip(1).map(|l| serde_json::from_str(l).unwrap()).collect()
}

/// Runs a command that writes `trips.xml`, in a folder.
fn simulate(folder: &Path, command: &str) -> TripTotals {
    let mut words = command.split_whitespace();
    let mut sumo = Command::new(words.next().unwrap());
    let output = sumo.args(words).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{}", stderr(&output));
    tripinfo::read(&folder.join("trips.xml")).unwrap()
}

fn check(row: &Value, trips: &TripTotals) {
    assert!(trips.vehicles > 0);
    assert_eq!(row["metrics"]["delay_s"], trips.delay_s / f64::from(trips.vehicles));
    assert_eq!(row["metrics"]["vehicles_veh"], f64::from(trips.vehicles));
}

#[test]
fn plain_sumo_with_the_recorded_seed_and_its_routes_gives_the_recorded_delay() {
    let folder = tempfile::tempdir().unwrap();
    let settings = "--set demand.peak_hour_factor=0.92 --set demand.approach_spread=0.4";
    let smoke = format!("run smoke --methods baseline --eval-seeds 2 --quiet {settings} --out out");
    succeed(folder.path(), &smoke);
    let rows = rows(&folder.path().join("out"), 0);
    assert_eq!(rows.len(), 2);
    for row in rows {
        let routes = format!("routes --point quiet smoke --seed {} --out r.xml", row["seed"]);
        let command = succeed(folder.path(), &format!("{routes} {settings}"));
        check(&row, &simulate(folder.path(), &command));
    }
}

#[test]
fn an_unknown_point_is_refused_before_anything_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let output = run(folder.path(), "routes --point nowhere smoke --seed 1 --out r.xml");
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("no point MDP \"nowhere\"; it has quiet, busy"));
    assert!(!folder.path().join("r.xml").exists() && !folder.path().join("networks").exists());
}

/// A folder with a network, its vehicles of the first ten minutes, and configurations of these names.
fn imported(step_length: &str, names: &[&str]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), "build-networks smoke --quiet");
    let text = format!(
        "<configuration><net-file v=\"networks/smoke/busy/busy.net.xml\"/>\
         <r>networks/smoke/busy/busy.rou.xml</r><begin value=\"0:00:00\"/>\
         <end value=\"00:10:00\"/><step-length value=\"{step_length}\"/></configuration>"
    );
    for name in names {
        fs::write(folder.path().join(name), &text).unwrap();
    }
    folder
}

#[test]
fn an_imported_configuration_keeps_its_step_length_and_a_renamed_one_its_vehicles() {
    let folder = imported("0.5", &["a.sumocfg", "b.sumocfg"]);
    for name in ["a", "b"] {
        let run = format!("run --sumocfg {name}.sumocfg --methods program,max-pressure");
        succeed(folder.path(), &format!("{run} --eval-seeds 1 --quiet --out {name}"));
    }
    let row = |name: &str, task| rows(&folder.path().join(name), task).remove(0);
    for task in [0, 1, 2] {
        assert_eq!(row("a", task), row("b", task));
    }
    let program = row("a", 1);
    let command = format!(
        "sumo -c a.sumocfg --seed {} --time-to-teleport -1 --xml-validation never \
         --tripinfo-output trips.xml --tripinfo-output.write-unfinished \
         --tripinfo-output.write-undeparted",
        program["seed"]
    );
    check(&program, &simulate(folder.path(), &command));
    assert!(row("a", 2)["metrics"]["delay_s"].as_f64().unwrap() > 0.0);
}

#[test]
fn a_step_length_that_cannot_work_is_refused_with_the_reason() {
    let folder = imported("0.3", &["a.sumocfg"]);
    let text = refused(folder.path(), "run --sumocfg a.sumocfg --out out");
    assert!(text.contains("a step-length of 0.3 s does not divide a second"), "{text}");
}
