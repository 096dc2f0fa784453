//! Plans that signals have today: phases in two rings, with the times that stand in the cabinet.
//!
//! [`table`] reads and writes them as CSV, [`utdf`](crate::utdf) as UTDF, [`placed`](crate::placed) gives their movements to the
//! arms of an intersection, and the environment shows them (`env::dual_ring`).
//!
//! Choices:
//! - **The plan's own times hold**: greens, yellow, all-red, walk and clearance are those of the cabinet, not the limits of
//!   `[signal]`, as with a network's own program.
//! - **Whole seconds**, because the simulation's steps are: starts and greens lie within a second of the plan's, so that the
//!   sum of what greens gain or lose is least and the cycle does not drift. Yellow and all-red are the rest, each one of the
//!   two whole seconds beside its own; where no cycle says so, their sum is the nearest.
//! - **A ring that is done before the other one** keeps its last phase green until the barrier, as Synchro does.
//! - **Offset and reference** have no effect: intersections are simulated apart. They are kept for whoever takes the plan
//!   back.
//!
//! Source: "Signal Timing Manual" (2nd ed., NCHRP Report 812), chapters 5 to 7; NEMA TS 2.

mod legal;
pub mod ran;
pub mod table;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use crate::timing::{Change, beside, nearest_s};
pub use table::read;

/// Most rings.
const RINGS: u32 = 2;

/// Shortest green that can be shown: a step of the simulation, seconds.
const STEP_S: f64 = 1.0;

/// How far cycle and splits may differ, seconds: tables have one digit after the point.
const CYCLE_SLACK_S: f64 = 0.55;

/// Highest number of a phase, a barrier or a position.
const MOST_NUMBER: f64 = 99.0;

/// Shortest green of a plan, seconds.
const LEAST_GREEN_S: f64 = 0.1;

/// A column of a phase, the record of UTDF that is the same, the limits of both, and the value.
pub(crate) type Limits = (&'static str, &'static str, RangeInclusive<f64>, fn(&PlanPhase) -> f64);

/// What values of phases may be.
pub(crate) const LIMITS: [Limits; 15] = [
    ("phase", "", 1.0..=MOST_NUMBER, |p| p.number.into()),
    ("phase", "", 1.0..=MOST_NUMBER, |p| p.also.unwrap_or(p.number).into()),
    ("ring", "", 1.0..=RINGS as f64, |p| p.ring.into()),
    ("barrier", "", 1.0..=MOST_NUMBER, |p| p.barrier.into()),
    ("position", "", 1.0..=MOST_NUMBER, |p| p.position.into()),
    ("yellow_s", "yellow", 0.0..=YELLOW_S[1], |p| p.yellow_s),
    ("max_green_s", "maxgreen", LEAST_GREEN_S..=900.0, |p| p.max_green_s),
    ("min_green_s", "mingreen", 0.0..=600.0, |p| p.min_green_s),
    ("min_split_s", "minsplit", 0.0..=900.0, |p| p.min_split_s.unwrap_or_default()),
    ("split_s", "", LEAST_GREEN_S..=930.0, PlanPhase::split_s),
    ("", "recall", 0.0..=3.0, |p| f64::from(p.recall as u32)),
    ("passage_s", "vehext", 0.0..=60.0, |p| p.passage_s),
    ("all_red_s", "allred", 0.0..=20.0, |p| p.all_red_s),
    ("walk_s", "walk", 0.0..=240.0, |p| p.walk_s.unwrap_or_default()[0]),
    ("clearance_s", "dontwalk", 0.0..=240.0, |p| p.walk_s.unwrap_or_default()[1]),
];

/// Shortest yellow of a phase of which something ends, and the longest, seconds.
const YELLOW_S: [f64; 2] = [1.0, 10.0];

/// How a signal goes on from phase to phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Control {
    /// Every phase lasts its split.
    #[default]
    Pretimed,
    /// Phases last as long as vehicles come, up to their longest green.
    Actuated,
    /// The same within a cycle: the coordinated phases are green until their split is over, and get what others leave.
    Coordinated,
}

/// What a phase is served for without a vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Recall {
    /// Nothing.
    #[default]
    None,
    /// Its shortest green, in every cycle.
    Min,
    /// Walk and clearance, in every cycle.
    Ped,
    /// Its longest green, in every cycle.
    Max,
}

