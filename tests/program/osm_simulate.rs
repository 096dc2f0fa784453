//! The networks of hand-written extracts in SUMO, with their real arms: all before a release, else a sixth.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::succeed;
use crate::nightly::is_nightly;
use osm_signals::DrivingSide;
use osm_signals::read::read;
use osm_signals::settings::Settings;
use osm_signals::survey::{Inputs, Survey};
use tsc_family::traffic::city::sites::City;

/// Five minutes, and vehicles that stand for half of them are teleported: none does at low demand.
const SCENARIO: &str = "\
name = \"cases\"
network.driving_side = \"SIDE\"
demand.horizon_s = 300
simulation.time_to_teleport_s = 150
[family]
approaches = \"approaches.csv\"
detail = \"per-approach\"
hourly_share = 0.02
";

/// Writes the approaches of every so many cases of a side as one table, each intersection under the name of its case.
fn write_approaches(file: &Path, wanted: DrivingSide, every: usize) -> usize {
    let mut writer = csv::Writer::from_path(file).unwrap();
    let mut intersections = 0;
    let folders = fs::read_dir("osm-signals/tests/networks").unwrap();
    let mut cases: Vec<PathBuf> = folders.map(|case| case.unwrap().path()).collect();
    cases.retain(|case| case.is_dir());
    cases.sort();
    for case in cases.into_iter().step_by(every) {
        let extract = read(&case.join("input.osm"), &|_, _| {}).unwrap();
        let settings = Settings::default();
        if case.to_string_lossy().contains("left_hand") != (wanted == DrivingSide::Left) {
            continue;
        }
        let inputs = Inputs { driving_side: wanted, ..Inputs::default() };
        let city = City::new(Survey::new(&extract, &settings, &inputs), wanted);
        intersections += city.sites().count();
        for mut row in city.approaches(&settings.intersections) {
            let name = case.file_name().unwrap().to_string_lossy();
            row.intersection = format!("{name}-{}", row.intersection);
            writer.serialize(row).unwrap();
        }
    }
    writer.flush().unwrap();
    intersections
}

/// A sixth of them at every change.
#[test]
fn every_case_simulates_without_an_error_or_a_teleport() {
    let every = if is_nightly() { 1 } else { 6 };
    assert!(simulated(DrivingSide::Right, every) > 30 / every);
}

#[test]
fn every_case_of_left_hand_traffic_simulates_without_an_error_or_a_teleport() {
    assert!(simulated(DrivingSide::Left, 1) >= 2);
}

fn simulated(side: DrivingSide, every: usize) -> usize {
    let folder = tempfile::tempdir().unwrap();
    let intersections = write_approaches(&folder.path().join("approaches.csv"), side, every);
    let scenario = SCENARIO.replace("SIDE", side.name());
    fs::write(folder.path().join("scenario.toml"), scenario).unwrap();
    succeed(
        folder.path(),
        "run scenario.toml --methods max-pressure --eval-seeds 1 --quiet --out out",
    );
    let mut scores = csv::Reader::from_path(folder.path().join("out/report/scores.csv")).unwrap();
    let head = scores.headers().unwrap().clone();
    let column = |name: &str| head.iter().position(|h| h == name).unwrap();
    let (teleports, arrived) = (column("teleports"), column("throughput_veh"));
    let mut rows = 0;
    for row in scores.records() {
        let row = row.unwrap();
        assert_eq!(row[teleports].parse::<f64>().unwrap(), 0.0, "{row:?}");
        assert!(row[arrived].parse::<f64>().unwrap() > 0.0, "{row:?}");
        rows += 1;
    }
    assert_eq!(rows, 2 * intersections);
    intersections
}
