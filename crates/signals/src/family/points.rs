//! A table of point MDPs written by hand: the six features, others beside them, and either importance
//! or counts.
//!
//! Columns: `point` (optional; numbered when absent), `importance` (sums to 1) or `intersections`
//! (counts, normalised), the six features of an intersection, and one column per further feature. A
//! column name that ends in a known unit (`_m`, `_mph`, `_vph`, `_s`, `_kg`) tells the feature's unit.

use crate::settings::SixFeatures;
use evaluation::family::MdpFamily;
use evaluation::family::error::FamilyError;
use evaluation::family::points::{self, Kind};
use evaluation::settings::within;

const UNITS: [(&str, &str); 6] = [
    ("_m", "m"),
    ("_mph", "mph"),
    ("_vph", "veh/h per approach"),
    ("_s", "s"),
    ("_kg", "kg"),
    ("_lanes", "lanes per approach"),
];

/// Ranges of the six features, in the order of [`SixFeatures::COLUMNS`].
pub(crate) const RANGES: [(f64, f64); 6] =
    [(1.0, 24.0), (1.0, 100.0), (10.0, 100_000.0), (1.0, 50_000.0), (0.0, 6.0), (0.0, 6.0)];

/// Reads a table of point MDPs.
///
/// # Errors
///
/// [`FamilyError`] naming file and line: a missing or doubled column, a value that is no number or
/// that no intersection has, a name that comes twice, importance that does not sum to 1. Turn lanes that leave
/// no lane to go straight get one more, as in a family that is derived from approaches
/// ([`super::features::incoming_lanes`]), and [`super::doubts`] says so.
pub fn read(name: &str, text: &str, file: &str) -> Result<MdpFamily, FamilyError> {
    let needed = SixFeatures::COLUMNS.map(|(name, _)| name);
    let kind = Kind {
        needed: &needed,
        counts: "intersections",
        large: &["inflow_vph"],
        units: &UNITS,
        check: &check,
    };
    points::read(name, text, file, &kind)
}

/// Checks the six features of an intersection.
fn check(number: &dyn Fn(&str) -> Result<f64, String>) -> Result<(), String> {
    for ((name, _), (low, high)) in SixFeatures::COLUMNS.iter().zip(RANGES) {
        let value = number(name)?;
        within(value, low, high).map_err(|expected| format!("{name} = {value}: {expected}"))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use evaluation::family::Feature;
    use evaluation::family::names::check_id;

    const SIX: &str = "lanes,speed_mph,length_m,inflow_vph,left_turn_lanes,right_turn_lanes";

    /// A table with the columns of the six features behind others, and usual values in them.
    fn family(columns: &str, rows: &[&str]) -> Result<MdpFamily, String> {
        let rows: String = rows.iter().map(|row| format!("{row},4,30,200,500,0,0\n")).collect();
        read("f", &format!("{columns},{SIX}\n{rows}"), "p.csv").map_err(|e| e.to_string())
    }

    #[test]
    fn features_have_units_counts_become_importance_and_names_become_ids() {
        let counted = family("intersections,mass_kg", &["3,1", "1,3"]).unwrap();
        assert_eq!(counted.features[0], Feature { name: "mass_kg".into(), unit: "kg".into() });
        assert_eq!(counted.points[1].features, [3.0, 4.0, 30.0, 200.0, 500.0, 0.0, 0.0]);
        assert_eq!((counted.importance(), &*counted.points[0].id), (vec![0.75, 0.25], "p0001"));
        let named = family("point,importance", &["Main St / 5th,0.5", "../a,0.5"]).unwrap();
        for (point, title) in named.points.iter().zip(["Main St / 5th", "../a"]) {
            check_id("point", &point.id).unwrap();
            assert_eq!(point.title, title);
        }
    }

    #[test]
    fn what_no_intersection_has_names_line_and_value() {
        for (columns, row, expected) in [
            (
                "importance",
                "1,4,300,200,500,0,0",
                "speed_mph = 300: expected a number from 1 to 100",
            ),
            ("importance", "1,4,,200,500,0,0", "speed_mph is empty; give a number"),
        ] {
            let e = read("f", &format!("{columns},{SIX}\n{row}\n"), "p.csv").unwrap_err();
            assert_eq!(e.to_string(), format!("p.csv, line 2: {expected}"));
        }
    }

    #[test]
    fn a_point_mdp_of_the_derived_family_can_be_written_by_hand() {
        let derived = crate::family::load::load("salt-lake-city").unwrap().family;
        let rows: String = (derived.points.iter())
            .map(|p| {
                let features: Vec<String> = p.features.iter().map(f64::to_string).collect();
                format!("{},{},{}\n", p.id, p.instances, features.join(","))
            })
            .collect();
        let text = format!("point,intersections,{SIX}\n{rows}");
        let by_hand = read("salt-lake-city", &text, "p.csv").unwrap();
        assert_eq!(by_hand.points, derived.points);
        let doubts = crate::family::doubts::of_points(&by_hand);
        let added: Vec<&String> = doubts.iter().flat_map(|d| &d.rows).collect();
        let expected = "point L4-S50-D300-Q750-l1-r1: 3 instead of 2".to_owned();
        assert!(added.contains(&&expected), "{added:?}");
    }
}
