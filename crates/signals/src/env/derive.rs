//! Derives movements and phases from a network's own links and signal programs.
//!
//! Users of the peers write these by hand for each signal; here they follow from what SUMO knows:
//! the links' directions, the lanes' headings and the programs' states.
//!
//! A green in which no link for vehicles is green, such as one for pedestrians alone, is no action: a
//! controller sees vehicles only, so it could not know when to choose it. What is made of the network's
//! own program has none either, so that all methods that replace it have the same time for vehicles; only the
//! own program itself shows it.
//!
//! Source: RESCO's signal configuration (`config/signal_config.py`), whose hand-written phase pairs
//! the derived ones equal on Ingolstadt.

use std::collections::BTreeSet;

use crate::control::{LaneSpec, Limits, Movement, Onward, Phase, SignalSpec};
use crate::settings::{Actions, SignalSettings};
use crate::sim::error::SimError;
use crate::sim::topology::edge;
use crate::sim::{Lane, Link, Program, ProgramKind, Scene, SignalInfo};
use crate::timing::{Approach, Timing, Way};
use crate::vocabulary::Light;

use super::movements::{RawMovement, raw_movements, turn_of};
use super::pairs::{Naming, names};

/// Program that generated networks carry beside netconvert's default one: the phases to choose
/// from.
pub const PHASES_PROGRAM: &str = "phases";

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
    /// Links of every movement of the spec, as index and number among the links of that index.
    pub movement_ways: Vec<Vec<(usize, usize)>>,
    /// Greens of the program that runs by default, in its order; one that comes twice in a cycle is there
    /// twice, one that serves no lane for cars is not.
    ///
    /// Deviation: RESCO's greens have those for pedestrians alone.
    pub own_greens: Vec<String>,
    /// Greens of the program with the phases that serve no vehicle and so are none.
    pub left_out: Vec<String>,
    /// By which movements the phases are named.
    pub naming: Naming,
    /// How far upstream each lane of the spec is seen, pieces included, metres; the detection distance
    /// may be less.
    pub seen_m: Vec<f64>,
    /// How long greens may and must be shown.
    pub timing: Timing,
    /// How SUMO advances the program that runs by default.
    pub own_kind: ProgramKind,
}

impl DerivedSignal {
    /// Whether its program shows cars one green only, so that there is nothing to decide.
    pub fn has_one_green(&self) -> bool {
        self.spec.phases.len() == 1 && self.own_greens.len() == 1
    }
}

/// Derives one signal of a scene: its lanes, movements, phases and their limits.
///
/// The phases are the greens of the program that runs by default, or with [`Actions::AllPairs`] those
/// of the program [`PHASES_PROGRAM`], where the network has it.
pub fn derive(
    scene: &Scene,
    signal: &SignalInfo,
    settings: &SignalSettings,
) -> Result<DerivedSignal, SimError> {
    let fail = |reason: &str| SimError::Signal { signal: signal.id.clone(), reason: reason.into() };
    if signal.links.iter().all(Vec::is_empty) {
        return Err(fail("it controls no vehicle lane; remove it from the network"));
    }
    let program = |id: &str| signal.programs.iter().find(|p| p.id == id);
    let own = program(&signal.active_program).or(signal.programs.first());
    let own = own.ok_or_else(|| fail("it has no program; add a tlLogic"))?;
    let mut timing = timing(scene, signal, settings);
    timing.close_crosswalks_without(&greens(own, &timing));
    let timing = timing;
    let pairs = program(PHASES_PROGRAM).filter(|_| settings.actions == Actions::AllPairs);
    let (states, left_out): (Vec<_>, Vec<_>) = greens(pairs.unwrap_or(own), &timing)
        .into_iter()
        .partition(|state| serves_vehicles(state, signal));
    let (states, left_out) = (distinct(states, signal), distinct(left_out, signal));
    let own_greens = covering(own, cycle(own, &timing, signal));
    if states.is_empty() || own_greens.is_empty() {
        return Err(fail(&format!(
            "no phase of its program {:?}, the one that runs at the start, is green for vehicles without yellow; check its \
             tlLogic",
            own.id
        )));
    }
    let raw = raw_movements(scene, signal, &states);

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
    for movement in &raw {
        movements.push(Movement {
            index: movement.index,
            turn: movement.turn,
            lanes: movement.lanes.iter().map(|l| position(&mut lanes, *l)).collect(),
            downstream: movement.downstream.iter().map(|l| position(&mut downstream, *l)).collect(),
            inner: Vec::new(),
            share: None,
        });
    }
    for movement in &mut movements {
        let own = |d: &usize| lanes.iter().position(|lane| *lane == downstream[*d]);
        movement.inner = movement.downstream.iter().filter_map(own).collect();
    }
    let services: Vec<Vec<Light>> = states.iter().map(|state| services(state, &raw)).collect();
    let (naming, pairs) = names(&services, &raw);
    // Only networks that were made with the setting have arrows by it.
    let arrows = program(PHASES_PROGRAM).is_some() && !timing.settings.left_turns.is_network();
    let limits = Limits { arrows, ..limits(&timing, &states, own) };
    let phases = states.into_iter().zip(pairs).zip(services);
    let lane = |lane: &usize| {
        let lane = &scene.lanes[*lane];
        LaneSpec { id: lane.id.clone(), length_m: lane.length_m }
    };
    let spec = SignalSpec {
        id: signal.id.clone(),
        lanes: lanes.iter().map(lane).collect(),
        movements,
        phases: phases.map(|((state, pair), service)| Phase { state, pair, service }).collect(),
        onward: Vec::new(),
        limits,
    };
    let seen_m = lanes.iter().map(|lane| seen_m(scene, *lane)).collect();
    let (movement_links, movement_ways) = raw.into_iter().map(|m| (m.links, m.ways)).unzip();
    Ok(DerivedSignal {
        spec,
        lanes,
        downstream,
        movement_links,
        movement_ways,
        own_greens,
        left_out,
        naming,
        seen_m,
        timing,
        own_kind: own.kind,
    })
}

