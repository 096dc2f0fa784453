//! Tests of what is told of tables.

use super::*;
use crate::family::approaches::gathered;

/// What is said of so many T junctions of which something is changed.
fn doubts(count: usize, detail: Detail, change: impl Fn(usize, &mut Approach)) -> Vec<String> {
    let row = |i: usize| Approach {
        intersection: (i / 3).to_string(),
        latitude: 40.0,
        longitude: -75.0,
        bearing_deg: [0.0, 90.0, 270.0][i % 3],
        lanes_in: 2,
        lanes_out: 2,
        speed_mph: 35.0,
        length_m: 390.0,
        aadt_veh_per_day_per_lane: 4000.0,
        movements: "lsr".into(),
        line: i as u64 + 2,
        ..Approach::default()
    };
    let mut rows: Vec<Approach> = (0..3 * count).map(row).collect();
    rows.iter_mut().enumerate().for_each(|(i, row)| change(i, row));
    let settings = FamilySettings { detail, ..FamilySettings::default() };
    of_approaches(&gathered(rows), &settings).iter().map(Doubt::brief).collect()
}

fn said(change: impl Fn(usize, &mut Approach)) -> Vec<String> {
    doubts(5, Detail::PerApproach, change)
}

fn one(change: impl Fn(usize, &mut Approach)) -> String {
    let said = said(change);
    assert_eq!(said.len(), 1, "{said:?}");
    said[0].clone()
}

#[test]
fn an_inflow_that_is_cut_or_raised_is_named_with_its_row() {
    assert_eq!(
        one(|i, row| row.aadt_veh_per_day_per_lane = if i == 3 { 24_000.0 } else { 4000.0 }),
        "inflows above family.inflow_cap_vph_per_lane = 900 are cut to it; set it higher if they are right \
         (line 5: 1000 veh/h per lane)"
    );
    assert_eq!(
        one(|i, row| row.aadt_veh_per_day_per_lane = if i == 4 { 600.0 } else { 4000.0 }),
        "inflows below family.min_inflow_vph = 60 are raised to it (line 6: 50 veh/h)"
    );
}

#[test]
fn six_features_name_the_intersections_that_a_minimum_holds_for() {
    let said = doubts(3, Detail::SixFeatures, |i, row| {
        if i < 3 {
            (row.length_m, row.aadt_veh_per_day_per_lane) = (40.0, 1000.0);
        }
    });
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
fn values_that_look_like_another_unit_or_a_place_that_is_none_are_told() {
    assert_eq!(said(|_, _| {}), Vec::<String>::new(), "a plain table has no doubt");
    type Change = fn(usize, &mut Approach);
    let cases: [(Change, &str); 6] = [
        (|i, row| row.imputed = i == 0, "the mean of other approaches stands for it (line 2: 4000"),
        (|i, row| row.speed_mph = [30.0, 60.0, 60.0][i % 3], "speed_mph: half of the approaches"),
        (|_, row| row.aadt_veh_per_day_per_lane = 4.2, "beyond 4.2, and in a city"),
        (|_, row| row.length_m = 1300.0, "from 15 to 1000; look whether the column has this unit"),
        (|i, row| row.movements = ["lstr", "ltr"][i.min(1)].into(), "t is a U-turn here"),
        (
            |i, row| (row.latitude, row.longitude) = [(0.0, 0.0), (40.0, -75.0)][(i / 3).min(1)],
            "latitude 0 and longitude 0, which stands for no place (line 2: intersection 0)",
        ),
    ];
    for (change, expected) in cases {
        let said = said(change);
        assert!(said.iter().any(|doubt| doubt.contains(expected)), "{expected}: {said:?}");
    }
}
