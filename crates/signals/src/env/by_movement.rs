//! What an episode is made of: how the vehicles of each movement fared, and how long its queue was.
//!
//! A movement is a way from one edge to another through a signal. It has the name that engineers give it, on the ground:
//! `NBL` are northbound vehicles that turn left. Turns are SUMO's; how they are named is in
//! [`vocabulary`](crate::vocabulary::movement_names).
//!
//! - **Delay** is that of the objective: time loss and departure delay, until the end for vehicles that have not arrived.
//! - **Stops** are SUMO's: how often a vehicle came below 0.1 m/s.
//! - **Green** is what the lights really showed its links, second by second: with the right of way (`G`) and yielding (`g`).
//! - **Lane group**: movements of an approach that share lanes, directly or through others (HCM, chapter 19).
//! - **Crosswalk**: those who cross the approach of a movement; see [`pedestrians`](super::pedestrians).
//! - **Queue** is the number of vehicles in the detection zone that have halted, on the lane of the movement that has most,
//!   at every decision. Movements that share a lane share its queue.

use std::collections::{BTreeMap, BTreeSet};

use osm_signals::angle::mirrored_deg;
use osm_signals::{DrivingSide, Turn};

use super::movements::turn_of;
use super::pedestrians::PedestrianTotals;
use crate::control::LaneObservation;
use crate::sim::topology::edge;
use crate::sim::tripinfo::Trip;
use crate::sim::{Link, Scene, SignalInfo};
use crate::vocabulary::{Heading, Light, listed_before, movement_names, on_side};

/// Edges from which and to which a vehicle drives.
pub type Way = (String, String);

/// Returns the way of every vehicle of an episode by its id, given the seed.
pub type Ways = Box<dyn Fn(u64) -> BTreeMap<String, Way>>;

/// How the vehicles of a movement fared in an episode.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MovementTotals {
    /// Edge from which they come.
    pub from: String,
    /// Edge to which they go.
    pub to: String,
    /// Its name on the ground.
    pub name: String,
    /// SUMO's id of its signal.
    pub signal: String,
    /// Its link indices at the signal.
    pub links: Vec<usize>,
    /// Vehicles that were to depart.
    pub vehicles: u32,
    /// Vehicles that had not arrived at the end.
    pub unfinished: u32,
    /// Sum of their delays, seconds.
    pub delay_s: f64,
    /// Sum of their stops.
    pub stops: f64,
    /// Vehicles in the queue at every decision.
    pub queue_veh: Vec<f64>,
    /// Names of the movements of its lane group, in the order of engineers.
    pub group: String,
    /// Lanes from which it can be made, and those of its lane group.
    pub lanes: [u32; 2],
    /// Length of its turn lanes where they are shorter than the street, metres.
    pub storage_m: Option<f64>,
    /// What its lights showed.
    pub lights: Lights,
    /// Those who cross its approach.
    pub crosswalk: PedestrianTotals,
}

/// What lights showed in an episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Lights {
    /// Seconds of green with the right of way.
    pub protected_s: u32,
    /// Seconds of green that yields.
    pub permissive_s: u32,
    /// How often green began.
    pub greens: u32,
    /// All seconds.
    pub seconds: u32,
}

impl Lights {
    /// Takes what is shown for some seconds.
    fn take(&mut self, light: Light, was: Light, seconds: u32) {
        self.seconds += seconds;
        match light {
            Light::Protected => self.protected_s += seconds,
            Light::Permissive => self.permissive_s += seconds,
            Light::Red => return,
        }
        self.greens += u32::from(was == Light::Red);
    }

    /// Adds those of another episode.
    pub fn add(&mut self, other: Self) {
        self.protected_s += other.protected_s;
        self.permissive_s += other.permissive_s;
        self.greens += other.greens;
        self.seconds += other.seconds;
    }
}

/// Turn lanes that are shorter than their street: edge at the signal, turn, and length in metres.
pub type Bays = Vec<(String, Turn, f64)>;

