//! Which lane leads where: the connections of an intersection.
//!
//! Lanes count from the right, as in SUMO. Right-only lanes are the rightmost, left-only lanes the
//! leftmost, and the *shared* ones between them go through; the leftmost of these also turns left
//! if no lane is left-only or [`Arm::shared_left`] says so, the rightmost also right.
//!
//! Choices where the data is silent or contradicts itself:
//! - **Turn lanes for a turn that does not exist** are shared lanes.
//! - **Turn lanes that leave a movement without a lane** (say one right-only lane although a
//!   through exit exists): one lane of the larger group, the innermost, becomes shared.
//! - **No through exit**: shared lanes turn left on the left half and right on the right half, a
//!   middle lane both; if only one of the two turns has lanes of its own, they all take the other.
//! - **Several exits on one side** share the lanes of that side from left to right, without
//!   crossing.
//! - **Exits** get as many lanes as the widest movement into them, so that the lanes of one
//!   approach never merge within the junction.

use std::ops::Range;

use osm_signals::Turn;

use super::intersection::{Arm, IntersectionSpec};
use super::movements::movements;
use crate::junction::Movement;
use crate::network::error::NetworkError;

/// A lane of an incoming edge that leads to a lane of an outgoing edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Connection {
    /// The movement that it belongs to.
    pub movement: Movement,
    /// Lane of the incoming edge, counted from the right.
    pub from_lane: u32,
    /// Lane of the outgoing edge, counted from the right.
    pub to_lane: u32,
}

/// The movements of an intersection, laid out on lanes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LaneLayout {
    /// All movements, by arm and from left to right.
    pub movements: Vec<Movement>,
    /// All connections, by movement.
    pub connections: Vec<Connection>,
    /// Per arm the lanes that lead away; 0 where there is no exit.
    pub exit_lanes: Vec<u32>,
    /// Per arm the lanes from which only left turns are possible and meant.
    pub left_only_lanes: Vec<u32>,
}

/// Lanes of one approach by turn, counted from the right; a lane may serve several turns.
#[derive(Debug, Clone, PartialEq, Eq)]
struct LaneUse {
    left: Range<u32>,
    through: Range<u32>,
    right: Range<u32>,
    left_only: u32,
    right_only: u32,
}

/// Returns the movements of an intersection and the lanes that they use.
/// Fails as [`movements`].
pub fn layout(spec: &IntersectionSpec) -> Result<LaneLayout, NetworkError> {
    let movements = movements(spec)?;
    let uses: Vec<LaneUse> =
        spec.arms.iter().enumerate().map(|(i, arm)| lane_use_of(arm, i, &movements)).collect();
    let lanes: Vec<Range<u32>> = movements
        .iter()
        .map(|m| {
            let same: Vec<_> =
                movements.iter().filter(|o| (o.from, o.turn) == (m.from, m.turn)).collect();
            let position = same.iter().position(|o| *o == m).expect("a movement is among its own");
            let lanes = match m.turn {
                Turn::Left => &uses[m.from].left,
                Turn::Through => &uses[m.from].through,
                Turn::Right => &uses[m.from].right,
            };
            share(lanes, position as u32, same.len() as u32)
        })
        .collect();
    let mut exit_lanes: Vec<u32> = spec.arms.iter().map(|a| a.lanes_out).collect();
    for (m, lanes) in movements.iter().zip(&lanes) {
        exit_lanes[m.to] = exit_lanes[m.to].max(lanes.len() as u32);
    }
    let mut connections = Vec::new();
    for (m, lanes) in movements.iter().zip(&lanes) {
        let first = first_exit_lane(m.turn, lanes, spec.arms[m.from].lanes_in, exit_lanes[m.to]);
        connections.extend(lanes.clone().zip(first..).map(|(from_lane, to_lane)| Connection {
            movement: *m,
            from_lane,
            to_lane,
        }));
    }
    // What shares a lane with the through movement has no green alone.
    let apart = |u: &LaneUse| u.through.is_empty() || u.left.start >= u.through.end;
    let left_only_lanes = uses.iter().map(|u| if apart(u) { u.left_only } else { 0 }).collect();
    Ok(LaneLayout { movements, connections, exit_lanes, left_only_lanes })
}

