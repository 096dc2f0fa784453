//! `tsc-family build-networks --osm` end to end, on hand-written extracts.

use std::fs;

use crate::common::stderr;
use crate::folder::{Folder, repository};

fn with(cases: &[&str]) -> Folder {
    let folder = Folder::new();
    for case in cases {
        let text = repository(&format!("osm-signals/tests/networks/{case}/input.osm"));
        folder.write(&format!("{case}.osm"), &text);
    }
    folder
}

fn command(case: &str, more: &str) -> String {
    format!("build-networks --out city --osm {case}.osm {more}")
}

#[test]
fn a_map_becomes_a_family_that_list_and_run_understand() {
    let folder = with(&["four_arms"]);
    let text = folder.run(&command("four_arms", ""));
    assert!(text.contains("1 signals: 1 in 1 intersections, which are 1 point MDPs"), "{text}");
    for file in [
        "approaches.csv", "family.csv", "scenario.toml", "intersections.geojson", "quality.html",
        "quality.json",
    ] {
        assert!(folder.has(&format!("city/{file}")), "{file} is missing");
    }
    let again = folder.run(&command("four_arms", ""));
    assert!(again.contains("0 built, 1 up to date"), "{again}");
    assert_eq!(folder.run("list city --json").lines().count(), 1);
    assert!(folder.run("run city --budget 1 --dry-run").contains("1 point MDP"));
    let text = folder.run("build-networks city/scenario.toml");
    assert!(text.contains("city/networks: 0 built, 1 up to date"), "{text}");
    folder.write("city/own.toml", "name = \"own\"\nfamily.points = \"family.csv\"\n");
    assert_eq!(folder.run("list city/own.toml --json").lines().count(), 1);
    // Real approaches stay what they are unless somebody asks for six features.
    folder.write("city/real.toml", "family.approaches = \"approaches.csv\"\n");
    assert!(folder.run("list city/real.toml").contains("n101"));
    let six = folder.run("list city/real.toml --set family.detail=six-features");
    assert!(six.contains("-Q") && !six.contains("n101"), "{six}");
    folder.edit("city/approaches.csv", ",25.0,", ",30.0,");
    let edited = folder.read("city/approaches.csv");
    assert!(folder.says(2, &command("four_arms", "")).contains("not as this command wrote it"));
    assert_eq!(folder.read("city/approaches.csv"), edited);
    folder.run(&command("four_arms", "--force"));
    assert_ne!(folder.read("city/approaches.csv"), edited);
}

#[test]
fn the_same_input_gives_the_same_files_whatever_the_number_of_workers() {
    let files = |jobs: &str| {
        let folder = with(&["divided_by_divided"]);
        folder.run(&command("divided_by_divided", &format!("--detail per-approach {jobs}")));
        let names = ["approaches.csv", "scenario.toml", "intersections.geojson", "quality.json"];
        names.map(|name| folder.read(&format!("city/{name}")))
    };
    assert_eq!(files("--jobs 1"), files("--jobs 3"));
}

#[test]
fn settings_reach_the_scenario_that_is_written_and_wrong_ones_are_refused() {
    let folder = with(&["four_arms"]);
    let config = "[traffic.default_aadt_per_lane]\nsecondary = 12000\n[scenario.family]\nhourly_share = 0.1\n";
    folder.write("own.toml", config);
    let own = "--config own.toml --detail per-approach --set demand.horizon_s=900";
    folder.run(&command("four_arms", own));
    folder.shows(
        "city/scenario.toml",
        &["hourly_share = 0.1", "default = 1.0", "detail = \"per-approach\"", "horizon_s = 900"],
    );
    folder.shows("city/approaches.csv", &[",12000.0,"]);
    for (text, named) in [
        ("[streets]\nspeed = 3\n", "speed"),
        ("[streets]\ndefault_speed_mph = -1\n", "streets.default_speed_mph"),
        ("[traffic.default_aadt_per_lane]\nboulevard = 2\n", "boulevard"),
        ("[counts]\nmatch_m = -5\n", "counts.match_m"),
        ("[scenario.family]\nhourly_share = 7\n", "hourly_share"),
        ("[scenario.family]\ndetail = \"six-features\"\n", "family.detail"),
        ("[scenario]\nname = \"other\"\n", "name"),
    ] {
        folder.write("own.toml", text);
        folder.refuses(&[(&command("four_arms", "--config own.toml"), named)]);
    }
}

