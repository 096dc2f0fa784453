//! `tsc-family build-networks --osm` end to end, on hand-written extracts.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{program, run, stderr, succeed};
use serde_json::Value;

fn case(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("osm-signals/tests/networks")
        .join(name)
        .join("input.osm")
}

/// Derives a family of a case into `city` of a folder, with further arguments.
fn build(folder: &Path, name: &str, more: &str) -> std::process::Output {
    let mut command = program(folder);
    command.args(["build-networks", "--out", "city", "--osm"]).arg(case(name));
    command.args(more.split_whitespace()).output().unwrap()
}

fn built(name: &str, more: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let output = build(folder.path(), name, more);
    assert!(output.status.success(), "{name} {more}: {}", stderr(&output));
    (folder, String::from_utf8(output.stdout).unwrap())
}

/// The message of a build that fails with code 2, without the path of this checkout.
fn refused(name: &str, more: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let output = build(folder.path(), name, more);
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{name} {more}: {message}");
    assert!(!folder.path().join("city").exists(), "nothing is written");
    message.replace(env!("CARGO_MANIFEST_DIR"), ".")
}

/// The same as a file of a folder, which is not the checkout's.
fn refused_file(name: &str, bytes: &[u8]) -> String {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(name), bytes).unwrap();
    let output = run(folder.path(), &format!("build-networks --osm {name} --out city"));
    let message = stderr(&output);
    assert_eq!(output.status.code(), Some(2), "{name}: {message}");
    message
}

#[test]
fn a_map_becomes_a_family_that_list_and_run_understand() {
    let (folder, text) = built("four_arms", "");
    assert!(text.contains("1 signals: 1 in 1 intersections, which are 1 point MDPs"), "{text}");
    assert!(text.contains("next: tsc-family run city --budget all --out results/city"), "{text}");
    let city = folder.path().join("city");
    for file in [
        "approaches.csv", "family.csv", "scenario.toml", "intersections.geojson", "quality.html",
        "quality.json", "networks/INDEX.csv",
    ] {
        assert!(city.join(file).is_file(), "{file} is missing");
    }
    let again = build(folder.path(), "four_arms", "");
    let again = String::from_utf8(again.stdout).unwrap();
    assert!(again.contains("0 built, 1 up to date"), "{again}");
    let list = succeed(folder.path(), "list city --json");
    assert_eq!(list.lines().count(), 1);
    let plan = succeed(folder.path(), "run city --budget 1 --dry-run");
    assert!(plan.contains("1 point MDP"), "{plan}");
    // `family.csv` is a table of point MDPs that a scenario can name.
    fs::write(city.join("own.toml"), "name = \"own\"\nfamily.points = \"family.csv\"\n").unwrap();
    assert_eq!(succeed(folder.path(), "list city/own.toml --json").lines().count(), 1);
}

#[test]
fn the_same_input_gives_the_same_files_whatever_the_number_of_workers() {
    let files = |jobs: &str| -> Vec<Vec<u8>> {
        let (folder, _) = built("divided_by_divided", &format!("--detail per-approach {jobs}"));
        let names = ["approaches.csv", "scenario.toml", "intersections.geojson", "quality.json"];
        let city = folder.path().join("city");
        names.map(|name| fs::read(city.join(name)).unwrap()).to_vec()
    };
    assert_eq!(files("--jobs 1"), files("--jobs 3"));
}

#[test]
fn settings_reach_the_scenario_that_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let config = "[traffic.default_aadt_per_lane]\nsecondary = 12000\n\
                  [scenario.family]\nhourly_share = 0.1\n";
    fs::write(folder.path().join("own.toml"), config).unwrap();
    let more = "--config own.toml --set demand.horizon_s=900 --detail per-approach";
    let output = build(folder.path(), "four_arms", more);
    assert!(output.status.success(), "{}", stderr(&output));
    let scenario = fs::read_to_string(folder.path().join("city/scenario.toml")).unwrap();
    for line in [
        "hourly_share = 0.1", "directional_split = 0.55", "default = 1.0",
        "detail = \"per-approach\"", "horizon_s = 900",
    ] {
        assert!(scenario.contains(line), "{scenario}");
    }
    let approaches = fs::read_to_string(folder.path().join("city/approaches.csv")).unwrap();
    assert!(approaches.contains(",12000.0,"), "{approaches}");
}