impl Recall {
    /// All of them, in the order of UTDF's numbers.
    pub const ALL: [Self; 4] = [Self::None, Self::Min, Self::Ped, Self::Max];
}

/// A phase of an existing plan; times in seconds.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanPhase {
    /// Its number.
    pub number: u32,
    /// The other number of a stage that is two phases at once, such as 6 of 2+6.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub also: Option<u32>,
    /// Its ring, from 1.
    pub ring: u32,
    /// The barrier that it comes before, from 1.
    pub barrier: u32,
    /// Its place in the ring before that barrier, from 1.
    pub position: u32,
    /// Movements with the right of way, such as `NBT`.
    pub movements: Vec<String>,
    /// Movements that yield.
    pub yielding: Vec<String>,
    /// Shortest green.
    pub min_green_s: f64,
    /// Longest green: the split without yellow and all-red.
    pub max_green_s: f64,
    /// Shortest split that whoever retimes the signal may give it; absent where nobody says.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min_split_s: Option<f64>,
    /// Time without a vehicle after which the green may end.
    pub passage_s: f64,
    /// Yellow.
    pub yellow_s: f64,
    /// Red clearance.
    pub all_red_s: f64,
    /// Walk and pedestrian clearance; absent without a crosswalk.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub walk_s: Option<[f64; 2]>,
    /// What it is served for without a vehicle.
    pub recall: Recall,
    /// Whether it is green beside the other ring's phase if nobody calls a phase of its ring.
    pub dual_entry: bool,
    /// Whether it may last longer than its longest green where it begins early, up to the end of its split (UTDF's
    /// `InhibitMax`); only when coordinated.
    pub inhibit_max: bool,
    /// What sheets say of its detectors; they are not simulated.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub detectors: String,
}

impl PlanPhase {
    /// Returns its number, of two phases at once both, such as `2+6`.
    pub fn label(&self) -> String {
        let mut numbers = [Some(self.number), self.also];
        numbers.sort_by_key(|number| number.unwrap_or(u32::MAX));
        numbers.iter().flatten().map(u32::to_string).collect::<Vec<_>>().join("+")
    }

    /// Returns yellow and all-red, seconds.
    pub fn change_s(&self) -> [f64; 2] {
        [self.yellow_s, self.all_red_s]
    }

    /// Returns its split, seconds.
    pub fn split_s(&self) -> f64 {
        self.max_green_s + self.yellow_s + self.all_red_s
    }

    /// Returns all its movements.
    pub fn all_movements(&self) -> impl Iterator<Item = &String> {
        self.movements.iter().chain(&self.yielding)
    }

    /// Whether it is for pedestrians alone: it has a walk, and no vehicle has green.
    pub fn is_for_people(&self) -> bool {
        self.all_movements().next().is_none() && self.walk_s.is_some()
    }
}

/// The plan of a signal.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExistingPlan {
    /// How it goes on from phase to phase.
    pub control: Control,
    /// Cycle, seconds; absent where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cycle_s: Option<f64>,
    /// Offset, seconds; absent where it is not known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_s: Option<f64>,
    /// Phases that the offset counts from: the coordinated ones.
    pub reference: Vec<u32>,
    /// What of the reference phases the offset counts from, as UTDF writes it.
    pub referenced_to: u32,
    /// Its phases.
    pub phases: Vec<PlanPhase>,
    /// Movements that have the right of way into one leg together, in pairs; none until it was placed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub merging: Vec<[String; 2]>,
    /// Edges from which and to which the vehicles of each movement drive; empty until it was placed.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub ways: BTreeMap<String, Vec<(String, String)>>,
}

/// A plan with what tables say of it.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedPlan {
    /// The intersection.
    pub intersection: String,
    /// Period of the day; empty for all.
    pub period: String,
    /// The plan.
    pub plan: ExistingPlan,
    /// First line of it.
    pub line: u64,
}

/// Plans from a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plans {
    /// Name of the file, for messages.
    pub file: String,
    /// Whether it is a network, of which plans that cannot be simulated are left out.
    pub is_utdf: bool,
    /// The plans.
    pub all: Vec<NamedPlan>,
}

impl ExistingPlan {
    /// Returns a plan of these phases, without a cycle.
    pub fn new(control: Control, phases: Vec<PlanPhase>) -> Self {
        Self { control, offset_s: Some(0.0), phases, ..Self::default() }
    }

