//! From approaches to six features per intersection, and from intersections to point MDPs.
//!
//! Deviation: the paper says neither how its 345 intersections became 164 distinct ones nor how a feature
//! of an intersection follows from its approaches. The rule here, for 282 intersections, is this project's: each feature
//! is the mean over the arms that lead to the signal, rounded **half to even** to a multiple of
//! its bin. Rounding half up would give another family (186 instead of 164 point MDPs), because
//! many values are exact ties.
//!
//! **The hour.** Traffic of a hour is `AADT K D`: a share `K` of the day falls into the hour
//! ([`FamilySettings::hourly_share`]), and of that a share `D` goes in the peak direction of a two-way street
//! ([`FamilySettings::directional_split`]). Annual counts do not tell which direction that is, and the larger share on every
//! arm would be more vehicles than were counted. So the peak direction of all streets is the one whose heading is within 90
//! degrees of one heading ([`FamilySettings::peak_heading_deg`], north-east: north- and eastbound traffic). Of two opposite
//! arms one gets `2 D` and the other `2 (1 - D)` times its mean, and the two ends of a straight street agree: what is inbound
//! at one is outbound at the other. One-way streets have no split. Source: directional design-hour volume, Highway Capacity
//! Manual, and FDOT's Project Traffic Forecasting Handbook. Deviation: there the peak direction of a street is counted.

use std::collections::BTreeMap;

use super::approaches::{Approach, Intersection};
use crate::settings::{EVEN_SPLIT, FamilySettings, SixFeatures};
use evaluation::family::MdpFamily;
use osm_signals::angle::turn_degrees;

/// Lanes of a direction that no turn lane uses up.
const MIN_SHARED_LANES: u32 = 1;

/// Returns the arriving vehicles per hour of an approach: those that were counted by turn, or its AADT per lane times
/// the hourly share and the share of its direction, capped per lane, times the lanes that lead to the signal.
pub fn inflow_vph(approach: &Approach, settings: &FamilySettings) -> f64 {
    if let Some(counted) = &approach.counted {
        return counted.total_vph();
    }
    uncapped_vph_per_lane(approach, settings).min(settings.inflow_cap_vph_per_lane)
        * f64::from(approach.lanes_in)
}

/// Returns the vehicles per hour and lane of an approach, before the cap.
pub(super) fn uncapped_vph_per_lane(approach: &Approach, settings: &FamilySettings) -> f64 {
    let factor = direction_factor(approach, settings);
    approach.aadt_veh_per_day_per_lane * settings.hourly_share * factor
}

/// Half of all headings, degrees.
const HALF_DEG: f64 = 90.0;

/// Returns by what the mean of both directions has to be multiplied for the flow towards the signal.
fn direction_factor(approach: &Approach, settings: &FamilySettings) -> f64 {
    if approach.lanes_out == 0 {
        return 1.0;
    }
    let heading_deg = approach.bearing_deg + 180.0;
    // Of two opposite headings exactly one is in the half-open range.
    let turn_deg = turn_degrees(settings.peak_heading_deg, heading_deg);
    let peak = turn_deg > -HALF_DEG && turn_deg <= HALF_DEG;
    let share = if peak { settings.directional_split } else { 1.0 - settings.directional_split };
    share / EVEN_SPLIT
}

/// Returns where a family has the six features.
///
/// # Errors
///
/// The name of the first that it lacks.
pub fn six_columns(family: &MdpFamily) -> Result<[usize; 6], &'static str> {
    let mut columns = [0; 6];
    for (column, (name, _)) in columns.iter_mut().zip(SixFeatures::COLUMNS) {
        *column = family.features.iter().position(|f| f.name == name).ok_or(name)?;
    }
    Ok(columns)
}

/// Returns the lanes of a six-feature approach that lead to the signal: half of its lanes rounded up, and then
/// as many as its turn lanes and one more need.
///
/// Source: this project's rule; the paper does not say how six features become a junction.
pub fn incoming_lanes(features: &SixFeatures) -> (u32, u32) {
    let whole = |value: f64| value.max(0.0).round() as u32;
    let half = whole(features.lanes).div_ceil(2);
    let turn_lanes = whole(features.left_turn_lanes) + whole(features.right_turn_lanes);
    (half, half.max(turn_lanes + MIN_SHARED_LANES))
}

/// Returns the six features of an intersection, unquantised: means over the arms that lead to it.
///
/// The inflow is not yet raised to the minimum of a point MDP.
pub fn six_features(intersection: &Intersection, settings: &FamilySettings) -> SixFeatures {
    let arms: Vec<_> = intersection.arms.iter().filter(|a| a.lanes_in > 0).collect();
    let count = arms.len() as f64;
    let mean = |f: &dyn Fn(&Approach) -> f64| arms.iter().map(|a| f(a)).sum::<f64>() / count;
    SixFeatures {
        lanes: mean(&|a| f64::from(a.lanes_in + a.lanes_out)),
        speed_mph: mean(&|a| a.speed_mph),
        length_m: mean(&|a| a.length_m * settings.length_scale),
        inflow_vph: mean(&|a| inflow_vph(a, settings)),
        left_turn_lanes: mean(&|a| f64::from(a.left_turn_lanes)),
        right_turn_lanes: mean(&|a| f64::from(a.right_turn_lanes)),
    }
}