/// A movement of a scene, with what an episode has collected of it.
#[derive(Debug, Clone, PartialEq)]
struct Movement {
    /// All but its vehicles.
    totals: MovementTotals,
    /// Indices in [`Scene::lanes`].
    lanes: Vec<usize>,
    turn: Turn,
    /// What its lights showed last.
    was: Light,
}

/// Collects what an episode is made of.
#[derive(Debug, Clone, Default)]
pub(super) struct ByMovement {
    movements: Vec<Movement>,
}

impl ByMovement {
    /// Returns what collects the movements of a scene, which is that of right-hand traffic.
    pub(super) fn new(scene: &Scene, side: DrivingSide, bays: &Bays) -> Self {
        let of_signal = |signal| movements(scene, signal, side);
        let mut movements: Vec<Movement> = scene.signals.iter().flat_map(of_signal).collect();
        for movement in &mut movements {
            let is_own = |bay: &&(String, Turn, f64)| {
                bay.0 == movement.totals.from && bay.1 == movement.turn
            };
            movement.totals.storage_m = bays.iter().find(is_own).map(|bay| bay.2);
        }
        Self { movements }
    }

    /// Takes what a signal shows for some seconds.
    pub(super) fn show(&mut self, signal: &str, state: &str, seconds: u32) {
        let of_link =
            |link: &usize| state.as_bytes().get(*link).map(|c| Light::of_letter((*c).into()));
        for Movement { totals, was, .. } in &mut self.movements {
            if totals.signal == signal {
                let light = totals.links.iter().filter_map(of_link).max().unwrap_or(Light::Red);
                totals.lights.take(light, *was, seconds);
                *was = light;
            }
        }
    }

    /// Takes those who crossed an approach of a signal.
    pub(super) fn cross(&mut self, signal: &str, edge: &str, people: PedestrianTotals) {
        let all = self.movements.iter_mut().map(|movement| &mut movement.totals);
        all.filter(|t| t.signal == signal && t.from == edge).for_each(|t| t.crosswalk = people);
    }

    /// Takes the queues of a decision.
    ///
    /// # Arguments
    ///
    /// * `lanes` — shape `[lanes of the scene]`.
    pub(super) fn decide(&mut self, lanes: &[LaneObservation]) {
        for movement in &mut self.movements {
            let queues_veh = movement.lanes.iter().map(|lane| lanes[*lane].queue);
            movement.totals.queue_veh.push(queues_veh.fold(0.0, f64::max));
        }
    }

    /// Returns the totals of an episode: of all vehicles that pass a signal.
    pub(super) fn finish(
        &mut self,
        trips: &[Trip],
        ways: &BTreeMap<String, Way>,
    ) -> Vec<MovementTotals> {
        let movements = std::mem::take(&mut self.movements).into_iter();
        let mut totals: Vec<MovementTotals> = movements.map(|movement| movement.totals).collect();
        for trip in trips {
            let Some((from, to)) = ways.get(&trip.id) else { continue };
            let Some(total) = totals.iter_mut().find(|t| t.from == *from && t.to == *to) else {
                continue;
            };
            total.vehicles += 1;
            total.unfinished += u32::from(!trip.arrived);
            total.delay_s += trip.delay_s;
            total.stops += trip.stops;
        }
        totals
    }
}

/// Returns per link index of a signal the names of its movements.
pub(super) fn link_names(
    scene: &Scene,
    signal: &SignalInfo,
    side: DrivingSide,
) -> Vec<Vec<String>> {
    let all = movements(scene, signal, side);
    let of = |links: &Vec<Link>| {
        let mut names: Vec<String> = Vec::new();
        for link in links {
            let way = way(scene, link);
            let own = all.iter().find(|m| (&m.totals.from, &m.totals.to) == (&way.0, &way.1));
            let name = own.map(|m| m.totals.name.clone());
            names.extend(name.filter(|name| !names.contains(name)));
        }
        names
    };
    signal.links.iter().map(of).collect()
}