    /// Adds a phase; of two numbers it goes by the one that no phase before it has.
    pub fn push(&mut self, mut phase: PlanPhase) {
        if let Some(also) = phase.also
            && self.phases.iter().any(|other| other.number == phase.number)
        {
            phase.also = Some(std::mem::replace(&mut phase.number, also));
        }
        self.phases.push(phase);
    }

    /// Returns the plan with other greens of its phases, seconds, and with the cycle that they make; none keeps its own.
    pub fn retimed(&self, greens_s: &[f64]) -> Self {
        let mut plan = self.clone();
        let phases = plan.phases.iter_mut().zip(greens_s);
        phases.for_each(|(phase, green_s)| phase.max_green_s = *green_s);
        if self.control == Control::Pretimed && !greens_s.is_empty() {
            plan.cycle_s = Some((plan.sum_s() * 10.0).round() / 10.0);
        }
        plan
    }

    /// Returns the sides in order, each with the indices of its phases per ring in their order.
    pub fn sides(&self) -> Vec<[Vec<usize>; 2]> {
        let barriers: BTreeSet<u32> = self.phases.iter().map(|p| p.barrier).collect();
        let of = |barrier: u32, ring: u32| {
            let is = |i: &usize| (self.phases[*i].barrier, self.phases[*i].ring) == (barrier, ring);
            let mut found: Vec<usize> = (0..self.phases.len()).filter(is).collect();
            found.sort_by_key(|i| self.phases[*i].position);
            found
        };
        barriers.into_iter().map(|barrier| [of(barrier, 1), of(barrier, RINGS)]).collect()
    }

    /// Returns the phases that are green together: one of each ring of a side, or one alone where the other ring has none.
    pub fn pairs(&self) -> Vec<Vec<usize>> {
        let mut pairs = Vec::new();
        for [first, second] in self.sides() {
            match (first.as_slice(), second.as_slice()) {
                (alone, []) | ([], alone) => pairs.extend(alone.iter().map(|p| vec![*p])),
                _ => pairs.extend(first.iter().flat_map(|a| second.iter().map(|b| vec![*a, *b]))),
            }
        }
        pairs
    }

    /// Returns the sum of the splits of the ring of each side that has more, seconds.
    pub fn sum_s(&self) -> f64 {
        self.sides().iter().map(|[a, b]| self.ring_s(a).max(self.ring_s(b))).sum()
    }

    fn ring_s(&self, ring: &[usize]) -> f64 {
        ring.iter().map(|i| self.phases[*i].split_s()).sum()
    }

    /// Checks that the plan can be shown, and returns what of it is not as it looks.
    pub fn check(&self) -> Result<Vec<String>, String> {
        self.checked().map_err(|(_, message)| message)
    }

    /// Does so; an error has the indices of the phases that it is about.
    fn checked(&self) -> Result<Vec<String>, (Vec<usize>, String)> {
        let whole = |message| (Vec::new(), message);
        if self.phases.iter().all(|p| p.all_movements().next().is_none()) {
            let message = "no phase has a movement; give movements such as NBT NBR";
            return Err(whole(message.to_owned()));
        }
        within("cycle_s", self.cycle_s.unwrap_or(2.0), &(2.0..=3600.0)).map_err(whole)?;
        let most_s = self.cycle_s.unwrap_or(3600.0);
        let offset_s = self.offset_s.unwrap_or_default();
        within("offset_s", offset_s, &(-most_s..=most_s)).map_err(whole)?;
        let (mut numbers, mut places) = (BTreeSet::new(), BTreeSet::new());
        for (i, phase) in self.phases.iter().enumerate() {
            let PlanPhase { number, ring, barrier, position, .. } = *phase;
            let wrong = |message| (vec![i], message);
            for (what, _, range, value) in LIMITS {
                within(&format!("phase {number}: {what}"), value(phase), &range).map_err(wrong)?;
            }
            if !numbers.insert(number) || !places.insert((barrier, ring, position)) {
                return Err(wrong(format!(
                    "phase {number} has the number, or barrier, ring and position, of a phase before it; give it its own"
                )));
            }
            if phase.min_green_s > phase.max_green_s && self.control != Control::Pretimed {
                return Err(wrong(format!(
                    "phase {number}: the shortest green of {} s is longer than the longest of {} s; correct one of the two \
                     (the longest green is the split without yellow and all-red)",
                    phase.min_green_s, phase.max_green_s
                )));
            }
        }
        self.check_changes()?;
        self.check_cycle(&numbers)?;
        let (timed, _) = schedule(self);
        for (i, (phase, timed)) in self.phases.iter().zip(&timed).enumerate() {
            let is_short = match self.control {
                Control::Actuated => phase.max_green_s < STEP_S,
                Control::Pretimed | Control::Coordinated => timed.green_s < 1,
            };
            if is_short {
                let message = format!(
                    "phase {} has a green of {} s, and steps are of 1 s; give it more, or remove the phase",
                    phase.number, phase.max_green_s
                );
                return Err((vec![i], message));
            }
        }
        Ok(self.notes(&timed))
    }

