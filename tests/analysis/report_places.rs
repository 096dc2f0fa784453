//! What a report says of intersections: names, results by place, the map, and signal plans.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::made_up::{evaluations, manifest, reported, well_formed, well_linked, words};
use tsc_family::domains;
use tsc_family::report;
use tsc_family::store::Layout;
use tsc_family::store::manifest::Manifest;
use tsc_family::store::opaque::Opaque;
use tsc_family::store::record::TaskResult;
use tsc_family::store::results::Results;
use tsc_family::traffic::places::{FILE, MappedIntersection, Places, StreetsOfRank};
use tsc_family::traffic::program::{ProgramKind, ProgramPhase, SignalProgram};

fn place(
    id: &str,
    streets: &[&str],
    at: (f64, f64),
    point: &str,
    stands: Option<&str>,
) -> MappedIntersection {
    MappedIntersection {
        id: id.to_owned(),
        streets: streets.iter().map(|s| (*s).to_owned()).collect(),
        latitude: at.0,
        longitude: at.1,
        point: point.to_owned(),
        stands: stands.map(str::to_owned),
    }
}

/// Five intersections: two of `quiet`, one of `busy`, one that `quiet` stands for, one of nobody.
fn places() -> Places {
    let main = ["Main Street", "3rd Avenue"];
    let line = vec![[-111.90, 40.76], [-111.88, 40.76]];
    Places {
        intersections: vec![
            place("n1", &main, (40.76, -111.89), "quiet", Some("quiet")),
            place("n2", &[], (40.765, -111.89), "quiet", Some("quiet")),
            place("n3", &["State & 4th"], (40.76, -111.88), "busy", Some("busy")),
            place("n4", &["Elm Street"], (40.765, -111.88), "middling", Some("quiet")),
            place("n5", &[], (40.77, -111.88), "far", None),
        ],
        streets: vec![StreetsOfRank { rank: 3, lines: vec![line] }],
        drawings: vec![],
    }
}

fn program(kind: ProgramKind, own: bool, phases: &[(&str, f64, Option<f64>)]) -> SignalProgram {
    let phase = |(state, duration_s, max_s): &(&str, f64, Option<f64>)| ProgramPhase {
        min_s: max_s.map(|_| *duration_s),
        max_s: *max_s,
        ..ProgramPhase::fixed(*state, *duration_s)
    };
    SignalProgram { own, ..SignalProgram::new("c", kind, phases.iter().map(phase).collect()) }
}