fn way(scene: &Scene, link: &Link) -> Way {
    (edge(&scene.lanes[link.from_lane].id).to_owned(), edge(&link.to_lane).to_owned())
}

fn movements(scene: &Scene, signal: &SignalInfo, side: DrivingSide) -> Vec<Movement> {
    let on_ground =
        |heading_deg: f64| if side.is_right() { heading_deg } else { mirrored_deg(heading_deg) };
    let mut found: Vec<(Movement, f64)> = Vec::new();
    for (index, link) in
        signal.links.iter().enumerate().flat_map(|(i, l)| l.iter().map(move |l| (i, l)))
    {
        let (lane, (from, to)) = (&scene.lanes[link.from_lane], way(scene, link));
        let known = found.iter().position(|(m, _)| (&m.totals.from, &m.totals.to) == (&from, &to));
        let known = known.unwrap_or_else(|| {
            let signal = signal.id.clone();
            let totals = MovementTotals { from, to, signal, ..MovementTotals::default() };
            let (lanes, turn) = (Vec::new(), turn_of(link.direction));
            let movement = Movement { totals, lanes, turn, was: Light::Red };
            found.push((movement, on_ground(lane.heading_deg)));
            found.len() - 1
        });
        let movement = &mut found[known].0;
        if !movement.lanes.contains(&link.from_lane) {
            movement.lanes.push(link.from_lane);
        }
        if !movement.totals.links.contains(&index) {
            movement.totals.links.push(index);
        }
    }
    let mut headings: BTreeMap<String, f64> = BTreeMap::new();
    for (movement, heading_deg) in &found {
        headings.entry(movement.totals.from.clone()).or_insert(*heading_deg);
    }
    let headings_deg: Vec<f64> = headings.values().copied().collect();
    let directions: BTreeMap<&String, Heading> =
        headings.keys().zip(Heading::of_approaches(&headings_deg)).collect();
    let ways = found.iter().map(|(m, _)| (directions[&m.totals.from], on_side(m.turn, side)));
    let names = movement_names(ways);
    let mut movements: Vec<Movement> = found.into_iter().map(|(movement, _)| movement).collect();
    movements.iter_mut().zip(names).for_each(|(movement, name)| movement.totals.name = name);
    movements.sort_by_key(|m| listed_before(&m.totals.name));
    group(&mut movements);
    movements
}