    /// Checks that a phase without a yellow ends nothing: all its movements go on in the phase after it.
    fn check_changes(&self) -> Result<(), (Vec<usize>, String)> {
        let [least, most] = YELLOW_S;
        for (i, (phase, next)) in self.phases.iter().zip(self.nexts()).enumerate() {
            let goes_on = next.is_some_and(|next| {
                let next = &self.phases[next];
                phase.all_movements().all(|name| next.all_movements().any(|other| other == name))
            });
            if phase.yellow_s < least && !goes_on {
                let message = format!(
                    "phase {} has a yellow of {} s; expected {least} to {most} s, or less where all its movements go on in \
                     the next phase of its ring and that phase comes in every cycle",
                    phase.number, phase.yellow_s
                );
                return Err((vec![i], message));
            }
        }
        Ok(())
    }

    /// Returns per phase the next one of its ring on its side of the barrier, where that comes in every cycle.
    fn nexts(&self) -> Vec<Option<usize>> {
        let (sides, mut nexts) = (self.sides(), vec![None; self.phases.len()]);
        for ring in sides.iter().flatten() {
            let first = ring.first().filter(|_| sides.len() == 1);
            for (place, index) in ring.iter().enumerate() {
                let next = ring.get(place + 1).or(first).copied();
                let comes = |next: &usize| self.phases[*next].recall != Recall::None;
                nexts[*index] = next.filter(|p| self.control == Control::Pretimed || comes(p));
            }
        }
        nexts
    }

    /// Returns per phase the state after it, all red but for links that surely stay green in the next phase.
    ///
    /// # Arguments
    ///
    /// * `states` — per phase the state in which its links are green, and no other.
    pub fn after(&self, states: &[String]) -> Vec<String> {
        let red = || states[0].replace('G', "r");
        self.nexts().into_iter().map(|next| next.map_or_else(red, |p| states[p].clone())).collect()
    }

    /// Checks that the reference phases can hold the green, one per ring, and that the splits make the cycle.
    fn check_cycle(&self, numbers: &BTreeSet<u32>) -> Result<(), (Vec<usize>, String)> {
        let whole = |message| Err((Vec::new(), message));
        if let Some(unknown) = self.reference.iter().find(|number| !numbers.contains(number)) {
            return whole(format!(
                "reference phase {unknown} is none of the phases {numbers:?}; correct the reference"
            ));
        }
        let is_coordinated = self.control == Control::Coordinated;
        let rings: Vec<u32> = self.coordinated().iter().map(|p| self.phases[*p].ring).collect();
        let is_held = matches!(rings[..], [_]) || matches!(rings[..], [a, b] if a != b);
        if self.reference.len() > 2 || is_coordinated && !is_held {
            return whole("give the phases that hold the green of a coordinated plan as reference, one per ring, such as 2 6"
                .to_owned());
        }
        let sum_s = self.sum_s();
        match self.cycle_s {
            _ if self.control == Control::Actuated => Ok(()),
            Some(cycle_s) if (cycle_s - sum_s).abs() > CYCLE_SLACK_S => {
                let tenth = |s: f64| (s * 10.0).round() / 10.0;
                let (mut rings, mut uneven) = (Vec::new(), Vec::new());
                for side in self.sides() {
                    let [a_s, b_s] = side.each_ref().map(|ring| tenth(self.ring_s(ring)));
                    if a_s != b_s && a_s.min(b_s) > 0.0 {
                        uneven.extend(side.concat());
                    }
                    for (ring, s) in side.iter().zip([a_s, b_s]) {
                        let named = |p: &PlanPhase| {
                            format!("{s} s in ring {} before barrier {}", p.ring, p.barrier)
                        };
                        rings.extend(ring.first().map(|i| named(&self.phases[*i])));
                    }
                }
                let message = format!(
                    "the cycle is {cycle_s} s, but the splits (longest green, yellow and all-red) of the longer ring of every \
                     side are {} s together ({}); correct the cycle or a green",
                    tenth(sum_s),
                    rings.join(", ")
                );
                Err((uneven, message))
            }
            None if is_coordinated => {
                whole("control is coordinated without a cycle; give cycle_s".to_owned())
            }
            _ => Ok(()),
        }
    }

