//! Turn lanes that are shorter than their street: the pieces that an incoming street consists of.
//!
//! The piece at the signal has all lanes and is as long as the shortest bay. Upstream of it the bay's lanes are missing, and
//! its neighbour leads into them. With bays of two lengths there are three pieces.
//!
//! Choices:
//! - **A bay that is nearly as long as the street** ([`LEAST_PIECE_M`]) is none.
//! - **One lane at least** goes on upstream, also where the bays would take all lanes: those that go straight on as well at
//!   the stop line, or else a lane of the longer bay.

use osm_signals::Turn;
use serde::{Deserialize, Serialize};

use super::intersection::{Arm, IntersectionSpec};
use super::lanes::turn_only_lanes;
use crate::family::approaches::LEAST_PIECE_M;
use crate::junction::incoming_edge;

/// Id of the signal and of its node.
pub const SIGNAL: &str = "c";

/// A piece of an incoming street.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// Id of its edge.
    pub edge: String,
    /// Id of the node that it begins at.
    pub from: String,
    /// Id of the node that it leads to.
    pub to: String,
    /// Lanes.
    pub lanes: u32,
    /// Lanes at the signal to the right of its rightmost one.
    pub right: u32,
    /// Length, metres.
    pub length_m: f64,
    /// From its beginning to the stop line, metres.
    pub begins_m: f64,
}

/// Turn lanes that are shorter than their street.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Storage {
    /// Of the left-turn lanes, metres; absent where they are as long as the street.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_m: Option<f64>,
    /// Of the right-turn lanes, metres.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub right_m: Option<f64>,
}

impl Storage {
    /// Returns the bays of an arm; `None` without any.
    pub fn of(arm: &Arm) -> Option<Self> {
        let bay = |storage_m: Option<f64>, lanes: u32| {
            storage_m.filter(|m| lanes > 0 && m + LEAST_PIECE_M <= arm.length_m)
        };
        let left_m = bay(arm.left_storage_m, arm.left_turn_lanes);
        let right_m = bay(arm.right_storage_m, arm.right_turn_lanes);
        (left_m.is_some() || right_m.is_some()).then_some(Self { left_m, right_m })
    }

    /// Returns how long the lanes of a turn are, metres.
    pub fn of_turn(&self, turn: Turn) -> Option<f64> {
        match turn {
            Turn::Left => self.left_m,
            Turn::Right => self.right_m,
            Turn::Through => None,
        }
    }
}

/// Returns the bays of an arm to the left and to the right, which leave one lane at least: length, metres, and lanes.
fn bays(spec: &IntersectionSpec, index: usize) -> [(f64, u32); 2] {
    let arm = &spec.arms[index];
    let storage = Storage::of(arm);
    let bay = |turn: Turn, lanes: u32| {
        let length_m = storage.and_then(|s| s.of_turn(turn));
        length_m.map_or((0.0, 0), |length_m| (length_m, lanes))
    };
    let mut left = bay(Turn::Left, arm.left_turn_lanes);
    let mut right = bay(Turn::Right, arm.right_turn_lanes);
    if left.1 + right.1 >= arm.lanes_in {
        let [left_only, right_only] = turn_only_lanes(spec, index);
        (left.1, right.1) = (left.1.min(left_only), right.1.min(right_only));
        if left.1 + right.1 == arm.lanes_in {
            let some = [&mut right, &mut left].into_iter().filter(|bay| bay.1 > 0);
            if let Some(longer) = some.max_by(|a, b| a.0.total_cmp(&b.0)) {
                longer.1 -= 1;
            }
        }
    }
    [left, right]
}

/// Returns the pieces of the street of an arm that leads to the signal, from the signal on; none without lanes to it.
pub fn pieces(spec: &IntersectionSpec, index: usize) -> Vec<Piece> {
    let arm = &spec.arms[index];
    if arm.lanes_in == 0 {
        return Vec::new();
    }
    let bays = bays(spec, index);
    let mut ends_m: Vec<f64> = bays.iter().filter(|bay| bay.1 > 0).map(|bay| bay.0).collect();
    ends_m.sort_by(f64::total_cmp);
    ends_m.dedup();
    let edges = [incoming_edge(index), format!("up{index}"), format!("far{index}")];
    let nodes = [SIGNAL.to_owned(), format!("b{index}"), format!("m{index}")];
    let mut pieces = Vec::new();
    let mut to_m = 0.0;
    for (k, edge) in edges.into_iter().take(ends_m.len() + 1).enumerate() {
        let begins_m = ends_m.get(k).copied().unwrap_or(arm.length_m);
        let [left, right] = bays.map(|(length_m, lanes)| if length_m <= to_m { lanes } else { 0 });
        pieces.push(Piece {
            edge,
            from: nodes
                .get(k + 1)
                .filter(|_| k < ends_m.len())
                .cloned()
                .unwrap_or(format!("n{index}")),
            to: nodes[k].clone(),
            lanes: arm.lanes_in - left - right,
            right,
            length_m: begins_m - to_m,
            begins_m,
        });
        to_m = begins_m;
    }
    pieces
}

