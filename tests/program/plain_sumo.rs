//! Plain `sumo` repeats recorded episodes of networks that are built.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::common::{stderr, succeed};
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
