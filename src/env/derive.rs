//! Derives movements and phases from a network's own links and signal programs.
//!
//! Users of the peers write these by hand for each signal; here they follow from what SUMO knows:
//! the links' directions, the lanes' headings and the programs' states.
//!
//! Source: RESCO's signal configuration (`config/signal_config.py`), whose hand-written phase pairs
//! the derived ones equal on Ingolstadt.

use std::collections::BTreeMap;

use crate::control::{LaneSpec, Movement, Phase, Service, SignalSpec, Turn};
use crate::error::SimError;
use crate::family::scenario::{Actions, SignalSettings};
use crate::sim::topology::edge;
use crate::sim::{Direction, Program, Scene, SignalInfo};
use crate::timing::Timing;
use crate::units::{normalise_degrees, turn_degrees};

use super::limits::{limits, timing};

/// Program that generated networks carry beside netconvert's default one: the phases to choose
/// from.
pub const PHASES_PROGRAM: &str = "phases";

/// Headings of the four slots of RESCO's movement order: S, W, N, E.
const SLOT_HEADINGS_DEG: [f64; 4] = [180.0, 270.0, 0.0, 90.0];

/// Half of the sector around north whose arms come first, degrees.
const NORTH_SECTOR_DEG: f64 = 45.0;

/// A signal's description for controllers and how its parts relate to the simulator's.
#[derive(Debug, Clone, PartialEq)]
pub struct DerivedSignal {
    /// What controllers see.
    pub spec: SignalSpec,
    /// Index in [`Scene::lanes`] per lane of the spec.
    pub lanes: Vec<usize>,
    /// Index in [`Scene::lanes`] per entry of the downstream queues.
    ///
    /// Deviation: RESCO subtracts the queues of all lanes that lead to the neighbour from the same
    /// side; here only of the lanes to which a link leads, through nodes without a signal and within
    /// the detection distance.
    pub downstream: Vec<usize>,
    /// Link indices of every movement of the spec.
    pub movement_links: Vec<Vec<usize>>,
    /// Greens of the program that runs by default, in its order.
    pub own_greens: Vec<String>,
    /// How long greens may and must be shown.
    pub timing: Timing,
}

/// Derives one signal of a scene: its lanes, movements, phases and their limits.
///
/// The phases are the greens of the program that runs by default, or with [`Actions::AllPairs`] those
/// of the program [`PHASES_PROGRAM`], where the network has it.
///
/// # Errors
///
/// [`SimError::Signal`] when it has no vehicle lane or no green phase.
pub fn derive(
    scene: &Scene,
    signal: &SignalInfo,
    settings: &SignalSettings,
) -> Result<DerivedSignal, SimError> {
    let fail = |reason: &str| SimError::Signal { signal: signal.id.clone(), reason: reason.into() };
    let slots = approach_slots(scene, signal);
    if slots.is_empty() {
        return Err(fail("it controls no vehicle lane; remove it from the network"));
    }
    let raw = raw_movements(scene, signal, &slots);

    // Lanes in the order in which they first appear in the movements, as RESCO lists them.
    let mut lanes: Vec<usize> = Vec::new();
    let mut downstream: Vec<usize> = Vec::new();
    let mut movements = Vec::new();
    let position = |list: &mut Vec<usize>, lane: usize| {
        list.iter().position(|l| *l == lane).unwrap_or_else(|| {
            list.push(lane);
            list.len() - 1
        })
    };
    for (index, movement) in &raw {
        movements.push(Movement {
            index: *index,
            turn: [Turn::Right, Turn::Through, Turn::Left][index % 3],
            lanes: movement.lanes.iter().map(|l| position(&mut lanes, *l)).collect(),
            downstream: movement.downstream.iter().map(|l| position(&mut downstream, *l)).collect(),
            share: None,
        });
    }

    let program = |id: &str| signal.programs.iter().find(|p| p.id == id);
    let own = program(&signal.active_program).or(signal.programs.first());
    let own = own.ok_or_else(|| fail("it has no program; add a tlLogic"))?;
    let pairs = program(PHASES_PROGRAM).filter(|_| settings.actions == Actions::AllPairs);
    let states = greens(pairs.unwrap_or(own));
    if states.is_empty() {
        return Err(fail("no phase of its program is green without yellow; check its tlLogic"));
    }
    let timing = timing(scene, signal, settings);
    let limits = limits(&timing, &states);
    let phases = states.into_iter().map(|state| phase(state, &raw, &movements)).collect();
    let spec = SignalSpec {
        id: signal.id.clone(),
        lanes: lanes
            .iter()
            .map(|l| LaneSpec {
                id: scene.lanes[*l].id.clone(),
                length_m: scene.lanes[*l].length_m,
            })
            .collect(),
        movements,
        phases,
        limits,
    };
    let movement_links = raw.into_values().map(|movement| movement.links).collect();
    Ok(DerivedSignal { spec, lanes, downstream, movement_links, own_greens: greens(own), timing })
}

