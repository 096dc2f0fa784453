//! An intersection as the generator sees it: arms around a centre, each with its own features.
//!
//! The generator knows right-hand traffic only: the arms of left-hand traffic are mirrored here, and
//! [`plain`](super::plain) mirrors the drawing back.

use osm_signals::DrivingSide;
use osm_signals::Turns;
use osm_signals::angle::normalise_degrees;
use serde::Serialize;

use crate::family::approaches::{Approach, Counted, Intersection};
use crate::family::features::{incoming_lanes, simulated_inflow_vph, six_columns};
use crate::family::load::LoadedScenario;
use crate::family::points::RANGES;
use crate::network::error::NetworkError;
use crate::settings::{Detail, FamilySettings, LeftTurns, SixFeatures};
use basics::units::mph_to_mps;
use evaluation::settings::within;

/// One arm of an intersection; a direction without lanes does not exist.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Arm {
    /// Direction from the centre to the arm, degrees clockwise from north.
    pub bearing_deg: f64,
    /// Lanes that lead to the signal.
    pub lanes_in: u32,
    /// Lanes that lead away; 0 when the arm is one-way towards the signal.
    pub lanes_out: u32,
    /// Incoming lanes, among `lanes_in`, from which only a left turn is allowed.
    pub left_turn_lanes: u32,
    /// Incoming lanes, among `lanes_in`, from which only a right turn is allowed.
    pub right_turn_lanes: u32,
    /// Length of the left-turn lanes, metres; `None`: that of the road.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_storage_m: Option<f64>,
    /// Length of the right-turn lanes, metres; `None`: that of the road.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub right_storage_m: Option<f64>,
    /// Whether the lane beside the left-only ones turns left as well.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub shared_left: bool,
    /// Whether the lane beside the right-only ones turns right as well.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub shared_right: bool,
    /// Whether a sign forbids turns on red.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub no_turn_on_red: bool,
    /// Speed limit, metres per second.
    pub speed_mps: f64,
    /// Length of the incoming road, metres.
    pub length_m: f64,
    /// Arriving vehicles per hour.
    pub inflow_vph: f64,
    /// Turns that the data names; a turn also needs an arm to lead to. `None`: all that geometry
    /// allows.
    pub turns: Option<Turns>,
    /// What was counted by turn; `None`: the turn shares of the demand hold.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub counted: Option<Counted>,
    /// How the existing plan signals the left turns; `None`: it does not say, or does not count.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub left_turns: Option<LeftTurns>,
}

/// An intersection to build: the name of its point MDP and its arms, clockwise from north.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct IntersectionSpec {
    /// Id of the point MDP.
    pub point: String,
    /// Three to six arms (two for tests), sorted by bearing; of left-hand traffic the mirror image,
    /// east and west, left and right exchanged.
    pub arms: Vec<Arm>,
    /// Edges from and to of the movements that an existing plan lets into one leg together.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub merging: Vec<(String, String)>,
    /// Side of the street that traffic keeps to.
    #[serde(skip_serializing_if = "DrivingSide::is_right")]
    pub side: DrivingSide,
}

/// Bearings of the four arms that six features make, degrees, and how far their inflow lies from the
/// mean, in units of `approach_spread / sqrt(5)`: evenly spaced, with deviation `approach_spread`.
/// North and south are the major street, each street has unequal directions.
const FOUR_ARMS: [(f64, f64); 4] = [(0.0, 3.0), (90.0, -1.0), (180.0, 1.0), (270.0, -3.0)];

impl IntersectionSpec {
    /// Returns the intersection of a six-feature point MDP: four arms that differ in nothing but
    /// their inflow, which varies around the feature by `approach_spread`.
    ///
    /// `lanes` counts both directions: incoming lanes are half of it rounded up, and at least the
    /// turn lanes plus one; the other lanes lead away, at least one. The features are as on the
    /// ground.
    ///
    /// Source: this project's rule; the paper does not say how six features become a junction.
    pub fn from_six_features(
        point: &str,
        features: &SixFeatures,
        approach_spread: f64,
        side: DrivingSide,
    ) -> Self {
        let whole = |value: f64| value.max(0.0).round() as u32;
        let lanes = whole(features.lanes);
        let turn_lanes = (whole(features.left_turn_lanes), whole(features.right_turn_lanes));
        let (left, right) = side.swapped(turn_lanes);
        let (_, lanes_in) = incoming_lanes(features);
        let arm = |(bearing_deg, steps): (f64, f64)| Arm {
            bearing_deg,
            lanes_in,
            lanes_out: (lanes / 2).max(1),
            left_turn_lanes: left,
            right_turn_lanes: right,
            speed_mps: mph_to_mps(features.speed_mph),
            length_m: features.length_m,
            inflow_vph: features.inflow_vph * (1.0 + approach_spread * steps / 5.0_f64.sqrt()),
            ..Arm::default()
        };
        let (point, arms) = (point.to_owned(), FOUR_ARMS.map(arm).to_vec());
        Self { point, arms, merging: Vec::new(), side }
    }

