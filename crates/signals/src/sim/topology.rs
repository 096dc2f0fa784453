//! The lanes of a network, how cars get from one to the next, and tracing along them.
//!
//! A street is often split into edges: where its speed or number of lanes changes, where a driveway
//! leaves it, or a metre before the stop line. What a detector sees and what a vehicle runs into do
//! not end there, so lanes are traced through nodes without a signal:
//! - **Through what**: a way from one lane to the next is followed unless the lane that it leaves is
//!   *signalled*, that is, a signal controls some way of it; and unless it turns back.
//! - **Upstream** from a stop line to the pieces that end within the reach. All lanes for cars of an
//!   edge are pieces as soon as one is: a vehicle beside may yet change lanes.
//! - **Downstream** from a junction, to the signalled lanes that begin within the reach.

use std::collections::{BTreeMap, HashMap};

use osm_signals::angle::{normalise_degrees, turn_degrees};

use super::Direction;
use crate::vocabulary::DEFAULT_LANE_WIDTH_M;

/// Largest angle between the way into a junction and the opposite of the way out of it for which the
/// two are one street, degrees.
const SAME_ARM_DEG: f64 = 30.0;

/// Narrowest median; what is less is how a network was drawn, metres.
const LEAST_MEDIAN_M: f64 = 0.5;

/// A lane of the network.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StreetLane {
    /// SUMO's lane id.
    pub id: String,
    /// Length, metres.
    pub length_m: f64,
    /// Width, metres.
    pub width_m: f64,
    /// Whether passenger cars may use it.
    pub cars: bool,
    /// Whether it is for pedestrians alone.
    pub foot: bool,
    /// Whether it lies within a junction.
    pub inner: bool,
    /// Its middle line, metres to the east and to the north.
    pub shape: Vec<[f64; 2]>,
    /// Ways for cars from its end; none of a lane within a junction.
    pub ways: Vec<Way>,
}

/// A way through a junction, from the end of a lane to the next lane.
#[derive(Debug, Clone, PartialEq)]
pub struct Way {
    /// Index of the lane that it leads to.
    pub to: usize,
    /// Indices of the lanes within the junction.
    pub inner: Vec<usize>,
    /// SUMO's direction, if it gives one.
    pub direction: Option<Direction>,
    /// Whether some signal controls it.
    pub controlled: bool,
}

/// Changes of lane that the way from a lane to a stop line takes at least, the shortest such way, metres, and an index of a
/// lane.
pub(super) type Lead = (u32, f64, usize);

/// The lanes of a network.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Topology {
    /// All lanes.
    pub lanes: Vec<StreetLane>,
    by_id: HashMap<String, usize>,
    /// Lanes by edge, without those within junctions.
    edges: HashMap<String, Vec<usize>>,
    /// Per lane, where ways to it begin: lane and number of the way there.
    sources: Vec<Vec<(usize, usize)>>,
}

impl Topology {
    /// Returns the topology of these lanes.
    pub fn new(lanes: Vec<StreetLane>) -> Self {
        let by_id = lanes.iter().enumerate().map(|(i, l)| (l.id.clone(), i)).collect();
        let mut edges: HashMap<String, Vec<usize>> = HashMap::new();
        let mut sources = vec![Vec::new(); lanes.len()];
        for (index, lane) in lanes.iter().enumerate() {
            if !lane.inner {
                edges.entry(edge(&lane.id).to_owned()).or_default().push(index);
            }
            for (number, way) in lane.ways.iter().enumerate() {
                sources[way.to].push((index, number));
            }
        }
        Self { lanes, by_id, edges, sources }
    }

    /// Returns the index of a lane.
    pub fn position(&self, id: &str) -> Option<usize> {
        self.by_id.get(id).copied()
    }

    /// Returns the lanes of an edge.
    pub fn edge(&self, edge: &str) -> &[usize] {
        self.edges.get(edge).map_or(&[], Vec::as_slice)
    }

    /// Whether a signal controls some way of the lane.
    fn signalled(&self, lane: usize) -> bool {
        self.lanes[lane].ways.iter().any(|way| way.controlled)
    }

    /// Returns the length of a way through a junction, metres.
    pub fn way_length_m(&self, way: &Way) -> f64 {
        way.inner.iter().map(|lane| self.lanes[*lane].length_m).sum()
    }

