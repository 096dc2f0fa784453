//! The movements of an intersection and which of them conflict.
//!
//! A movement leads from one arm to another. Only geometry decides whether it is a left turn,
//! goes through or is a right turn ([`osm_signals::turn`]).
//!
//! Choices where implementations differ:
//! - **Named turns** ([`Arm::turns`]) only remove movements. Where they would remove all of an
//!   arm, the data contradicts the geometry and geometry wins.
//! - **Conflicts** are those of right-hand traffic on a circle: movements of different arms
//!   conflict if they end in the same arm or if their chords cross.

use osm_signals::turn::{self, Turn};

use super::intersection::{Arm, IntersectionSpec};
use crate::family::approaches::ARMS;
use crate::junction::Movement;
use crate::network::error::NetworkError;

/// Returns all movements, by arm and within an arm from the leftmost to the rightmost.
/// Fails with [`NetworkError::Intersection`] if the arms are too few, too many or not sorted by bearing, or
/// if an incoming arm has no exit.
pub fn movements(spec: &IntersectionSpec) -> Result<Vec<Movement>, NetworkError> {
    let fail =
        |reason: String| Err(NetworkError::Intersection { point: spec.point.clone(), reason });
    let arms = &spec.arms;
    if !ARMS.contains(&arms.len()) {
        let (low, high) = (ARMS.start(), ARMS.end());
        return fail(format!("{} arms; expected {low} to {high}", arms.len()));
    }
    if arms.windows(2).any(|w| w[0].bearing_deg >= w[1].bearing_deg) {
        return fail("arms are not sorted by bearing, or two have the same".to_owned());
    }
    let mut all = Vec::new();
    for from in (0..arms.len()).filter(|&i| arms[i].lanes_in > 0) {
        let mut exits = exits(arms, from);
        if exits.is_empty() {
            return fail(format!(
                "no way out for vehicles from arm {from}; give another arm an exit"
            ));
        }
        let named = |turn: Turn| arms[from].turns.is_none_or(|turns| turns.has(turn));
        if exits.iter().any(|m| named(m.turn)) {
            exits.retain(|m| named(m.turn));
        }
        all.extend(exits);
    }
    if all.is_empty() {
        return fail("no incoming lane; remove it".to_owned());
    }
    Ok(all)
}

/// Returns the arm whose through movement leads here, if ours leads there.
pub fn opposite(all: &[Movement], arm: usize) -> Option<usize> {
    let is_ahead = |m: &&Movement, from: usize| m.from == from && m.turn == Turn::Through;
    let ahead = |from: usize| all.iter().find(|m| is_ahead(m, from)).map(|m| m.to);
    ahead(arm).filter(|&other| ahead(other) == Some(arm))
}

/// Returns the movements that geometry allows from one arm, leftmost first.
pub(super) fn exits(arms: &[Arm], from: usize) -> Vec<Movement> {
    let others = arms.iter().enumerate().filter(|(to, arm)| *to != from && arm.lanes_out > 0);
    let exits = turn::exits(arms[from].bearing_deg, others.map(|(to, arm)| (to, arm.bearing_deg)));
    exits.into_iter().map(|(to, turn)| Movement { from, to, turn }).collect()
}

/// Intersections for the tests of this folder.
#[cfg(test)]
pub(crate) mod shapes {
    use super::super::intersection::{Arm, IntersectionSpec};

    /// Two-lane arms at these bearings.
    pub(crate) fn spec(bearings_deg: &[f64]) -> IntersectionSpec {
        let arm = |bearing_deg: &f64| Arm {
            bearing_deg: *bearing_deg,
            lanes_in: 2,
            lanes_out: 2,
            speed_mps: 13.41,
            length_m: 200.0,
            inflow_vph: 400.0,
            ..Arm::default()
        };
        let arms = bearings_deg.iter().map(arm).collect();
        IntersectionSpec { point: "p".into(), arms, ..IntersectionSpec::default() }
    }

    pub(crate) fn cross() -> IntersectionSpec {
        spec(&[0.0, 90.0, 180.0, 270.0])
    }

    pub(crate) fn tee() -> IntersectionSpec {
        spec(&[0.0, 90.0, 180.0])
    }

    pub(crate) fn wye() -> IntersectionSpec {
        spec(&[0.0, 120.0, 240.0])
    }

    pub(crate) fn star(arms: u32) -> IntersectionSpec {
        let step = 360.0 / f64::from(arms);
        spec(&(0..arms).map(|i| f64::from(i) * step).collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use osm_signals::Turns;

    use super::shapes::{cross, star, tee, wye};
    use super::*;

    /// Turns of one arm as letters with the arms that they lead to.
    fn turns(spec: &IntersectionSpec, from: usize) -> String {
        let letter = |m: &Movement| ['l', 's', 'r'][m.turn as usize];
        let all = movements(spec).unwrap();
        all.iter().filter(|m| m.from == from).map(|m| format!("{}{}", letter(m), m.to)).collect()
    }

    fn movement(from: usize, to: usize) -> Movement {
        *movements(&cross()).unwrap().iter().find(|m| (m.from, m.to) == (from, to)).unwrap()
    }

    #[test]
    fn turns_go_from_the_leftmost_exit_to_the_rightmost() {
        assert_eq!(turns(&cross(), 0), "l1s2r3", "from the north the south is through");
        assert_eq!(turns(&tee(), 1), "l2r0", "a stem has only left and right");
        assert_eq!(turns(&tee(), 2), "s0r1");
        assert_eq!(turns(&star(6), 2), "l3l4s5r0r1");
        assert_eq!(turns(&star(5), 0), "l1l2s3r4", "of two equally straight the right one");
        assert_eq!(turns(&star(5), 4), "l0l1s2r3");
        let mut one_way = cross();
        one_way.arms[2].lanes_out = 0;
        assert_eq!(turns(&one_way, 0), "l1r3");
    }

    #[test]
    fn named_turns_remove_the_others_unless_geometry_lacks_them() {
        let (mut cross, mut wye) = (cross(), wye());
        cross.arms[0].turns = Some(Turns { left: false, ..Turns::ALL });
        wye.arms[0].turns = Some(Turns { left: false, through: true, right: false });
        assert_eq!((turns(&cross, 0), turns(&wye, 0)), ("s2r3".into(), "l1r2".into()));
    }

    #[test]
    fn an_arm_without_an_exit_is_refused() {
        let mut s = cross();
        for arm in &mut s.arms[1..] {
            arm.lanes_out = 0;
        }
        let e = movements(&s).unwrap_err().to_string();
        assert_eq!(e, "p: no way out for vehicles from arm 0; give another arm an exit");
    }

    #[test]
    fn movements_conflict_that_cross_or_end_in_the_same_arm() {
        for (a, b, conflict, why) in [
            ((0, 2), (2, 0), false, "opposite through movements"),
            ((0, 1), (2, 3), false, "opposite lefts"),
            ((0, 1), (2, 0), true, "a left and the opposite through"),
            ((0, 2), (1, 3), true, "crossing through movements"),
            ((1, 3), (0, 2), true, "the same the other way"),
            ((0, 3), (1, 3), true, "into the same arm"),
            ((0, 3), (2, 0), false, "a right turn and the through that it leaves behind"),
        ] {
            let a = movement(a.0, a.1);
            assert_eq!(a.conflicts_with(&movement(b.0, b.1)), conflict, "{why}");
        }
    }
}