/// Returns per connection of a layout the link that netconvert gives it: by arm, clockwise from north, then by lane and by
/// exit from the right. In left-hand traffic, whose mirror image the layout is, arms count clockwise from south in it: on the
/// ground anticlockwise from south (south, east, north, west), then from the left.
///
/// Source: seen in SUMO 1.15 at all 282 intersections of Salt Lake City, in right-hand and in left-hand traffic.
pub fn link_order(spec: &IntersectionSpec, layout: &LaneLayout) -> Vec<usize> {
    let arms = spec.arms.len();
    let first = |arm: usize| {
        let bearing_deg = spec.arms[arm].bearing_deg;
        if spec.side.is_right() { bearing_deg } else { (bearing_deg + 180.0) % 360.0 }
    };
    let mut order: Vec<usize> = (0..layout.connections.len()).collect();
    order.sort_by(|a, b| {
        let [a, b] = [a, b].map(|c| &layout.connections[*c]);
        let rank = |c: &Connection| {
            let around = (c.movement.to + arms - c.movement.from) % arms;
            (c.from_lane, arms - around, c.to_lane)
        };
        let [from_a, from_b] = [a, b].map(|c| first(c.movement.from));
        from_a.total_cmp(&from_b).then_with(|| rank(a).cmp(&rank(b)))
    });
    let mut links = vec![0; order.len()];
    order.iter().enumerate().for_each(|(link, connection)| links[*connection] = link);
    links
}

/// Whether an approach turns left, and from no lane that goes through as well.
pub fn turns_left_from_its_own_lanes(layout: &LaneLayout, arm: usize) -> bool {
    let lanes = |turn| {
        let own = move |c: &&Connection| c.movement.from == arm && c.movement.turn == turn;
        layout.connections.iter().filter(own).map(|c| c.from_lane)
    };
    let mut left = lanes(Turn::Left).peekable();
    left.peek().is_some() && left.all(|lane| lanes(Turn::Through).all(|other| other != lane))
}

/// Returns how many lanes of an arm turn left alone and right alone; none where the intersection has no movements.
pub fn turn_only_lanes(spec: &IntersectionSpec, arm: usize) -> [u32; 2] {
    let movements = movements(spec).unwrap_or_default();
    let LaneUse { left_only, right_only, .. } = lane_use_of(&spec.arms[arm], arm, &movements);
    [left_only, right_only]
}

fn lane_use_of(arm: &Arm, index: usize, movements: &[Movement]) -> LaneUse {
    let has = |turn| movements.iter().any(|m| m.from == index && m.turn == turn);
    lane_use(arm, has(Turn::Left), has(Turn::Through), has(Turn::Right))
}

/// Distributes the lanes of an approach over the turns that exist.
fn lane_use(arm: &Arm, left: bool, through: bool, right: bool) -> LaneUse {
    let lanes = arm.lanes_in;
    let mut right_only = if right { arm.right_turn_lanes.min(lanes) } else { 0 };
    let mut left_only = if left { arm.left_turn_lanes.min(lanes - right_only) } else { 0 };
    let homeless = through || (left && left_only == 0) || (right && right_only == 0);
    if lanes > 0 && right_only + left_only == lanes && homeless {
        if right_only >= left_only {
            right_only -= 1;
        } else {
            left_only -= 1;
        }
    }
    let shared = right_only..lanes - left_only;
    let half = shared.len() as u32 / 2;
    let (own_left, own_right) = (left_only > 0, right_only > 0);
    let (left_from, right_to) = if through {
        (shared.end - u32::from(left && !own_left), shared.start + u32::from(right && !own_right))
    } else if left && right && own_left == own_right {
        (shared.start + half, shared.end - half)
    } else if left && (!right || own_right) {
        (shared.start, shared.start)
    } else {
        (shared.end, shared.end)
    };
    let one_of = |is: bool| u32::from(is && !shared.is_empty());
    let left_from = left_from.min(shared.end - one_of(arm.shared_left && own_left));
    let right_to = right_to.max(shared.start + one_of(arm.shared_right && own_right));
    LaneUse {
        left: if left { left_from.min(lanes)..lanes } else { lanes..lanes },
        through: if through { shared } else { lanes..lanes },
        right: if right { 0..right_to } else { 0..0 },
        left_only,
        right_only,
    }
}

/// Returns the share of lanes of the exit at a position from the left among several exits; lanes
/// at a boundary serve both sides, so that every exit has one.
fn share(lanes: &Range<u32>, position: u32, exits: u32) -> Range<u32> {
    let count = lanes.len() as u32;
    let (from_left, to_left) = (position * count / exits, ((position + 1) * count).div_ceil(exits));
    lanes.end - to_left..lanes.end - from_left
}

