//! Which intersections of a map have nothing to decide: all their streams can have green at the same time.

use osm_signals::{DrivingSide, Intersection, Turns};

use crate::junction::Conflicts;
use crate::network::intersection::{Arm, IntersectionSpec};
use crate::network::lanes::layout;
use crate::network::phases::phases;
use basics::units::mph_to_mps;

/// Returns whether all streams of an intersection can have green at the same time.
pub(super) fn has_one_green(intersection: &Intersection, side: DrivingSide) -> bool {
    let spec = spec(intersection, side);
    let greens = layout(&spec).map(|l| phases(&spec, &l, &Conflicts::of(&l.movements), None).len());
    greens.is_ok_and(|greens| greens == 1)
}

/// Returns an intersection as the network generator sees it, without its traffic.
fn spec(intersection: &Intersection, side: DrivingSide) -> IntersectionSpec {
    let of = |(arm, turns): (&osm_signals::Arm, &Option<Turns>)| {
        let (left_turn_lanes, right_turn_lanes) =
            side.swapped((arm.left_turn_lanes, arm.right_turn_lanes));
        Arm {
            bearing_deg: side.bearing_deg(arm.bearing_deg),
            lanes_in: arm.lanes_in,
            lanes_out: arm.lanes_out,
            left_turn_lanes,
            right_turn_lanes,
            left_storage_m: None,
            right_storage_m: None,
            speed_mps: mph_to_mps(arm.speed_mph),
            length_m: arm.length_m,
            inflow_vph: 0.0,
            counted: None,
            turns: turns.map(|turns| if side.is_right() { turns } else { turns.mirrored() }),
        }
    };
    let mut arms: Vec<Arm> = intersection.arms.iter().zip(&intersection.turns).map(of).collect();
    arms.sort_by(|a, b| a.bearing_deg.total_cmp(&b.bearing_deg));
    IntersectionSpec { point: intersection.id.clone(), arms, side }
}