#[test]
fn a_signal_list_decides_which_intersections_count_and_names_them() {
    let folder = tempfile::tempdir().unwrap();
    let list = "SIGNAL,LAT,LNG\n1001,40.00005,-75.0\n1002,40.1,-75.0\n";
    fs::write(folder.path().join("list.csv"), list).unwrap();
    let output = build(folder.path(), "four_arms", "--signals list.csv");
    assert!(output.status.success(), "{}", stderr(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(text.contains("1 of 2 listed signals matched"), "{text}");
    let quality = fs::read_to_string(folder.path().join("city/quality.json")).unwrap();
    let quality: Value = serde_json::from_str(&quality).unwrap();
    assert_eq!(quality["spots"][0]["id"], "1001");
    assert_eq!(quality["listed"][1]["reason"], "no junction of streets within reach");
}

#[test]
fn rows_of_a_list_that_are_no_signals_are_told_and_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let list =
        "id,Type,shape\n1001,SIGNAL,POINT (-75.0 40.00005)\n1002,BEACON,POINT (-75.0 40.1)\n";
    fs::write(folder.path().join("list.csv"), list).unwrap();
    let all = build(folder.path(), "four_arms", "--signals list.csv");
    let warning = "list.csv: 1 rows may be no signals: column Type has BEACON (1); leave them out with --signals-where";
    assert!(stderr(&all).contains(warning), "{}", stderr(&all));
    let some = build(folder.path(), "four_arms", "--signals list.csv --signals-where type=signal");
    assert!(some.status.success(), "{}", stderr(&some));
    assert!(stderr(&some).contains("1 rows are not as asked for"), "{}", stderr(&some));
    let text = String::from_utf8(some.stdout).unwrap();
    assert!(text.contains("1 of 1 listed signals matched"), "{text}");
    // A listed junction without a signal on the map is counted in the terminal.
    let unmapped = "id,lat,lon\n1,40.0,-75.0\n";
    fs::write(folder.path().join("unmapped.csv"), unmapped).unwrap();
    let map = fs::read_to_string(case("four_arms")).unwrap();
    fs::write(folder.path().join("bare.osm"), map.replace("traffic_signals", "crossing")).unwrap();
    let text =
        succeed(folder.path(), "build-networks --osm bare.osm --signals unmapped.csv --out bare");
    assert!(text.contains("1 of them have no signal on the map"), "{text}");
}

#[test]
fn real_approaches_stay_what_they_are_unless_somebody_asks_for_six_features() {
    let (folder, _) = built("t_junction", "");
    let scenario = fs::read_to_string(folder.path().join("city/scenario.toml")).unwrap();
    assert!(scenario.contains("detail = \"per-approach\""), "{scenario}");
    let approaches = folder.path().join("city/approaches.csv");
    fs::copy(&approaches, folder.path().join("own.csv")).unwrap();
    fs::write(folder.path().join("own.toml"), "family.approaches = \"own.csv\"\n").unwrap();
    assert!(succeed(folder.path(), "list own.toml").contains("n101"));
    let six = succeed(folder.path(), "list own.toml --set family.detail=six-features");
    assert!(six.contains("-Q") && !six.contains("n101"), "{six}");
}

#[test]
fn what_is_doubtful_in_a_table_is_told_by_every_command_and_listed_in_full() {
    let (folder, _) = built("four_arms", "");
    let text = fs::read_to_string(folder.path().join("city/approaches.csv")).unwrap();
    // Every count is empty or beyond the cap.
    let counts = |(i, row): (usize, &str)| {
        let mut fields: Vec<&str> = row.split(',').collect();
        fields[11] = if i == 1 { "" } else { "24000" };
        fields.join(",") + "\n"
    };
    let mut lines = text.lines();
    let header = lines.next().unwrap();
    let rows: String = lines.enumerate().map(counts).collect();
    fs::write(folder.path().join("own.csv"), format!("{header}\n{rows}")).unwrap();
    fs::write(folder.path().join("own.toml"), "family.approaches = \"own.csv\"\n").unwrap();
    let output = run(folder.path(), "run own.toml --dry-run");
    let message = stderr(&output);
    assert!(message.contains("warning: own.csv: inflows above"), "{message}");
    assert!(
        message.contains("is empty, and the mean of other approaches stands for it (line 3"),
        "{message}"
    );
    let all = succeed(folder.path(), "list own.toml --warnings");
    assert!(all.lines().count() > 5 && all.contains("\n  line 2: "), "{all}");
}

#[test]
fn counts_replace_the_default_of_the_class() {
    let folder = tempfile::tempdir().unwrap();
    let line = r#"{"type": "FeatureCollection", "features": [{"type": "Feature",
        "properties": {"AADT2023": 24000}, "geometry": {"type": "LineString",
        "coordinates": [[-75.003, 40.0], [-74.998, 40.0]]}}]}"#;
    fs::write(folder.path().join("aadt.geojson"), line).unwrap();
    let output = build(folder.path(), "four_arms", "--aadt aadt.geojson --detail per-approach");
    assert!(output.status.success(), "{}", stderr(&output));
    let approaches = fs::read_to_string(folder.path().join("city/approaches.csv")).unwrap();
    let per_lane: Vec<&str> =
        approaches.lines().skip(1).map(|row| row.split(',').nth(11).unwrap()).collect();
    // 24000 vehicles a day, half of them towards the signal, on two lanes.
    assert_eq!((per_lane[1], per_lane[3]), ("6000.0", "6000.0"));
}

