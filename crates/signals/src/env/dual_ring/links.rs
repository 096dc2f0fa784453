//! What the programs of a signal say of its links: which may be green together, and who yields.
//!
//! Choices:
//! - **Programs are the witnesses**, as they are for imported networks: two links may be green together if they are
//!   so in a green of some program, or come from one approach. What nobody shows together is taken for a conflict.
//! - **A link yields** to those that have right of way in a green in which it is permissive, unless another green
//!   gives it right of way beside them, or SUMO says that their vehicles never meet, as a right turn into a lane of
//!   its own.

use std::collections::BTreeSet;

use osm_signals::Turn;

use crate::env::derive::{approach_edges, approach_of};
use crate::env::movements::turn_of;
use crate::junction::Set;
use crate::junction::conflicts::matrix;
use crate::sim::{Direction, Scene, SignalInfo};

/// What a link index steers for cars.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Car {
    /// Number of the approach, in the order in which edges first appear.
    pub(super) approach: usize,
    /// Through if it has any, else left if it has any, else right; U-turns count as left turns.
    pub(super) turn: Turn,
    /// Indices in [`Scene::lanes`].
    pub(super) lanes: Vec<usize>,
}

/// The links of a signal.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Links {
    /// By index; `None` for those that steer no cars.
    pub(super) cars: Vec<Option<Car>>,
    /// Direction of travel of every approach, degrees.
    pub(super) headings: Vec<f64>,
    /// Whether some index steers cars from several approaches.
    pub(super) mixed: bool,
    /// Whether lanes lie between two of its stop lines, as those of a signal over several nodes do.
    pub(super) has_inner: bool,
    /// Whether left turns have a phase of their own only where some program shows them an arrow.
    pub(super) arrows_only: bool,
    /// Greens that the programs have.
    pub(super) states: Vec<String>,
    /// By link those that may be green beside it.
    pub(super) together: Vec<Set>,
    /// By link those that may have right of way as it does.
    pub(super) free: Vec<Set>,
    /// By link those to which it yields.
    pub(super) yields: Vec<Set>,
    /// Links that no green gives right of way.
    pub(super) minor: Set,
}

impl Links {
    /// Returns the links of a signal; `states` are greens of its programs.
    pub(super) fn new(scene: &Scene, signal: &SignalInfo, states: Vec<String>) -> Self {
        let edges = approach_edges(scene, signal);
        let mut mixed = false;
        let mut cars = Vec::new();
        let rank = |turn| [Turn::Right, Turn::Left, Turn::Through].iter().position(|t| *t == turn);
        for links in &signal.links {
            let mut car: Option<Car> = None;
            for link in links {
                let approach = approach_of(&edges, &scene.lanes[link.from_lane]);
                // A U-turn beside another turn does not decide what the link is.
                let turn = turn_of(link.direction);
                let decides = link.direction != Direction::Turn;
                match &mut car {
                    None => car = Some(Car { approach, turn, lanes: vec![link.from_lane] }),
                    Some(car) => {
                        mixed |= car.approach != approach;
                        car.lanes.push(link.from_lane);
                        if decides && rank(turn) > rank(car.turn) {
                            car.turn = turn;
                        }
                    }
                }
            }
            cars.push(car);
        }
        let headings = edges.iter().map(|(_, lane)| lane.heading_deg).collect();
        Self::of(cars, headings, mixed, states, &|a, b| signal.may_meet(a, b))
    }