/// Gives movements their lane groups.
fn group(movements: &mut [Movement]) {
    for index in 0..movements.len() {
        let mut members = vec![index];
        let mut lanes: BTreeSet<usize> = movements[index].lanes.iter().copied().collect();
        while let Some(next) = (0..movements.len()).find(|other| {
            let m = &movements[*other];
            !members.contains(other) && m.lanes.iter().any(|lane| lanes.contains(lane))
        }) {
            members.push(next);
            lanes.extend(&movements[next].lanes);
        }
        members.sort_unstable();
        let names: Vec<&str> = members.iter().map(|m| movements[*m].totals.name.as_str()).collect();
        let (group, own) = (names.join(" "), movements[index].lanes.len());
        let totals = &mut movements[index].totals;
        (totals.group, totals.lanes) = (group, [own as u32, lanes.len() as u32]);
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::crossing;
    use super::*;

    fn scene() -> Scene {
        let mut scene =
            crossing(&[("n_0", 182.0, "rs"), ("n_1", 182.0, "l"), ("w_0", 85.0, "s")], &["GGGG"]);
        let to = ["west_0", "south_0", "east_0", "east_0"];
        for (links, to) in scene.signals[0].links.iter_mut().zip(to) {
            links[0] = Link { to_lane: to.to_owned(), ..links[0].clone() };
        }
        scene
    }

    fn names_of(scene: &Scene, signal: usize, side: DrivingSide) -> Vec<String> {
        movements(scene, &scene.signals[signal], side).into_iter().map(|m| m.totals.name).collect()
    }

    #[test]
    fn every_signal_of_a_scene_has_the_names_of_the_ground_that_it_has_alone() {
        let mut scene = scene();
        assert_eq!(names_of(&scene, 0, DrivingSide::Left), ["SBL", "SBT", "SBR", "WBT"]);
        // The second signal has an approach in the same quarter as one of the first, and one that needs eight directions.
        let mut lanes = scene.lanes.clone();
        lanes.iter_mut().for_each(|lane| lane.id = format!("far_{}", lane.id));
        lanes[2].heading_deg = 215.0;
        let mut second = scene.signals[0].clone();
        second.id = "second".to_owned();
        second.links.iter_mut().flatten().for_each(|link| {
            link.from_lane += scene.lanes.len();
            link.to_lane = format!("far_{}", link.to_lane);
        });
        scene.lanes.extend(lanes);
        scene.signals.push(second);
        let right = DrivingSide::Right;
        assert_eq!(names_of(&scene, 0, right), ["SBL", "SBT", "SBR", "EBT"]);
        assert_eq!(names_of(&scene, 1, right), ["SBL", "SBT", "SBR", "SWT"]);
    }

    #[test]
    fn movements_that_share_lanes_are_a_group_and_have_the_green_that_is_shown() {
        let bays = vec![("n".to_owned(), Turn::Left, 45.7), ("n".to_owned(), Turn::Right, 20.0)];
        let mut by_movement = ByMovement::new(&scene(), DrivingSide::Right, &bays);
        // Links: right and through of one lane, left of another one, and a through lane of the cross street.
        for (state, seconds) in [("GGgr", 20), ("yyyr", 4), ("rrrG", 30), ("rrrr", 1), ("rrGr", 5)]
        {
            by_movement.show("s", state, seconds);
            by_movement.show("another", "GGGG", seconds);
        }
        let totals = by_movement.finish(&[], &BTreeMap::new());
        let of = |name: &str| totals.iter().find(|t| t.name == name).unwrap();
        assert_eq!((of("SBT").group.as_str(), of("SBT").lanes), ("SBT SBR", [1, 1]));
        assert_eq!((of("SBL").group.as_str(), of("SBL").storage_m), ("SBL", Some(45.7)));
        assert_eq!((of("SBR").storage_m, of("EBT").storage_m), (Some(20.0), None));
        let left = Lights { protected_s: 5, permissive_s: 20, greens: 2, seconds: 60 };
        assert_eq!(of("SBL").lights, left);
    }

    #[test]
    fn vehicles_count_in_their_movement_and_queues_on_its_longest_lane() {
        let mut by_movement = ByMovement::new(&scene(), DrivingSide::Right, &Bays::new());
        let queue = |queue: f64| LaneObservation { queue, ..LaneObservation::default() };
        by_movement.decide(&[queue(3.0), queue(1.0), queue(0.0)]);
        by_movement.decide(&[queue(0.0), queue(4.0), queue(0.0)]);
        let trip = |id: &str, delay_s: f64, arrived: bool| Trip {
            id: id.to_owned(),
            delay_s,
            stops: 1.0,
            arrived,
        };
        let way = |to: &str| ("n".to_owned(), to.to_owned());
        let ways = BTreeMap::from([
            ("a".to_owned(), way("east")),
            ("b".to_owned(), way("east")),
            ("c".to_owned(), way("south")),
        ]);
        let trips = [
            trip("a", 10.0, true),
            trip("b", 30.0, false),
            trip("c", 5.0, true),
            trip("x", 9.0, true),
        ];
        let totals = by_movement.finish(&trips, &ways);
        let left = &totals[0];
        assert_eq!((left.vehicles, left.unfinished, left.delay_s, left.stops), (2, 1, 40.0, 2.0));
        assert_eq!(
            (&left.queue_veh[..], &totals[1].queue_veh[..]),
            (&[1.0, 4.0][..], &[3.0, 0.0][..])
        );
        assert_eq!(totals[1].vehicles, 1);
    }
}