/// Returns the exit lane of the rightmost of the lanes of a movement.
fn first_exit_lane(turn: Turn, lanes: &Range<u32>, lanes_in: u32, exit_lanes: u32) -> u32 {
    let leftmost = exit_lanes - lanes.len() as u32;
    match turn {
        Turn::Left => leftmost,
        Turn::Right => 0,
        // Opposite arms share the centre line, so a lane keeps its number from the left.
        Turn::Through => leftmost.saturating_sub(lanes_in - lanes.end),
    }
}

#[cfg(test)]
mod tests {
    use osm_signals::Turns;

    use super::super::movements::shapes::{cross, star, tee, wye};
    use super::*;

    /// Lanes of arm 0 from the right, each with the turns that it allows.
    fn lanes(spec: &IntersectionSpec) -> Vec<String> {
        let layout = layout(spec).unwrap();
        let letters = |lane: u32| {
            let mut text = String::new();
            for (turn, letter) in [(Turn::Left, 'l'), (Turn::Through, 's'), (Turn::Right, 'r')] {
                let serves = |c: &&Connection| {
                    c.movement.from == 0 && c.movement.turn == turn && c.from_lane == lane
                };
                text.extend(std::iter::repeat_n(
                    letter,
                    layout.connections.iter().filter(serves).count(),
                ));
            }
            text
        };
        (0..spec.arms[0].lanes_in).map(letters).collect()
    }

    fn with(mut spec: IntersectionSpec, lanes: [u32; 3], named: Option<&str>) -> IntersectionSpec {
        let arm = &mut spec.arms[0];
        [arm.lanes_in, arm.left_turn_lanes, arm.right_turn_lanes] = lanes;
        arm.turns = named.map(|n| Turns {
            left: n.contains('l'),
            through: n.contains('s'),
            right: n.contains('r'),
        });
        spec
    }

    #[test]
    fn lanes_serve_the_turns_that_exist_turn_lanes_outermost() {
        for (spec, arm, named, expected) in [
            (cross(), [3, 0, 0], None, &["sr", "s", "ls"][..]),
            (cross(), [4, 1, 1], None, &["r", "s", "s", "l"]),
            // A lane for a turn that does not exist is shared.
            (cross(), [2, 1, 0], Some("sr"), &["sr", "s"]),
            // The last turn lane also goes through if no other lane does.
            (cross(), [2, 1, 1], None, &["sr", "l"]),
            (cross(), [1, 1, 0], None, &["lsr"]),
            // Lanes of a stem split, or take the turn that has none of its own.
            (wye(), [2, 0, 0], None, &["r", "l"]),
            (wye(), [3, 0, 0], None, &["r", "lr", "l"]),
            (wye(), [3, 1, 0], None, &["r", "r", "l"]),
            (wye(), [3, 0, 1], None, &["r", "l", "l"]),
            (wye(), [2, 1, 0], Some("r"), &["r", "r"]),
            (wye(), [2, 0, 2], Some("r"), &["r", "r"]),
        ] {
            assert_eq!(lanes(&with(spec, arm, named)), expected, "{arm:?}");
        }
    }

    #[test]
    fn two_left_exits_share_two_left_lanes_without_crossing() {
        let layout = layout(&with(star(5), [3, 2, 0], None)).unwrap();
        let left: Vec<_> = layout
            .connections
            .iter()
            .filter(|c| c.movement.from == 0 && c.movement.turn == Turn::Left)
            .map(|c| (c.movement.to, c.from_lane))
            .collect();
        assert_eq!(left, [(1, 2), (2, 1)]);
    }

    #[test]
    fn an_exit_is_wide_enough_for_the_lanes_that_lead_to_it() {
        let layout = layout(&with(cross(), [4, 0, 0], None)).unwrap();
        assert_eq!(layout.exit_lanes, [2, 2, 4, 2]);
    }

    #[test]
    fn through_lanes_keep_their_place_from_the_centre_line() {
        let mut spec = with(cross(), [3, 1, 0], None);
        spec.arms[2].lanes_out = 3;
        let connections = layout(&spec).unwrap().connections;
        let through: Vec<_> = connections
            .iter()
            .filter(|c| c.movement.from == 0 && c.movement.turn == Turn::Through)
            .map(|c| (c.from_lane, c.to_lane))
            .collect();
        assert_eq!(through, [(0, 0), (1, 1)]);
    }

    #[test]
    fn left_turns_end_in_the_leftmost_lane_and_right_turns_in_the_rightmost() {
        let connections = layout(&tee()).unwrap().connections;
        let stem: Vec<_> =
            connections.iter().filter(|c| c.movement.from == 1).map(|c| c.to_lane).collect();
        assert_eq!(stem, [1, 0]);
    }
}