#[test]
fn counts_of_another_city_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let table = "latitude,longitude,aadt\n41.0,-75.0,9000\n";
    fs::write(folder.path().join("aadt.csv"), table).unwrap();
    let output = build(folder.path(), "four_arms", "--aadt aadt.csv");
    assert_eq!(output.status.code(), Some(2));
    let message = stderr(&output);
    assert!(message.contains("aadt.csv: none of its 1 counts"), "{message}");
    fs::write(folder.path().join("list.csv"), "lat,lon\n41.0,-75.0\n").unwrap();
    let output = build(folder.path(), "four_arms", "--signals list.csv");
    assert_eq!(output.status.code(), Some(2));
    let message = stderr(&output);
    assert!(message.contains("list.csv: none of its 1 signals"), "{message}");
    assert!(message.contains("latitudes 41.000 to 41.000"), "{message}");
    fs::write(folder.path().join("list.csv"), "{\"type\": \"FeatureCollection\"}").unwrap();
    let output = build(folder.path(), "four_arms", "--signals list.csv");
    assert_eq!(output.status.code(), Some(2));
    assert!(
        stderr(&output).contains("a FeatureCollection of points is needed"),
        "{}",
        stderr(&output)
    );
    fs::write(folder.path().join("list.csv"), "lat,lon\n-75.0,40.0\n").unwrap();
    let output = build(folder.path(), "four_arms", "--signals list.csv");
    let message = stderr(&output);
    assert!(
        message.contains("exchange latitude and longitude, with which they lie at the extract"),
        "{message}"
    );
}

#[test]
fn a_boundary_leaves_out_what_lies_beyond() {
    let message = refused("four_arms", "--boundary=-76,40,-75.5,41");
    assert!(message.contains("1 outside the boundary"), "{message}");
    assert!(message.contains("the extract covers longitudes -75.003 to -74.99"), "{message}");
    built("four_arms", "--boundary=-76,39,-74,41");
}

#[test]
fn options_of_a_map_need_a_map() {
    let folder = tempfile::tempdir().unwrap();
    let options =
        ["--signals a.csv", "--boundary=1,2,3,4", "--detail per-approach", "--driving-side left"];
    for arguments in options {
        for (scenario, expected) in [("", "--osm"), ("smoke", "give one with --osm")] {
            let command = format!("build-networks {scenario} --out nets {arguments}");
            let output = run(folder.path(), &command);
            assert_eq!(output.status.code(), Some(2), "{command}");
            assert!(stderr(&output).contains(expected), "{command}: {}", stderr(&output));
            assert!(!folder.path().join("nets").exists(), "{command}: nothing is written");
        }
    }
    let output = run(folder.path(), "build-networks smoke --osm a.osm");
    assert_eq!(output.status.code(), Some(2));
}

#[test]
fn extracts_without_an_intersection_say_why() {
    let message = refused("crossing_signals_alone", "");
    assert!(message.contains("no signal (highway=traffic_signals)"), "{message}");
    let message = refused("all_at_border", "");
    assert!(message.contains("2 at the border of the extract"), "{message}");
    let message = refused("roundabout_with_signals", "");
    assert!(message.contains("4 roundabout"), "{message}");
}

