//! `tsc-family routes`: plain `sumo` repeats a recorded episode.
#![cfg(feature = "libsumo")]
#![expect(clippy::unwrap_used, reason = "a test may panic")]

mod common;

use std::fs;
use std::path::Path;
use std::process::Command;

use common::{run, stderr, succeed};
use serde_json::Value;
use tsc_family::sim::tripinfo;

/// The rows of the baseline's record on the first point MDP.
fn rows(results: &Path) -> Vec<Value> {
    let text = fs::read_to_string(results.join("done/000/0.jsonl")).unwrap();
    text.lines().skip(1).map(|l| serde_json::from_str(l).unwrap()).collect()
}

#[test]
fn plain_sumo_with_the_recorded_seed_and_its_routes_gives_the_recorded_delay() {
    let folder = tempfile::tempdir().unwrap();
    let settings = "--set demand.peak_hour_factor=0.92 --set demand.approach_spread=0.4";
    let smoke = format!("run smoke --methods baseline --eval-seeds 2 --quiet {settings} --out out");
    succeed(folder.path(), &smoke);
    let rows = rows(&folder.path().join("out"));
    assert_eq!(rows.len(), 2);
    for row in rows {
        let routes = format!("routes --point quiet smoke --seed {} --out r.xml", row["seed"]);
        let command = succeed(folder.path(), &format!("{routes} {settings}"));
        let mut words = command.split_whitespace();
        let mut sumo = Command::new(words.next().unwrap());
        let output = sumo.args(words).current_dir(folder.path()).output().unwrap();
        assert!(output.status.success(), "{}", stderr(&output));
        let trips = tripinfo::read(&folder.path().join("trips.xml")).unwrap();
        let delay_s = trips.delay_s / f64::from(trips.vehicles);
        assert_eq!(row["metrics"]["delay_s"], delay_s);
        assert_eq!(row["metrics"]["vehicles_veh"], f64::from(trips.vehicles));
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
