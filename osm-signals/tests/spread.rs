//! How far a count reaches along its street, on extracts made of coordinates.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::fs;
use std::path::Path;

use osm_signals::counts::{CountSettings, Counts};
use osm_signals::extract::Extract;
use osm_signals::read::read;
use osm_signals::settings::Settings;
use osm_signals::survey::{Inputs, Survey};
use osm_signals::traffic::InflowSource;

/// Metres per degree at the equator.
const PER_DEG: f64 = 111_195.083;

/// Distance between the junctions of Main Street, metres.
const BLOCK_M: f64 = 250.0;

/// Classes of the streets that cross Main Street, from west to east; all are signalised.
const CROSSING: [&str; 5] = ["residential"; 5];

/// Main Street, secondary, from west to east, and the streets that cross it; `tags` are further tags
/// of each block of Main Street.
fn town(crossing: &[&str], tags: &dyn Fn(usize) -> String) -> Extract {
    let mut text = "<osm version=\"0.6\">\n".to_owned();
    let mut node = |id: usize, east: f64, north: f64, signal: bool| {
        let (lat, lon) = (north / PER_DEG, east / PER_DEG);
        let tag = if signal { "<tag k=\"highway\" v=\"traffic_signals\"/>" } else { "" };
        text += &format!("<node id=\"{id}\" lat=\"{lat:.7}\" lon=\"{lon:.7}\">{tag}</node>\n");
    };
    node(1, -BLOCK_M, 0.0, false);
    for i in 0..crossing.len() {
        let east = BLOCK_M * i as f64;
        node(10 + i, east, 0.0, true);
        node(100 + i, east, 200.0, false);
        node(200 + i, east, -200.0, false);
    }
    node(2, BLOCK_M * crossing.len() as f64, 0.0, false);
    let main: Vec<usize> = [1].into_iter().chain(10..10 + crossing.len()).chain([2]).collect();
    for (block, ends) in main.windows(2).enumerate() {
        text += &format!(
            "<way id=\"{}\"><nd ref=\"{}\"/><nd ref=\"{}\"/><tag k=\"highway\" v=\"secondary\"/>\
             <tag k=\"lanes\" v=\"2\"/>{}</way>\n",
            1000 + block,
            ends[0],
            ends[1],
            tags(block)
        );
    }
    for (i, class) in crossing.iter().enumerate() {
        text += &format!(
            "<way id=\"{}\"><nd ref=\"{}\"/><nd ref=\"{}\"/><nd ref=\"{}\"/>\
             <tag k=\"highway\" v=\"{class}\"/><tag k=\"name\" v=\"{i}th Street\"/></way>\n",
            2000 + i,
            100 + i,
            10 + i,
            200 + i
        );
    }
    let file = tempfile::Builder::new().suffix(".osm").tempfile().unwrap();
    fs::write(file.path(), text + "</osm>\n").unwrap();
    read(file.path(), &|_, _| {}).unwrap()
}

fn main_street(_: usize) -> String {
    "<tag k=\"name\" v=\"Main Street\"/>".to_owned()
}

/// Per junction the eastern and western arm's source and AADT per lane, with a count of 10,000 on the
/// westernmost block of Main Street.
fn read_with(extract: &Extract, spread_m: f64) -> Vec<[(InflowSource, f64); 2]> {
    let line = format!("[[{:.7}, 0], [0, 0]]", -BLOCK_M / PER_DEG);
    let text = format!(
        "{{\"type\": \"FeatureCollection\", \"features\": [{{\"type\": \"Feature\", \"properties\": \
         {{\"AADT\": 10000}}, \"geometry\": {{\"type\": \"LineString\", \"coordinates\": {line}}}}}]}}"
    );
    let settings = CountSettings { spread_m, ..CountSettings::default() };
    let counts = Counts::from_bytes(text.as_bytes(), Path::new("c.geojson"), &settings).unwrap();
    let config = Settings { counts: settings, ..Settings::default() };
    let city =
        Survey::new(extract, &config, &Inputs { counts: Some(&counts), ..Inputs::default() });
    let junctions = city.found.intersections.iter().zip(&city.traffic);
    let arm = |(i, traffic): (&_, &Vec<osm_signals::traffic::ArmTraffic>), towards: f64| {
        let i: &osm_signals::intersections::Intersection = i;
        let near = |bearing: f64| (bearing - towards).abs() < 5.0;
        let index = i.arms.iter().position(|a| near(a.bearing_deg)).unwrap();
        (traffic[index].source, traffic[index].aadt_per_lane)
    };
    junctions.map(|j| [arm(j, 90.0), arm(j, 270.0)]).collect()
}

fn sources(extract: &Extract, spread_m: f64) -> String {
    let letter = |(source, _): &(InflowSource, f64)| match source {
        InflowSource::Counted => 'c',
        InflowSource::Spread => 's',
        InflowSource::Imputed => 'i',
        InflowSource::Default => 'd',
    };
    read_with(extract, spread_m).iter().flatten().map(letter).collect()
}

#[test]
fn a_count_reaches_along_its_street_up_to_the_distance() {
    let town = town(&CROSSING, &main_street);
    // Eastern and western arm of five junctions, 0 to 1000 m from the counted block.
    assert_eq!(sources(&town, 0.0), "dcdddddddd");
    assert_eq!(sources(&town, 100.0), "scdddddddd");
    assert_eq!(sources(&town, 250.0), "scssdddddd");
    assert_eq!(sources(&town, 1000.0), "scssssssss");
    let spread = read_with(&town, 1000.0);
    assert_eq!(spread[4][0], (InflowSource::Spread, 5000.0), "half of it goes each way");
}

#[test]
fn a_signalised_junction_with_a_larger_street_ends_it() {
    let crossing = ["residential", "residential", "primary", "residential", "residential"];
    assert_eq!(sources(&town(&crossing, &main_street), 1000.0), "scssdsdddd");
    let equal = ["residential", "residential", "secondary", "residential", "residential"];
    assert_eq!(sources(&town(&equal, &main_street), 1000.0), "scssssssss");
}

#[test]
fn another_name_ends_it_and_a_ref_stands_for_a_name_that_is_missing() {
    let renamed = |block: usize| match block {
        0..=2 => main_street(block),
        _ => "<tag k=\"name\" v=\"Other Street\"/>".to_owned(),
    };
    assert_eq!(sources(&town(&CROSSING, &renamed), 1000.0), "scssdsdddd");
    let numbered = |_: usize| "<tag k=\"ref\" v=\"US 1\"/>".to_owned();
    assert_eq!(sources(&town(&CROSSING, &numbered), 1000.0), "scssssssss");
    assert_eq!(sources(&town(&CROSSING, &|_| String::new()), 1000.0), "dcdddddddd");
}

#[test]
fn the_count_of_a_two_way_street_does_not_reach_its_one_way_part() {
    let one_way = |block: usize| match block {
        0..=2 => main_street(block),
        _ => main_street(block) + "<tag k=\"oneway\" v=\"-1\"/>",
    };
    let read = sources(&town(&CROSSING, &one_way), 1000.0);
    assert_eq!(&read[..4], "scss");
    assert!(!read[4..].contains('c'), "{read}");
    // The eastern arm of the third junction leads to it one way: no count of both directions.
    assert_eq!(&read[4..5], "d", "{read}");
}