/// What the signals of a method ran.
fn programs(method: &str) -> Vec<SignalProgram> {
    let changes = [("yr", 4.0, None), ("rr", 1.0, None), ("rG", 20.0, None), ("ry", 3.0, None)];
    let cycle = |green: (&'static str, f64, Option<f64>)| [&[green][..], &changes].concat();
    match method {
        "baseline" => vec![program(ProgramKind::Static, true, &cycle(("Gr", 42.0, None)))],
        "fixed-time" => vec![program(ProgramKind::Static, false, &cycle(("Gr", 30.0, None)))],
        "actuated" => {
            vec![program(ProgramKind::Actuated, false, &cycle(("Gr", 7.0, Some(50.0))))]
        }
        _ => Vec::new(),
    }
}

fn results(root: &Path, manifest: &Manifest) -> Layout {
    let delays = |method: &str, point: &str| match (method, point) {
        ("baseline", "quiet") => [20.0, 22.0],
        ("baseline", _) => [90.0, 95.0],
        ("fixed-time", "quiet") => [9.0, 9.5],
        ("fixed-time", _) => [60.0, 62.0],
        ("actuated", "quiet") => [12.0, 11.0],
        ("actuated", _) => [70.0, 71.0],
        (_, "quiet") => [10.0, 10.5],
        _ => [40.0, 41.0],
    };
    crate::made_up::write_results(root, manifest, |task| {
        let programs = match programs(&task.method) {
            none if none.is_empty() => Opaque::default(),
            some => Opaque::of(&some),
        };
        let rows = evaluations(&delays(&task.method, &task.point));
        Some(Ok(TaskResult { rows, programs, ..TaskResult::default() }))
    })
}

const METHODS: [&str; 4] = ["baseline", "fixed-time", "actuated", "max-pressure"];

/// A results directory with places and its report.
fn report_on(root: &Path, places: &Places) -> Layout {
    let mut manifest = manifest(&METHODS);
    for point in &mut manifest.identity.points {
        point.environment = "network".to_owned();
    }
    manifest.provenance.networks = "no/such/folder".to_owned();
    let layout = results(root, &manifest);
    fs::write(layout.root().join(FILE), places.to_json()).unwrap();
    report::write(&layout, &reported(&layout)).unwrap();
    layout
}

fn text(layout: &Layout, file: &str) -> String {
    fs::read_to_string(layout.report().join(file)).unwrap()
}

#[test]
fn intersections_csv_has_the_results_of_the_point_mdp_that_stands_for_each() {
    let dir = tempfile::tempdir().unwrap();
    insta::assert_snapshot!(text(&report_on(dir.path(), &places()), "intersections.csv"));
}

#[test]
fn results_geojson_has_a_point_per_intersection_with_the_columns_of_the_table() {
    let dir = tempfile::tempdir().unwrap();
    let layout = report_on(dir.path(), &places());
    let geojson: serde_json::Value =
        serde_json::from_str(&text(&layout, "results.geojson")).unwrap();
    let features = geojson["features"].as_array().unwrap();
    assert_eq!(features.len(), 5);
    assert_eq!(features[0]["geometry"]["coordinates"], serde_json::json!([-111.89, 40.76]));
    let mut table = csv::Reader::from_path(layout.report().join("intersections.csv")).unwrap();
    let columns: Vec<String> = table.headers().unwrap().iter().map(str::to_owned).collect();
    for (row, feature) in table.records().zip(features) {
        let row = row.unwrap();
        let properties = feature["properties"].as_object().unwrap();
        for (name, cell) in columns.iter().zip(&row).filter(|(n, _)| !n.ends_with("itude")) {
            match &properties[name] {
                serde_json::Value::Null => assert_eq!(cell, "", "{name}"),
                serde_json::Value::String(text) => assert_eq!(cell, text, "{name}"),
                serde_json::Value::Bool(is) => assert_eq!(cell, is.to_string(), "{name}"),
                number => assert_eq!(cell.parse::<f64>().unwrap(), number.as_f64().unwrap()),
            }
        }
        assert_eq!(properties.len() + 2, columns.len());
    }
}

#[test]
fn plans_csv_has_every_green_with_its_change_and_says_who_has_no_program() {
    let dir = tempfile::tempdir().unwrap();
    insta::assert_snapshot!(text(&report_on(dir.path(), &places()), "plans.csv"));
}

#[test]
fn a_plan_is_a_file_for_sumo_and_an_older_report_s_are_gone() {
    let dir = tempfile::tempdir().unwrap();
    let layout = report_on(dir.path(), &places());
    let plans = layout.report().join("plans");
    fs::write(plans.join("old.add.xml"), "old").unwrap();
    let paths = report::write(&layout, &reported(&layout)).unwrap();
    let mut names: Vec<String> = fs::read_dir(&plans)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    let expected =
        ["busy.actuated.add.xml", "busy.add.xml", "quiet.actuated.add.xml", "quiet.add.xml"];
    assert_eq!(names, expected);
    insta::assert_snapshot!(fs::read_to_string(plans.join("quiet.add.xml")).unwrap());
    let [missing] = paths.notes.as_slice() else { panic!("{:?}", paths.notes) };
    assert!(missing.contains("no/such/folder/quiet/quiet.sumocfg is not here"), "{missing}");
}

#[test]
fn the_map_shows_streets_all_intersections_and_who_stands_for_them() {
    let dir = tempfile::tempdir().unwrap();
    let layout = report_on(dir.path(), &places());
    let map = text(&layout, "map.svg");
    well_formed(&map);
    let mut tips: Vec<&str> =
        map.split("<title>").skip(1).filter_map(|rest| rest.split("</title>").next()).collect();
    tips.dedup();
    insta::assert_snapshot!(tips.join("\n"), @r#"
    n5 (far): no result
    Main Street / 3rd Avenue (n1): delay_s 10.2 (level B), score 0.49 (of quiet)
    n2 (quiet): delay_s 10.2 (level B), score 0.49 (of quiet)
    Elm Street (n4): delay_s 10.2 (level B), score 0.49 (of quiet, which stands for it)
    State &amp; 4th (n3): delay_s 40.5 (level D), score 0.44 (of busy)
    "#);
    for legend in [
        "its point MDP was simulated",
        "not simulated: colour of the point MDP that stands for it",
        "not simulated, and no point MDP stands for it",
        "OpenStreetMap contributors",
    ] {
        assert!(map.contains(legend), "{legend}");
    }
    assert!(map.contains("<path"), "a street");
}

#[test]
fn the_page_calls_single_intersections_by_their_streets() {
    let dir = tempfile::tempdir().unwrap();
    let layout = report_on(dir.path(), &places());
    let page = text(&layout, "index.html");
    well_linked(&page);
    let words = words(&page);
    let from = words.find("Map\n[drawing]").unwrap();
    let until = from + words[from..].find("Method notes\nScore").unwrap();
    insta::assert_snapshot!(&words[from..until]);
}

#[test]
fn without_coordinates_there_are_no_files_of_places_and_damaged_ones_are_refused() {
    let dir = tempfile::tempdir().unwrap();
    let mut manifest = manifest(&METHODS);
    for point in &mut manifest.identity.points {
        point.places.clear();
    }
    let layout = results(dir.path(), &manifest);
    let paths = report::write(&layout, &reported(&layout)).unwrap();
    let further = ["plans.csv", "cabinet.csv"].map(|name| layout.report().join(name));
    assert_eq!(paths.further, further);
    assert!(!layout.report().join("map.svg").exists());
    fs::write(layout.root().join(FILE), "{\"intersections\":[{}]}").unwrap();
    let results = Results::load(&layout).unwrap();
    let e = domains::report(&layout, &results).err().unwrap().to_string();
    assert!(e.contains("places.json") && e.contains("missing field"), "{e}");
}

#[test]
fn old_records_have_their_plans_in_words() {
    let dir = tempfile::tempdir().unwrap();
    let manifest = manifest(&["baseline", "fixed-time", "max-pressure"]);
    let layout = crate::made_up::write_results(dir.path(), &manifest, |task| {
        let text = "cycle 36 s: Gr 20 s, rG 10 s".to_owned();
        let details = match task.method.as_str() {
            "fixed-time" => BTreeMap::from([("plan c".to_owned(), text)]),
            _ => BTreeMap::new(),
        };
        let rows = evaluations(&[10.0, 11.0]);
        Some(Ok(TaskResult { rows, details, ..TaskResult::default() }))
    });
    report::write(&layout, &reported(&layout)).unwrap();
    insta::assert_snapshot!(text(&layout, "plans.csv"));
    assert!(layout.report().join("plans/busy.add.xml").exists());
}