#[test]
fn a_signal_list_decides_which_intersections_count_and_names_them() {
    let folder = with(&["four_arms"]);
    let list =
        "id,Type,shape\n1001,SIGNAL,POINT (-75.0 40.00005)\n1002,BEACON,POINT (-75.0 40.1)\n";
    folder.write("list.csv", list);
    let output = folder.output(&command("four_arms", "--signals list.csv"));
    assert!(output.status.success(), "{}", stderr(&output));
    assert!(stderr(&output).contains("list.csv: 1 rows may be no signals"), "{}", stderr(&output));
    let quality = folder.json("city/quality.json");
    assert_eq!(quality["spots"][0]["id"], "1001");
    assert_eq!(quality["listed"]["no junction of streets within reach"], 1);
    let text = folder.run(&command("four_arms", "--signals list.csv --signals-where type=signal"));
    assert!(text.contains("1 matched, and a signal on the map"), "{text}");
    // A listed junction without a signal on the map is counted in the terminal.
    folder.edit("four_arms.osm", "traffic_signals", "crossing");
    let text = folder.run(&command("four_arms", "--signals list.csv --signals-where type=signal"));
    assert!(text.contains("1 matched, at a junction without a signal on the map"), "{text}");
}

#[test]
fn counts_replace_the_default_of_the_class() {
    let line = r#"{"type": "FeatureCollection", "features": [{"type": "Feature",
        "properties": {"AADT2023": 24000}, "geometry": {"type": "LineString",
        "coordinates": [[-75.003, 40.0], [-74.998, 40.0]]}}]}"#;
    let folder = with(&["four_arms"]);
    folder.write("aadt.geojson", line);
    folder.run(&command("four_arms", "--aadt aadt.geojson --detail per-approach"));
    let rows = folder.rows("city/approaches.csv");
    // 24000 vehicles a day, half of them towards the signal, on two lanes.
    for arm in [1, 3] {
        assert_eq!(rows[arm]["aadt_veh_per_day_per_lane"], "6000.0");
    }
    // What is doubtful in a table is told by every command and listed in full.
    folder.edit("city/approaches.csv", ",6000.0,", ",24000,");
    let said = folder.says(0, "run city --dry-run");
    assert!(said.contains("approaches.csv: inflows above"), "{said}");
    assert!(folder.run("list city --warnings").contains("\n  line "));
}

#[test]
fn what_cannot_become_a_family_is_refused_with_the_reason() {
    let cases = [
        "four_arms", "crossing_signals_alone", "all_at_border", "roundabout_with_signals",
        "left_hand_divided",
    ];
    let folder = with(&cases);
    let whole = folder.read("four_arms.osm");
    folder.write("aadt.csv", "latitude,longitude,aadt\n41.0,-75.0,9000\n");
    folder.write("far.csv", "lat,lon\n41.0,-75.0\n");
    folder.write("no.json", "{\"type\": \"FeatureCollection\"}");
    folder.write("half.osm", &whole[..whole.len() / 2]);
    folder.write("empty.osm", "");
    let four = |more: &str| command("four_arms", more);
    folder.refuses(&[
        (&four("--aadt aadt.csv"), "aadt.csv: none of its 1 counts"),
        (&four("--signals far.csv"), "latitudes 41.000 to 41.000"),
        (&four("--signals no.json"), "a FeatureCollection of points is needed"),
        (&four("--boundary=-76,40,-75.5,41"), "1 outside the boundary"),
        (&four("--set family.detail=six-features"), "family.detail"),
        (&command("crossing_signals_alone", ""), "no signal (highway=traffic_signals)"),
        (&command("all_at_border", ""), "2 at the border of the extract"),
        (&command("roundabout_with_signals", ""), "4 roundabout"),
        ("build-networks --osm half.osm --out city", "half.osm"),
        ("build-networks --osm empty.osm --out city", "empty.osm"),
        ("build-networks --osm missing.osm.pbf", "missing.osm.pbf"),
        ("build-networks --out nets --signals far.csv", "--osm"),
        ("build-networks smoke --out nets --driving-side left", "cannot be used with"),
        ("build-networks smoke --osm four_arms.osm", "cannot be used with"),
    ]);
    folder.run(&four("--boundary=-76,39,-74,41"));
}

#[test]
fn left_hand_traffic_is_known_by_its_place_and_said_everywhere() {
    let folder = with(&["left_hand_divided"]);
    let text = folder.run(&command("left_hand_divided", "--detail per-approach"));
    assert!(text.contains("traffic keeps to the left"), "{text}");
    folder.shows("city/scenario.toml", &["[network]\ndriving_side = \"left\""]);
    folder.shows("city/networks/n101/n101.net.xml", &["lefthand=\"true\""]);
    let signals = folder.run("signals n101 city");
    // The lane beside the centre turns right, across opposing traffic.
    let row = |lane: &str| signals.lines().any(|l| l.contains(lane) && l.contains("right"));
    assert!(row("in0_1") && !row("in0_0"), "{signals}");
    // The other side is taken when it is set.
    fs::remove_dir_all(folder.join("city")).unwrap();
    folder.run(&command("left_hand_divided", "--driving-side right"));
    assert!(!folder.read("city/scenario.toml").contains("driving_side ="));
}