    /// Returns the lanes upstream of a stop line that end within `reach_m` of it, the nearest first.
    pub(super) fn upstream(&self, stop_lane: usize, reach_m: f64) -> Vec<Lead> {
        let mut found: BTreeMap<usize, (u32, f64)> = BTreeMap::new();
        let stop_edge = self.edge(edge(&self.lanes[stop_lane].id));
        let start = |lane: &usize| (*lane, u32::from(*lane != stop_lane), 0.0);
        let mut open: Vec<_> = stop_edge.iter().map(start).collect();
        while let Some((lane, changes, beyond_m)) = open.pop() {
            let start_m = beyond_m + self.lanes[lane].length_m;
            for &(from, number) in &self.sources[lane] {
                let way = &self.lanes[from].ways[number];
                if start_m >= reach_m || self.signalled(from) || way.turns_back() {
                    continue;
                }
                let mut end_m = start_m;
                for inner in way.inner.iter().rev() {
                    closer(&mut found, *inner, (changes, end_m), reach_m);
                    end_m += self.lanes[*inner].length_m;
                }
                for &beside in self.edge(edge(&self.lanes[from].id)) {
                    if !self.lanes[beside].cars || self.signalled(beside) {
                        continue;
                    }
                    let changes = changes + u32::from(beside != from);
                    if closer(&mut found, beside, (changes, end_m), reach_m) {
                        open.push((beside, changes, end_m));
                    }
                }
            }
        }
        let piece = |(lane, (changes, beyond_m))| (changes, beyond_m, lane);
        let mut pieces: Vec<Lead> = found.into_iter().map(piece).collect();
        pieces.sort_by(|a, b| a.1.total_cmp(&b.1));
        pieces
    }

    /// Returns the signalled lanes that vehicles on a lane come to next, of those that begin within
    /// `reach_m` of this lane's start, in ascending order.
    pub fn downstream(&self, lane: usize, reach_m: f64) -> Vec<usize> {
        self.next_stop_lines(lane, reach_m).into_keys().collect()
    }

    /// Returns the lanes of [`Self::downstream`], with the way from the start of this lane to their stop lines, metres.
    pub fn next_stop_lines(&self, lane: usize, reach_m: f64) -> BTreeMap<usize, f64> {
        let mut found = BTreeMap::from([(lane, (0, 0.0))]);
        let mut open = vec![(lane, 0.0)];
        while let Some((lane, start_m)) = open.pop() {
            if self.signalled(lane) {
                continue;
            }
            for way in self.lanes[lane].ways.iter().filter(|way| !way.turns_back()) {
                let next_m = start_m + self.lanes[lane].length_m + self.way_length_m(way);
                if closer(&mut found, way.to, (0, next_m), reach_m) {
                    open.push((way.to, next_m));
                }
            }
        }
        let signalled = found.into_iter().filter(|(lane, _)| self.signalled(*lane));
        signalled.map(|(lane, (_, start_m))| (lane, start_m + self.lanes[lane].length_m)).collect()
    }

    /// Returns the width of the street at a stop line, metres: all lanes of the edge but those for
    /// pedestrians alone, and those of the edge that leaves the junction beside it, if there is one, with the
    /// median between the two. That is the edge that leads back within 30 degrees; of several the one that begins
    /// nearest. Beside it: how many of these lanes have SUMO's width.
    /// * `stop_lane` — a lane at the stop line.
    /// * `exits` — lanes that leave the junction.
    pub fn street_width_m(&self, stop_lane: usize, exits: &[usize]) -> (f64, u32) {
        let lane = &self.lanes[stop_lane];
        let (mut width_m, mut plain) = self.edge_width_m(&lane.id);
        let (Some(end), Some(heading)) = (lane.shape.last(), lane.end_heading_deg()) else {
            return (width_m, plain);
        };
        let beside = exits
            .iter()
            .map(|exit| &self.lanes[*exit])
            .filter(|exit| {
                let turn = |h| turn_degrees(normalise_degrees(heading + 180.0), h).abs();
                exit.start_heading_deg().is_some_and(|h| turn(h) <= SAME_ARM_DEG)
            })
            .min_by(|a, b| distance(a.shape[0], *end).total_cmp(&distance(b.shape[0], *end)));
        if let Some(exit) = beside {
            let (exit_m, exit_plain) = self.edge_width_m(&exit.id);
            width_m += exit_m + self.median_m(&lane.id, &exit.id, heading);
            plain += exit_plain;
        }
        (width_m, plain)
    }