/// Returns the six features of an intersection that keeps its own arms: as [`six_features`], but with
/// the inflow of every arm raised to the minimum, as it is simulated.
pub fn per_approach_features(
    intersection: &Intersection,
    settings: &FamilySettings,
) -> SixFeatures {
    let inflows: Vec<f64> = (intersection.arms.iter().filter(|a| a.lanes_in > 0))
        .map(|a| simulated_inflow_vph(a, settings))
        .collect();
    let inflow_vph = inflows.iter().sum::<f64>() / inflows.len() as f64;
    SixFeatures { inflow_vph, ..six_features(intersection, settings) }
}

/// Returns the arriving vehicles per hour of an approach that is simulated as it is: at least the minimum, unless they
/// were counted by turn.
pub fn simulated_inflow_vph(approach: &Approach, settings: &FamilySettings) -> f64 {
    let inflow_vph = inflow_vph(approach, settings);
    if approach.counted.is_some() { inflow_vph } else { inflow_vph.max(settings.min_inflow_vph) }
}

/// Returns `value` as a whole number of bins, half to even.
fn bin_index(value: f64, bin: f64) -> i64 {
    (value / bin).round_ties_even() as i64
}

/// Groups intersections whose quantised features are equal.
///
/// Returns the quantised features and the indices of the intersections, ordered by the features.
/// A quantised inflow below the settings' minimum is raised to it; lanes, speed and length are at
/// least one bin.
pub fn group(
    intersections: &[Intersection],
    settings: &FamilySettings,
) -> Vec<(SixFeatures, Vec<usize>)> {
    let bins = settings.bins.to_array();
    let mut groups: BTreeMap<[i64; 6], Vec<usize>> = BTreeMap::new();
    for (i, intersection) in intersections.iter().enumerate() {
        let values = six_features(intersection, settings).to_array();
        let mut key = std::array::from_fn(|f| bin_index(values[f], bins[f]));
        for k in &mut key[..3] {
            *k = (*k).max(1);
        }
        groups.entry(key).or_default().push(i);
    }
    groups
        .into_iter()
        .map(|(key, members)| {
            let mut features =
                SixFeatures::from_array(std::array::from_fn(|f| key[f] as f64 * bins[f]));
            features.inflow_vph = features.inflow_vph.max(settings.min_inflow_vph);
            (features, members)
        })
        .collect()
}

/// Returns the id of a point MDP, which spells its features: `L4-S30-D300-Q500-l0-r0` has 4 lanes,
/// 30 mph, 300 m, 500 veh/h per approach, no left-only and no right-only lane.
pub fn point_id(features: &SixFeatures) -> String {
    format!(
        "L{}-S{}-D{}-Q{}-l{}-r{}",
        features.lanes,
        features.speed_mph,
        features.length_m,
        features.inflow_vph,
        features.left_turn_lanes,
        features.right_turn_lanes
    )
}