#[test]
fn files_that_are_no_extract_are_refused_by_name() {
    let xml = fs::read(case("four_arms")).unwrap();
    for bytes in [&xml[..xml.len() / 2], b"", b"<osm></osm>", b"{}"] {
        assert!(refused_file("a.osm", bytes).contains("a.osm"));
    }
    let folder = tempfile::tempdir().unwrap();
    let output = run(folder.path(), "build-networks --osm missing.osm.pbf");
    assert_eq!(output.status.code(), Some(2));
    assert!(stderr(&output).contains("missing.osm.pbf"));
}

#[test]
fn wrong_settings_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let settings = [
        ("[streets]\nspeed = 3\n", "speed"),
        ("[streets]\ndefault_speed_mph = -1\n", "streets.default_speed_mph"),
        ("[traffic]\ndirectional_split = 2\n", "traffic.directional_split"),
        ("[traffic.default_aadt_per_lane]\nboulevard = 2\n", "boulevard"),
        ("[intersections]\nmedian_m = 5\n", "intersections.median_m"),
        ("[counts]\nmatch_m = -5\n", "counts.match_m"),
        ("[scenario.family]\nhourly_share = 7\n", "hourly_share"),
    ];
    for (text, named) in settings {
        fs::write(folder.path().join("own.toml"), text).unwrap();
        let output = build(folder.path(), "four_arms", "--config own.toml");
        assert_eq!(output.status.code(), Some(2), "{text}");
        assert!(stderr(&output).contains(named), "{text}: {}", stderr(&output));
    }
}

#[test]
fn tables_that_were_edited_are_not_overwritten_without_force() {
    let (folder, _) = built("four_arms", "");
    let approaches = folder.path().join("city/approaches.csv");
    let own = fs::read_to_string(&approaches).unwrap().replace(",25.0,", ",30.0,");
    fs::write(&approaches, &own).unwrap();
    let output = build(folder.path(), "four_arms", "");
    assert_eq!(output.status.code(), Some(2));
    let message = stderr(&output);
    assert!(message.contains("approaches.csv: not as this command wrote it"), "{message}");
    assert_eq!(fs::read_to_string(&approaches).unwrap(), own);
    assert!(build(folder.path(), "four_arms", "--force").status.success());
    assert_ne!(fs::read_to_string(&approaches).unwrap(), own);
}

#[test]
fn settings_that_the_command_decides_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (text, named) in [
        ("[scenario.family]\ndetail = \"six-features\"\n", "family.detail"),
        ("[scenario.family]\napproaches = \"q.csv\"\n", "family.approaches"),
        ("[scenario]\nname = \"other\"\n", "name"),
        ("[scenario.family]\nfamiliy = 1\n", "familiy"),
    ] {
        fs::write(folder.path().join("own.toml"), text).unwrap();
        let output = build(folder.path(), "four_arms", "--config own.toml");
        let message = stderr(&output);
        assert_eq!(output.status.code(), Some(2), "{text}: {message}");
        assert!(message.contains("own.toml") && message.contains(named), "{message}");
    }
    let message = refused("four_arms", "--set family.detail=six-features");
    assert!(message.contains("--set") && message.contains("family.detail"), "{message}");
}

#[test]
fn a_scenario_file_in_a_city_s_folder_uses_its_networks() {
    let (folder, _) = built("four_arms", "");
    let text = succeed(folder.path(), "build-networks city/scenario.toml");
    assert!(text.contains("city/networks: 0 built, 1 up to date"), "{text}");
}

#[test]
fn left_hand_traffic_has_to_be_said_and_is_written_everywhere() {
    assert!(refused("left_hand_divided", "").contains("give --driving-side left or right"));
    let message = refused("four_arms", "--set network.driving_side=left");
    assert!(message.contains("with --osm --driving-side decides it"), "{message}");
    let (folder, text) = built("left_hand_divided", "--driving-side left");
    assert!(text.contains("traffic keeps to the left"), "{text}");
    let city = folder.path().join("city");
    let scenario = fs::read_to_string(city.join("scenario.toml")).unwrap();
    assert!(scenario.contains("[network]\ndriving_side = \"left\""), "{scenario}");
    let net = fs::read_to_string(city.join("networks/n101/n101.net.xml")).unwrap();
    assert!(net.contains("lefthand=\"true\""));
    let signals = succeed(folder.path(), "signals n101 city");
    assert!(signals.contains("signal c (left-hand traffic"), "{signals}");
    // The lane beside the centre turns right, across opposing traffic.
    let row =
        |lane: &str| signals.lines().find(|l| l.contains(lane) && l.contains("right")).is_some();
    assert!(row("in0_1") && !row("in0_0"), "{signals}");
}
