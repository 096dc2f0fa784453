//! What is doubtful in a table, and what of it is not simulated as it stands there: nothing of it stops a
//! run, and nothing of it is believed without a word.
//!
//! - **Changed:** an inflow that is cut or raised, a count that is missing, a turn lane that needs another lane.
//! - **Another unit:** a column whose median no city has in its unit.
//! - **No place:** latitude and longitude 0.
//!
//! Source: thresholds are this project's; each is beside its reason.

use std::collections::BTreeSet;
use std::fmt::Display;

use super::approaches::{Approach, Intersection, LEAST_PIECE_M};
use super::features::{
    incoming_lanes, inflow_vph, six_columns, six_features, uncapped_vph_per_lane,
};
use crate::settings::{Detail, FamilySettings, SixFeatures};
use evaluation::family::MdpFamily;
pub use evaluation::family::doubt::Doubt;
pub(crate) use evaluation::family::doubt::Said;

/// Medians between which a column of a city lies: speeds in miles per hour, not in metres per second or km/h; lengths over
/// which more than a car waits; counts per day and lane, not in thousands or of all lanes (FHWA's quietest urban streets have
/// 40 to 350; Highway Functional Classification, 2013, table 3-6).
type Column = (&'static str, (f64, f64), fn(&Approach) -> Option<f64>);
const COLUMNS: [Column; 3] = [
    ("speed_mph", (15.0, 50.0), |a| Some(a.speed_mph)),
    ("length_m", (15.0, 1000.0), |a| Some(a.length_m)),
    ("aadt_veh_per_day_per_lane", (100.0, 12_000.0), |a| {
        (!a.imputed && a.counted.is_none()).then_some(a.aadt_veh_per_day_per_lane)
    }),
];

/// Flow that no lane carries, vehicles per hour: the base saturation flow of the Highway Capacity Manual, without any
/// red.
const MOST_VPH_PER_LANE: f64 = 1900.0;

/// Least rows of which a median tells a unit.
const ENOUGH: usize = 3;

fn at_line(line: u64, text: impl Display) -> String {
    format!("line {line}: {text}")
}

/// Returns what is doubtful in a table of approaches, and what of it is changed.
pub fn of_approaches(intersections: &[Intersection], settings: &FamilySettings) -> Vec<Doubt> {
    let mut doubts = changes(intersections, settings);
    doubts.extend(periods(intersections, settings));
    if settings.inflows.is_none() {
        // Else this program wrote the table from a map, in the right units.
        doubts.extend(units(intersections));
        let nowhere = intersections.iter().filter(|i| i.latitude == 0.0 && i.longitude == 0.0);
        let rows = nowhere.map(|i| at_line(i.line, format!("intersection {}", i.id))).collect();
        doubts.extend(Doubt::of("latitude 0 and longitude 0, which stands for no place", rows));
    }
    doubts
}

fn incoming(intersections: &[Intersection]) -> impl Iterator<Item = &Approach> {
    intersections.iter().flat_map(|i| &i.arms).filter(|arm| arm.lanes_in > 0)
}

/// Returns the values that are simulated otherwise than they stand there, with their rows.
fn changes(intersections: &[Intersection], settings: &FamilySettings) -> Vec<Doubt> {
    let rows = |is: &dyn Fn(&Approach) -> Option<String>| -> Vec<String> {
        incoming(intersections).filter_map(|a| is(a).map(|text| at_line(a.line, text))).collect()
    };
    let per_approach = settings.detail == Detail::PerApproach;
    let (cap, least) = (settings.inflow_cap_vph_per_lane, settings.min_inflow_vph);
    let raised = match per_approach {
        true => rows(&|a| {
            let vph = inflow_vph(a, settings);
            (a.counted.is_none() && vph < least).then(|| format!("{vph:.0} veh/h"))
        }),
        false => in_bin_0(intersections, settings, 3, settings.bins.inflow_vph, "veh/h"),
    };
    let mut doubts = vec![
        (
            format!(
                "inflows above family.inflow_cap_vph_per_lane = {cap} are cut to it; set it higher if they are right"
            ),
            rows(&|a| {
                let vph = uncapped_vph_per_lane(a, settings);
                (a.counted.is_none() && vph > cap).then(|| format!("{vph:.0} veh/h per lane"))
            }),
        ),
        (format!("inflows below family.min_inflow_vph = {least} are raised to it"), raised),
        (
            "aadt_veh_per_day_per_lane is empty, and the mean of other approaches stands for it".into(),
            rows(&|a| {
                let aadt = a.aadt_veh_per_day_per_lane;
                a.imputed.then(|| format!("{aadt:.0} veh/day per lane"))
            }),
        ),
        (
            "movements: t is a U-turn here and nobody goes straight on, because other rows of the table have both s \
             and t; write s where straight on is meant"
                .into(),
            rows(&|a| {
                let is_u_turn = a.movements.contains('t') && !a.movements.contains('s');
                is_u_turn.then(|| a.movements.clone())
            }),
        ),
    ];
    let bay = |a: &Approach, most_m: f64| {
        let bays = [(a.left_storage_m, "left"), (a.right_storage_m, "right")];
        bays.into_iter().find_map(|(m, side)| Some((m.filter(|m| *m > most_m)?, side)))
    };
    if per_approach {
        doubts.push((
            "turn lanes whose storage length is nearly that of the approach are as long as the approach".into(),
            rows(&|a| {
                let (m, side) = bay(a, a.length_m * settings.length_scale - LEAST_PIECE_M)?;
                Some(format!("{side}, {m} m of {} m", a.length_m))
            }),
        ));
    } else {
        let bin_m = settings.bins.length_m;
        doubts.extend([
            (
                "six features have no storage lengths; say detail = \"per-approach\" in [family] to simulate them"
                    .into(),
                rows(&|a| bay(a, 0.0).map(|(m, side)| format!("{side}, {m} m"))),
            ),
            (
                "six features keep only the sum of the vehicles that were counted by turn; say detail = \
                 \"per-approach\" in [family] to simulate the turns"
                    .into(),
                rows(&|a| a.counted.map(|c| format!("{:.0} veh/h", c.total_vph()))),
            ),
            (
                format!("lengths below half of family.bins.length_m = {bin_m} become {bin_m} m"),
                in_bin_0(intersections, settings, 2, bin_m, "m"),
            ),
        ]);
    }
    doubts.into_iter().filter_map(|(about, rows)| Doubt::of(about, rows)).collect()
}

/// Returns the intersections of which a mean over the arms falls into the bin of 0, so that a minimum takes
/// its place.
fn in_bin_0(
    intersections: &[Intersection],
    settings: &FamilySettings,
    feature: usize,
    bin: f64,
    unit: &str,
) -> Vec<String> {
    let low = intersections.iter().filter_map(|i| {
        let value = six_features(i, settings).to_array()[feature];
        let text = || format!("intersection {}, {value:.0} {unit} in the mean", i.id);
        ((value / bin).round_ties_even() < 1.0).then(|| at_line(i.line, text()))
    });
    low.collect()
}

/// Returns that periods count equally, where nobody said how long they are.
fn periods(intersections: &[Intersection], settings: &FamilySettings) -> Option<Doubt> {
    let periods: BTreeSet<&str> = intersections.iter().map(|i| i.period.as_str()).collect();
    (settings.periods.is_none() && periods.len() > 1).then(|| {
        let names = periods.iter().map(|p| if p.is_empty() { "(none)" } else { p });
        Doubt::whole(format!(
            "the periods {} count equally; give their hours per year in [family.periods]",
            names.collect::<Vec<_>>().join(", ")
        ))
    })
}

/// Returns the columns whose median no city has in their unit.
fn units(intersections: &[Intersection]) -> impl Iterator<Item = Doubt> {
    COLUMNS.into_iter().filter_map(|(column, (low, high), of)| {
        let mut values: Vec<f64> = incoming(intersections).filter_map(of).collect();
        values.sort_by(f64::total_cmp);
        let median = values.get(values.len() / 2).filter(|_| values.len() >= ENOUGH)?;
        (!(low..high).contains(median)).then(|| {
            Doubt::whole(format!(
                "{column}: half of the approaches are beyond {median}, and in a city that is from {low} to {high}; look \
                 whether the column has this unit"
            ))
        })
    })
}

/// Returns what is doubtful in a table of point MDPs, and what of it is changed.
pub fn of_points(family: &MdpFamily) -> Vec<Doubt> {
    let Ok(columns) = six_columns(family) else { return Vec::new() };
    let points = || {
        family.points.iter().map(|point| {
            let features = SixFeatures::from_array(columns.map(|c| point.features[c]));
            (format!("point {}", point.title), features, incoming_lanes(&features))
        })
    };
    let added = points().filter(|(_, _, (half, lanes))| lanes > half);
    let added = Doubt::of(
        "turn lanes leave no lane to go straight, so more lanes lead to the signal than half of `lanes`",
        added
            .map(|(name, _, (half, lanes))| format!("{name}: {lanes} instead of {half}"))
            .collect(),
    );
    let busy =
        points().filter(|(_, f, (_, lanes))| f.inflow_vph > MOST_VPH_PER_LANE * f64::from(*lanes));
    let busy = Doubt::of(
        format!(
            "inflow_vph above {MOST_VPH_PER_LANE} per incoming lane, which no lane carries; it is per approach and \
             hour, not per day"
        ),
        busy.map(|(name, f, (_, lanes))| {
            format!("{name}: {} veh/h on {lanes} lanes", f.inflow_vph)
        })
        .collect(),
    );
    added.into_iter().chain(busy).collect()
}

#[cfg(test)]
mod tests;