/// Returns where the movements of a signal lead to: lanes of other signals, each once per movement, the shortest way.
pub(super) fn onward(scene: &Scene, signals: &[DerivedSignal], from: usize) -> Vec<Onward> {
    let mut found: Vec<Onward> = Vec::new();
    for (movement, ways) in signals[from].movement_ways.iter().enumerate() {
        for (index, number) in ways {
            let link = &scene.signals[from].links[*index][*number];
            for (place, distance_m) in &link.onward {
                for (signal, other) in signals.iter().enumerate().filter(|(i, _)| *i != from) {
                    let Some(lane) = other.lanes.iter().position(|l| l == place) else { continue };
                    let travel_s = distance_m / scene.lanes[*place].speed_mps.max(0.1);
                    let (distance_m, place) = (*distance_m, (movement, signal, lane));
                    let new = Onward { movement, signal, lane, distance_m, travel_s };
                    match found.iter_mut().find(|o| (o.movement, o.signal, o.lane) == place) {
                        Some(old) if new.distance_m < old.distance_m => *old = new,
                        Some(_) => {}
                        None => found.push(new),
                    }
                }
            }
        }
    }
    found
}

/// Returns the green states of a program in their order: some link is green, none yellow, and the program comes to them
/// from its first phase.
///
/// Deviation: an all-red in which links stay green that are so before and after is none; RESCO takes it
/// for a green.
///
/// Source: RESCO, multi_signal.py and its first public version.
pub(super) fn greens(program: &Program, timing: &Timing) -> Vec<String> {
    let phases = program.phases();
    timing.greens(&phases).into_iter().map(|i| phases[i].0.to_owned()).collect()
}

/// Returns the greens of a program that serve vehicles, in their order. Those that follow each other and are
/// [`alike`] are one, the last and the first too.
fn cycle(program: &Program, timing: &Timing, signal: &SignalInfo) -> Vec<String> {
    let mut states: Vec<String> = Vec::new();
    for state in greens(program, timing).into_iter().filter(|s| serves_vehicles(s, signal)) {
        let last = states.len().checked_sub(1).filter(|last| alike(&states[*last], &state, signal));
        join(&mut states, last, state);
    }
    if states.len() > 1 && alike(&states[0], &states[states.len() - 1], signal) {
        let last = states.pop().unwrap_or_default();
        join(&mut states, Some(0), last);
    }
    states
}

/// Returns the greens of a program that make a cycle: of one that does not run its phases one after the other, such
/// as a dual-ring one, as many as it takes to serve whatever it serves.
fn covering(program: &Program, mut greens: Vec<String>) -> Vec<String> {
    if program.kind != ProgramKind::Other {
        return greens;
    }
    let served = |greens: &[String]| -> BTreeSet<usize> {
        greens.iter().flat_map(|green| green.match_indices(['G', 'g']).map(|(i, _)| i)).collect()
    };
    let all = served(&greens);
    let enough = (1..greens.len()).find(|count| served(&greens[..*count]) == all);
    greens.truncate(enough.unwrap_or(greens.len()));
    greens
}

