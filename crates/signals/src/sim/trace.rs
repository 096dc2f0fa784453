//! What [`Topology`] adds to a scene, and which signal's lane a vehicle upstream belongs to.
//!
//! The rule, for a vehicle on a lane of a signal: it is on that lane. For one on a piece of street
//! upstream, its **route** decides:
//! - It counts at the next signal on its route, if the piece was traced from that signal, and there on
//!   a lane from which its connection starts. So a vehicle that will turn off before the signal, or
//!   ends there, counts nowhere, and no vehicle counts twice.
//! - A connection is a link index at the signal and the edges that it leads from and to: one index may steer
//!   several turns.
//! - SUMO plans the lanes of a route, and most often a connection starts from one lane alone. If it
//!   starts from several, that lane is taken to which the piece leads the shortest way; if the piece
//!   leads to none of them, because the vehicle must change lanes first, the first one.

use std::collections::HashMap;

use super::topology::{Lead, Topology, edge};
use super::{Link, Piece, Scene};

/// Farthest that the street before a stop line begins behind another signal for the two to be coordinated, metres: half a mile.
///
/// Source: MUTCD (2009), section 4D.01: signals within half a mile of one another along a major route should be coordinated.
const COORDINATED_M: f64 = 804.67;

/// Signal, link index there, and number of the first link of that index between the same edges.
type Connection = (u32, u32, u32);

/// Which lanes to watch and what they belong to.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Tracing {
    /// Lanes of the scene; they come first among those that are watched.
    lanes: usize,
    /// Ids of the pieces upstream, watched after the lanes of the scene.
    pub(super) pieces: Vec<String>,
    /// Signal of each lane.
    signals: Vec<u32>,
    /// Lane of the scene by piece, signal and connection.
    owners: Vec<HashMap<Connection, u32>>,
}

impl Tracing {
    /// Traces the lanes of a scene: adds to it the lengths of links, the lanes downstream, the pieces
    /// upstream and the widths of streets.
    pub fn new(scene: &mut Scene, topology: &Topology, reach_m: f64) -> Self {
        let place: Vec<Option<usize>> =
            scene.lanes.iter().map(|lane| topology.position(&lane.id)).collect();
        let index: HashMap<usize, usize> =
            place.iter().enumerate().filter_map(|(i, p)| p.map(|p| (p, i))).collect();
        describe_links(scene, topology, &place, &index, reach_m);
        describe_widths(scene, topology, &place);

        let mut tracing = Self { lanes: scene.lanes.len(), ..Self::default() };
        tracing.signals = vec![0; scene.lanes.len()];
        for (number, signal) in (0..).zip(&scene.signals) {
            signal.links.iter().flatten().for_each(|l| tracing.signals[l.from_lane] = number);
        }
        // Per piece, the lanes that it leads to, with changes of lane and distance.
        let mut numbers: HashMap<usize, usize> = HashMap::new();
        let mut leads: Vec<Vec<Lead>> = Vec::new();
        for (lane, place) in place.iter().enumerate() {
            let upstream = place.map(|place| topology.upstream(place, reach_m));
            for (changes, beyond_m, piece) in upstream.into_iter().flatten() {
                let street = &topology.lanes[piece];
                let number = *numbers.entry(piece).or_insert_with(|| {
                    tracing.pieces.push(street.id.clone());
                    leads.push(Vec::new());
                    leads.len() - 1
                });
                leads[number].push((changes, beyond_m, lane));
                if !street.inner {
                    scene.lanes[lane].pieces.push(Piece {
                        id: street.id.clone(),
                        length_m: street.length_m,
                        beyond_m,
                    });
                }
            }
        }
        tracing.owners = leads.iter().map(|leads| owners(scene, &tracing.signals, leads)).collect();
        tracing
    }