/// Returns the ways of lanes from a piece to the next one towards the signal.
pub fn ways(from: &Piece, to: &Piece) -> Vec<(u32, u32)> {
    let first = from.right - to.right;
    let last = from.lanes - 1;
    let opened_right = (0..first).map(|lane| (0, lane));
    let straight = (0..from.lanes).map(|lane| (lane, lane + first));
    let opened_left = (last + first + 1..to.lanes).map(|lane| (last, lane));
    opened_right.chain(straight).chain(opened_left).collect()
}

#[cfg(test)]
mod tests {
    use super::super::movements::shapes::{cross, tee};
    use super::*;

    fn street(lanes: [u32; 3], storage_m: [Option<f64>; 2]) -> Vec<Piece> {
        let mut spec = cross();
        let arm = &mut spec.arms[0];
        [arm.lanes_in, arm.left_turn_lanes, arm.right_turn_lanes] = lanes;
        [arm.left_storage_m, arm.right_storage_m] = storage_m;
        pieces(&spec, 0)
    }

    fn shape(pieces: &[Piece]) -> Vec<(&str, u32, u32, f64)> {
        pieces.iter().map(|p| (p.edge.as_str(), p.lanes, p.right, p.length_m)).collect()
    }

    #[test]
    fn a_street_without_bays_is_one_piece() {
        let whole = street([4, 1, 1], [None, None]);
        assert_eq!(shape(&whole), [("in0", 4, 0, 200.0)]);
        assert_eq!((whole[0].from.as_str(), whole[0].to.as_str()), ("n0", "c"));
        assert_eq!(shape(&street([4, 1, 1], [Some(190.0), None])), [("in0", 4, 0, 200.0)]);
        assert_eq!(
            shape(&street([4, 0, 1], [Some(90.0), None])),
            [("in0", 4, 0, 200.0)],
            "no lanes"
        );
    }

    #[test]
    fn bays_of_two_lengths_make_three_pieces() {
        let pieces = street([5, 2, 1], [Some(80.0), Some(30.0)]);
        let expected = [("in0", 5, 0, 30.0), ("up0", 4, 1, 50.0), ("far0", 2, 1, 120.0)];
        assert_eq!(shape(&pieces), expected);
        assert_eq!(ways(&pieces[1], &pieces[0]), [(0, 0), (0, 1), (1, 2), (2, 3), (3, 4)]);
        assert_eq!(ways(&pieces[2], &pieces[1]), [(0, 0), (1, 1), (1, 2), (1, 3)]);
    }

    #[test]
    fn where_all_lanes_turn_one_goes_on() {
        // The right lane goes straight on as well.
        let pieces = street([2, 1, 1], [Some(40.0), Some(40.0)]);
        assert_eq!(shape(&pieces), [("in0", 2, 0, 40.0), ("up0", 1, 0, 160.0)]);
        assert_eq!(ways(&pieces[1], &pieces[0]), [(0, 0), (0, 1)]);
    }

    /// A stem, whose vehicles turn left or right.
    fn stem(lanes: [u32; 3], storage_m: [Option<f64>; 2]) -> Vec<Piece> {
        let mut spec = tee();
        let arm = &mut spec.arms[1];
        [arm.lanes_in, arm.left_turn_lanes, arm.right_turn_lanes] = lanes;
        [arm.left_storage_m, arm.right_storage_m] = storage_m;
        pieces(&spec, 1)
    }

    #[test]
    fn where_nobody_goes_straight_on_a_lane_of_the_longer_bay_goes_on() {
        let right_longer = stem([2, 1, 1], [Some(45.0), Some(90.0)]);
        assert_eq!(shape(&right_longer), [("in1", 2, 0, 45.0), ("up1", 1, 0, 155.0)]);
        let left_longer = stem([2, 1, 1], [Some(90.0), Some(45.0)]);
        assert_eq!(shape(&left_longer), [("in1", 2, 0, 45.0), ("up1", 1, 1, 155.0)]);
        let double = stem([3, 2, 1], [Some(90.0), Some(45.0)]);
        let expected = [("in1", 3, 0, 45.0), ("up1", 2, 1, 45.0), ("far1", 1, 1, 110.0)];
        assert_eq!(shape(&double), expected);
    }

    #[test]
    fn ways_lead_to_lanes_that_exist_and_every_lane_is_reached() {
        let lengths = [40.0, 80.0].map(Some);
        for lanes in [[2, 1, 1], [3, 2, 1], [3, 1, 2]] {
            for storage_m in [[lengths[0], lengths[1]], [lengths[1], lengths[0]], [lengths[0]; 2]] {
                for pieces in [street(lanes, storage_m), stem(lanes, storage_m)] {
                    for pair in pieces.windows(2) {
                        let ways = ways(&pair[1], &pair[0]);
                        let mut reached: Vec<u32> = ways.iter().map(|way| way.1).collect();
                        reached.sort_unstable();
                        let all: Vec<u32> = (0..pair[0].lanes).collect();
                        assert_eq!(reached, all, "{lanes:?} {storage_m:?}: {pieces:?}");
                        assert!(ways.iter().all(|way| way.0 < pair[1].lanes), "{pieces:?}");
                    }
                }
            }
        }
    }
}
