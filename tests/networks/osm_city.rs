//! What a city makes of a survey of its map, on hand-written extracts.

use std::fs;
use std::path::Path;
use std::sync::Mutex;

use osm_signals::signals::{SignalColumns, SignalList};
use osm_signals::{DrivingSide, Extract, Inputs, Settings, Survey, read};
use tsc_family::traffic::city::derive::{Event, Request, derive};
use tsc_family::traffic::city::sites::{City, Reason};
use tsc_family::traffic::family::approaches::to_csv;
use tsc_family::traffic::family::load::{from_text, load};

fn case(name: &str) -> Extract {
    let folder = Path::new("osm-signals/tests/networks").join(name);
    read(&folder.join("input.osm"), &|_, _| {}).unwrap()
}

fn city(extract: &Extract, signals: Option<&SignalList>) -> City {
    let inputs = Inputs { signals, ..Inputs::default() };
    City::new(Survey::new(extract, &Settings::default(), &inputs), DrivingSide::Right)
}

fn ids(city: &City) -> Vec<&str> {
    city.sites().map(|site| site.found.id.as_str()).collect()
}

fn list(rows: &str) -> SignalList {
    let text = format!("id,lat,lon\n{rows}");
    SignalList::from_bytes(text.as_bytes(), Path::new("l.csv"), &SignalColumns::default()).unwrap()
}

#[test]
fn an_id_of_free_text_names_the_intersection_and_its_network_gets_a_safe_one() {
    let signals = list("\"../Main St,  5th\",40.0,-75.0\n");
    let city = city(&case("four_arms"), Some(&signals));
    assert_eq!(ids(&city), ["../Main St, 5th"]);
    let (row, left_out) = city.listed().next().unwrap();
    assert_eq!(row.intersection.as_deref(), Some("../Main St, 5th"));
    assert_eq!((row.note, left_out), (None, None));
    let settings = Settings::default().intersections;
    let csv = to_csv(&city.approaches(&settings));
    for detail in ["six-features", "per-approach"] {
        let csv = |_: &str| Ok(csv.clone());
        let text =
            format!("name = \"x\"\n[family]\napproaches = \"a.csv\"\ndetail = \"{detail}\"\n");
        let loaded = from_text(&text, "x.toml", &[], &csv).unwrap();
        assert_eq!(loaded.intersections[0].id, "../Main St, 5th");
        let point = &loaded.family.points[0];
        assert!(!point.id.contains('/') && !point.id.contains(' '), "{}", point.id);
        if detail == "per-approach" {
            assert!(point.id.starts_with("Main-St-5th-"), "{}", point.id);
            assert_eq!(point.title, "../Main St, 5th");
        }
    }
}

#[test]
fn what_is_left_out_keeps_intersections_and_traffic_together() {
    let signals = list("a,40.0,-75.0\nb,40.0,-74.9993\n");
    let mut city = city(&case("two_signals_60_m"), Some(&signals));
    assert_eq!(ids(&city), ["a", "b"]);
    let second = city.survey.traffic[1].clone();
    city.leave_out(&[("a".to_owned(), "no room".to_owned())].into(), Reason::NoNetwork);
    assert_eq!(ids(&city), ["b"]);
    assert_eq!(city.sites().next().unwrap().traffic, second);
    assert_eq!(city.skips(), [(Reason::NoNetwork, 1)]);
    let left_out: Vec<_> = city.listed().map(|(_, reason)| reason).collect();
    assert_eq!(left_out, [Some(Reason::NoNetwork), None]);
}

#[test]
fn an_intersection_with_a_single_green_is_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let extract = "osm-signals/tests/networks/one_green/input.osm";
    let (extract, out) = (extract.into(), folder.path().join("town"));
    let error = derive(&Request { extract, out, ..Request::default() }, &|_| {}).unwrap_err();
    assert!(
        error.to_string().contains(
            "no signalised intersection; signals: 1 a single green; see which nodes have \
             highway=traffic_signals"
        ),
        "{error}"
    );
}

#[test]
fn a_city_is_derived_without_the_command_and_written_when_asked() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("town");
    let extract = Path::new("osm-signals/tests/networks/four_arms/input.osm");
    let request = Request { extract: extract.into(), out: out.clone(), ..Request::default() };
    let warnings = Mutex::new(Vec::new());
    let derived = derive(&request, &|event| {
        if let Event::Warning(text) = event {
            warnings.lock().unwrap().push(text.to_owned());
        }
    })
    .unwrap();
    // Inflows without any count are below the minimum, which is told.
    assert!(warnings.into_inner().unwrap()[0].contains("are raised to it"));
    assert_eq!((ids(&derived.city), derived.built), (vec!["n101"], 1));
    assert_eq!((derived.quality.intersections, derived.loaded.family.points.len()), (1, 1));
    let files = || -> Vec<String> {
        let entries = fs::read_dir(&out).unwrap().map(|e| e.unwrap().file_name());
        let mut names: Vec<String> = entries.map(|n| n.into_string().unwrap()).collect();
        names.sort();
        names
    };
    assert_eq!(files(), ["networks"]);
    derived.write(&out).unwrap();
    let expected = [
        "approaches.csv", "family.csv", "intersections.geojson", "networks", "scenario.toml",
        "streets.geojson",
    ];
    assert_eq!(files(), expected);
    let loaded = load(&out.display().to_string()).unwrap();
    assert_eq!(loaded.family.points, derived.loaded.family.points);
}
