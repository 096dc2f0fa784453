//! The phases of a signal, in two rings and any number of sides.
//!
//! 1. **Streets.** Two approaches are one street if at least half of their links, right turns apart, are green in
//!    one green of the signal's programs, and whatever of them is no left turn may be green together; opposite ones
//!    come first. Each street is a side; so is an approach that is no part of one. The street with most lanes is the
//!    main street and comes first.
//! 2. **Through phases.** Each approach of a street has one: what is green of it in the green of step 1. They are in
//!    different rings. An approach alone has one phase, beside which the other ring rests.
//! 3. **Left turns** have a phase of their own before the through phases (leading), in the ring of the opposing
//!    approach, if they yield to it and have a lane of their own. They stay green, and yield, in their through
//!    phase where the programs show them so.
//! 4. **Overlaps**: right turns and links for others than cars are green whenever they may be beside all that is.
//!    A right turn with a street's lefts is the usual one.
//!
//! Where this leaves a link without green, an index steers cars of several approaches, or lanes lie between two stop
//! lines of the signal, each green of the signal's own program is a phase alone (*stages*); they keep their order and are
//! skipped like any other phase. A lane between two stop lines is no street: with a phase of its own it would keep
//! full while those that fill it are green.
//!
//! Crosswalks belong to the through phase of another street that they lie to the right of, as usual; where there is
//! none, to the nearest. A stage has those that it serves; of several stages the one with most greens.
//!
//! Phases are numbered as usual: 2 and 6 are the through phases of the main street, 4 and 8 those of the next one,
//! 1, 5, 3 and 7 the left turns that oppose them; further ones count on from 9.

use osm_signals::Turn;
use osm_signals::angle::turn_degrees;

use super::links::Links;
use crate::control::dual_ring::{Config, Recall};
use crate::junction::Set;
use crate::timing::{Change, Timing, nearest_s};

/// Least share of an approach's links that are green where it is served.
const SERVED: f64 = 0.5;

/// How traffic that comes from the right turns, seen by whoever it crosses, degrees.
const TO_THE_LEFT_DEG: f64 = -90.0;

#[derive(Debug, Clone, PartialEq)]
pub(super) struct Detector {
    pub(super) lane: usize,
    /// How far from the stop line it begins, metres.
    pub(super) reach_m: f64,
    /// Whether it calls the phase; it prolongs the green anyway.
    pub(super) calls: bool,
    /// Links that serve it whoever's phase they are green in: it does not call while all of them are.
    pub(super) served_by: Vec<usize>,
}

impl Detector {
    pub(super) fn new(links: &Links, lane: usize, config: &Config) -> Self {
        let is_for = |turn| links.is_lane_for(lane, turn);
        let reach_m = if is_for(Turn::Left) { config.left_detector_m } else { config.detector_m };
        let served_by = if is_for(Turn::Right) { links.on_lane(lane) } else { Vec::new() };
        Self { lane, reach_m, calls: true, served_by }
    }
}

#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Phase {
    pub(super) number: u32,
    pub(super) serves: &'static str,
    pub(super) links: Set,
    pub(super) detectors: Vec<Detector>,
    /// Its crosswalks, each with walk and clearance, seconds.
    pub(super) crossings: Vec<(usize, u32)>,
    /// Shortest green, seconds; that of its crosswalks where they are served in every cycle.
    pub(super) min_s: u32,
    /// Longest green while another phase is called, seconds.
    pub(super) max_s: u32,
    /// Longest green whoever is called, seconds.
    pub(super) limit_s: Option<u32>,
    /// Yellow and red after it, where nothing else ends with it.
    pub(super) change: Change,
    /// Time without a vehicle after which its green may end, seconds.
    pub(super) passage_s: u32,
    pub(super) recall: bool,
    /// Whether it lasts as if vehicles came all the time.
    pub(super) is_full: bool,
    /// Whether it is green beside the other ring where its own ring has no called phase (dual entry).
    pub(super) enters: bool,
}

