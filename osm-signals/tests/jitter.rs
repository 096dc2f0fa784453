//! How often a row of a signal list finds its own intersection when its coordinates are off, on real
//! extracts.
//!
//! The data is not part of the repository (its licence is unclear); without it the test says so and
//! ends. Every intersection of the map gets one row, moved by 5 to 30 m.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use std::io::Write;
use std::path::{Path, PathBuf};

use osm_signals::geometry::LocalMetric;
use osm_signals::intersections::Intersection;
use osm_signals::read::read;
use osm_signals::settings::Settings;
use osm_signals::signals::{SignalColumns, SignalList};
use osm_signals::survey::{Inputs, Survey};

/// Angle between the moves of successive rows, degrees: the golden angle, so that they go everywhere.
const GOLDEN_DEG: f64 = 137.507_764;

/// Distances by which rows are moved, metres.
const MOVES_M: [f64; 6] = [5.0, 10.0, 15.0, 20.0, 25.0, 30.0];

/// Least share of rows that find their own intersection.
const LEAST: f64 = 0.97;

#[expect(
    clippy::explicit_write,
    reason = "the test harness shows what is printed of failures only"
)]
fn data(name: &str) -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/osm").join(name);
    if !path.exists() {
        writeln!(std::io::stderr(), "skipped: there is no {}", path.display()).unwrap();
    }
    path.exists().then_some(path)
}

/// Returns a list with a row per intersection, moved.
fn jittered(intersections: &[Intersection]) -> SignalList {
    let mut text = "id,lat,lon\n".to_owned();
    for (i, intersection) in intersections.iter().enumerate() {
        let metric = LocalMetric::at(intersection.centre.latitude());
        let (sin, cos) = (GOLDEN_DEG * i as f64).to_radians().sin_cos();
        let metres = MOVES_M[i % MOVES_M.len()];
        let latitude = intersection.centre.latitude() + metres * cos / metric.north_m_per_deg;
        let longitude = intersection.centre.longitude() + metres * sin / metric.east_m_per_deg;
        text += &format!("r{i},{latitude:.7},{longitude:.7}\n");
    }
    SignalList::from_bytes(text.as_bytes(), Path::new("l.csv"), &SignalColumns::default()).unwrap()
}

#[test]
fn rows_that_are_off_by_up_to_30_m_find_their_own_intersection() {
    for name in ["r5_washington_dc.osm.pbf", "valhalla_harrisburg.osm.pbf"] {
        let Some(path) = data(name) else { return };
        let extract = read(&path, &|_, _| {}).unwrap();
        let config = Settings::default();
        let truth = Survey::new(&extract, &config, &Inputs::default()).found.intersections;
        let list = jittered(&truth);
        let inputs = Inputs { signals: Some(&list), ..Inputs::default() };
        let city = Survey::new(&extract, &config, &inputs);
        let (mut own, mut other, mut unmapped, mut none) = (0, 0, 0, 0);
        for (row, truth) in city.listed.iter().zip(&truth) {
            let matched = row.intersection.as_ref().and_then(|id| {
                city.found.intersections.iter().find(|intersection| intersection.id == *id)
            });
            match matched {
                Some(i) if i.signals.iter().any(|s| truth.signals.contains(s)) => own += 1,
                Some(i) if i.signals.is_empty() => unmapped += 1,
                Some(_) => other += 1,
                None => none += 1,
            }
        }
        let share = f64::from(own) / truth.len() as f64;
        println!(
            "{name}: of {} rows {own} ({:.1}%) at their own intersection, {other} at another, \
             {unmapped} at a junction without a signal, {none} at none; {} intersections",
            truth.len(),
            100.0 * share,
            city.found.intersections.len()
        );
        assert!(share >= LEAST, "{name}: {share}");
    }
}