    /// Returns the lane of the scene to which a vehicle belongs and its link index at the signal
    /// there, if it uses one; `None` for a vehicle upstream that comes to none of the lanes.
    /// * `watched` — number of the lane that it is on, the scene's first, then the pieces.
    /// * `next` — its connection at the next signal on its route.
    pub fn attribute(&self, watched: u32, next: Option<Connection>) -> Option<(u32, Option<u32>)> {
        match (watched as usize).checked_sub(self.lanes) {
            None => {
                let signal = self.signals[watched as usize];
                Some((watched, next.filter(|n| n.0 == signal).map(|n| n.1)))
            }
            Some(piece) => {
                let next = next?;
                self.owners[piece].get(&next).map(|lane| (*lane, Some(next.1)))
            }
        }
    }
}

fn describe_links(
    scene: &mut Scene,
    topology: &Topology,
    place: &[Option<usize>],
    index: &HashMap<usize, usize>,
    reach_m: f64,
) {
    for link in scene.signals.iter_mut().flat_map(|s| s.links.iter_mut().flatten()) {
        let Some(to) = topology.position(&link.to_lane) else { continue };
        link.downstream =
            topology.downstream(to, reach_m).iter().filter_map(|l| index.get(l).copied()).collect();
        link.downstream.sort_unstable();
        let from = place[link.from_lane].map(|from| &topology.lanes[from]);
        if let Some(way) = from.and_then(|from| from.ways.iter().find(|way| way.to == to)) {
            link.length_m = topology.way_length_m(way);
        }
        let next = topology.next_stop_lines(to, COORDINATED_M).into_iter();
        link.onward = next
            .filter_map(|(lane, beyond_m)| Some((*index.get(&lane)?, link.length_m + beyond_m)))
            .collect();
    }
}

fn describe_widths(scene: &mut Scene, topology: &Topology, place: &[Option<usize>]) {
    for signal in &scene.signals {
        let mut incoming: Vec<usize> = signal.links.iter().flatten().map(|l| l.from_lane).collect();
        incoming.sort_unstable();
        incoming.dedup();
        let ways = incoming.iter().filter_map(|l| place[*l]).flat_map(|l| &topology.lanes[l].ways);
        let exits: Vec<usize> = ways.map(|way| way.to).collect();
        for lane in incoming {
            if let Some(place) = place[lane] {
                (scene.lanes[lane].street_width_m, scene.lanes[lane].plain_lanes) =
                    topology.street_width_m(place, &exits);
            }
        }
    }
}

/// Returns the edges that a link leads from and to.
fn edges<'a>(scene: &'a Scene, link: &'a Link) -> (&'a str, &'a str) {
    (edge(&scene.lanes[link.from_lane].id), edge(&link.to_lane))
}

/// Returns the lane by connection for vehicles on a piece that leads to some lanes.
fn owners(scene: &Scene, signals: &[u32], leads: &[Lead]) -> HashMap<Connection, u32> {
    let mut owners: HashMap<Connection, Lead> = HashMap::new();
    for lead in leads {
        let signal = signals[lead.2];
        for (index, links) in (0..).zip(&scene.signals[signal as usize].links) {
            for link in links.iter().filter(|link| link.from_lane == lead.2) {
                let same = |(_, other): &(u32, &Link)| edges(scene, other) == edges(scene, link);
                let first = (0..).zip(links).find(same).expect("the link itself is one");
                let best = owners.entry((signal, index, first.0)).or_insert(*lead);
                if lead < best {
                    *best = *lead;
                }
            }
        }
    }
    owners.into_iter().map(|(key, (_, _, lane))| (key, lane as u32)).collect()
}

#[cfg(test)]
mod tests {
    use super::super::topology::testing::topology;
    use super::super::{Direction, Lane, Link, SignalInfo};
    use super::*;

