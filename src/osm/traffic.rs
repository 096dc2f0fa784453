//! How many vehicles each arm carries: counts where they match, else what the class of the street
//! suggests.

use std::collections::BTreeMap;

use super::arms::Arm;
use super::config::TrafficSettings;
use super::counts::Counts;
use super::intersections::Intersection;
use super::streets::Source;
use super::tags::Highway;

/// Fewest counted arms of a class whose mean stands for the others.
const MIN_COUNTED: u32 = 3;

/// Annual average daily traffic of an arm.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmTraffic {
    /// Vehicles per day and incoming lane; 0 for an arm without incoming lanes.
    pub aadt_per_lane: f64,
    /// What it rests on; a count is tagged.
    pub source: Source,
    /// Id of the count and its distance, metres.
    pub count: Option<(String, f64)>,
}

/// Returns the traffic of every arm, by intersection.
///
/// A count that is the total of both directions is split on two-way arms; an arm without a count
/// gets the mean per lane of the counted arms of its class, or the default of its class if fewer
/// than three are counted.
pub fn traffic(
    intersections: &[Intersection],
    counts: Option<&Counts>,
    settings: &TrafficSettings,
) -> Vec<Vec<ArmTraffic>> {
    let counted: Vec<Vec<Option<ArmTraffic>>> = intersections
        .iter()
        .map(|i| i.arms.iter().map(|arm| counted(arm, counts?, settings)).collect())
        .collect();
    let mut sums: BTreeMap<Highway, (f64, u32)> = BTreeMap::new();
    for (arm, traffic) in intersections.iter().flat_map(|i| &i.arms).zip(counted.iter().flatten()) {
        if let Some(traffic) = traffic {
            let (sum, count) = sums.entry(arm.highway).or_default();
            *sum += traffic.aadt_per_lane;
            *count += 1;
        }
    }
    let typical = |highway: Highway| match sums.get(&highway) {
        Some((sum, count)) if *count >= MIN_COUNTED => (sum / f64::from(*count), Source::Imputed),
        _ => {
            (settings.default_aadt_per_lane.get(&highway).copied().unwrap_or(0.0), Source::Default)
        }
    };
    let complete = |arm: &Arm, traffic: Option<ArmTraffic>| {
        traffic.unwrap_or_else(|| {
            let (aadt_per_lane, source) = typical(arm.highway);
            let aadt_per_lane = if arm.lanes_in == 0 { 0.0 } else { aadt_per_lane };
            ArmTraffic { aadt_per_lane, source, count: None }
        })
    };
    intersections
        .iter()
        .zip(counted)
        .map(|(i, row)| i.arms.iter().zip(row).map(|(arm, t)| complete(arm, t)).collect())
        .collect()
}

fn counted(arm: &Arm, counts: &Counts, settings: &TrafficSettings) -> Option<ArmTraffic> {
    if arm.lanes_in == 0 {
        return None;
    }
    let found = counts.along(&arm.places, arm.lanes_in + arm.lanes_out)?;
    let share = match arm.lanes_out > 0 && settings.both_directions {
        true => settings.directional_split,
        false => 1.0,
    };
    Some(ArmTraffic {
        aadt_per_lane: found.aadt_veh_per_day * share / f64::from(arm.lanes_in),
        source: Source::Tagged,
        count: Some((found.id, found.distance_m)),
    })
}