    /// Returns a real intersection with its own arms, which the table has as on the ground.
    fn from_approaches(
        point: &str,
        intersection: &Intersection,
        settings: &FamilySettings,
        side: DrivingSide,
    ) -> Self {
        let mut arms: Vec<_> =
            intersection.arms.iter().map(|a| Arm::from_approach(a, settings, side)).collect();
        arms.sort_by(|a, b| a.bearing_deg.total_cmp(&b.bearing_deg));
        Self { point: point.to_owned(), arms, merging: Vec::new(), side }
    }
}

impl Arm {
    fn from_approach(approach: &Approach, settings: &FamilySettings, side: DrivingSide) -> Self {
        let has = |letter| approach.movements.contains(letter);
        let turns = (!approach.movements.is_empty()).then(|| {
            let (left, right) = side.swapped((has('l'), has('r')));
            Turns { left, through: has('s'), right }
        });
        let (left_turn_lanes, right_turn_lanes) =
            side.swapped((approach.left_turn_lanes, approach.right_turn_lanes));
        let (left_storage_m, right_storage_m) =
            side.swapped((approach.left_storage_m, approach.right_storage_m));
        let (shared_left, shared_right) =
            side.swapped((approach.shared_left, approach.shared_right));
        Self {
            bearing_deg: side.bearing_deg(normalise_degrees(approach.bearing_deg)),
            lanes_in: approach.lanes_in,
            lanes_out: approach.lanes_out,
            left_turn_lanes,
            right_turn_lanes,
            left_storage_m,
            right_storage_m,
            shared_left,
            shared_right,
            no_turn_on_red: approach.no_turn_on_red,
            speed_mps: mph_to_mps(approach.speed_mph),
            length_m: approach.length_m * settings.length_scale,
            inflow_vph: simulated_inflow_vph(approach, settings),
            turns,
            counted: approach.counted.map(|counted| counted.as_right_hand(side)),
            left_turns: None,
        }
    }
}

/// Returns the intersection of every point MDP of a scenario, in the order of the family.
/// Fails with [`NetworkError::Intersection`] when the family lacks one of the six features or has a value
/// that no intersection can have.
pub fn intersections(loaded: &LoadedScenario) -> Result<Vec<IntersectionSpec>, NetworkError> {
    let family = &loaded.family;
    let side = loaded.scenario.network.driving_side;
    if loaded.scenario.family.detail == Detail::PerApproach {
        return Ok(family
            .points
            .iter()
            .zip(&loaded.members)
            .map(|(point, members)| {
                let intersection = &loaded.intersections[members[0]];
                let settings = &loaded.scenario.family;
                IntersectionSpec::from_approaches(&point.id, intersection, settings, side)
            })
            .collect());
    }
    let columns = six_columns(family).map_err(|name| NetworkError::Intersection {
        point: family.name.clone(),
        reason: format!("the family has no feature {name}; add a column of that name"),
    })?;
    family
        .points
        .iter()
        .map(|point| {
            let features = SixFeatures::from_array(columns.map(|c| point.features[c]));
            check_six(&point.id, &features)?;
            let spread = loaded.scenario.demand.approach_spread;
            Ok(IntersectionSpec::from_six_features(&point.id, &features, spread, side))
        })
        .collect()
}

fn check_six(point: &str, features: &SixFeatures) -> Result<(), NetworkError> {
    let named = SixFeatures::COLUMNS.iter().zip(features.to_array());
    for (((name, _), value), (low, high)) in named.zip(RANGES) {
        within(value, low, high).map_err(|expected| NetworkError::Intersection {
            point: point.to_owned(),
            reason: format!("{name} = {value}: {expected}"),
        })?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::MAX_APPROACH_SPREAD;

    fn arms([lanes, left, right]: [f64; 3], approach_spread: f64) -> Vec<Arm> {
        let features = SixFeatures::from_array([lanes, 30.0, 300.0, 500.0, left, right]);
        let side = DrivingSide::Right;
        IntersectionSpec::from_six_features("p", &features, approach_spread, side).arms
    }

    /// Inflows of a point MDP of 500 veh/h per approach: north, east, south, west.
    fn inflows(approach_spread: f64) -> Vec<f64> {
        arms([4.0, 0.0, 0.0], approach_spread).iter().map(|a| a.inflow_vph).collect()
    }

    #[test]
    fn incoming_lanes_are_half_rounded_up_and_leave_one_beside_the_turn_lanes() {
        let arm = &arms([5.0, 0.0, 0.0], 0.0)[0];
        assert_eq!((arm.lanes_in, arm.lanes_out), (3, 2));
        assert_eq!(arms([2.0, 1.0, 1.0], 0.0)[2].lanes_in, 3);
        assert!(inflows(MAX_APPROACH_SPREAD).iter().all(|q| *q > 0.0));
    }

    #[test]
    fn inflows_vary_by_the_spread_around_the_feature() {
        let inflows = inflows(0.4);
        let mean = inflows.iter().sum::<f64>() / 4.0;
        let variance = inflows.iter().map(|q| (q - mean).powi(2)).sum::<f64>() / 4.0;
        assert!((mean - 500.0).abs() < 1e-9 && (variance.sqrt() / mean - 0.4).abs() < 1e-12);
        let [north, east, south, west] = inflows[..] else { unreachable!() };
        assert!(north > south && south > east && east > west && north + south > east + west);
    }
}
