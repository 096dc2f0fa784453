//! What signal lists, counts and boundaries change in a survey, on a hand-written extract.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::path::Path;

use osm_signals::boundary::Boundary;
use osm_signals::counts::{CountSettings, Counts};
use osm_signals::extract::Extract;
use osm_signals::flags::Flag;
use osm_signals::intersections::Skip;
use osm_signals::listing::RowNote;
use osm_signals::read::read;
use osm_signals::settings::Settings;
use osm_signals::signals::{SignalColumns, SignalList};
use osm_signals::survey::{Inputs, Survey};
use osm_signals::traffic::InflowSource;

/// The four arms of Main Street (east and west) and First Street, after replacing some text.
fn four_arms(replace: &[(&str, &str)]) -> Extract {
    let mut text = fs::read_to_string("tests/networks/four_arms/input.osm").unwrap();
    for (from, to) in replace {
        assert!(text.contains(from), "{from}");
        text = text.replace(from, to);
    }
    let file = tempfile::Builder::new().suffix(".osm").tempfile().unwrap();
    fs::write(file.path(), text).unwrap();
    read(file.path(), &|_, _| {}).unwrap()
}

fn list(rows: &str) -> SignalList {
    let text = format!("id,lat,lon\n{rows}");
    SignalList::from_bytes(text.as_bytes(), Path::new("l.csv"), &SignalColumns::default()).unwrap()
}

/// Counts on lines given by their ends, longitude first.
fn counts(lines: &[(f64, [[f64; 2]; 2])]) -> Counts {
    let features: Vec<String> = lines
        .iter()
        .map(|(aadt, line)| {
            format!(
                "{{\"type\": \"Feature\", \"properties\": {{\"AADT\": {aadt}}}, \"geometry\": \
                 {{\"type\": \"LineString\", \"coordinates\": {line:?}}}}}"
            )
        })
        .collect();
    let text =
        format!("{{\"type\": \"FeatureCollection\", \"features\": [{}]}}", features.join(","));
    Counts::from_bytes(text.as_bytes(), Path::new("c.geojson"), &CountSettings::default()).unwrap()
}

fn ids(survey: &Survey) -> Vec<&str> {
    survey.found.intersections.iter().map(|i| i.id.as_str()).collect()
}

const EAST: [[f64; 2]; 2] = [[-75.0, 40.0], [-74.998, 40.0]];
const WEST: [[f64; 2]; 2] = [[-75.0, 40.0], [-75.003, 40.0]];
const NORTH: [[f64; 2]; 2] = [[-75.0, 40.0], [-75.0, 40.002]];

/// Metres per degree at the equator.
const PER_DEG: f64 = 111_195.083;

/// A signal of the map.
const MAPPED: &str = "<tag k=\"highway\" v=\"traffic_signals\"/>";

#[test]
fn half_of_a_total_goes_each_way_unless_told_otherwise() {
    let extract = four_arms(&[]);
    let counts = counts(&[(20_000.0, EAST)]);
    let inputs = Inputs { counts: Some(&counts), ..Inputs::default() };
    let mut settings = Settings::default();
    let per_lane = |settings: &Settings| {
        let survey = Survey::new(&extract, settings, &inputs);
        assert_eq!(survey.traffic[0][1].source, InflowSource::Counted);
        survey.traffic[0][1].aadt_per_lane
    };
    assert_eq!(per_lane(&settings), 5_000.0);
    settings.traffic.both_directions = false;
    assert_eq!(per_lane(&settings), 10_000.0);
}

#[test]
fn an_arm_without_a_count_gets_the_mean_of_its_class_or_its_default() {
    let class = [("v=\"residential\"", "v=\"secondary\"")];
    let three = [(8_000.0, EAST), (16_000.0, WEST), (3_000.0, NORTH)];
    let south = |extract: &Extract, counts: &Counts| {
        let inputs = Inputs { counts: Some(counts), ..Inputs::default() };
        let mut settings = Settings::default();
        settings.counts.spread_m = 0.0;
        let traffic = Survey::new(extract, &settings, &inputs).traffic[0][2].clone();
        (traffic.aadt_per_lane, traffic.source)
    };
    // Half of each on 2, 2 and 2 lanes: all streets have the 4 lanes of the only tagged one.
    let mean = (2_000.0 + 4_000.0 + 750.0) / 3.0;
    assert_eq!(south(&four_arms(&class), &counts(&three)), (mean, InflowSource::Imputed));
    assert_eq!(south(&four_arms(&class), &counts(&three[..2])), (4250.0, InflowSource::Default));
    assert_eq!(south(&four_arms(&[]), &counts(&three)), (195.0, InflowSource::Default));
}

