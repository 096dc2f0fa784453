//! Left-hand traffic is read exactly as the mirror image of right-hand traffic, on all hand-written extracts.

use std::fs;
use std::io::Write;
use std::path::PathBuf;

use osm_signals::DrivingSide;
use osm_signals::extract::Extract;
use osm_signals::mirror::mirrored_extract;
use osm_signals::read::read;
use osm_signals::settings::Settings;
use osm_signals::survey::{Inputs, Survey};
use tsc_family::traffic::city::config::CityConfig;
use tsc_family::traffic::city::sites::City;
use tsc_family::traffic::family::approaches::Approach;

fn nothing(_: u64, _: u64) {}

fn folders() -> Vec<PathBuf> {
    let entries =
        fs::read_dir("osm-signals/tests/networks").unwrap().map(|entry| entry.unwrap().path());
    let mut folders: Vec<PathBuf> = entries.filter(|path| path.is_dir()).collect();
    folders.sort();
    folders
}

fn of_text(text: &str) -> Extract {
    let mut file = tempfile::Builder::new().suffix(".osm").tempfile().unwrap();
    file.write_all(text.as_bytes()).unwrap();
    read(file.path(), &nothing).unwrap()
}

fn city(extract: &Extract, settings: &Settings, driving_side: DrivingSide) -> City {
    let survey = Survey::new(extract, settings, &Inputs { driving_side, ..Inputs::default() });
    City::new(survey, driving_side)
}

/// The table of approaches, by intersection and bearing, without the letters of the arms.
fn rows(city: &City, settings: &Settings) -> Vec<Approach> {
    let mut rows = city.approaches(&settings.intersections);
    for row in &mut rows {
        row.arm = String::new();
    }
    rows.sort_by(|a, b| {
        a.intersection.cmp(&b.intersection).then_with(|| a.bearing_deg.total_cmp(&b.bearing_deg))
    });
    rows
}

fn mirrored(rows: &[Approach]) -> Vec<Approach> {
    let letter = |c| match c {
        'l' => 'r',
        'r' => 'l',
        other => other,
    };
    let mut mirrored: Vec<Approach> = rows
        .iter()
        .map(|row| Approach {
            longitude: -row.longitude,
            bearing_deg: (10.0 * (360.0 - row.bearing_deg)).round() / 10.0 % 360.0,
            left_turn_lanes: row.right_turn_lanes,
            right_turn_lanes: row.left_turn_lanes,
            left_storage_m: row.right_storage_m,
            right_storage_m: row.left_storage_m,
            movements: row.movements.chars().rev().map(letter).collect(),
            ..row.clone()
        })
        .collect();
    mirrored.sort_by(|a, b| {
        a.intersection.cmp(&b.intersection).then_with(|| a.bearing_deg.total_cmp(&b.bearing_deg))
    });
    mirrored
}

/// Every number of a field in what `Debug` writes: fields that nobody thought of are there as well.
fn longitudes(value: &impl std::fmt::Debug) -> Vec<i32> {
    let text = format!("{value:?}");
    let numbers = text.split("longitude_e7: ").skip(1);
    numbers.map(|t| t.split([' ', ',', '}']).next().unwrap().parse().unwrap()).collect()
}

fn assert_mirrored(name: &str, extract: &Extract, mirror: &Extract, settings: &Settings) -> usize {
    let side = settings.streets.driving_side.unwrap_or_default();
    let other = if side.is_right() { DrivingSide::Left } else { DrivingSide::Right };
    let (a, b) = (city(extract, settings, side), city(mirror, settings, other));
    assert_eq!(mirrored(&rows(&a, settings)), rows(&b, settings), "{name}");
    let skipped = |city: &City, sign: i32| -> Vec<_> {
        let all = city.survey.found.skipped.iter();
        all.map(|s| (s.signals.clone(), s.reason, s.place.latitude_e7, sign * s.place.longitude_e7))
            .collect()
    };
    assert_eq!(skipped(&a, -1), skipped(&b, 1), "{name}");
    let sorted = |city: &City, sign: i32| {
        let mut all: Vec<i32> = longitudes(&city.survey.found).iter().map(|l| sign * l).collect();
        all.sort_unstable();
        all
    };
    assert_eq!(sorted(&a, -1), sorted(&b, 1), "{name}");
    a.sites().count()
}

#[test]
fn every_hand_written_extract_is_read_in_the_mirror_as_its_mirror_image() {
    let folders = folders();
    let mut intersections = 0;
    for folder in &folders {
        let config = folder.join("config.toml");
        let config = if config.exists() {
            CityConfig::read(&config).unwrap()
        } else {
            CityConfig::default()
        };
        let settings = config.settings;
        let text = fs::read_to_string(folder.join("input.osm")).unwrap();
        let (extract, mirror) = (of_text(&text), of_text(&crate::xml::mirrored(&text)));
        assert_eq!(mirrored_extract(&extract).nodes, mirror.nodes, "{}", folder.display());
        assert_eq!(mirrored_extract(&extract).ways, mirror.ways, "{}", folder.display());
        let name = folder.display().to_string();
        intersections += assert_mirrored(&name, &extract, &mirror, &settings);
    }
    assert!(folders.len() > 40 && intersections > 35, "{intersections} of {}", folders.len());
}

#[test]
fn on_the_wrong_side_many_cases_are_read_wrong() {
    // Otherwise the test above could not fail.
    let settings = Settings::default();
    let read = |extract: &Extract, side| rows(&city(extract, &settings, side), &settings);
    let wrong: Vec<PathBuf> = folders()
        .into_iter()
        .filter(|folder| {
            let text = fs::read_to_string(folder.join("input.osm")).unwrap();
            let mirror = of_text(&crate::xml::mirrored(&text));
            read(&mirror, DrivingSide::Left) != read(&mirror, DrivingSide::Right)
        })
        .collect();
    assert!(wrong.len() >= 6, "{wrong:?}");
}