/// Returns the distinct green states of a program in their order: some link is green, none yellow.
///
/// Source: RESCO, multi_signal.py and its first public version.
pub fn greens(program: &Program) -> Vec<String> {
    let mut states: Vec<String> = Vec::new();
    for phase in &program.phases {
        let green = phase.state.contains(['G', 'g']) && !phase.state.contains(['y', 'Y', 'u']);
        if green && !states.contains(&phase.state) {
            states.push(phase.state.clone());
        }
    }
    states
}

/// A movement in the simulator's terms.
#[derive(Debug, Clone, Default, PartialEq)]
struct RawMovement {
    /// Indices in [`Scene::lanes`].
    lanes: Vec<usize>,
    /// Indices in [`Scene::lanes`] of other signals' lanes.
    downstream: Vec<usize>,
    /// Link indices of the signal.
    links: Vec<usize>,
}

/// Returns the slot of every approach, by the id of its edge.
fn approach_slots<'a>(scene: &'a Scene, signal: &SignalInfo) -> BTreeMap<&'a str, usize> {
    let mut headings: BTreeMap<&str, f64> = BTreeMap::new();
    for link in signal.links.iter().flatten() {
        let lane = &scene.lanes[link.from_lane];
        headings.entry(edge(&lane.id)).or_insert(lane.heading_deg);
    }
    // Clockwise by the bearing of the arm, which lies opposite to the heading. An arm just west
    // of north comes first, as if it were north.
    let bearing = |heading: f64| normalise_degrees(heading + 180.0 + NORTH_SECTOR_DEG);
    let mut order: Vec<(&str, f64)> = headings.into_iter().collect();
    order.sort_by(|a, b| bearing(a.1).total_cmp(&bearing(b.1)).then_with(|| a.0.cmp(b.0)));
    let slots = match order.len() {
        0..=4 => cardinal_slots(&order.iter().map(|(_, h)| *h).collect::<Vec<_>>()),
        n => (0..n).collect(),
    };
    order.into_iter().map(|(edge, _)| edge).zip(slots).collect()
}