/// A cycle that a plan keeps to. Times are counted from when the first of the coordinated phases may end.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Coordination {
    pub(super) cycle_s: u32,
    /// Per phase when its green ends at the latest, that of a coordinated one when it may end, seconds. One that is not
    /// coordinated and is green up to or across that moment ends in the next cycle: its time is at least `cycle_s`.
    pub(super) ends_s: Vec<u32>,
    /// Per phase, whether it is coordinated: green until it may end, with or without vehicles.
    pub(super) holds: Vec<bool>,
    /// Per phase, whether it may last longer than its longest green until it has to end.
    pub(super) inhibits_max: Vec<bool>,
    /// Where in the cycle the episode begins.
    pub(super) begins_s: u32,
    /// When the first of the coordinated phases may end, seconds after time 0 and its multiples of the cycle; absent where
    /// nobody says so.
    pub(super) yields_s: Option<u32>,
    /// Per phase its green, yellow and red in the cycle, seconds; absent for one that is never called.
    pub(super) splits_s: Vec<Option<u32>>,
}

impl Coordination {
    /// Returns a cycle in which phases are green from and to these seconds, and the coordinated phase whose end it counts from:
    /// that after which no other one ends long after.
    pub(super) fn new(
        cycle_s: u32,
        greens_s: &[Option<[u32; 2]>],
        holds: Vec<bool>,
    ) -> Option<(usize, Self)> {
        let after_s = |from_s: u32, to_s: u32| (cycle_s + to_s - from_s % cycle_s) % cycle_s;
        let end_s = |phase: usize| greens_s[phase].map_or(0, |green| green[1]);
        let held = || (0..holds.len()).filter(|phase| holds[*phase]);
        let longest_s =
            |first: &usize| held().map(|other| after_s(end_s(*first), end_s(other))).max();
        let first = held().min_by_key(longest_s)?;
        let in_cycle_s = |(green, holds): (&Option<[u32; 2]>, &bool)| {
            let Some([begin_s, end_of_green_s]) = *green else { return 0 };
            let end_s = after_s(end_s(first), end_of_green_s);
            let goes_on = end_s < end_of_green_s - begin_s && !holds;
            if goes_on { cycle_s + end_s } else { end_s }
        };
        let cycle = Self {
            cycle_s,
            ends_s: greens_s.iter().zip(&holds).map(in_cycle_s).collect(),
            inhibits_max: vec![false; holds.len()],
            splits_s: vec![None; holds.len()],
            begins_s: 0,
            yields_s: None,
            holds,
        };
        Some((first, cycle))
    }
}

/// What lies between two barriers: phases per ring, in their order.
pub(super) type Side = [Vec<usize>; 2];

/// The phases of a signal.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Plan {
    pub(super) phases: Vec<Phase>,
    /// The sides, the main street first.
    pub(super) sides: Vec<Side>,
    /// Links that are green whenever they may be.
    pub(super) overlaps: Vec<usize>,
    /// Whether the phases are the greens of the signal's own program.
    pub(super) stages: bool,
    /// Whether it is an existing plan, whose phases have their own yellow and red.
    pub(super) is_existing: bool,
    pub(super) coordination: Option<Coordination>,
}

impl Plan {
    /// Returns the phases of a signal.
    ///
    /// # Arguments
    ///
    /// * `own` — greens of its own program, in its order.
    pub(super) fn new(links: &Links, own: &[String], timing: &Timing, config: &Config) -> Self {
        let has_streets = !links.mixed && !links.has_inner;
        let rings = has_streets.then(|| streets(links)).flatten();
        let plan = rings.map(|streets| Builder { links, timing, config }.rings(&streets));
        plan.filter(|plan| plan.is_sound(links))
            .unwrap_or_else(|| Builder { links, timing, config }.stages(own))
    }

