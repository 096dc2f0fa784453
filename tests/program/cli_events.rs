//! `tsc-family events` end to end.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::common::{run, stderr, succeed};

const RUN: &str = "run smoke --budget all --preset field --methods nema,fixed-time,max-pressure,idqn --eval-seeds 2 \
    --set demand.horizon_s=300 --set fixed_time.simulations=8 --set training.episodes=2 --out results --quiet";

fn refused(folder: &Path, args: &str) -> String {
    let output = run(folder, &format!("events {args}"));
    assert_eq!(output.status.code(), Some(2), "{args}: {}", stderr(&output));
    stderr(&output)
}

/// Returns how often each code comes in the events of a folder.
fn codes(folder: &Path) -> BTreeMap<u32, usize> {
    let text = fs::read_to_string(folder.join("events.csv")).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("TimeStamp,DeviceId,EventId,Parameter"));
    let mut codes = BTreeMap::new();
    let mut last = String::new();
    for line in lines {
        let cells: Vec<&str> = line.split(',').collect();
        assert!(*cells[0] >= *last, "{line} comes after {last}");
        cells[0].clone_into(&mut last);
        *codes.entry(cells[2].parse().unwrap()).or_default() += 1;
    }
    codes
}

#[test]
fn an_episode_of_every_kind_of_method_is_the_one_that_was_recorded() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    succeed(folder, RUN);
    for method in ["baseline", "nema", "fixed-time", "max-pressure", "idqn"] {
        let command = format!(
            "events results --point busy --method {method} --start 2026-03-02 --out ev/{method}"
        );
        let output = run(folder, &command);
        assert_eq!(output.status.code(), Some(0), "{method}: {}", stderr(&output));
        // It would warn of another delay.
        assert_eq!(stderr(&output), "", "{method}");
        let codes = codes(&folder.join("ev").join(method));
        for code in [1, 8, 10, 81, 82] {
            assert!(codes.get(&code) > Some(&3), "{method}: {codes:?}");
        }
        assert_eq!(codes.contains_key(&4), method == "nema", "{method}: {codes:?}");
        let is_cycle = ["baseline", "fixed-time"].contains(&method);
        assert_eq!(codes.get(&132).copied(), is_cycle.then_some(1), "{method}: {codes:?}");
    }
    // Channels are those of the network, whatever the method.
    let channels = |method: &str| -> Vec<String> {
        let text = fs::read_to_string(folder.join(format!("ev/{method}/detectors.csv"))).unwrap();
        let own = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            [cells[0], cells[2], cells[3], cells[5]].join(",")
        };
        text.lines().map(own).collect()
    };
    assert!(channels("nema").len() > 8);
    assert_eq!(channels("nema"), channels("idqn"));
    // Two seeds are two episodes.
    let text = fs::read_to_string(folder.join("results/report/episodes.csv")).unwrap();
    let is = |line: &&str| line.starts_with("nema,busy,0,evaluation,");
    let seeds: Vec<&str> = text.lines().filter(is).map(|l| l.split(',').nth(5).unwrap()).collect();
    let again = |seed: &str, out: &str| {
        let args = format!("--point busy --method nema --start 2026-03-02 --seed {seed}");
        succeed(folder, &format!("events results {args} --out {out}"));
        fs::read(folder.join(out).join("events.csv")).unwrap()
    };
    assert_eq!(again(seeds[0], "again"), fs::read(folder.join("ev/nema/events.csv")).unwrap());
    assert_ne!(again(seeds[0], "again"), again(seeds[1], "other"));

    let nema = "--point busy --method nema";
    let e = refused(folder, "results --point bussy --method nema --out x");
    assert!(e.contains("has no point MDP \"bussy\"") && e.contains("busy"), "{e}");
    let e = refused(folder, "results --point busy --method actuated --out x");
    assert!(e.contains("has no method \"actuated\"") && e.contains("it has baseline, "), "{e}");
    let e = refused(folder, &format!("results {nema} --seed 1 --out x"));
    assert!(e.contains("--seed 1 is of no evaluation episode") && e.contains(seeds[0]), "{e}");
    let e = refused(folder, &format!("results {nema} --replicate 3 --out x"));
    assert!(e.contains("has no training 3 of nema on busy; they count from 0"), "{e}");
    let e = refused(folder, &format!("results {nema} --start noon --out x"));
    assert!(e.contains("--start: expected a day, such as 2026-01-31"), "{e}");
    let e = refused(folder, &format!("results {nema} --advance-m 5 --out x"));
    assert!(e.contains("expected metres from 10 to 1000"), "{e}");
    let e = refused(folder, &format!("results {nema} --out results"));
    assert!(e.contains("is not empty and no folder that events wrote"), "{e}");
    assert!(!folder.join("x").exists());
}