/// Returns the assignment of up to four headings to distinct slots with the smallest sum of
/// squared angles.
fn cardinal_slots(headings: &[f64]) -> Vec<usize> {
    fn search(headings: &[f64], used: u8) -> (f64, Vec<usize>) {
        let Some((first, rest)) = headings.split_first() else { return (0.0, Vec::new()) };
        (0..4)
            .filter(|slot| used >> slot & 1 == 0)
            .map(|slot| {
                let (cost, mut slots) = search(rest, used | 1 << slot);
                slots.insert(0, slot);
                (cost + turn_degrees(SLOT_HEADINGS_DEG[slot], *first).powi(2), slots)
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .expect("there are at most as many headings as slots")
    }
    search(headings, 0).1
}

pub(super) fn turn_of(direction: Direction) -> Turn {
    match direction {
        Direction::Right | Direction::PartRight => Turn::Right,
        Direction::Straight => Turn::Through,
        Direction::Left | Direction::PartLeft | Direction::Turn => Turn::Left,
    }
}

fn raw_movements(
    scene: &Scene,
    signal: &SignalInfo,
    slots: &BTreeMap<&str, usize>,
) -> BTreeMap<usize, RawMovement> {
    let mut movements: BTreeMap<usize, RawMovement> = BTreeMap::new();
    for (index, links) in signal.links.iter().enumerate() {
        for link in links {
            let slot = slots[edge(&scene.lanes[link.from_lane].id)];
            let movement =
                movements.entry(3 * slot + turn_of(link.direction) as usize).or_default();
            let add = |list: &mut Vec<usize>, value: usize| {
                if !list.contains(&value) {
                    list.push(value);
                }
            };
            add(&mut movement.lanes, link.from_lane);
            add(&mut movement.links, index);
            for lane in &link.downstream {
                add(&mut movement.downstream, *lane);
            }
        }
    }
    for movement in movements.values_mut() {
        movement.lanes.sort_unstable();
        movement.downstream.sort_unstable();
    }
    movements
}

fn phase(state: String, raw: &BTreeMap<usize, RawMovement>, movements: &[Movement]) -> Phase {
    let letters: Vec<char> = state.chars().collect();
    let service: Vec<Service> = raw
        .values()
        .map(|movement| {
            let best = |link: &usize| match letters.get(*link) {
                Some('G') => Service::Protected,
                Some('g') => Service::Permissive,
                _ => Service::None,
            };
            movement.links.iter().map(best).max().unwrap_or(Service::None)
        })
        .collect();
    let pair = pair(&service, movements);
    Phase { state, pair, service }
}

/// Returns the one or two movements that a phase is named by: those with right of way, through
/// before left; a right turn only where there is nothing else, from the same approach if possible.
fn pair(service: &[Service], movements: &[Movement]) -> Vec<usize> {
    let rank = |m: &usize, first: Option<usize>| {
        let movement = &movements[*m];
        let same = first.is_none_or(|f| movements[f].approach() == movement.approach());
        (
            movement.turn == Turn::Right,
            service[*m] != Service::Protected,
            movement.turn == Turn::Right && !same,
            movement.turn == Turn::Left,
            movement.index,
        )
    };
    let served: Vec<usize> = (0..service.len()).filter(|m| service[*m] != Service::None).collect();
    let Some(first) = served.iter().copied().min_by_key(|m| rank(m, None)) else {
        return Vec::new();
    };
    // A second movement counts if it has right of way, or belongs to the first one's approach.
    let second = served
        .into_iter()
        .filter(|m| *m != first)
        .filter(|m| {
            service[*m] == Service::Protected
                || movements[*m].approach() == movements[first].approach()
        })
        .min_by_key(|m| rank(m, Some(first)));
    let mut pair: Vec<usize> = std::iter::once(first).chain(second).collect();
    pair.sort_unstable();
    pair
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sim::{Lane, Link, ProgramKind, ProgramPhase};

    const NO_LINKS: [(&str, f64, &str); 0] = [];

    /// A scene of one signal; one link per `(lane, heading, directions)` and direction letter.
    fn scene(lanes: &[(&str, f64, &str)], greens: &[&str]) -> Scene {
        let mut links = Vec::new();
        for (index, (_, _, directions)) in lanes.iter().enumerate() {
            for letter in directions.chars() {
                let direction = Direction::from_letter(letter).unwrap();
                links.push(vec![Link::new(index, "x_0", direction)]);
            }
        }
        let lane = |(id, heading_deg, _): &(&str, f64, &str)| Lane {
            id: (*id).into(),
            length_m: 100.0,
            speed_mps: 14.0,
            heading_deg: *heading_deg,
            ..Lane::default()
        };
        let phases = greens.iter().map(|g| ProgramPhase::fixed(*g, 30.0)).collect();
        let program = Program { id: "0".into(), kind: ProgramKind::Static, phases };
        Scene {
            lanes: lanes.iter().map(lane).collect(),
            signals: vec![SignalInfo {
                id: "s".into(),
                links,
                programs: vec![program],
                active_program: "0".into(),
            }],
        }
    }

    fn pairs(derived: &DerivedSignal) -> Vec<Vec<usize>> {
        let index = |m: &usize| derived.spec.movements[*m].index;
        derived.spec.phases.iter().map(|p| p.pair.iter().map(index).collect()).collect()
    }

    #[test]
    fn pairs_of_a_t_junction_are_resco_s_for_ingolstadt() {
        // The topology of RESCO's ingolstadt1: northbound through and left, eastbound right and
        // left, southbound right and through.
        let lanes = [
            ("north_1", 5.0, "s"),
            ("north_2", 5.0, "s"),
            ("north_3", 5.0, "l"),
            ("east_1", 95.0, "r"),
            ("east_2", 95.0, "l"),
            ("south_1", 184.0, "rs"),
            ("south_2", 184.0, "s"),
        ];
        let scene = scene(&lanes, &["GGgGrGGG", "GGGrrrrr", "rrrGGGrr"]);
        let derived = derive(&scene, &scene.signals[0], &SignalSettings::default()).unwrap();
        assert_eq!(pairs(&derived), [[1, 7], [7, 8], [9, 11]]);
    }

    #[test]
    fn lanes_are_listed_in_the_order_of_the_movements() {
        let lanes = [("n_0", 0.0, "s"), ("s_0", 180.0, "rs"), ("s_1", 180.0, "l")];
        let scene = scene(&lanes, &["GGGG"]);
        let derived = derive(&scene, &scene.signals[0], &SignalSettings::default()).unwrap();
        let ids: Vec<_> = derived.spec.lanes.iter().map(|l| l.id.as_str()).collect();
        assert_eq!(ids, ["s_0", "s_1", "n_0"]);
        let indices: Vec<_> = derived.spec.movements.iter().map(|m| m.index).collect();
        assert_eq!(indices, [0, 1, 2, 7]);
    }

    #[test]
    fn a_permissive_left_does_not_name_a_phase() {
        let lanes = [("n_0", 0.0, "sl"), ("s_0", 180.0, "sl")];
        let scene = scene(&lanes, &["GgGg"]);
        let derived = derive(&scene, &scene.signals[0], &SignalSettings::default()).unwrap();
        assert_eq!(pairs(&derived), [[1, 7]]);
        assert_eq!(derived.spec.phases[0].service[1], Service::Permissive);
    }

    #[test]
    fn five_arms_are_numbered_clockwise_from_north() {
        let lanes = [
            ("a_0", 180.0, "s"),
            ("b_0", 252.0, "s"),
            ("c_0", 324.0, "s"),
            ("d_0", 36.0, "s"),
            ("e_0", 108.0, "s"),
        ];
        let scene = scene(&lanes, &["Grrrr"]);
        let derived = derive(&scene, &scene.signals[0], &SignalSettings::default()).unwrap();
        let indices: Vec<_> = derived.spec.movements.iter().map(|m| m.index).collect();
        assert_eq!(indices, [1, 4, 7, 10, 13]);
        assert_eq!(derived.spec.lanes[4].id, "e_0");
    }

    #[test]
    fn a_signal_without_lanes_or_greens_is_refused() {
        let empty = scene(&NO_LINKS, &["G"]);
        assert!(derive(&empty, &empty.signals[0], &SignalSettings::default()).is_err());
        let red = scene(&[("n_0", 0.0, "s")], &["r", "y"]);
        assert!(derive(&red, &red.signals[0], &SignalSettings::default()).is_err());
    }
}