    /// Returns the same phases with other longest greens, within their limits.
    pub(super) fn with_longest(mut self, greens_s: &[f64]) -> Self {
        for (phase, green_s) in self.phases.iter_mut().zip(greens_s) {
            let least_s = phase.min_s.max(longest_s(&phase.crossings));
            phase.max_s = within(nearest_s(*green_s), phase.limit_s, least_s);
        }
        for side in self.sides.iter().filter(|_| !greens_s.is_empty()) {
            let last = side.iter().filter_map(|ring| ring.last());
            let max_s = last.map(|p| self.phases[*p].max_s).min().unwrap_or_default();
            let least_s = plan_min(&self.phases, side);
            for p in side.iter().flat_map(|ring| &ring[..ring.len().saturating_sub(1)]) {
                let phase = &mut self.phases[*p];
                let room_s = max_s.saturating_sub(phase.change.total_s() + least_s);
                phase.max_s = phase.max_s.min(room_s).max(phase.min_s);
            }
        }
        self
    }

    /// Whether every link for cars has green and phases that may be green together fit.
    fn is_sound(&self, links: &Links) -> bool {
        let of = |phase: &usize| &self.phases[*phase].links;
        let fits = |a: &usize, b: &usize| of(a).ones().all(|link| links.fits(link, of(b)));
        let fit = |[first, second]: &Side| first.iter().all(|a| second.iter().all(|b| fits(a, b)));
        let has_green = |link: usize| {
            self.phases.iter().any(|p| p.links.contains(link))
                || self.sides.iter().any(|side| self.at_rest(side, links, link))
        };
        self.sides.iter().all(fit)
            && (0..links.cars.len()).all(|link| links.cars[link].is_none() || has_green(link))
    }

    /// Whether a link is green while a side's last phases are.
    fn at_rest(&self, side: &Side, links: &Links, link: usize) -> bool {
        let last = side.iter().filter_map(|ring| ring.last());
        let mut green = links.set(last.flat_map(|phase| self.phases[*phase].links.ones()));
        for &link in &self.overlaps {
            if links.fits(link, &green) {
                green.insert(link);
            }
        }
        green.contains(link)
    }

    /// Whether a phase is green whoever comes, until the cycle lets it end.
    pub(super) fn holds(&self, phase: usize) -> bool {
        self.coordination.as_ref().is_some_and(|c| c.holds[phase])
    }
}

/// What phases are made of.
struct Builder<'a> {
    links: &'a Links,
    timing: &'a Timing,
    config: &'a Config,
}

