//! What is worth a look at an intersection, as it was read.

use super::angle::turn_degrees;
use super::arms::Arm;
use super::flags::Flag;
use super::intersections::Intersection;
use super::turn::Turns;

/// Angle between neighbouring arms below which they may be one, degrees.
const CLOSE_DEG: f64 = 25.0;

/// Number of arms from which on an intersection may be several.
const MANY_ARMS: usize = 5;

/// Lanes of an approach from which on they may be counted twice.
const MANY_LANES: u32 = 7;

/// Right-only lanes of an approach from which on a slip lane may be counted twice.
const MANY_RIGHT: u32 = 2;

/// Distance from its place in the signal list beyond which a match is doubtful, metres: more than a
/// junction is wide.
const FAR_M: f64 = 25.0;

/// Returns what is worth a look at an intersection.
pub fn flags(i: &Intersection) -> Vec<Flag> {
    let approaches = || i.arms.iter().zip(&i.turns).filter(|(arm, _)| arm.lanes_in > 0);
    let any = |is: &dyn Fn(&Arm, &Option<Turns>) -> bool| approaches().any(|(a, t)| is(a, t));
    let next = |index: usize| &i.arms[(index + 1) % i.arms.len()];
    let close = i.arms.iter().enumerate().any(|(index, arm)| {
        turn_degrees(arm.bearing_deg, next(index).bearing_deg).abs() < CLOSE_DEG
    });
    let flags = [
        (Flag::NoWayAcross, any(&|_, turns| turns.is_none())),
        (Flag::DrawnTwice, i.arms.iter().any(|arm| arm.drawn_twice)),
        (Flag::CloseArms, close),
        (Flag::ManyArms, i.arms.len() >= MANY_ARMS),
        (Flag::ManyLanes, any(&|arm, _| arm.lanes_in >= MANY_LANES)),
        (Flag::ManyRight, any(&|arm, _| arm.right_turn_lanes >= MANY_RIGHT)),
        (Flag::NotOnMap, i.signals.is_empty() && !i.flags.contains(&Flag::CrossingsOnly)),
        (Flag::FarFromList, i.list_distance_m.is_some_and(|metres| metres > FAR_M)),
        (Flag::Cut, any(&|arm, _| arm.cut)),
        (Flag::OtherLength, any(&|arm, _| arm.clamped && !arm.cut)),
    ];
    let applying = flags.into_iter().filter(|(_, applies)| *applies).map(|(flag, _)| flag);
    let mut all: Vec<Flag> = i.flags.iter().copied().chain(applying).collect();
    all.sort_unstable();
    all
}
