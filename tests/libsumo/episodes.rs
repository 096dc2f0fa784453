use std::fs;

use crate::fixture::Scenario;
use tsc_family::traffic::sim::libsumo::SumoSim;
use tsc_family::traffic::sim::{Sim, Snapshot};

/// More vehicles than the edges from W can take in, with SUMO's random speeds.
const ROUTES: &str = r#"<flow id="f" begin="0" end="300" number="300" departLane="random">
    <route edges="WA AB BE"/></flow>"#;

#[test]
fn equal_seeds_give_equal_tripinfo_with_unfinished_and_undeparted_vehicles() {
    let _alone = crate::alone();
    let scenario = Scenario::new();
    let mut sim = SumoSim::new().unwrap();
    let mut run = |name: &str, seed: &str| {
        let mut options = scenario.options("net", "flow", ROUTES);
        options.tripinfo = scenario.file(name, "tripinfo");
        options.args = vec!["--seed".to_owned(), seed.to_owned()];
        sim.start(&options).unwrap();
        let mut snapshots = Vec::new();
        for _ in 0..30 {
            sim.step(10).unwrap();
            let mut snapshot = Snapshot::default();
            sim.observe(&mut snapshot).unwrap();
            snapshots.push(snapshot);
        }
        sim.close().unwrap();
        let text = fs::read_to_string(options.tripinfo).unwrap();
        // The header has the date and the file's own name.
        let (_, rows) = text.split_once("-->").unwrap();
        (snapshots, rows.to_owned())
    };
    let first = run("first", "1");
    let second = run("second", "1");
    let other = run("other", "2");
    assert!(first == second, "the same seed twice gave different results");
    assert!(first.1 != other.1, "the seed changed nothing");

    let (_, rows) = first;
    assert!(rows.trim_end().ends_with("</tripinfos>"), "the output was cut off");
    let count = |what: &str| rows.lines().filter(|row| row.contains(what)).count();
    let unfinished = count(r#" arrival="-1"#);
    let undeparted = count(r#" depart="-1"#);
    assert!(count("<tripinfo ") > unfinished && unfinished > undeparted && undeparted > 0);
}