impl Builder<'_> {
    fn rings(&self, streets: &[Street]) -> Plan {
        let is_overlap = |link: &usize| matches!(self.links.turn(*link), None | Some(Turn::Right));
        let overlaps = (0..self.links.cars.len()).filter(is_overlap).collect();
        let mut plan = Plan { overlaps, ..Plan::default() };
        let crossings = self.crossings(streets);
        for (place, street) in streets.iter().enumerate() {
            let numbers: [u32; 4] = match place {
                0 => [1, 2, 5, 6],
                1 => [3, 4, 7, 8],
                _ => std::array::from_fn(|i| 9 + 4 * (place as u32 - 2) + i as u32),
            };
            self.add(&mut plan, street, numbers, self.recalls(place == 0), &crossings);
        }
        plan
    }

    /// Whether the phases of a street are served in every cycle.
    fn recalls(&self, is_main: bool) -> bool {
        let recall = self.config.recall;
        recall == Recall::All || is_main && recall == Recall::Main
    }

    /// Returns per crosswalk the approach whose through phase it belongs to; none where it is closed.
    fn crossings(&self, streets: &[Street]) -> Vec<Option<usize>> {
        let headings = &self.links.headings;
        let of = |crossing: usize| {
            // Whoever comes from the right goes the other way: a quarter to the left.
            let beside = |a: &usize| {
                let turn = turn_degrees(headings[*a], headings[crossing]);
                turn_degrees(TO_THE_LEFT_DEG, turn).abs()
            };
            let others = streets.iter().filter(|s| !s.approaches.contains(&crossing));
            let approaches = others.flat_map(|s| s.approaches.iter().copied());
            approaches.min_by(|a, b| beside(a).total_cmp(&beside(b)))
        };
        let open =
            |crossing: usize| (!self.timing.closed[crossing]).then(|| of(crossing)).flatten();
        (0..self.timing.crossings()).map(open).collect()
    }

    /// Returns crosswalks with the time that they take, seconds.
    fn timed(&self, is: impl Fn(&usize) -> bool) -> Vec<(usize, u32)> {
        let all = (0..self.timing.crossings()).filter(is);
        all.map(|crossing| (crossing, self.timing.crossing_s(crossing))).collect()
    }

    /// Returns a phase of some links that are green in a state, with crosswalks that are served in every cycle where others
    /// do not push buttons.
    fn phase(
        &self,
        number: u32,
        serves: &'static str,
        links: Set,
        state: &str,
        crossings: Vec<(usize, u32)>,
    ) -> Phase {
        let none = self.links.plain(&self.links.set([]));
        let change = self.timing.change(&self.links.plain(&links), &none);
        let walk_s = longest_s(&crossings);
        let in_every_cycle_s = if self.timing.recalls_pedestrians() { walk_s } else { 0 };
        let min_s = self.timing.alone_s(state, false).max(in_every_cycle_s);
        let limit_s = self.timing.max_green_s(state);
        Phase {
            number,
            serves,
            change: change.unwrap_or_default(),
            links,
            crossings,
            min_s,
            max_s: within(self.config.max_green_s, limit_s, min_s.max(walk_s)),
            limit_s,
            passage_s: self.config.passage_s,
            enters: true,
            ..Phase::default()
        }
    }

    fn add(
        &self,
        plan: &mut Plan,
        street: &Street,
        numbers: [u32; 4],
        recall: bool,
        crossings: &[Option<usize>],
    ) {
        let links = self.links;
        let is_shown = |link: &usize| is_green(&links.states[street.state], *link);
        let through = |approach: usize| links.of_approach(approach).filter(is_shown);
        let together = street.approaches.iter().flat_map(|approach| through(*approach));
        let together = links.plain(&links.set(together));
        let walk_s = longest_s(
            &self.timed(|c| crossings[*c].is_some_and(|a| street.approaches.contains(&a))),
        );
        let limit_s = self.timing.max_green_s(&together).map(|max| max.max(walk_s));
        let least_s = self.timing.alone_s(&together, false).max(walk_s);
        let max_s = within(self.config.max_green_s, limit_s, least_s);
        let serves = if street.approaches.len() == 1 { "approach" } else { "through" };
        let mut side = Side::default();
        for (ring, &approach) in street.approaches.iter().enumerate() {
            let own = links.set(through(approach));
            let detectors = self.detectors(approach, &own, street.lefts[ring]);
            let crossings = self.timed(|c| crossings[*c] == Some(approach));
            let number = numbers[2 * ring + 1];
            let phase = self.phase(number, serves, own, &together, crossings);
            plan.phases.push(Phase { detectors, max_s, limit_s, recall, ..phase });
            side[ring].push(plan.phases.len() - 1);
        }
        // The left turns of an approach are in the ring of the opposing one, before it.
        for (k, &approach) in street.approaches.iter().enumerate().filter(|(k, _)| street.lefts[*k])
        {
            let ring = 1 - k;
            let is_left = |link: &usize| links.turn(*link) == Some(Turn::Left);
            let own = links.set(links.of_approach(approach).filter(is_left));
            let own_lanes = links.lanes(own.ones()).into_iter();
            let detectors = own_lanes
                .filter(|lane| links.is_lane_for(*lane, Turn::Left))
                .map(|lane| Detector::new(links, lane, self.config))
                .collect();
            let state = links.plain(&own);
            let phase = self.phase(numbers[2 * ring], "left", own, &state, Vec::new());
            let room_s =
                max_s.saturating_sub(phase.change.total_s() + plan_min(&plan.phases, &side));
            let max_s = self.config.left_max_green_s.min(room_s).max(phase.min_s);
            plan.phases.push(Phase { detectors, max_s, limit_s, enters: false, ..phase });
            side[ring].insert(0, plan.phases.len() - 1);
        }
        plan.sides.push(side);
    }

    /// Returns greens as phases, one after the other.
    fn stages(&self, own: &[String]) -> Plan {
        let mut states: Vec<&String> = Vec::new();
        own.iter().for_each(|s| {
            if !states.contains(&s) {
                states.push(s);
            }
        });
        let best = |crossing: usize| {
            let serves = |s: &&&String| self.timing.serves_crossing(s, crossing);
            let greens = |s: &&&String| s.matches(['G', 'g']).count();
            states.iter().filter(serves).rev().max_by_key(greens).copied()
        };
        let phase = |(place, state): (usize, &&String)| {
            let links = self.links.set((0..self.links.cars.len()).filter(|l| is_green(state, *l)));
            let crossings = self.timed(|crossing| best(*crossing) == Some(*state));
            let phase = self.phase(place as u32 + 1, "stage", links, state, crossings);
            let detectors = self.stage_detectors(place, &states);
            Phase { detectors, recall: self.recalls(place == 0), ..phase }
        };
        Plan {
            phases: states.iter().enumerate().map(phase).collect(),
            sides: (0..states.len()).map(|place| [vec![place], Vec::new()]).collect(),
            stages: true,
            ..Plan::default()
        }
    }

    fn detectors(&self, approach: usize, served: &Set, own_lefts: bool) -> Vec<Detector> {
        let links = self.links;
        let detector = |lane: usize| {
            let of_lane = links.on_lane(lane);
            let is_other = own_lefts && links.is_lane_for(lane, Turn::Left);
            let is_served = !is_other && of_lane.iter().any(|l| served.contains(*l));
            is_served.then(|| Detector::new(links, lane, self.config))
        };
        links.lanes(links.of_approach(approach)).into_iter().filter_map(detector).collect()
    }

    /// Returns the detectors of a stage: lanes that no other serves better.
    fn stage_detectors(&self, place: usize, states: &[&String]) -> Vec<Detector> {
        let links = self.links;
        let detector = |lane: usize| {
            let of_lane = links.on_lane(lane);
            let value = |state: &&String| {
                let letters = of_lane.iter().map(|link| state.as_bytes()[*link]);
                letters.map(|l| 2 * u32::from(l == b'G') + u32::from(l == b'g')).sum::<u32>()
            };
            let best = states.iter().map(value).max().filter(|best| *best > 0)?;
            let first = states.iter().position(|state| value(state) == best);
            let calls = first == Some(place);
            let detector = Detector::new(links, lane, self.config);
            let own = Detector { calls, served_by: of_lane.clone(), ..detector };
            (value(&states[place]) == best).then_some(own)
        };
        links.lanes(0..links.cars.len()).into_iter().filter_map(detector).collect()
    }
}

