//! How many vehicles each arm carries: counts where they match, else a count of the same street, else
//! what the class of the street suggests.

use std::collections::BTreeMap;

use serde::Serialize;

use super::arms::Arm;
use super::counts::Counts;
use super::intersections::Intersection;
use super::settings::TrafficSettings;
use super::spread::Spread;
use super::tags::Highway;

/// Share of a two-way street's count that goes each way.
const EACH_WAY: f64 = 0.5;

/// Fewest counted arms of a class whose mean stands for the others.
const MIN_COUNTED: u32 = 3;

/// What an inflow rests on, the best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum InflowSource {
    /// A count on the arm.
    Counted,
    /// A count elsewhere on its street.
    Spread,
    /// The mean of counted arms of its class.
    Imputed,
    /// A default of its class.
    Default,
}

impl InflowSource {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Counted, Self::Spread, Self::Imputed, Self::Default];
}

/// Annual average daily traffic of an arm.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmTraffic {
    /// Vehicles per day and incoming lane, the mean of both directions of a two-way street; 0 for an
    /// arm without incoming lanes.
    pub aadt_per_lane: f64,
    /// What it rests on.
    pub source: InflowSource,
    /// If it rests on a count, the distance of the street from the counted line or station, metres; of a spread count the
    /// distance of the counted block from the junction, along the street.
    pub count_distance_m: Option<f64>,
}

/// Returns the traffic of every arm, by intersection.
///
/// Half of a count that is the total of both directions goes to a two-way arm. An arm without a count
/// gets one from elsewhere on its street ([`Spread`]), else the mean per lane of the counted arms of its
/// class, or the default of its class if fewer than three are counted.
pub(crate) fn traffic(
    intersections: &[Intersection],
    counts: Option<(&Counts, &Spread<'_>)>,
    settings: &TrafficSettings,
) -> Vec<Vec<ArmTraffic>> {
    let here = |arm: &Arm| {
        let (counts, _) = counts.filter(|_| arm.lanes_in > 0)?;
        let found = counts.along(&arm.places, arm.lanes_in + arm.lanes_out)?;
        let found = (found.aadt_veh_per_day, found.distance_m);
        Some(counted(arm, InflowSource::Counted, found, settings))
    };
    let elsewhere = |arm: &Arm| {
        let (counts, spread) = counts.filter(|_| arm.lanes_in > 0)?;
        Some(counted(arm, InflowSource::Spread, spread.find(arm, counts)?, settings))
    };
    let counted_here: Vec<Vec<Option<ArmTraffic>>> =
        intersections.iter().map(|i| i.arms.iter().map(&here).collect()).collect();
    let mut sums: BTreeMap<Highway, (f64, u32)> = BTreeMap::new();
    for (arm, traffic) in
        intersections.iter().flat_map(|i| &i.arms).zip(counted_here.iter().flatten())
    {
        if let Some(traffic) = traffic {
            let (sum, count) = sums.entry(arm.highway).or_default();
            *sum += traffic.aadt_per_lane;
            *count += 1;
        }
    }
    let typical = |highway: Highway| match sums.get(&highway) {
        Some((sum, count)) if *count >= MIN_COUNTED => {
            (sum / f64::from(*count), InflowSource::Imputed)
        }
        _ => (
            settings.default_aadt_per_lane.get(&highway).copied().unwrap_or(0.0),
            InflowSource::Default,
        ),
    };
    let complete = |arm: &Arm, traffic: Option<ArmTraffic>| {
        traffic.or_else(|| elsewhere(arm)).unwrap_or_else(|| {
            let (aadt_per_lane, source) = typical(arm.highway);
            let aadt_per_lane = if arm.lanes_in == 0 { 0.0 } else { aadt_per_lane };
            ArmTraffic { aadt_per_lane, source, count_distance_m: None }
        })
    };
    intersections
        .iter()
        .zip(counted_here)
        .map(|(i, row)| i.arms.iter().zip(row).map(|(arm, t)| complete(arm, t)).collect())
        .collect()
}

fn counted(
    arm: &Arm,
    source: InflowSource,
    (aadt_veh_per_day, distance_m): (f64, f64),
    settings: &TrafficSettings,
) -> ArmTraffic {
    let aadt_per_lane = per_lane(arm, aadt_veh_per_day, settings);
    ArmTraffic { aadt_per_lane, source, count_distance_m: Some(distance_m) }
}

/// Returns the part of a count that one incoming lane of an arm carries on the mean of its directions.
fn per_lane(arm: &Arm, aadt_veh_per_day: f64, settings: &TrafficSettings) -> f64 {
    let both = arm.lanes_out > 0 && settings.both_directions;
    aadt_veh_per_day * if both { EACH_WAY } else { 1.0 } / f64::from(arm.lanes_in)
}