/// Returns what tells intersections with their own arms apart beyond the six means, such as a crossing from a T junction:
/// the six features; the number of arms, and of those with traffic in one direction only; the shares of approaches from which
/// a left turn, the way straight on and a right turn exist; the standard deviation of the inflow between approaches, divided
/// by its mean. Where every intersection keeps its own arms, k-means compares these columns, each standardised.
///
/// Deviation: the paper clusters the context features, which here describe four equal arms.
pub fn describing(intersection: &Intersection, settings: &FamilySettings) -> Vec<f64> {
    let arms = &intersection.arms;
    let approaches: Vec<&Approach> = arms.iter().filter(|a| a.lanes_in > 0).collect();
    let count = approaches.len() as f64;
    let one_way = arms.iter().filter(|a| (a.lanes_in == 0) != (a.lanes_out == 0)).count();
    // Where a table names no movements, all that geometry allows exist.
    let share = |turn: char| {
        let has = |a: &&&Approach| a.movements.is_empty() || a.movements.contains(turn);
        approaches.iter().filter(has).count() as f64 / count
    };
    let inflows: Vec<f64> = approaches.iter().map(|a| simulated_inflow_vph(a, settings)).collect();
    let mean = inflows.iter().sum::<f64>() / count;
    let variance = inflows.iter().map(|q| (q - mean).powi(2)).sum::<f64>() / count;
    let mut columns = per_approach_features(intersection, settings).to_array().to_vec();
    columns.extend([arms.len() as f64, one_way as f64]);
    columns.extend(['l', 's', 'r'].map(share));
    columns.push(variance.sqrt() / mean);
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::family::approaches::Counted;

    fn arm(lanes_in: u32, lanes_out: u32, aadt: f64) -> Approach {
        Approach {
            lanes_in,
            lanes_out,
            speed_mph: 30.0,
            length_m: 250.0,
            aadt_veh_per_day_per_lane: aadt,
            ..Approach::default()
        }
    }

    fn intersection(arms: Vec<Approach>) -> Intersection {
        Intersection { arms, ..Intersection::default() }
    }

    #[test]
    fn the_inflow_is_that_of_arms_that_lead_here_capped_or_raised_unless_turns_were_counted() {
        let settings = FamilySettings::default();
        let features =
            six_features(&intersection(vec![arm(2, 1, 2400.0), arm(0, 9, 9.0)]), &settings);
        assert_eq!((features.lanes, features.inflow_vph), (3.0, 200.0));
        assert_eq!(inflow_vph(&arm(2, 0, 200_403.0), &settings), 1800.0);
        let own = intersection(vec![arm(1, 1, 2400.0), arm(1, 1, 0.0)]);
        assert_eq!(per_approach_features(&own, &settings).inflow_vph, 80.0);
        let counted = |left_vph: f64, through_vph: f64| Approach {
            counted: Some(Counted { left_vph, through_vph, ..Counted::default() }),
            ..arm(1, 1, 0.0)
        };
        let inflow = |a| simulated_inflow_vph(&a, &settings);
        assert_eq!([inflow(counted(200.0, 1900.0)), inflow(counted(3.0, 4.0))], [2100.0, 7.0]);
    }

    #[test]
    fn a_daily_count_gives_the_design_hour_of_each_direction_whatever_the_lanes() {
        // The example of docs/own-city.md: AADT 20,000, K = 0.09, D = 0.55, north- and eastbound in the peak.
        let settings = FamilySettings {
            hourly_share: 0.09,
            directional_split: 0.55,
            peak_heading_deg: 45.0,
            ..FamilySettings::default()
        };
        let inflow = |bearing_deg, lanes: (u32, u32), aadt| {
            let arm = Approach { bearing_deg, ..arm(lanes.0, lanes.1, aadt) };
            inflow_vph(&arm, &settings).round()
        };
        let south = inflow(180.0, (3, 2), 20_000.0 / 6.0);
        let north = inflow(0.0, (2, 3), 20_000.0 / 4.0);
        // A one-way street of 8,000.
        let east = inflow(90.0, (2, 0), 8000.0 / 2.0);
        assert_eq!([south, north, east], [990.0, 810.0, 720.0]);
    }

    #[test]
    fn the_id_spells_the_features_and_an_empty_bin_of_inflow_gets_the_minimum() {
        for (arm, id) in [
            (arm(2, 2, 6000.0), "L4-S30-D200-Q500-l0-r0"),
            (arm(1, 1, 24.0), "L2-S30-D200-Q60-l0-r0"),
        ] {
            let groups = group(&[intersection(vec![arm])], &FamilySettings::default());
            assert_eq!(point_id(&groups[0].0), id);
        }
        assert_eq!([250.0, 350.0].map(|value| bin_index(value, 100.0)), [2, 4], "ties go to even");
    }

    fn factor(bearing_deg: f64, lanes_out: u32, split: f64) -> f64 {
        let approach = Approach { bearing_deg, lanes_in: 1, lanes_out, ..Approach::default() };
        let settings = FamilySettings { directional_split: split, ..FamilySettings::default() };
        direction_factor(&approach, &settings)
    }

    #[test]
    fn opposite_arms_have_the_whole_together_whatever_their_bearing() {
        assert_eq!([factor(30.0, 1, 0.5), factor(30.0, 0, 0.7)], [1.0; 2], "a one-way street");
        for tenth in 0..3600 {
            let bearing_deg = f64::from(tenth) / 10.0;
            let both = factor(bearing_deg, 1, 0.6) + factor((bearing_deg + 180.0) % 360.0, 1, 0.6);
            assert!((both - 2.0).abs() < 1e-12, "{bearing_deg}");
        }
    }

    fn turning(arm: Approach, movements: &str) -> Approach {
        Approach { movements: movements.into(), ..arm }
    }

    fn described(arms: Vec<Approach>) -> Vec<f64> {
        describing(&intersection(arms), &FamilySettings::default())[6..].to_vec()
    }

    #[test]
    fn arms_movements_and_the_spread_of_inflow_tell_intersections_with_equal_means_apart() {
        let cross = described(vec![turning(arm(1, 1, 2400.0), "lsr"); 4]);
        assert_eq!(cross, [4.0, 0.0, 1.0, 1.0, 1.0, 0.0]);
        let tee = [
            turning(arm(1, 1, 2400.0), "sr"),
            turning(arm(1, 1, 2400.0), "ls"),
            turning(arm(1, 1, 2400.0), "lr"),
        ];
        let third = 2.0 / 3.0;
        assert_eq!(described(tee.to_vec()), [3.0, 0.0, third, third, third, 0.0]);
        let uneven = vec![
            turning(arm(1, 0, 3600.0), ""),
            turning(arm(1, 1, 2400.0), ""),
            turning(arm(0, 1, 0.0), ""),
        ];
        assert_eq!(described(uneven), [3.0, 2.0, 1.0, 1.0, 1.0, 0.2]);
    }
}