/// Returns a green that is wanted, within its limits, seconds.
fn within(wanted_s: u32, limit_s: Option<u32>, least_s: u32) -> u32 {
    wanted_s.min(limit_s.unwrap_or(u32::MAX)).max(least_s)
}

/// Returns the longest time of crosswalks, seconds.
pub(super) fn longest_s(crossings: &[(usize, u32)]) -> u32 {
    crossings.iter().map(|crossing| crossing.1).max().unwrap_or(0)
}

/// Returns the shortest green of a side's through phases, with pedestrians.
fn plan_min(phases: &[Phase], side: &Side) -> u32 {
    let last = side.iter().filter_map(|ring| ring.last()).map(|phase| &phases[*phase]);
    last.map(|phase| phase.min_s.max(longest_s(&phase.crossings))).max().unwrap_or(0)
}

/// A street, or an approach alone.
#[derive(Debug, Clone, PartialEq)]
struct Street {
    approaches: Vec<usize>,
    /// Green of a program that serves it.
    state: usize,
    /// Per approach, whether its left turns have a phase of their own.
    lefts: Vec<bool>,
}

/// Returns the streets of a signal, the main one first; `None` where an approach has no green that serves it.
fn streets(links: &Links) -> Option<Vec<Street>> {
    let approaches = links.headings.len();
    let mut pairs: Vec<(f64, Street)> = Vec::new();
    for a in 0..approaches {
        for b in a + 1..approaches {
            let turn = turn_degrees(links.headings[a], links.headings[b]).abs();
            pairs.extend(street(links, a, b).map(|street| ((180.0 - turn).abs().round(), street)));
        }
    }
    // The sort is stable: of pairs that are as opposite the first one.
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut taken = vec![false; approaches];
    let mut streets = Vec::new();
    for (_, street) in pairs {
        if street.approaches.iter().all(|a| !taken[*a]) {
            street.approaches.iter().for_each(|a| taken[*a] = true);
            streets.push(street);
        }
    }
    for approach in (0..approaches).filter(|a| !taken[*a]) {
        let state = best_state(links, &[approach])?;
        streets.push(Street { approaches: vec![approach], state, lefts: vec![false] });
    }
    let lanes = |street: &Street| {
        links.lanes(street.approaches.iter().flat_map(|a| links.of_approach(*a))).len()
    };
    streets.sort_by_key(|s| (std::cmp::Reverse(lanes(s)), s.approaches[0]));
    Some(streets)
}

