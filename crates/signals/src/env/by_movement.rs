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
//! - **Queue** is the number of vehicles in the detection zone that have halted, on the lane of the movement that has most,
//!   at every decision. Movements that share a lane share its queue.

use std::collections::{BTreeMap, BTreeSet};

use osm_signals::angle::mirrored_deg;
use osm_signals::{DrivingSide, Turn};

use super::movements::turn_of;
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

/// A movement of a scene.
#[derive(Debug, Clone, PartialEq, Default)]
struct Movement {
    way: Way,
    name: String,
    signal: String,
    /// Link indices at the signal.
    links: Vec<usize>,
    /// Indices in [`Scene::lanes`].
    lanes: Vec<usize>,
    turn: Option<Turn>,
    /// Names of its lane group, and how many lanes that has.
    group: (String, u32),
    storage_m: Option<f64>,
}

/// Collects what an episode is made of.
#[derive(Debug, Clone, Default)]
pub(super) struct ByMovement {
    movements: Vec<Movement>,
    queues_veh: Vec<Vec<f64>>,
    lights: Vec<(Lights, Light)>,
}

impl ByMovement {
    /// Returns what collects the movements of a scene, which is that of right-hand traffic.
    pub(super) fn new(scene: &Scene, side: DrivingSide, bays: &Bays) -> Self {
        let of_signal = |signal| movements(scene, signal, side);
        let mut movements: Vec<Movement> = scene.signals.iter().flat_map(of_signal).collect();
        for movement in &mut movements {
            let own =
                bays.iter().find(|bay| bay.0 == movement.way.0 && Some(bay.1) == movement.turn);
            movement.storage_m = own.map(|bay| bay.2);
        }
        let queues_veh = vec![Vec::new(); movements.len()];
        let lights = vec![(Lights::default(), Light::Red); movements.len()];
        Self { movements, queues_veh, lights }
    }

    /// Takes what a signal shows for some seconds.
    pub(super) fn show(&mut self, signal: &str, state: &str, seconds: u32) {
        let of_link =
            |link: &usize| state.as_bytes().get(*link).map(|c| Light::of_letter((*c).into()));
        for (movement, (lights, was)) in self.movements.iter().zip(&mut self.lights) {
            if movement.signal == signal {
                let light = movement.links.iter().filter_map(of_link).max().unwrap_or(Light::Red);
                lights.take(light, *was, seconds);
                *was = light;
            }
        }
    }

    /// Takes the queues of a decision.
    ///
    /// # Arguments
    ///
    /// * `lanes` — shape `[lanes of the scene]`.
    pub(super) fn decide(&mut self, lanes: &[LaneObservation]) {
        for (movement, queue) in self.movements.iter().zip(&mut self.queues_veh) {
            queue.push(movement.lanes.iter().map(|lane| lanes[*lane].queue).fold(0.0, f64::max));
        }
    }

    /// Returns the totals of an episode: of all vehicles that pass a signal.
    pub(super) fn finish(
        &mut self,
        trips: &[Trip],
        ways: &BTreeMap<String, Way>,
    ) -> Vec<MovementTotals> {
        let lights = std::mem::take(&mut self.lights);
        let total =
            |((m, queue_veh), (lights, _)): ((&Movement, &mut Vec<f64>), (Lights, Light))| {
                MovementTotals {
                    from: m.way.0.clone(),
                    to: m.way.1.clone(),
                    name: m.name.clone(),
                    signal: m.signal.clone(),
                    links: m.links.clone(),
                    queue_veh: std::mem::take(queue_veh),
                    group: m.group.0.clone(),
                    lanes: [m.lanes.len() as u32, m.group.1],
                    storage_m: m.storage_m,
                    lights,
                    ..MovementTotals::default()
                }
            };
        let mut totals: Vec<MovementTotals> =
            self.movements.iter().zip(&mut self.queues_veh).zip(lights).map(total).collect();
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
            let name = all.iter().find(|m| m.way == way).map(|m| m.name.clone());
            names.extend(name.filter(|name| !names.contains(name)));
        }
        names
    };
    signal.links.iter().map(of).collect()
}

fn way(scene: &Scene, link: &Link) -> Way {
    (edge(&scene.lanes[link.from_lane].id).to_owned(), edge(&link.to_lane).to_owned())
}

/// Returns the movements of a signal.
fn movements(scene: &Scene, signal: &SignalInfo, side: DrivingSide) -> Vec<Movement> {
    let on_ground =
        |heading_deg: f64| if side.is_right() { heading_deg } else { mirrored_deg(heading_deg) };
    let mut found: Vec<(Movement, f64, Turn)> = Vec::new();
    for (index, link) in
        signal.links.iter().enumerate().flat_map(|(i, l)| l.iter().map(move |l| (i, l)))
    {
        let (lane, way) = (&scene.lanes[link.from_lane], way(scene, link));
        let known = found.iter().position(|(m, ..)| m.way == way);
        let known = known.unwrap_or_else(|| {
            let movement = Movement { way, signal: signal.id.clone(), ..Movement::default() };
            found.push((movement, on_ground(lane.heading_deg), turn_of(link.direction)));
            found.len() - 1
        });
        let movement = &mut found[known].0;
        if !movement.lanes.contains(&link.from_lane) {
            movement.lanes.push(link.from_lane);
        }
        if !movement.links.contains(&index) {
            movement.links.push(index);
        }
    }
    let mut headings: BTreeMap<String, f64> = BTreeMap::new();
    for (movement, heading_deg, _) in &found {
        headings.entry(movement.way.0.clone()).or_insert(*heading_deg);
    }
    let headings_deg: Vec<f64> = headings.values().copied().collect();
    let directions: BTreeMap<&String, Heading> =
        headings.keys().zip(Heading::of_approaches(&headings_deg)).collect();
    let ways = found.iter().map(|(m, _, turn)| (directions[&m.way.0], on_side(*turn, side)));
    let names = movement_names(ways);
    let mut movements: Vec<Movement> = found
        .into_iter()
        .zip(names)
        .map(|((movement, _, turn), name)| Movement { name, turn: Some(turn), ..movement })
        .collect();
    movements.sort_by_key(|m| listed_before(&m.name));
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
        let names: Vec<&str> = members.iter().map(|m| movements[*m].name.as_str()).collect();
        movements[index].group = (names.join(" "), lanes.len() as u32);
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
        movements(scene, &scene.signals[signal], side).into_iter().map(|m| m.name).collect()
    }

    fn names(side: DrivingSide) -> Vec<String> {
        names_of(&scene(), 0, side)
    }

    #[test]
    fn movements_have_the_names_of_the_ground() {
        assert_eq!(names(DrivingSide::Right), ["SBL", "SBT", "SBR", "EBT"]);
        assert_eq!(names(DrivingSide::Left), ["SBL", "SBT", "SBR", "WBT"]);
    }

    #[test]
    fn approaches_in_one_quarter_of_the_compass_have_eight_directions() {
        let mut scene = scene();
        scene.lanes[2].heading_deg = 215.0;
        assert_eq!(names_of(&scene, 0, DrivingSide::Right), ["SBL", "SBT", "SBR", "SWT"]);
    }

    #[test]
    fn every_signal_of_a_scene_has_the_names_that_it_has_alone() {
        let mut scene = scene();
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
        assert_eq!(
            of("EBT").lights,
            Lights { protected_s: 30, permissive_s: 0, greens: 1, seconds: 60 }
        );
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