    /// Returns what of the plan is not as it looks.
    fn notes(&self, timed: &[Timed]) -> Vec<String> {
        let is_actuated = self.control == Control::Actuated;
        let unused = |s: f64| format!("the plan is actuated, so its cycle of {s} s has no effect");
        let cycle_s = self.cycle_s.filter(|_| is_actuated);
        let mut notes: Vec<String> = cycle_s.map(unused).into_iter().collect();
        for (phase, timed) in self.phases.iter().zip(timed) {
            if let Some(min_s) = phase.min_split_s.filter(|s| *s > phase.split_s() + STEP_S / 2.0) {
                let (number, split_s) = (phase.number, phase.split_s());
                notes.push(format!(
                    "phase {number} has a split of {split_s:.1} s, below its min_split_s of {min_s} s"
                ));
            }
            let is_empty = phase.all_movements().next().is_none();
            let note = match self.control {
                _ if is_empty && phase.walk_s.is_none() => {
                    "has no movement, and is green for nobody"
                }
                Control::Pretimed if is_empty => {
                    "is for pedestrians alone: a fixed cycle keeps its time, but nobody walks in it, so do not compare \
                     pedestrian_delay_s"
                }
                _ if is_empty => {
                    "is for pedestrians alone, and serves the crosswalks beside which no other phase has a walk"
                }
                _ => "",
            };
            if is_empty {
                notes.push(format!("phase {} {note}", phase.number));
            }
            if !is_actuated && f64::from(timed.green_s) - phase.max_green_s > 1.5 {
                notes.push(format!(
                    "phase {} lasts {} s instead of {} s, until its ring meets the other one at the barrier",
                    phase.number, timed.green_s, phase.max_green_s
                ));
            }
        }
        notes
    }

    /// Returns the indices of the coordinated phases.
    pub fn coordinated(&self) -> Vec<usize> {
        let is = |i: &usize| self.reference.contains(&self.phases[*i].number);
        (0..self.phases.len()).filter(is).collect()
    }
}

/// Checks that a value is within its limits.
fn within(what: &str, value: f64, range: &RangeInclusive<f64>) -> Result<(), String> {
    let (low, high) = (range.start(), range.end());
    let wrong = || format!("{what} = {value}: expected {low} to {high}");
    if range.contains(&value) { Ok(()) } else { Err(wrong()) }
}

/// When a phase is green in a cycle of splits, seconds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Timed {
    /// From the beginning of the cycle.
    pub begin_s: u32,
    /// Green, until yellow.
    pub green_s: u32,
    /// What follows it.
    pub change: Change,
}

impl Timed {
    /// Returns green, yellow and all-red together.
    pub fn split_s(self) -> u32 {
        self.green_s + self.change.total_s()
    }

    /// Returns a green as near to its own as the change allows, each part of which is one of the whole seconds beside it.
    fn within([begin_s, end_s]: [u32; 2], green_s: f64, change_s: [f64; 2]) -> Self {
        let split_s = end_s.saturating_sub(begin_s);
        let [low_s, high_s] = beside(change_s.iter().sum());
        let total_s = nearest_s(f64::from(split_s) - green_s).clamp(low_s, high_s).min(split_s);
        Self { begin_s, green_s: split_s - total_s, change: Change::of(total_s, change_s) }
    }
}