    fn edge_width_m(&self, lane_id: &str) -> (f64, u32) {
        let is_plain = |lane: &&StreetLane| (lane.width_m - DEFAULT_LANE_WIDTH_M).abs() < 1e-6;
        let plain = self.carriageway(lane_id).filter(is_plain).count();
        (self.carriageway(lane_id).map(|lane| lane.width_m).sum(), plain as u32)
    }

    /// Returns the lanes of the edge of a lane but those for pedestrians alone.
    fn carriageway(&self, lane_id: &str) -> impl Iterator<Item = &StreetLane> {
        let lanes = self.edge(edge(lane_id)).iter().map(|lane| &self.lanes[*lane]);
        lanes.filter(|lane| !lane.foot)
    }

    /// Returns what lies between the nearest lanes of two directions at a junction, metres; 0 for less than a
    /// kerb.
    fn median_m(&self, lane_in: &str, lane_out: &str, heading_deg: f64) -> f64 {
        let (sin, cos) = heading_deg.to_radians().sin_cos();
        let to_the_right = |point: &[f64; 2]| point[0] * cos - point[1] * sin;
        let ends =
            self.carriageway(lane_in).filter_map(|l| Some((l, to_the_right(l.shape.last()?))));
        let mut gap_m = f64::INFINITY;
        for (a, at) in ends {
            for b in self.carriageway(lane_out) {
                if let Some(start) = b.shape.first() {
                    let middles_m = (at - to_the_right(start)).abs();
                    gap_m = gap_m.min(middles_m - (a.width_m + b.width_m) / 2.0);
                }
            }
        }
        if gap_m.is_finite() && gap_m >= LEAST_MEDIAN_M { gap_m } else { 0.0 }
    }
}

impl StreetLane {
    /// Returns the direction of travel at its start, degrees clockwise from north.
    fn start_heading_deg(&self) -> Option<f64> {
        let (first, rest) = self.shape.split_first()?;
        rest.iter().find(|point| *point != first).map(|next| heading_deg(*first, *next))
    }

    /// Returns the direction of travel at its end, degrees clockwise from north.
    fn end_heading_deg(&self) -> Option<f64> {
        let (last, rest) = self.shape.split_last()?;
        rest.iter().rfind(|point| *point != last).map(|before| heading_deg(*before, *last))
    }
}

impl Way {
    fn turns_back(&self) -> bool {
        self.direction == Some(Direction::Turn)
    }
}

/// Returns the edge of a lane.
pub fn edge(lane_id: &str) -> &str {
    lane_id.rsplit_once('_').map_or(lane_id, |(edge, _)| edge)
}

/// Remembers the changes of lane and the distance of a lane if it is within reach and they are less
/// than what was known before.
fn closer(
    found: &mut BTreeMap<usize, (u32, f64)>,
    lane: usize,
    new: (u32, f64),
    reach_m: f64,
) -> bool {
    let better = new.1 < reach_m && found.get(&lane).is_none_or(|known| new < *known);
    if better {
        found.insert(lane, new);
    }
    better
}

fn heading_deg(from: [f64; 2], to: [f64; 2]) -> f64 {
    normalise_degrees((to[0] - from[0]).atan2(to[1] - from[1]).to_degrees())
}

fn distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

#[cfg(test)]
pub(super) mod testing {
    use super::*;

    /// Lanes of `(id, length)` and ways of `(from, to, direction, controlled)`; each way has a lane of
    /// 2 m within its junction.
    pub(in crate::sim) fn topology(
        lanes: &[(&str, f64)],
        ways: &[(&str, &str, char, bool)],
    ) -> Topology {
        let lane = |id: &str, length_m| StreetLane {
            id: id.into(),
            length_m,
            width_m: 3.0,
            cars: true,
            ..StreetLane::default()
        };
        let mut all: Vec<StreetLane> = lanes.iter().map(|(id, m)| lane(id, *m)).collect();
        let position = |id: &str| lanes.iter().position(|(l, _)| *l == id).expect("a lane");
        for (number, (from, to, letter, controlled)) in ways.iter().enumerate() {
            let inner = vec![all.len()];
            all.push(StreetLane { inner: true, ..lane(&format!(":{number}_0_0"), 2.0) });
            let direction = Direction::from_letter(*letter);
            let way = Way { to: position(to), inner, direction, controlled: *controlled };
            all[position(from)].ways.push(way);
        }
        Topology::new(all)
    }
}