/// Returns states in the order in which they first appear, of those that are [`alike`] one: the actions to choose from.
fn distinct(states: Vec<String>, signal: &SignalInfo) -> Vec<String> {
    let mut once: Vec<String> = Vec::new();
    for state in states {
        let other = once.iter().position(|other| alike(other, &state, signal));
        join(&mut once, other, state);
    }
    once
}

/// Adds a state, to the one that it is like if there is one.
fn join(states: &mut Vec<String>, like: Option<usize>, state: String) {
    match like {
        Some(like) => states[like] = greener(std::mem::take(&mut states[like]), state),
        None => states.push(state),
    }
}

/// Whether two states are the same to vehicles, such as a green while pedestrians walk and the one while they clear the
/// crosswalk.
///
/// Deviation: RESCO has an action for each of them, between which it sees no difference.
fn alike(a: &str, b: &str, signal: &SignalInfo) -> bool {
    let of = |state: &str| -> Vec<char> {
        let letters = state.chars().zip(&signal.links);
        letters.filter(|(_, links)| !links.is_empty()).map(|(letter, _)| letter).collect()
    };
    a == b || serves_vehicles(a, signal) && of(a) == of(b)
}

/// Returns the one of two states that is green for more, the first of equals: the one in which pedestrians walk.
fn greener(a: String, b: String) -> String {
    let greens = |state: &str| state.matches(['G', 'g']).count();
    if greens(&b) > greens(&a) { b } else { a }
}

/// Whether a link for vehicles is green.
fn serves_vehicles(state: &str, signal: &SignalInfo) -> bool {
    state.chars().zip(&signal.links).any(|(c, links)| matches!(c, 'G' | 'g') && !links.is_empty())
}

/// Returns how a state serves each movement: as well as the best of the links that decide.
fn services(state: &str, raw: &[RawMovement]) -> Vec<Light> {
    let light = |link: &usize| state.chars().nth(*link).map_or(Light::Red, Light::of_letter);
    raw.iter().map(|m| m.deciding.iter().map(light).max().unwrap_or(Light::Red)).collect()
}

/// Returns how far upstream of its stop line a lane of a scene is seen, metres.
fn seen_m(scene: &Scene, lane: usize) -> f64 {
    let lane = &scene.lanes[lane];
    lane.pieces.iter().map(|p| p.beyond_m + p.length_m).fold(lane.length_m, f64::max)
}

/// Returns the incoming edges of a signal in the order of its approaches, that in which its links name them, with their first
/// lanes.
pub(super) fn approach_edges<'a>(
    scene: &'a Scene,
    signal: &SignalInfo,
) -> Vec<(&'a str, &'a Lane)> {
    let mut edges: Vec<(&str, &Lane)> = Vec::new();
    for link in signal.links.iter().flatten() {
        let lane = &scene.lanes[link.from_lane];
        if edges.iter().all(|(known, _)| *known != edge(&lane.id)) {
            edges.push((edge(&lane.id), lane));
        }
    }
    edges
}

/// Returns the approach of a lane.
pub(super) fn approach_of(edges: &[(&str, &Lane)], lane: &Lane) -> usize {
    let own = edges.iter().position(|(known, _)| *known == edge(&lane.id));
    own.expect("edges are those of all links")
}

/// Returns the limits of a signal: its approaches are its incoming edges.
fn timing(scene: &Scene, signal: &SignalInfo, settings: &SignalSettings) -> Timing {
    let edges = approach_edges(scene, signal);
    let approach = |(_, lane): &(&str, &Lane)| Approach {
        heading_deg: lane.heading_deg,
        width_m: lane.street_width_m,
        plain_lanes: lane.plain_lanes,
        speed_mps: lane.speed_mps,
    };
    let way = |link: &Link| {
        let approach = approach_of(&edges, &scene.lanes[link.from_lane]);
        Way { approach, turn: turn_of(link.direction) }
    };
    let links = signal.links.iter().map(|links| links.iter().map(way).collect()).collect();
    Timing::new(settings, edges.iter().map(approach).collect(), links)
}

/// Returns the limits of the phases as controllers see them.
fn limits(timing: &Timing, greens: &[String], own: &Program) -> Limits {
    let seconds = |time: u32| f64::from(time);
    let change = |from: &String, to: &String| {
        timing.change(from, to).map_or(0.0, |change| seconds(change.total_s()))
    };
    Limits {
        min_green_s: greens.iter().map(|g| seconds(timing.min_green_s(g))).collect(),
        needs: timing.needs(&greens.iter().map(String::as_str).collect::<Vec<_>>()),
        max_green_s: (greens.iter())
            .map(|g| timing.max_green_s(g).map_or(f64::INFINITY, seconds))
            .collect(),
        change_s: greens.iter().map(|a| greens.iter().map(|b| change(a, b)).collect()).collect(),
        min_cycle_s: seconds(timing.settings.min_cycle_s),
        max_cycle_s: seconds(timing.settings.max_cycle_s),
        own_program: own.kind == ProgramKind::Static && timing.keeps(&own.phases()),
        arrows: false,
    }
}