/// Returns when every phase is green if each lasts its split, and the cycle, seconds. The last phase of a ring lasts until
/// the barrier.
pub fn schedule(plan: &ExistingPlan) -> (Vec<Timed>, u32) {
    let mut timed = vec![Timed::default(); plan.phases.len()];
    let mut side_begins_s = 0.0;
    for side in plan.sides() {
        let side_ends_s = side_begins_s + plan.ring_s(&side[0]).max(plan.ring_s(&side[1]));
        for ring in &side {
            let mut begins_s = side_begins_s;
            // Of all ways to the end of a phase the one whose greens miss least, milliseconds, and where it ends.
            let mut ways: Vec<(u64, Vec<Timed>)> = vec![(0, Vec::new())];
            for (place, index) in ring.iter().enumerate() {
                let phase = &plan.phases[*index];
                let is_last = place + 1 == ring.len();
                let ends_s = if is_last { side_ends_s } else { begins_s + phase.split_s() };
                let lasts_s = ends_s - begins_s - phase.change_s().iter().sum::<f64>();
                let begin_s = nearest_s(side_begins_s);
                let to = |end_s: u32| {
                    let way = |(missed_ms, before): &(u64, Vec<Timed>)| {
                        let begin_s = before.last().map_or(begin_s, |b| b.begin_s + b.split_s());
                        let timed = Timed::within([begin_s, end_s], lasts_s, phase.change_s());
                        let own_ms = 1000.0 * (f64::from(timed.green_s) - lasts_s).abs();
                        (missed_ms + own_ms.round() as u64, [&before[..], &[timed]].concat())
                    };
                    ways.iter().map(way).min_by_key(|way| way.0).expect("there is one")
                };
                let nearest = nearest_s(ends_s);
                let others = beside(ends_s).into_iter().filter(|s| *s != nearest && !is_last);
                ways = std::iter::once(nearest).chain(others).map(to).collect();
                begins_s = ends_s;
            }
            let best = ways.into_iter().min_by_key(|way| way.0).expect("there is one");
            ring.iter().zip(best.1).for_each(|(index, way)| timed[*index] = way);
        }
        side_begins_s = side_ends_s;
    }
    (timed, nearest_s(side_begins_s))
}

/// Plans written by hand, for tests.
#[cfg(test)]
pub(crate) mod testing {
    use proptest::array::{uniform8, uniform12};
    use proptest::collection::vec;
    use proptest::option;
    use proptest::prelude::{Just, Strategy, any};

    use super::*;

    /// A phase of 5 to 20 s, 3.5 s of yellow and 1 s of all-red, with these movements; of those in small letters it yields.
    pub(crate) fn phase(
        number: u32,
        [barrier, ring, position]: [u32; 3],
        names: &str,
    ) -> PlanPhase {
        let of = |small: bool| {
            let is = |name: &&str| name.chars().any(char::is_lowercase) == small;
            names.split_whitespace().filter(is).map(str::to_uppercase).collect()
        };
        PlanPhase {
            number,
            ring,
            barrier,
            position,
            movements: of(false),
            yielding: of(true),
            min_green_s: 5.0,
            max_green_s: 20.0,
            passage_s: 3.0,
            yellow_s: 3.5,
            all_red_s: 1.0,
            dual_entry: number.is_multiple_of(2),
            ..PlanPhase::default()
        }
    }