#[cfg(test)]
mod tests {
    use super::testing::topology;
    use super::*;

    /// A street in three edges to a stop line, with a driveway that joins it, a signal before and
    /// a U-turn at the far end.
    fn street() -> Topology {
        topology(
            &[
                ("z_0", 90.0),
                ("a_0", 60.0),
                ("b_0", 50.0),
                ("c_0", 0.9),
                ("d_0", 30.0),
                ("x_0", 80.0),
            ],
            &[
                ("z_0", "a_0", 's', true),
                ("a_0", "b_0", 's', false),
                ("d_0", "b_0", 'r', false),
                ("b_0", "c_0", 's', false),
                ("c_0", "x_0", 's', true),
                ("x_0", "d_0", 't', false),
            ],
        )
    }

    fn upstream(topology: &Topology, lane: &str, reach_m: f64) -> Vec<(String, f64)> {
        let lane = topology.position(lane).unwrap();
        let pieces = topology.upstream(lane, reach_m);
        let name = |(_, beyond_m, lane): &Lead| (topology.lanes[*lane].id.clone(), *beyond_m);
        pieces.iter().map(name).filter(|(id, _)| !id.starts_with(':')).collect()
    }

    #[test]
    fn a_street_is_traced_up_to_the_signal_before() {
        let found = upstream(&street(), "c_0", 200.0);
        let expected = [("b_0", 2.9), ("a_0", 54.9), ("d_0", 54.9)];
        assert_eq!(found, expected.map(|(id, m)| (id.to_owned(), m)));
        // Lanes within a plain node are pieces, and those within a signal's junction are not.
        let street = street();
        let pieces = street.upstream(street.position("c_0").unwrap(), 200.0);
        let ids = pieces.iter().map(|p| street.lanes[p.2].id.as_str());
        let inner: Vec<&str> = ids.filter(|id| id.starts_with(':')).collect();
        assert_eq!(inner, [":3_0_0", ":1_0_0", ":2_0_0"]);
    }

    #[test]
    fn downstream_ends_at_the_next_signal_or_beyond_the_reach() {
        let street = street();
        let next = |lane: &str, reach_m| {
            street
                .downstream(street.position(lane).unwrap(), reach_m)
                .into_iter()
                .map(|lane| street.lanes[lane].id.as_str())
                .collect::<Vec<_>>()
        };
        assert_eq!(next("a_0", 200.0), ["c_0"]);
        assert_eq!(next("a_0", 100.0), [""; 0]);
        // A lane that is signalled itself begins at no distance; a U-turn leads nowhere.
        assert_eq!(next("c_0", 0.0), ["c_0"]);
        assert_eq!(next("x_0", 200.0), [""; 0]);
    }

    #[test]
    fn a_street_is_as_wide_as_its_lanes_in_both_directions_and_its_median_without_pavements() {
        let lane = |id: &str, foot: bool, shape: [[f64; 2]; 2]| StreetLane {
            id: id.into(),
            width_m: 3.0,
            cars: !foot,
            foot,
            shape: shape.to_vec(),
            ..StreetLane::default()
        };
        let lanes = vec![
            lane("in_0", true, [[-100.0, -9.0], [-10.0, -9.0]]),
            lane("in_1", false, [[-100.0, -6.0], [-10.0, -6.0]]),
            lane("in_2", false, [[-100.0, -3.0], [-10.0, -3.0]]),
            lane("out_0", false, [[-10.0, 3.0], [-100.0, 23.0]]),
            lane("far_0", false, [[-40.0, 3.0], [-100.0, 3.0]]),
            lane("on_0", false, [[10.0, -3.0], [100.0, -3.0]]),
        ];
        let topology = Topology::new(lanes);
        // Between the lanes whose middles are 6 m apart lie 3 m.
        assert_eq!(topology.street_width_m(1, &[5, 4, 3]), (12.0, 0));
        assert_eq!(topology.street_width_m(1, &[5]), (6.0, 0));
    }
}