/// Returns the street that two approaches make, if they do.
fn street(links: &Links, a: usize, b: usize) -> Option<Street> {
    let state = best_state(links, &[a, b])?;
    let of = |approach: usize, left: bool| {
        let is = move |link: &usize| (links.turn(*link) == Some(Turn::Left)) == left;
        links.of_approach(approach).filter(is).collect::<Vec<usize>>()
    };
    let others = links.set(of(b, false));
    if !of(a, false).iter().all(|link| links.fits(*link, &others)) {
        return None;
    }
    let own = |approach: usize, opposing: usize| {
        let lefts = of(approach, true);
        let opposed = |l: &usize| {
            let meets =
                |m: &usize| links.yields[*l].contains(*m) || !links.together[*l].contains(*m);
            of(opposing, false).iter().any(meets)
        };
        let has_lane =
            |l: &usize| links.lanes([*l]).iter().all(|lane| links.is_lane_for(*lane, Turn::Left));
        let has_arrow = |l: &usize| !links.arrows_only || !links.minor.contains(*l);
        lefts.iter().any(opposed) && lefts.iter().any(has_lane) && lefts.iter().any(has_arrow)
    };
    let mut lefts = vec![own(a, b), own(b, a)];
    // Two left turns that are only ever permissive together may meet each other.
    let pair = of(a, true).iter().all(|l| of(b, true).iter().all(|m| links.free[*l].contains(*m)));
    if lefts == [true, true] && !pair {
        lefts = vec![false, false];
    }
    // A left turn that is not green beside the opposing approach needs its own phase.
    let green = |link: &usize| is_green(&links.states[state], *link);
    let served = |approach: usize, own: bool| own || of(approach, true).iter().all(green);
    (served(a, lefts[0]) && served(b, lefts[1])).then(|| Street {
        approaches: vec![a, b],
        state,
        lefts,
    })
}

/// Returns the green of the programs that serves most of some approaches, and all of them.
fn best_state(links: &Links, approaches: &[usize]) -> Option<usize> {
    let served = |state: &str, approach: usize| {
        let ahead = |link: &usize| links.turn(*link) != Some(Turn::Right);
        let mut counted: Vec<usize> = links.of_approach(approach).filter(ahead).collect();
        if counted.is_empty() {
            counted = links.of_approach(approach).collect();
        }
        let green = counted.iter().filter(|l| is_green(state, **l)).count();
        green as f64 / counted.len() as f64
    };
    let greens = |state: &str| {
        let of = |a: &usize| links.of_approach(*a).filter(|l| is_green(state, *l)).count();
        approaches.iter().map(of).sum::<usize>()
    };
    let fit = |state: &String| approaches.iter().all(|a| served(state, *a) >= SERVED);
    let fitting = links.states.iter().enumerate().filter(|(_, state)| fit(state));
    // The first of the best.
    fitting.rev().max_by_key(|(_, state)| greens(state)).map(|(i, _)| i)
}

fn is_green(state: &str, link: usize) -> bool {
    matches!(state.as_bytes().get(link), Some(b'G' | b'g'))
}