    /// Plans that can be shown: phases by number, movements of four arms as engineers list them, times in tenths of seconds.
    pub(crate) fn plans() -> impl Strategy<Value = ExistingPlan> {
        let values = (uniform8(10..100u32), any::<[bool; 5]>(), 0..4usize, uniform12(0..9u8));
        let phase =
            values.prop_map(|(tenths, [walks, splits, twin, enters, inhibits], recall, lights)| {
                let of = |light| {
                    let all = ["N", "E", "S", "W"]
                        .map(|arm| ["L", "T", "R"].map(|turn| format!("{arm}B{turn}")));
                    let own =
                        all.into_iter().flatten().zip(lights).filter(move |(_, l)| *l == light);
                    own.map(|(name, _)| name).collect()
                };
                let s = |tenths: u32| f64::from(tenths) / 10.0;
                let [max, min, passage, yellow, red, walk, clear, split] = tenths;
                PlanPhase {
                    also: twin.then_some(1),
                    movements: of(0),
                    yielding: of(1),
                    min_green_s: s(min),
                    max_green_s: s(min + max),
                    min_split_s: splits.then(|| s(split)),
                    passage_s: s(passage),
                    yellow_s: s(yellow),
                    all_red_s: s(red),
                    walk_s: walks.then(|| [s(walk), s(clear)]),
                    recall: if walks { Recall::ALL[recall] } else { Recall::Max },
                    dual_entry: enters,
                    inhibit_max: inhibits,
                    ..phase(1, [1, 1, 1], "")
                }
            });
        let numbers = Just((1..100).collect::<Vec<u32>>()).prop_shuffle();
        let phases = vec((phase, 1..4u32, 1..=RINGS), 1..9);
        let more = (0..3usize, option::of(-50..50i32), 0..4u32, 1..=RINGS);
        let plan = (phases, numbers, more).prop_map(
            |(phases, numbers, (control, offset_s, referenced_to, rings))| {
                let control = [Control::Pretimed, Control::Actuated, Control::Coordinated][control];
                let mut plan = ExistingPlan::new(control, Vec::new());
                for (position, ((phase, barrier, ring), two)) in
                    (1..).zip(phases.into_iter().zip(numbers.chunks(2)))
                {
                    let (number, also) =
                        (two[0].min(two[1]), phase.also.map(|_| two[0].max(two[1])));
                    plan.phases.push(PlanPhase {
                        number,
                        also,
                        ring: ring.min(rings),
                        barrier,
                        position,
                        ..phase
                    });
                }
                plan.phases.sort_by_key(|phase| phase.number);
                let held =
                    plan.sides().swap_remove(0).map(|ring| Some(plan.phases[*ring.last()?].number));
                plan.reference = held.into_iter().flatten().collect();
                plan.cycle_s =
                    (control != Control::Actuated).then(|| (plan.sum_s() * 10.0).round() / 10.0);
                ExistingPlan {
                    offset_s: offset_s.map(|s| f64::from(s) / 10.0),
                    referenced_to,
                    ..plan
                }
            },
        );
        plan.prop_filter("can be shown", |plan| plan.check().is_ok())
    }

    /// Four arms with leading lefts of 8 s on the street of phases 2 and 6, permissive lefts on the other one: splits of
    /// 12.5, 24.5 and 24.5 s.
    pub(crate) fn plan(control: Control) -> ExistingPlan {
        let left = |phase: PlanPhase| PlanPhase { max_green_s: 8.0, ..phase };
        let phases = vec![
            left(phase(1, [1, 1, 1], "SBL")),
            phase(2, [1, 1, 2], "NBT NBR"),
            phase(4, [2, 1, 1], "EBT EBR ebl"),
            left(phase(5, [1, 2, 1], "NBL")),
            phase(6, [1, 2, 2], "SBT SBR"),
            phase(8, [2, 2, 1], "WBT WBR wbl"),
        ];
        let cycle_s = (control != Control::Actuated).then_some(61.5);
        ExistingPlan { cycle_s, reference: vec![2, 6], ..ExistingPlan::new(control, phases) }
    }
}

#[cfg(test)]
mod tests {
    use super::testing::{phase, plan, plans};
    use super::*;

    fn refused(change: &dyn Fn(&mut ExistingPlan)) -> String {
        let mut plan = plan(Control::Coordinated);
        change(&mut plan);
        plan.check().unwrap_err()
    }

    #[test]
    fn rings_are_sides_with_phases_in_their_order_and_pairs_are_green_together() {
        let plan = plan(Control::Pretimed);
        assert_eq!(plan.sides(), [[vec![0, 1], vec![3, 4]], [vec![2], vec![5]]]);
        assert_eq!(plan.pairs(), [vec![0, 3], vec![0, 4], vec![1, 3], vec![1, 4], vec![2, 5]]);
        assert_eq!(plan.check(), Ok(vec![]));
        assert_eq!(plan.sum_s(), 61.5);
    }

    #[test]
    fn a_phase_that_ends_nothing_needs_no_yellow() {
        let checked = |next: &str, recall: Recall| {
            let mut phases = vec![
                phase(1, [1, 1, 1], "SBL"),
                phase(2, [1, 1, 2], next),
                phase(4, [2, 1, 1], "EBT"),
            ];
            (phases[0].yellow_s, phases[0].all_red_s) = (0.0, 0.0);
            phases.iter_mut().for_each(|p| p.recall = recall);
            ExistingPlan::new(Control::Actuated, phases).check()
        };
        assert_eq!(checked("SBT SBL", Recall::Min), Ok(vec![]));
        assert_eq!(checked("SBT sbl", Recall::Min), Ok(vec![]));
        for (next, recall) in [("SBT", Recall::Min), ("SBT SBL", Recall::None)] {
            let e = checked(next, recall).unwrap_err();
            assert!(
                e.contains("phase 1 has a yellow of 0 s; expected 1 to 10 s, or less where"),
                "{e}"
            );
        }
    }