#[test]
fn a_list_names_junctions_that_the_map_has_no_signal_at() {
    let extract = four_arms(&[(MAPPED, "")]);
    let settings = Settings::default();
    assert!(Survey::new(&extract, &settings, &Inputs::default()).found.intersections.is_empty());
    let signals = list("A7,40.0001,-75.0\n");
    let survey =
        Survey::new(&extract, &settings, &Inputs { signals: Some(&signals), ..Inputs::default() });
    assert_eq!(ids(&survey), ["A7"]);
    assert_eq!(survey.found.intersections[0].arms.len(), 4);
    let matched = &survey.listed[0];
    assert!(!matched.on_map);
    assert!((matched.distance_m.unwrap() - 11.1).abs() < 0.1, "{matched:?}");
}

/// An east-west street that two streets cross 38 m apart; the western junction, node 10, has a
/// signal of the map.
fn two_crossings(signals: &[(i64, f64)]) -> Extract {
    let mut nodes: Vec<(i64, f64, f64)> =
        vec![(10, 0.0, 0.0), (20, 38.0, 0.0), (1, -200.0, 0.0), (2, 238.0, 0.0)];
    nodes.extend([(11, 0.0, 200.0), (12, 0.0, -200.0), (21, 38.0, 200.0), (22, 38.0, -200.0)]);
    nodes.extend(signals.iter().filter(|(id, _)| *id > 22).map(|(id, east)| (*id, *east, 0.0)));
    let mut main: Vec<_> = nodes.iter().filter(|(.., north)| *north == 0.0).copied().collect();
    main.sort_by(|a, b| a.1.total_cmp(&b.1));
    let main: Vec<i64> = main.iter().map(|(id, ..)| *id).collect();
    let mut text = "<osm version=\"0.6\">\n".to_owned();
    for (id, east, north) in nodes {
        let tag = if signals.iter().any(|(s, _)| *s == id) { MAPPED } else { "" };
        let (lat, lon) = (north / PER_DEG, east / PER_DEG);
        text += &format!("<node id=\"{id}\" lat=\"{lat:.7}\" lon=\"{lon:.7}\">{tag}</node>\n");
    }
    for (id, refs) in [(1, &main[..]), (2, &[11, 10, 12]), (3, &[21, 20, 22])] {
        let refs: String = refs.iter().map(|r| format!("<nd ref=\"{r}\"/>")).collect();
        let name = format!("<tag k=\"name\" v=\"{id}\"/>");
        text +=
            &format!("<way id=\"{id}\">{refs}<tag k=\"highway\" v=\"secondary\"/>{name}</way>\n");
    }
    text += "</osm>\n";
    let file = tempfile::Builder::new().suffix(".osm").tempfile().unwrap();
    fs::write(file.path(), text).unwrap();
    read(file.path(), &|_, _| {}).unwrap()
}

/// A row so many metres east of the western crossing.
fn row(id: &str, east: f64) -> String {
    format!("{id},0,{:.7}\n", east / PER_DEG)
}

#[test]
fn a_listed_junction_beside_a_signal_of_the_map_is_an_intersection_of_its_own() {
    let extract = two_crossings(&[(10, 0.0)]);
    for rows in [[("a", 0.0), ("b", 38.0)], [("b", 36.0), ("a", 2.0)]] {
        let signals = list(&rows.map(|(id, east)| row(id, east)).concat());
        let inputs = Inputs { signals: Some(&signals), ..Inputs::default() };
        let survey = Survey::new(&extract, &Settings::default(), &inputs);
        let nodes: Vec<_> =
            survey.found.intersections.iter().map(|i| (&*i.id, &i.nodes[..])).collect();
        assert_eq!(nodes, [("a", &[10][..]), ("b", &[20])]);
        assert_eq!(survey.listed.iter().filter(|l| l.on_map).count(), 1);
    }
}

