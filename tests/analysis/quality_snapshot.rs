//! What the page on the quality of a derived family says, word by word.

use std::collections::BTreeMap;
use std::fs;

use crate::made_up::{well_formed, well_linked, words};
use osm_signals::DrivingSide;
use osm_signals::intersections::Skip;
use osm_signals::oddities::Oddities;
use osm_signals::traffic::InflowSource;
use tsc_family::traffic::city::InputFile;
use tsc_family::traffic::city::quality::{MATCHED, Provenance, Quality, SkipCount, Spot};
use tsc_family::traffic::city::sites::Reason;
use tsc_family::traffic::report::quality::write_quality;

fn rests_on(feature: &'static str, tagged: f64, imputed: f64) -> Provenance {
    Provenance { feature, tagged, spread: 0.0, imputed, default: 1.0 - tagged - imputed }
}

fn spot(id: &str, streets: &str, known: f64) -> Spot {
    Spot {
        id: id.to_owned(),
        streets: streets.to_owned(),
        latitude: 40.0 + known / 100.0,
        longitude: -75.0,
        arms: 4,
        inflow_sources: vec![InflowSource::Default; 3],
        signals: 2,
        known,
        flags: match known > 0.0 {
            true => vec![],
            false => vec!["two arms less than 25 degrees apart", "cut by the extract"],
        },
    }
}

fn skip(reason: Skip, signals: usize, examples: &[i64]) -> SkipCount {
    let (reason, text) = (Reason::Map(reason), reason.reason());
    SkipCount { reason, text, signals, examples: examples.to_vec() }
}

fn plain() -> Quality {
    let mut ignored = Oddities::default();
    ignored.add("unusable number of lanes", || "way 17, lanes=<many>".to_owned());
    let file =
        |role, name: &str| InputFile { role, name: name.to_owned(), sha256: "ab".repeat(32) };
    Quality {
        timed_restrictions: (0, 0),
        name: "made-up".to_owned(),
        version: "0.1.0",
        inputs: vec![file("extract", "a <b> & \"c\".osm.pbf")],
        written: BTreeMap::new(),
        driving_side: DrivingSide::Left,
        ways: 30,
        signals: 10,
        signals_used: 4,
        intersections: 2,
        approaches: 8,
        point_mdps: 2,
        hourly_share: 0.09,
        directional_split: 0.55,
        peak_heading_deg: 45.0,
        skipped: vec![skip(Skip::Border, 4, &[11, 12]), skip(Skip::NotOnStreet, 1, &[13])],
        provenance: vec![
            rests_on("lanes", 0.75, 0.25),
            rests_on("turn_lanes", 0.5, 0.0),
            rests_on("speed", 0.25, 0.5),
            rests_on("length", 0.875, 0.0),
            rests_on("inflow", 0.0, 0.0),
        ],
        cut_approaches: 1,
        no_way_across: 1,
        left_out: BTreeMap::new(),
        listed: BTreeMap::new(),
        ignored,
        spots: vec![spot("n1", "<script>A</script> & B / C", 0.5), spot("n2", "", 0.0)],
    }
}

fn listed() -> Quality {
    let mut q = plain();
    q.provenance[4] = Provenance { spread: 0.125, ..rests_on("inflow", 0.25, 0.125) };
    q.provenance[4].default -= 0.125;
    q.listed = BTreeMap::from([(MATCHED[0], 1), (MATCHED[1], 1), ("roundabout", 52)]);
    q
}

/// Returns a page, which is well-formed and loads nothing.
fn page(quality: &Quality) -> String {
    let dir = tempfile::tempdir().unwrap();
    let page = fs::read_to_string(write_quality(dir.path(), quality).unwrap()).unwrap();
    // The two elements that HTML leaves open.
    let closed = page.replace("utf-8\">", "utf-8\"/>").replace("scale=1\">", "scale=1\"/>");
    well_formed(&closed.replace("<!DOCTYPE html>", ""));
    well_linked(&page.replace("<script>", ""));
    page
}

#[test]
fn the_words_of_the_page_are_these() {
    insta::assert_snapshot!(words(&page(&plain())));
}

#[test]
fn a_list_has_a_section_of_its_own() {
    let words = words(&page(&listed()));
    let (summary, rest) = words.split_once("\nSignals\n").unwrap();
    let (_, rest) = rest.split_once("\nSignal list\nWhat").unwrap();
    let (list, _) = rest.split_once("\nIntersections\n").unwrap();
    insta::assert_snapshot!(format!("{summary}\nWhat{list}"));
}

#[test]
fn the_data_are_beside_the_page() {
    let dir = tempfile::tempdir().unwrap();
    write_quality(dir.path(), &plain()).unwrap();
    let json = fs::read_to_string(dir.path().join("quality.json")).unwrap();
    let value: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(value["skipped"][0]["reason"], "border");
    assert_eq!(value["spots"].as_array().unwrap().len(), 2);
}