    #[test]
    fn what_cannot_be_shown_is_said_with_the_way_out() {
        type Change<'a> = &'a dyn Fn(&mut ExistingPlan);
        let cases: [(Change<'_>, &str); 8] = [
            (
                &|p| p.phases[1].number = 1,
                "phase 1 has the number, or barrier, ring and position, of",
            ),
            (&|p| p.phases[1].position = 1, "phase 2 has the number, or barrier, ring and"),
            (&|p| p.phases[1].min_green_s = 30.0, "phase 2: the shortest green of 30 s is longer"),
            (
                &|p| p.reference = vec![3],
                "phase 3 is none of the phases {1, 2, 4, 5, 6, 8}; correct",
            ),
            (&|p| p.reference.clear(), "give the phases that hold the green"),
            (&|p| p.reference = vec![1, 2], "as reference, one per ring, such as 2 6"),
            (
                &|p| p.cycle_s = Some(90.0),
                "the cycle is 90 s, but the splits (longest green, yellow",
            ),
            (&|p| p.cycle_s = None, "coordinated without a cycle"),
        ];
        for (change, expected) in cases {
            let e = refused(change);
            assert!(e.contains(expected), "{e}");
        }
        let nothing = |p: &mut ExistingPlan| {
            p.phases.iter_mut().for_each(|p| (p.movements, p.yielding) = (vec![], vec![]));
        };
        assert!(refused(&nothing).contains("no phase has a movement"));
    }

    #[test]
    fn a_green_shorter_than_a_second_is_refused_and_a_ring_that_waits_is_said() {
        let e = refused(&|p| {
            p.phases[0].max_green_s = 0.1;
            p.phases[0].min_green_s = 0.1;
            p.phases[1].max_green_s = 27.9;
        });
        assert!(e.contains("phase 1 has a green of 0.1 s, and steps are of 1 s"), "{e}");
        let mut plan = plan(Control::Pretimed);
        plan.phases[4].max_green_s = 15.0;
        let mut people = phase(9, [3, 1, 1], "");
        (people.walk_s, plan.cycle_s) = (Some([7.0, 6.0]), None);
        plan.phases.push(people);
        let notes = plan.check().unwrap();
        assert!(notes[0].contains("phase 6 lasts 20 s instead of 15 s"), "{notes:?}");
        assert!(notes[1].contains("phase 9 is for pedestrians alone: a fixed"), "{notes:?}");
    }

    proptest::proptest! {
        #[test]
        fn greens_miss_the_plan_s_by_the_least_sum_and_the_cycle_stays(plan in plans()) {
            let mut plan = ExistingPlan { control: Control::Pretimed, ..plan };
            plan.phases.truncate(4);
            plan.phases.iter_mut().for_each(|phase| (phase.barrier, phase.ring) = (1, 1));
            plan.phases.sort_by_key(|phase| phase.position);
            let (timed, cycle_s) = schedule(&plan);
            proptest::prop_assert_eq!(cycle_s, nearest_s(plan.sum_s()));
            proptest::prop_assert_eq!(timed.iter().map(|t| t.split_s()).sum::<u32>(), cycle_s);
            let missed_s = |phase: &PlanPhase, green: u32| (phase.max_green_s - f64::from(green)).abs();
            let ours = plan.phases.iter().zip(&timed).map(|(phase, t)| missed_s(phase, t.green_s));
            // All greens, changes and ends of whole seconds beside their own that make the cycle.
            let (mut all, mut ends_s) = (vec![(0.0, 0)], 0.0);
            for phase in &plan.phases {
                ends_s += phase.split_s();
                let changes = beside(phase.yellow_s + phase.all_red_s);
                let of = |green| changes.map(|change| (missed_s(phase, green), green + change));
                let both: Vec<(f64, u32)> = beside(phase.max_green_s).map(of).concat();
                all = both.iter().flat_map(|(s, sum)| all.iter().map(move |way| (way.0 + s, way.1 + sum))).collect();
                all.retain(|way| beside(ends_s).contains(&way.1));
            }
            let least = all.iter().filter(|way| way.1 == cycle_s).map(|way| way.0);
            proptest::prop_assert!(ours.sum::<f64>() < least.fold(f64::INFINITY, f64::min) + 1e-9, "{timed:?}");
        }
    }
}