#[test]
fn signals_of_one_controller_are_one_intersection() {
    let extract = two_crossings(&[(10, 0.0), (20, 38.0)]);
    let text = format!(
        "id,lat,lon,controller_id\n{}",
        [("a", 0.0, "7"), ("b", 38.0, "7")]
            .map(|(id, east, c)| { format!("{},{c}\n", row(id, east).trim_end()) })
            .concat()
    );
    let read = |text: &str| {
        SignalList::from_bytes(text.as_bytes(), Path::new("l.csv"), &SignalColumns::default())
            .unwrap()
    };
    let signals = read(&text);
    let inputs = Inputs { signals: Some(&signals), ..Inputs::default() };
    let survey = Survey::new(&extract, &Settings::default(), &inputs);
    assert_eq!(ids(&survey), ["a"]);
    let one = &survey.found.intersections[0];
    assert_eq!(one.nodes, [10, 20]);
    assert!(one.flags.contains(&Flag::OneController), "{:?}", one.flags);
    let (second, owner) = (&survey.listed[1], Some("a"));
    assert_eq!(
        (second.note, second.intersection.as_deref()),
        (Some(RowNote::SameController(2)), owner)
    );
    // Two controllers are two intersections, which are flagged as near each other.
    let signals = read(&text.replace(",7\nb", ",8\nb"));
    let inputs = Inputs { signals: Some(&signals), ..Inputs::default() };
    let survey = Survey::new(&extract, &Settings::default(), &inputs);
    assert_eq!(ids(&survey), ["a", "b"]);
    assert!(survey.found.intersections.iter().all(|i| i.flags.contains(&Flag::NearSignal)));
}

#[test]
fn counts_in_thousands_and_of_an_hour_are_told() {
    let extract = four_arms(&[("v=\"residential\"", "v=\"secondary\"")]);
    let doubt = |factor: f64| {
        let lines =
            [(factor * 8_000.0, EAST), (factor * 16_000.0, WEST), (factor * 9_000.0, NORTH)];
        let counts = counts(&lines);
        let inputs = Inputs { counts: Some(&counts), ..Inputs::default() };
        Survey::new(&extract, &Settings::default(), &inputs).count_doubt()
    };
    assert_eq!(doubt(1.0), None);
    assert!(doubt(0.001).unwrap().contains("multiply them by 1000"));
    assert!(doubt(0.09).unwrap().contains("of an hour"));
}

#[test]
fn a_row_that_is_off_goes_to_the_junction_with_a_signal() {
    // The signal is at the western crossing, 38 m from the eastern one.
    let extract = two_crossings(&[(10, 0.0)]);
    let node = |east: f64| {
        let signals = list(&row("a", east));
        let inputs = Inputs { signals: Some(&signals), ..Inputs::default() };
        let survey = Survey::new(&extract, &Settings::default(), &inputs);
        (survey.found.intersections[0].nodes.clone(), survey.listed[0].on_map)
    };
    assert_eq!([node(5.0), node(25.0)], [(vec![10], true), (vec![10], true)]);
    // A second row between them is a duplicate, though the other junction is nearer.
    let signals = list(&[row("a", 1.0), row("b", 22.0)].concat());
    let inputs = Inputs { signals: Some(&signals), ..Inputs::default() };
    let survey = Survey::new(&extract, &Settings::default(), &inputs);
    assert_eq!((ids(&survey), survey.listed[1].note), (vec!["a"], Some(RowNote::Duplicate(2))));
    // Right on the other junction, and the signal is clearly farther away.
    assert_eq!(node(37.0), (vec![20], false));
}

#[test]
fn of_two_rows_at_one_intersection_the_nearer_one_is_matched() {
    let extract = four_arms(&[]);
    let signals = list("far,40.0002,-75.0\nnear,40.0001,-75.0\nelsewhere,40.1,-75.0\nno,0,0\n");
    let inputs = Inputs { signals: Some(&signals), ..Inputs::default() };
    let survey = Survey::new(&extract, &Settings::default(), &inputs);
    assert_eq!(ids(&survey), ["near"]);
    let notes: Vec<_> = survey.listed.iter().map(|l| l.note).collect();
    let expected = [RowNote::Duplicate(3), RowNote::NothingNear, RowNote::NoPlace];
    assert_eq!(notes, [Some(expected[0]), None, Some(expected[1]), Some(expected[2])]);
    let metres: Vec<_> = survey.listed.iter().map(|l| l.distance_m.map(f64::round)).collect();
    assert_eq!(metres, [Some(22.0), Some(11.0), None, None]);
}

#[test]
fn a_boundary_decides_by_the_middle_of_an_intersection() {
    let extract = four_arms(&[]);
    let settings = Settings::default();
    let survey = |bbox| {
        let boundary = Boundary::parse(bbox).unwrap();
        Survey::new(&extract, &settings, &Inputs { boundary: Some(&boundary), ..Inputs::default() })
    };
    assert_eq!(ids(&survey("-75.0001,39.9999,-74.9999,40.0001")), ["n101"]);
    assert_eq!(survey("-74.9999,39.9999,-74.9,40.0001").skips(), [(Skip::OutsideBoundary, 1)]);
}
