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

    fn error(columns: &str, rows: &[&str]) -> String {
        family(columns, rows).unwrap_err()
    }

    fn six(values: &str) -> Result<MdpFamily, String> {
        read("f", &format!("importance,{SIX}\n1,{values}\n"), "p.csv").map_err(|e| e.to_string())
    }

    #[test]
    fn any_number_of_features_is_read_with_units() {
        let family = family("point,importance,mass_kg", &["a,0.5,1", "b,0.5,3"]).unwrap();
        assert_eq!(family.features[0], Feature { name: "mass_kg".into(), unit: "kg".into() });
        assert_eq!(family.points[1].features, [3.0, 4.0, 30.0, 200.0, 500.0, 0.0, 0.0]);
    }

    #[test]
    fn counts_become_importance() {
        let family = family("intersections", &["3", "1"]).unwrap();
        assert_eq!(family.importance(), [0.75, 0.25]);
        assert_eq!(family.points[0].id, "p0001");
    }

    #[test]
    fn a_negative_feature_names_line_and_value() {
        assert_eq!(
            error("importance,x", &["1,-2"]),
            "p.csv, line 2: x = -2: expected a number that is not negative"
        );
    }

    #[test]
    fn a_feature_that_networks_need_has_to_be_there_and_possible() {
        let without =
            read("f", "importance,lanes,speed\n1,4,30\n", "p.csv").unwrap_err().to_string();
        assert_eq!(
            without,
            "p.csv, line 1: no column speed_mph; if it is the column speed, rename that"
        );
        let other_unit = read("f", "importance,lanes,speed_kmh\n1,4,50\n", "p.csv").unwrap_err();
        assert_eq!(
            other_unit.to_string(),
            "p.csv, line 1: no column speed_mph; the column speed_kmh has another unit: multiply it by \
             0.621371 and call it speed_mph"
        );
        let e = six("4,300,200,500,0,0").unwrap_err();
        assert_eq!(e, "p.csv, line 2: speed_mph = 300: expected a number from 1 to 100");
        let e = six("4,,200,500,0,0").unwrap_err();
        assert_eq!(e, "p.csv, line 2: speed_mph is empty; give a number");
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

    #[test]
    fn a_name_may_be_any_text_and_its_id_stays_in_the_folder() {
        let family = family("point,importance", &["Main St / 5th,0.5", "../a,0.5"]).unwrap();
        for point in &family.points {
            check_id("point", &point.id).unwrap();
        }
        let titles: Vec<_> = family.points.iter().map(|p| p.title.as_str()).collect();
        assert_eq!(titles, ["Main St / 5th", "../a"]);
    }

    #[test]
    fn a_doubled_point_is_refused() {
        assert!(error("point,importance", &["a,0.5", "a,0.5"]).contains("point a stands twice"));
    }
}