    /// A street of two lanes whose second edge has a third, for left turns; the connection 0 is
    /// the left turn, 1 straight on from both other lanes. It forks after the signal.
    fn scene() -> (Scene, Topology) {
        let topology = topology(
            &[
                ("a_0", 80.0),
                ("a_1", 80.0),
                ("b_0", 40.0),
                ("b_1", 40.0),
                ("b_2", 40.0),
                ("x_0", 70.0),
                ("y_0", 9.0),
                ("z_0", 60.0),
            ],
            &[
                ("a_0", "b_0", 's', false),
                ("a_1", "b_1", 's', false),
                ("b_0", "x_0", 's', true),
                ("b_1", "x_0", 's', true),
                ("b_2", "y_0", 'l', true),
                ("x_0", "z_0", 's', false),
                ("z_0", "y_0", 's', true),
            ],
        );
        let lane = |id: &str, length_m| Lane { id: id.into(), length_m, ..Lane::default() };
        let link = |from_lane, to: &str| Link::new(from_lane, to, Direction::Straight);
        let signal = |id: &str, links| SignalInfo { id: id.into(), links, ..SignalInfo::default() };
        let scene = Scene {
            lanes: vec![lane("b_0", 40.0), lane("b_1", 40.0), lane("b_2", 40.0), lane("z_0", 60.0)],
            signals: vec![
                signal("s", vec![vec![link(2, "y_0")], vec![link(0, "x_0"), link(1, "x_0")]]),
                signal("t", vec![vec![link(3, "y_0")]]),
            ],
        };
        (scene, topology)
    }

    fn traced(reach_m: f64) -> (Scene, Tracing) {
        let (mut scene, topology) = scene();
        let tracing = Tracing::new(&mut scene, &topology, reach_m);
        (scene, tracing)
    }

    fn on(tracing: &Tracing, piece: &str, next: Option<(u32, u32)>) -> Option<u32> {
        let number = tracing.pieces.iter().position(|p| p == piece).unwrap() + tracing.lanes;
        let connection = next.map(|(signal, link)| (signal, link, 0));
        tracing.attribute(number as u32, connection).map(|(lane, link)| {
            assert_eq!(link, next.map(|n| n.1));
            lane
        })
    }

    #[test]
    fn where_several_lanes_share_a_connection_the_lane_ahead_is_taken() {
        let (_, tracing) = traced(200.0);
        assert_eq!(on(&tracing, "a_0", Some((0, 1))), Some(0));
        assert_eq!(on(&tracing, "a_1", Some((0, 1))), Some(1));
    }

    #[test]
    fn where_one_link_index_steers_two_turns_the_turn_decides() {
        let (mut scene, topology) = scene();
        // The left turn from lane 2, straight on from lanes 0 and 1.
        let others = scene.signals[0].links.remove(1);
        scene.signals[0].links[0].extend(others);
        let tracing = Tracing::new(&mut scene, &topology, 200.0);
        let piece = |id| (tracing.pieces.iter().position(|p| p == id).unwrap() + 4) as u32;
        let lane = |id, way| tracing.attribute(piece(id), Some((0, 0, way)));
        assert_eq!(lane("a_0", 0), Some((2, Some(0))));
        assert_eq!([lane("a_0", 1), lane("a_1", 1)], [Some((0, Some(0))), Some((1, Some(0)))]);
    }

    #[test]
    fn a_vehicle_that_does_not_come_to_the_signal_belongs_to_no_lane() {
        let (_, tracing) = traced(200.0);
        assert_eq!(on(&tracing, "a_0", None), None);
        assert_eq!(on(&tracing, "a_0", Some((1, 0))), None);
        assert_eq!(on(&tracing, "x_0", Some((1, 0))), Some(3));
    }

    #[test]
    fn links_know_their_length_and_the_lanes_that_they_lead_to() {
        let (scene, _) = traced(200.0);
        let link = &scene.signals[0].links[1][0];
        assert_eq!((link.length_m, link.downstream.as_slice()), (2.0, &[3][..]));
        assert_eq!(traced(50.0).0.signals[0].links[1][0].downstream, [0; 0]);
        let pieces: Vec<&str> = scene.lanes[0].pieces.iter().map(|p| p.id.as_str()).collect();
        assert_eq!(pieces, ["a_0", "a_1"]);
        assert_eq!(scene.lanes[2].pieces.len(), 2);
        let (_, plain) = traced(0.0);
        assert!(plain.pieces.is_empty());
        // On a lane of a signal it belongs to that, whatever its route.
        assert_eq!(plain.attribute(1, Some((0, 1, 0))), Some((1, Some(1))));
        assert_eq!(plain.attribute(1, Some((1, 0, 0))), Some((1, None)));
    }
}