    /// Returns links of which all is known but how they stand to each other.
    ///
    /// # Arguments
    ///
    /// * `may_meet` — whether vehicles on two links may meet, as far as SUMO knows.
    pub(super) fn of(
        cars: Vec<Option<Car>>,
        headings: Vec<f64>,
        mixed: bool,
        mut states: Vec<String>,
        may_meet: &dyn Fn(usize, usize) -> bool,
    ) -> Self {
        let count = cars.len();
        states.retain(|state| state.len() >= count);
        let bytes: Vec<&[u8]> = states.iter().map(String::as_bytes).collect();
        let same = |a: usize, b: usize| match (&cars[a], &cars[b]) {
            (Some(a), Some(b)) => a.approach == b.approach,
            _ => a == b,
        };
        let any = |is: &dyn Fn(u8, u8) -> bool, a: usize, b: usize| {
            bytes.iter().any(|state| is(state[a], state[b]))
        };
        let is_green = |letter: u8| matches!(letter, b'G' | b'g');
        let yields = |a, b| {
            !same(a, b)
                && may_meet(a, b)
                && any(&|a, b| (a, b) == (b'g', b'G'), a, b)
                && !any(&|a, b| a == b'G' && is_green(b), a, b)
        };
        let has = |link: &usize, letter: u8| bytes.iter().any(|state| state[*link] == letter);
        Self {
            together: matrix(count, &|a, b| {
                same(a, b) || any(&|a, b| is_green(a) && is_green(b), a, b)
            }),
            free: matrix(count, &|a, b| same(a, b) || any(&|a, b| (a, b) == (b'G', b'G'), a, b)),
            yields: matrix(count, &yields),
            minor: (0..count).filter(|l| has(l, b'g') && !has(l, b'G')).collect(),
            cars,
            headings,
            mixed,
            states,
            ..Self::default()
        }
    }

    pub(super) fn set(&self, links: impl IntoIterator<Item = usize>) -> Set {
        let mut set = Set::with_capacity(self.cars.len());
        set.extend(links);
        set
    }

    /// Whether a link may be green beside others.
    pub(super) fn fits(&self, link: usize, others: &Set) -> bool {
        others.is_subset(&self.together[link])
    }

    pub(super) fn yields_to(&self, link: usize, others: &Set) -> bool {
        !self.yields[link].is_disjoint(others)
    }

    /// Returns the links of an approach.
    pub(super) fn of_approach(&self, approach: usize) -> impl Iterator<Item = usize> + '_ {
        let is = move |car: &Option<Car>| car.as_ref().is_some_and(|c| c.approach == approach);
        self.cars.iter().enumerate().filter(move |(_, car)| is(car)).map(|(link, _)| link)
    }

    /// Returns the turn of a link; none for one without cars.
    pub(super) fn turn(&self, link: usize) -> Option<Turn> {
        self.cars[link].as_ref().map(|car| car.turn)
    }

    pub(super) fn is_lane_for(&self, lane: usize, turn: Turn) -> bool {
        let cars = self.cars.iter().flatten();
        cars.filter(|car| car.lanes.contains(&lane)).all(|car| car.turn == turn)
    }

    /// Returns the links of a lane.
    pub(super) fn on_lane(&self, lane: usize) -> Vec<usize> {
        let is = |link: &usize| self.cars[*link].as_ref().is_some_and(|c| c.lanes.contains(&lane));
        (0..self.cars.len()).filter(is).collect()
    }

    /// Returns the lanes of some links, ascending.
    pub(super) fn lanes(&self, links: impl IntoIterator<Item = usize>) -> BTreeSet<usize> {
        let cars = links.into_iter().filter_map(|link| self.cars[link].as_ref());
        cars.flat_map(|car| car.lanes.iter().copied()).collect()
    }

    /// Returns the letters of greens: `g` for those that yield to another that is green or coming.
    pub(super) fn letters(&self, green: &Set, coming: &Set) -> String {
        let is_as = |state: &&String| {
            state
                .bytes()
                .zip(0..self.cars.len())
                .all(|(c, l)| matches!(c, b'G' | b'g') == green.contains(l))
        };
        let own = self.states.iter().find(is_as).filter(|_| coming.is_clear());
        let met = green | coming;
        let letter = |link: usize| match own {
            _ if !green.contains(link) => 'r',
            Some(state) => char::from(state.as_bytes()[link]),
            None if self.minor.contains(link) || self.yields_to(link, &met) => 'g',
            None => 'G',
        };
        (0..self.cars.len()).map(letter).collect()
    }

    /// Returns the state in which some links are green, and nothing else.
    pub(super) fn plain(&self, green: &Set) -> String {
        (0..self.cars.len()).map(|l| if green.contains(l) { 'G' } else { 'r' }).collect()
    }
}