/// Puts the turning shares that the demand of a world says into a signal's movements; a movement of an
/// approach of which the demand says nothing has none.
pub(super) fn share_turns(
    spec: &mut SignalSpec,
    movement_ways: &[Vec<(usize, usize)>],
    (scene, signal): (&Scene, &SignalInfo),
    shares: &[(String, String, f64)],
) {
    for (movement, ways) in spec.movements.iter_mut().zip(movement_ways) {
        let links = || ways.iter().map(|(index, number)| &signal.links[*index][*number]);
        let comes = |from: &str, link: &Link| edge(&scene.lanes[link.from_lane].id) == from;
        let ways = |(from, to, _): &&(String, String, f64)| {
            links().any(|link| comes(from, link) && edge(&link.to_lane) == to)
        };
        let is_known = shares.iter().any(|(from, ..)| links().any(|link| comes(from, link)));
        movement.share = is_known.then(|| shares.iter().filter(ways).map(|share| share.2).sum());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::env::SignalEnv;
    use crate::env::testing::{crossing as scene, env};
    use crate::sim::testing::MockSim;

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
    fn a_green_for_pedestrians_alone_is_no_phase() {
        // The last link has no vehicle lane.
        let mut scene = scene(&[("n_0", 0.0, "s"), ("e_0", 90.0, "s")], &["Grr", "rrG", "rGr"]);
        scene.signals[0].links.push(vec![]);
        let derived = derive(&scene, &scene.signals[0], &SignalSettings::default()).unwrap();
        assert_eq!(pairs(&derived), [[7], [10]]);
        assert_eq!(derived.left_out, ["rrG"]);
        assert_eq!(derived.own_greens, ["Grr", "rGr"]);
        scene.signals[0].programs[0].phases.retain(|p| p.state == "rrG");
        let e =
            derive(&scene, &scene.signals[0], &SignalSettings::default()).unwrap_err().to_string();
        assert!(e.contains("green for vehicles"), "{e}");
    }

    #[test]
    fn a_green_that_comes_twice_in_a_cycle_is_one_action_and_stays_twice_in_the_cycle() {
        let lanes = [("n_0", 0.0, "s"), ("e_0", 90.0, "s"), ("w_0", 270.0, "s")];
        let own = |greens: &[&str]| {
            let scene = scene(&lanes, greens);
            let derived = derive(&scene, &scene.signals[0], &SignalSettings::default()).unwrap();
            let states: Vec<_> = derived.spec.phases.into_iter().map(|p| p.state).collect();
            (states, derived.own_greens)
        };
        let texts = |greens: &[&str]| greens.iter().map(|g| (*g).to_owned()).collect::<Vec<_>>();
        let (actions, cycle) = own(&["Grr", "rGr", "Grr", "rrG"]);
        assert_eq!(actions, texts(&["Grr", "rGr", "rrG"]));
        assert_eq!(cycle, texts(&["Grr", "rGr", "Grr", "rrG"]));
        // Equal neighbours are one green, across the end of the cycle too.
        assert_eq!(own(&["Grr", "Grr", "rGr", "rrG", "Grr"]).1, texts(&["Grr", "rGr", "rrG"]));
        assert_eq!(own(&["Grr", "Grr"]).1, texts(&["Grr"]));
    }

    fn shares(turn_shares: Vec<(String, String, f64)>) -> Vec<Option<f64>> {
        let dir = tempfile::tempdir().unwrap();
        let mut env: SignalEnv<MockSim> = env(vec![], dir.path());
        env.world_mut().turn_shares = turn_shares;
        env.reset(1).unwrap();
        env.signals()[0].movements.iter().map(|m| m.share).collect()
    }

    #[test]
    fn movements_have_the_shares_that_the_demand_says_of_their_edges() {
        let known = [("s", "x", 0.75), ("s", "y", 0.25)];
        let known = known.map(|(from, to, share)| (from.into(), to.into(), share)).to_vec();
        assert_eq!(shares(known), [Some(0.75), None]);
        assert_eq!(shares(vec![]), [None, None]);
    }
}
