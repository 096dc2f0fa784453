//! Hand-written extracts: what `tests/networks/<case>/expected.txt` says of `input.osm` must be
//! found. A folder is a test; its format is described in `tests/networks/README.md`.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use osm_signals::arms::Arm;
use osm_signals::intersections::Found;
use osm_signals::read::read;
use osm_signals::settings::Settings;
use osm_signals::streets::Source;
use osm_signals::survey::{Inputs, Survey};

/// How far bearings may be off, degrees.
const BEARING_DEG: f64 = 3.0;

/// How far lengths may be off: a share, and at least some metres.
const LENGTH: (f64, f64) = (0.05, 3.0);

fn cases() -> Vec<PathBuf> {
    let mut folders: Vec<_> = fs::read_dir("tests/networks")
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.is_dir())
        .collect();
    folders.sort();
    folders
}

fn found(case: &Path) -> Found {
    let mut extract = read(&case.join("input.osm"), &|_, _| {}).unwrap();
    let config = case.join("config.toml");
    let config = if config.exists() { settings(&config) } else { Settings::default() };
    let driving_side = config.streets.driving_side.unwrap_or_default();
    extract.ways.retain(|way| config.streets.is_street(way.street.highway));
    Survey::new(&extract, &config, &Inputs { driving_side, ..Inputs::default() }).found
}

fn settings(path: &Path) -> Settings {
    let settings: Settings = toml::from_str(&fs::read_to_string(path).unwrap()).unwrap();
    settings.check().unwrap();
    settings.completed()
}

fn describe(found: &Found) -> String {
    let mut blocks: Vec<(i64, String)> = Vec::new();
    for i in &found.intersections {
        let signals: Vec<String> = i.signals.iter().map(i64::to_string).collect();
        let flags = i.flags.iter().map(|f| format!("; {}", f.words()));
        let flags: String = flags.collect();
        let mut text = format!("intersection {}: signals {}{flags}\n", i.id, signals.join(" "));
        for (arm, turns) in i.arms.iter().zip(&i.turns) {
            let turns = turns.map_or_else(
                || "-".to_owned(),
                |t| {
                    let letters = [(t.left, 'l'), (t.through, 's'), (t.right, 'r')];
                    letters.iter().filter(|(exists, _)| *exists).map(|(_, c)| *c).collect()
                },
            );
            writeln!(text, "  {}", line(arm, &turns)).unwrap();
        }
        blocks.push((i.signals.first().or(i.nodes.first()).copied().unwrap(), text));
    }
    for skipped in &found.skipped {
        let signal = skipped.signals[0];
        blocks.push((signal, format!("skipped n{signal}: {}\n", skipped.reason.reason())));
    }
    blocks.sort();
    blocks.into_iter().map(|(_, text)| text).collect()
}

fn line(arm: &Arm, turns: &str) -> String {
    let lanes = match arm.lanes_source {
        Source::Tagged => "tagged",
        Source::Imputed | Source::Default => "imputed",
    };
    let speed = match arm.speed_source {
        Source::Tagged => "tagged",
        Source::Imputed => "imputed",
        Source::Default => "default",
    };
    format!(
        "arm {:.0} deg: in {} (left {}, right {}), out {}, {:.0} mph {speed}, {:.0} m, lanes \
         {lanes}, turns {turns}",
        arm.bearing_deg,
        arm.lanes_in,
        arm.left_turn_lanes,
        arm.right_turn_lanes,
        arm.lanes_out,
        arm.speed_mph,
        arm.length_m
    )
}

/// Compares two descriptions word by word; bearings and lengths only roughly.
fn agree(expected: &str, found: &str) -> bool {
    let words =
        |text: &str| -> Vec<String> { text.split_whitespace().map(str::to_owned).collect() };
    let (expected, found) = (words(expected), words(found));
    expected.len() == found.len()
        && (0..expected.len()).all(|i| {
            let (a, b) = (&expected[i], &found[i]);
            let unit = expected.get(i + 1).map(String::as_str);
            match (a.parse::<f64>(), b.parse::<f64>(), unit) {
                (Ok(a), Ok(b), Some("deg:")) => {
                    let apart = (a - b).rem_euclid(360.0);
                    apart.min(360.0 - apart) <= BEARING_DEG
                }
                (Ok(a), Ok(b), Some("m,")) => (a - b).abs() <= (LENGTH.0 * a).max(LENGTH.1),
                _ => a == b,
            }
        })
}

#[test]
fn every_hand_written_extract_has_the_expected_arms() {
    let mut wrong = String::new();
    let cases = cases();
    assert!(cases.len() > 20, "only {} cases", cases.len());
    for case in &cases {
        let expected = fs::read_to_string(case.join("expected.txt")).unwrap();
        let expected: String = expected
            .lines()
            .filter(|l| !l.starts_with('#') && !l.trim().is_empty())
            .map(|l| format!("{l}\n"))
            .collect();
        let found = describe(&found(case));
        if !agree(&expected, &found) {
            writeln!(wrong, "{}\nexpected:\n{expected}found:\n{found}", case.display()).unwrap();
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}
