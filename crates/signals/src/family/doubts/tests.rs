//! Tests of what is told of tables.

use super::*;
use crate::family::approaches::read;

const HEADER: &str = "intersection,arm,latitude,longitude,bearing_deg,lanes_in,lanes_out,left_turn_lanes,\
    right_turn_lanes,speed_mph,length_m,aadt_veh_per_day_per_lane,movements\n";

/// Metres per degree of latitude.
const PER_DEG: f64 = 111_195.0;

/// One arm, with its usual values.
#[derive(Clone)]
struct Row {
    intersection: usize,
    arm: char,
    latitude: f64,
    longitude: f64,
    bearing: f64,
    speed: f64,
    length: f64,
    aadt: f64,
    movements: &'static str,
}

/// A row of T junctions along a street that goes east, 400 m apart, each with an arm to the north.
fn street(count: usize) -> Vec<Row> {
    let (latitude, per_deg) = (40.0, PER_DEG * 40.0_f64.to_radians().cos());
    let arms = |i: usize| {
        let row = move |(arm, bearing)| Row {
            intersection: i,
            arm,
            latitude,
            longitude: -75.0 + 400.0 * i as f64 / per_deg,
            bearing,
            speed: 35.0,
            length: 390.0,
            aadt: 4000.0,
            movements: "lsr",
        };
        [('A', 0.0), ('B', 90.0), ('C', 270.0)].map(row)
    };
    (0..count).flat_map(arms).collect()
}

fn doubts(rows: &[Row], settings: &FamilySettings) -> Vec<Doubt> {
    let line = |r: &Row| {
        let aadt = if r.aadt.is_nan() { String::new() } else { r.aadt.to_string() };
        format!(
            "{},{},{},{},{},2,2,0,0,{},{},{aadt},{}\n",
            r.intersection,
            r.arm,
            r.latitude,
            r.longitude,
            r.bearing,
            r.speed,
            r.length,
            r.movements
        )
    };
    let text: String = rows.iter().map(line).collect();
    of_approaches(&read(&format!("{HEADER}{text}"), "a.csv").unwrap(), settings)
}

/// What is said of a street of five T junctions of which something is changed.
fn said(change: impl Fn(usize, &mut Row)) -> Vec<String> {
    let mut rows = street(5);
    rows.iter_mut().enumerate().for_each(|(i, row)| change(i, row));
    let settings = FamilySettings { detail: Detail::PerApproach, ..FamilySettings::default() };
    doubts(&rows, &settings).iter().map(Doubt::brief).collect()
}

fn one(change: impl Fn(usize, &mut Row)) -> String {
    let said = said(change);
    assert_eq!(said.len(), 1, "{said:?}");
    said[0].clone()
}

#[test]
fn a_plain_table_has_no_doubt() {
    assert_eq!(said(|_, _| {}), Vec::<String>::new());
}

#[test]
fn an_inflow_that_is_cut_or_raised_is_named_with_its_row() {
    assert_eq!(
        one(|i, row| row.aadt = if i == 3 { 24_000.0 } else { 4000.0 }),
        "inflows above family.inflow_cap_vph_per_lane = 900 are cut to it; set it higher if they are right \
         (line 5: 1000 veh/h per lane)"
    );
    assert_eq!(
        one(|i, row| row.aadt = if i == 4 { 600.0 } else { 4000.0 }),
        "inflows below family.min_inflow_vph = 60 are raised to it (line 6: 50 veh/h)"
    );
}

#[test]
fn a_count_that_is_missing_is_named_with_what_stands_for_it() {
    assert_eq!(
        one(|i, row| row.aadt = if i == 0 { f64::NAN } else { 4000.0 }),
        "aadt_veh_per_day_per_lane is empty, and the mean of other approaches stands for it (line 2: 4000 \
         veh/day per lane)"
    );
}

#[test]
fn six_features_name_the_intersections_that_a_minimum_holds_for() {
    let mut rows = street(3);
    rows[..3].iter_mut().for_each(|row| (row.length, row.aadt) = (40.0, 1000.0));
    let settings = FamilySettings { detail: Detail::SixFeatures, ..FamilySettings::default() };
    let said: Vec<String> = doubts(&rows, &settings).iter().map(Doubt::brief).collect();
    assert_eq!(
        said,
        [
            "inflows below family.min_inflow_vph = 60 are raised to it (line 2: intersection 0, 83 veh/h in the \
             mean)",
            "lengths below half of family.bins.length_m = 100 become 100 m (line 2: intersection 0, 40 m in the \
             mean)"
        ]
    );
}

#[test]
fn speeds_in_other_units_are_told() {
    let kmh = |row: &mut Row, i: usize| row.speed = if i.is_multiple_of(3) { 30.0 } else { 60.0 };
    assert!(one(|i, row| kmh(row, i)).contains("if it is in km/h, multiply it by 0.621371"));
    assert!(one(|_, row| row.speed = 13.9).contains("in m/s, multiply it by 2.236936"));
}

#[test]
fn counts_in_other_units_are_told() {
    assert!(said(|_, row| row.aadt = 4.2).iter().any(|s| s.contains("multiply them by 1000")));
    let hourly = one(|_, row| row.aadt = 380.0 * 2.0);
    assert!(hourly.contains("divide them by the hour's share of the day"), "{hourly}");
    assert!(said(|_, row| row.aadt = 16_000.0).iter().any(|s| s.contains("counts of all lanes")));
}

#[test]
fn a_u_turn_that_may_be_meant_as_through_is_told() {
    let u_turns = said(|i, row| row.movements = if i == 0 { "lstr" } else { "ltr" });
    assert!(u_turns[0].contains("t is a U-turn here"), "{u_turns:?}");
}

#[test]
fn a_short_message_names_five_rows_and_counts_the_others() {
    let doubt = Doubt::of("x", (0..7).map(|i| i.to_string()).collect()).unwrap();
    assert_eq!(doubt.brief(), "x (0; 1; 2; 3; 4; and 2 more)");
    assert_eq!(doubt.full().lines().count(), 8);
}

#[test]
fn lengths_in_other_units_and_places_that_are_none_are_told() {
    let km = one(|_, row| row.length = 1.2);
    assert!(km.contains("if it is in km, multiply it by 1000"), "{km}");
    let feet = one(|_, row| row.length = 1300.0);
    assert!(feet.contains("if it is in feet, multiply it by 0.3048"), "{feet}");
    let nowhere = said(|i, row| {
        if i < 3 {
            (row.latitude, row.longitude) = (0.0, 0.0);
        }
    });
    assert_eq!(
        nowhere,
        ["latitude 0 and longitude 0, which stands for no place (line 2: intersection 0)"]
    );
}
