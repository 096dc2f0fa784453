//! Plans that signals have today: phases in two rings, with the times that stand in the cabinet.
//!
//! [`table`] reads and writes them as CSV, [`utdf`](crate::utdf) as UTDF, [`placed`](crate::placed) gives their movements to the
//! arms of an intersection, and the environment shows them (`env::dual_ring`).
//!
//! Choices:
//! - **The plan's own times hold**: greens, yellow, all-red, walk and clearance are those of the cabinet, not the limits of
//!   `[signal]`, as with a network's own program.
//! - **Whole seconds**, because the simulation's steps are: yellow is rounded up, all-red so that both together are rounded
//!   up once, and starts of greens to the nearest second, so that the cycle does not drift.
//! - **A ring that is done before the other one** keeps its last phase green until the barrier, as Synchro does.
//! - **Offset and reference** have no effect: intersections are simulated apart. They are kept for whoever takes the plan
//!   back.
//!
//! Source: "Signal Timing Manual" (2nd ed., NCHRP Report 812), chapters 5 to 7; NEMA TS 2.

pub mod ran;
pub mod table;

use std::collections::{BTreeMap, BTreeSet};
use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use crate::timing::Change;
pub use table::read;

/// Most rings.
const RINGS: u32 = 2;

/// Shortest green that can be shown: a step of the simulation, seconds.
const STEP_S: f64 = 1.0;

/// How far cycle and splits may differ, seconds: tables have one digit after the point.
const CYCLE_SLACK_S: f64 = 0.55;

/// Highest number of a phase, a barrier or a position.
const MOST_NUMBER: f64 = 99.0;

/// Shortest yellow of a phase of which something ends, and the longest, seconds.
const YELLOW_S: [f64; 2] = [1.0, 10.0];

/// How a signal goes on from phase to phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Control {
    /// Every phase lasts its split.
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanPhase {
    /// Its number.
    pub number: u32,
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
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
        Self {
            control,
            cycle_s: None,
            offset_s: Some(0.0),
            reference: Vec::new(),
            referenced_to: 0,
            phases,
            merging: Vec::new(),
            ways: BTreeMap::new(),
        }
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
        let ring = |ring: &Vec<usize>| ring.iter().map(|i| self.phases[*i].split_s()).sum::<f64>();
        self.sides().iter().map(|side| ring(&side[0]).max(ring(&side[1]))).sum()
    }

    /// Checks that the plan can be shown, and returns what of it is not as it looks.
    pub fn check(&self) -> Result<Vec<String>, String> {
        if self.phases.iter().all(|p| p.all_movements().next().is_none()) {
            return Err("no phase has a movement; give movements such as NBT NBR".to_owned());
        }
        within("cycle_s", self.cycle_s.unwrap_or(2.0), 2.0..=3600.0)?;
        let most_s = self.cycle_s.unwrap_or(3600.0);
        within("offset_s", self.offset_s.unwrap_or_default(), -most_s..=most_s)?;
        let (mut numbers, mut places) = (BTreeSet::new(), BTreeSet::new());
        for phase in &self.phases {
            let PlanPhase { number, ring, barrier, position, .. } = *phase;
            let [walk_s, clearance_s] = phase.walk_s.unwrap_or_default();
            for (what, value, range) in [
                ("phase", number.into(), 1.0..=MOST_NUMBER),
                ("ring", ring.into(), 1.0..=RINGS.into()),
                ("barrier", barrier.into(), 1.0..=MOST_NUMBER),
                ("position", position.into(), 1.0..=MOST_NUMBER),
                ("yellow_s", phase.yellow_s, 0.0..=YELLOW_S[1]),
                ("max_green_s", phase.max_green_s, 0.1..=900.0),
                ("min_green_s", phase.min_green_s, 0.0..=600.0),
                ("min_split_s", phase.min_split_s.unwrap_or_default(), 0.0..=900.0),
                ("passage_s", phase.passage_s, 0.0..=60.0),
                ("all_red_s", phase.all_red_s, 0.0..=20.0),
                ("walk_s", walk_s, 0.0..=240.0),
                ("clearance_s", clearance_s, 0.0..=240.0),
            ] {
                within(&format!("phase {number}: {what}"), value, range)?;
            }
            if !numbers.insert(number) || !places.insert((barrier, ring, position)) {
                return Err(format!(
                    "phase {number} has the number, or barrier, ring and position, of a phase before it; give it its own"
                ));
            }
            if phase.min_green_s > phase.max_green_s && self.control != Control::Pretimed {
                return Err(format!(
                    "phase {number}: the shortest green of {} s is longer than the longest of {} s; correct one of the two \
                     (the longest green is the split without yellow and all-red)",
                    phase.min_green_s, phase.max_green_s
                ));
            }
        }
        self.check_changes()?;
        self.check_cycle(&numbers)?;
        let (timed, _) = schedule(self);
        for (phase, timed) in self.phases.iter().zip(&timed) {
            let is_short = match self.control {
                Control::Actuated => phase.max_green_s < STEP_S,
                Control::Pretimed | Control::Coordinated => timed.green_s < 1,
            };
            if is_short {
                return Err(format!(
                    "phase {} has a green of {} s, and steps are of 1 s; give it more, or remove the phase",
                    phase.number, phase.max_green_s
                ));
            }
        }
        Ok(self.notes(&timed))
    }

    /// Checks that a phase without a yellow ends nothing: all its movements go on in the phase after it.
    fn check_changes(&self) -> Result<(), String> {
        let sides = self.sides();
        for ring in sides.iter().flatten() {
            for (place, phase) in ring.iter().map(|i| &self.phases[*i]).enumerate() {
                let first = ring.first().filter(|_| sides.len() == 1);
                let goes_on = ring.get(place + 1).or(first).is_some_and(|next| {
                    let next = &self.phases[*next];
                    let comes = self.control == Control::Pretimed || next.recall != Recall::None;
                    let has = |name: &String| next.all_movements().any(|other| other == name);
                    comes && phase.all_movements().all(has)
                });
                let [least, most] = YELLOW_S;
                if phase.yellow_s < least && !goes_on {
                    return Err(format!(
                        "phase {} has a yellow of {} s; expected {least} to {most} s, or less where all its movements go on in \
                         the next phase of its ring and that phase comes in every cycle",
                        phase.number, phase.yellow_s
                    ));
                }
            }
        }
        Ok(())
    }

    /// Checks that the reference phases can hold the green, one per ring, and that the splits make the cycle.
    fn check_cycle(&self, numbers: &BTreeSet<u32>) -> Result<(), String> {
        if let Some(unknown) = self.reference.iter().find(|number| !numbers.contains(number)) {
            let known: Vec<String> = numbers.iter().map(u32::to_string).collect();
            let known = known.join(", ");
            return Err(format!(
                "reference phase {unknown} is none of the phases ({known}); correct the reference"
            ));
        }
        let is_coordinated = self.control == Control::Coordinated;
        let rings: Vec<u32> = self.coordinated().iter().map(|p| self.phases[*p].ring).collect();
        let is_held = matches!(rings[..], [_]) || matches!(rings[..], [a, b] if a != b);
        if self.reference.len() > 2 || is_coordinated && !is_held {
            return Err("give the phases that hold the green of a coordinated plan as reference, one per ring, such as 2 6"
                .to_owned());
        }
        let sum_s = self.sum_s();
        match self.cycle_s {
            _ if self.control == Control::Actuated => Ok(()),
            Some(cycle_s) if (cycle_s - sum_s).abs() > CYCLE_SLACK_S => Err(format!(
                "the cycle is {cycle_s} s, but the splits (longest green, yellow and all-red) of the longer ring of every \
                 side are {} s together; correct the cycle or a green",
                (sum_s * 10.0).round() / 10.0
            )),
            None if is_coordinated => {
                Err("control is coordinated without a cycle; give cycle_s".to_owned())
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
fn within(what: &str, value: f64, range: RangeInclusive<f64>) -> Result<(), String> {
    let (low, high) = (range.start(), range.end());
    let wrong = || format!("{what} = {value}: expected {low} to {high}");
    if range.contains(&value) { Ok(()) } else { Err(wrong()) }
}

/// What makes a time that is a whole number but for rounding stay one, seconds.
const ROUNDING_S: f64 = 1e-6;

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
}

/// Returns yellow and all-red in whole seconds: yellow is rounded up, and both together once.
pub fn whole_change(yellow_s: f64, all_red_s: f64) -> Change {
    let up = |seconds: f64| (seconds - ROUNDING_S).ceil().max(0.0) as u32;
    let whole_s = up(yellow_s);
    Change { yellow_s: whole_s, all_red_s: up(yellow_s + all_red_s).saturating_sub(whole_s) }
}

/// Returns the nearest whole second; a half is rounded up.
pub fn nearest_s(seconds: f64) -> u32 {
    (seconds + ROUNDING_S).round().max(0.0) as u32
}

/// Returns when every phase is green if each lasts its split, and the cycle, seconds. The last phase of a ring lasts until
/// the barrier.
pub fn schedule(plan: &ExistingPlan) -> (Vec<Timed>, u32) {
    let mut timed = vec![Timed::default(); plan.phases.len()];
    let mut side_begins_s = 0.0;
    for side in plan.sides() {
        let sum = |ring: &Vec<usize>| ring.iter().map(|i| plan.phases[*i].split_s()).sum::<f64>();
        let side_ends_s = side_begins_s + sum(&side[0]).max(sum(&side[1]));
        for ring in &side {
            let mut begins_s = side_begins_s;
            for (place, index) in ring.iter().enumerate() {
                let phase = &plan.phases[*index];
                let is_last = place + 1 == ring.len();
                let ends_s = if is_last { side_ends_s } else { begins_s + phase.split_s() };
                let change = whole_change(phase.yellow_s, phase.all_red_s);
                let (begin_s, end_s) = (nearest_s(begins_s), nearest_s(ends_s));
                let green_s = (end_s - begin_s).saturating_sub(change.total_s());
                timed[*index] = Timed { begin_s, green_s, change };
                begins_s = ends_s;
            }
        }
        side_begins_s = side_ends_s;
    }
    (timed, nearest_s(side_begins_s))
}

/// Plans written by hand, for tests.
#[cfg(test)]
pub(crate) mod testing {
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
            min_split_s: None,
            passage_s: 3.0,
            yellow_s: 3.5,
            all_red_s: 1.0,
            walk_s: None,
            recall: Recall::None,
            dual_entry: number.is_multiple_of(2),
            inhibit_max: false,
            detectors: String::new(),
        }
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
    use super::testing::{phase, plan};
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
        let cases: [(Change<'_>, &str); 9] = [
            (
                &|p| p.phases[1].number = 1,
                "phase 1 has the number, or barrier, ring and position, of",
            ),
            (&|p| p.phases[1].position = 1, "phase 2 has the number, or barrier, ring and"),
            (&|p| p.phases[0].ring = 3, "phase 1: ring = 3: expected 1 to 2"),
            (&|p| p.phases[1].min_green_s = 30.0, "phase 2: the shortest green of 30 s is longer"),
            (
                &|p| p.reference = vec![3],
                "phase 3 is none of the phases (1, 2, 4, 5, 6, 8); correct",
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
        assert!(notes[0].contains("phase 6 lasts 19 s instead of 15 s"), "{notes:?}");
        assert!(notes[1].contains("phase 9 is for pedestrians alone: a fixed"), "{notes:?}");
    }

    #[test]
    fn yellow_is_rounded_up_and_both_together_once() {
        let of = |yellow_s, all_red_s| {
            let Change { yellow_s, all_red_s } = whole_change(yellow_s, all_red_s);
            (yellow_s, all_red_s)
        };
        assert_eq!([of(3.5, 1.0), of(3.6, 1.4), of(4.3, 1.2)], [(4, 1), (4, 1), (5, 1)]);
        assert_eq!([of(3.0, 0.0), of(4.1, 1.1)], [(3, 0), (5, 1)]);
    }

    #[test]
    fn starts_are_rounded_and_the_cycle_does_not_drift() {
        // Splits of 12.5, 24.5 and 24.5 s: starts at 0, 12.5 and 37 s, cycle 61.5 s.
        let (timed, cycle_s) = schedule(&plan(Control::Pretimed));
        let of = |i: usize| (timed[i].begin_s, timed[i].green_s);
        assert_eq!([of(0), of(1), of(2)], [(0, 8), (13, 19), (37, 20)]);
        assert_eq!((of(3), of(4), of(5), cycle_s), (of(0), of(1), of(2), 62));
        let mut alone = plan(Control::Pretimed);
        alone.phases.remove(3);
        // Phase 6 alone in ring 2, until the barrier: 37 s without its change of 5 s.
        assert_eq!((schedule(&alone).0[3].begin_s, schedule(&alone).0[3].green_s), (0, 32));
    }
}
