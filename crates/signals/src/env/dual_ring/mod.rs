//! Dual-ring control of one signal: phases from its links, rings that go on every second.
//!
//! `links` says what may be green together, `streets` and `plan` make phases of it, or `existing` those of a plan that
//! somebody brings, `coordination` puts phases into a cycle; `rings` plays them. All are pure; this file joins them to a scene.

mod coordination;
mod existing;
mod links;
mod plan;
mod rings;
mod streets;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;

use crate::control::dual_ring::Config;
use crate::existing::ExistingPlan;
use crate::program::{ProgramKind, ProgramPhase, RingPhase, RingStages, SignalProgram};
use crate::sim::{Scene, SignalInfo};
use crate::vocabulary::listed_before;

use self::coordination::coordinate;
use self::existing::Wired;
pub use self::existing::fixed_cycle;
use self::links::Links;
use self::plan::Plan;
use self::rings::{Rings, Seen};
use super::derive::{DerivedSignal, PHASES_PROGRAM};
use super::pedestrians::Pedestrians;
use crate::timing::{Timing, WALK_S};

/// Dual-ring control of one signal.
#[derive(Debug, Clone)]
pub struct DualRing {
    rings: Rings,
    seen: Seen,
    stages: Option<RingStages>,
    /// The cycle of the stages, with what is shown between them.
    cycle: Vec<ProgramPhase>,
}

impl DualRing {
    /// Returns the control of a signal that is about to begin.
    pub fn new(
        scene: &Scene,
        signal: &SignalInfo,
        derived: &DerivedSignal,
        config: &Config,
    ) -> Self {
        let (links, plan) = planned(scene, signal, derived, config);
        Self::of(links, plan, derived)
    }

    /// Returns the control of a signal that is about to begin within a cycle.
    ///
    /// # Arguments
    ///
    /// * `now_s` — the time, seconds.
    pub fn coordinated(
        scene: &Scene,
        signal: &SignalInfo,
        derived: &DerivedSignal,
        (config, stages): (&Config, &RingStages),
        now_s: f64,
    ) -> Result<Self, String> {
        let (links, plan) = planned(scene, signal, derived, config);
        let plan = coordinate(stages, plan, &links, &derived.timing, now_s.round() as u32)?;
        let cycle = cycle_of(stages, &derived.timing).into_iter();
        let cycle = cycle.map(|(state, s)| ProgramPhase::fixed(state, s)).collect();
        Ok(Self { stages: Some(stages.clone()), cycle, ..Self::of(links, plan, derived) })
    }

    /// Returns the control of a signal that runs an existing plan and sees vehicles.
    pub fn existing(
        scene: &Scene,
        signal: &SignalInfo,
        derived: &DerivedSignal,
        plan: &ExistingPlan,
    ) -> Result<Self, String> {
        let wired = Wired::new(plan, scene, signal)?;
        let rings = wired.rings(&derived.timing);
        Ok(Self::of(wired.links, rings, derived))
    }

    fn of(links: Links, plan: Plan, derived: &DerivedSignal) -> Self {
        let none = vec![false; plan.phases.len()];
        Self {
            rings: Rings::new(links, plan, derived.timing.clone()),
            seen: Seen { calls: none.clone(), extends: none, walk_s: Vec::new() },
            stages: None,
            cycle: Vec::new(),
        }
    }

    /// Returns what is shown now.
    pub fn shown(&self) -> &str {
        self.rings.shown()
    }

    /// Lets a second go by and returns what is shown from then on, if it is something else.
    ///
    /// # Arguments
    ///
    /// * `nearest_m` — shape `[lanes of the scene]`; distance of the first vehicle of each lane to the stop line,
    ///   metres, infinite without one.
    /// * `pedestrians` — the time, seconds, and who wants to cross, where they push buttons.
    pub fn second(
        &mut self,
        nearest_m: &[f64],
        pedestrians: Option<(f64, &mut Pedestrians)>,
    ) -> Option<&str> {
        for (index, phase) in self.rings.plan().phases.iter().enumerate() {
            let mut on =
                phase.detectors.iter().filter(|d| nearest_m[d.lane] <= d.reach_m).peekable();
            self.seen.extends[index] = phase.is_full || on.peek().is_some();
            self.seen.calls[index] = on.any(|d| {
                let served = !d.served_by.is_empty() && self.rings.all_green(&d.served_by);
                d.calls && !served
            });
        }
        let Some((now_s, pedestrians)) = pedestrians else {
            return self.rings.second(&self.seen);
        };
        pedestrians.arrive(now_s);
        let phases = &self.rings.plan().phases;
        let waiting = |c: &&(usize, u32)| pedestrians.waits(c.0);
        self.seen.walk_s =
            phases.iter().map(|p| p.crossings.iter().filter(waiting).map(|c| c.1).max()).collect();
        for (call, walk_s) in self.seen.calls.iter_mut().zip(&self.seen.walk_s) {
            *call |= walk_s.is_some();
        }
        let before = self.rings.shown().to_owned();
        self.rings.second(&self.seen);
        for phase in self.rings.walking() {
            for (crossing, _) in &self.rings.plan().phases[phase].crossings {
                pedestrians.go(*crossing, now_s);
            }
        }
        (self.rings.shown() != before).then(|| self.rings.shown())
    }

    /// Returns what a cabinet is told of the signal. Of existing plans, which say it themselves, it has no cycle.
    ///
    /// # Arguments
    ///
    /// * `names` — per link index the names of its movements.
    pub fn program(&self, signal: &str, names: &[Vec<String>]) -> SignalProgram {
        let coordination = self.rings.plan().coordination.as_ref();
        let cycle = coordination.and_then(|cycle| Some((cycle.cycle_s, cycle.yields_s?)));
        SignalProgram {
            offset_s: cycle.map_or(0.0, |(_, yields_s)| f64::from(yields_s)),
            cycle_s: cycle.map(|(cycle_s, _)| cycle_s),
            stages: self.stages.clone(),
            rings: self.sheet(names),
            ..SignalProgram::new(signal, ProgramKind::DualRing, self.cycle.clone())
        }
    }

    fn sheet(&self, names: &[Vec<String>]) -> Vec<RingPhase> {
        let plan = self.rings.plan();
        // An existing plan says itself what its cycle is.
        let cycle = plan.coordination.as_ref().filter(|cycle| cycle.yields_s.is_some());
        let mut sheet = Vec::new();
        for (barrier, side) in plan.sides.iter().enumerate() {
            for (ring, phases) in side.iter().enumerate() {
                let is_called =
                    |index: &&usize| cycle.is_none_or(|c| c.splits_s[**index].is_some());
                for (position, index) in phases.iter().filter(is_called).enumerate() {
                    let phase = &plan.phases[*index];
                    let (mut movements, mut yielding): (Vec<String>, Vec<String>) =
                        Default::default();
                    for link in &phase.links {
                        let into = match self.rings.yields(*link, *index, &side[1 - ring]) {
                            true => &mut yielding,
                            false => &mut movements,
                        };
                        for name in names.get(*link).into_iter().flatten() {
                            if !into.contains(name) {
                                into.push(name.clone());
                            }
                        }
                    }
                    // A movement whose links differ has the right of way on some of its lanes.
                    yielding.retain(|name| !movements.contains(name));
                    movements.sort_by_key(|name| listed_before(name));
                    yielding.sort_by_key(|name| listed_before(name));
                    let people_s = phase.crossings.iter().map(|crossing| crossing.1).max();
                    sheet.push(RingPhase {
                        number: phase.number,
                        ring: ring as u32 + 1,
                        barrier: barrier as u32 + 1,
                        position: position as u32 + 1,
                        movements,
                        yielding,
                        min_green_s: phase.min_s,
                        passage_s: phase.passage_s,
                        max_green_s: phase.max_s,
                        yellow_s: phase.change_s.0,
                        all_red_s: phase.change_s.1,
                        walk_s: people_s.map(|all_s| all_s.min(WALK_S)),
                        clearance_s: people_s.map(|all_s| all_s.saturating_sub(WALK_S)),
                        recall: phase.recall,
                        split_s: cycle.and_then(|cycle| cycle.splits_s[*index]),
                        coordinated: cycle.is_some_and(|cycle| cycle.holds[*index]),
                    });
                }
            }
        }
        sheet
    }

    /// Returns the phases in words, as records keep them.
    pub fn describe(&self) -> String {
        let plan = self.rings.plan();
        let cycle = plan.coordination.as_ref().filter(|cycle| cycle.yields_s.is_some());
        let phase = |index: &usize| {
            let p = &plan.phases[*index];
            let (yellow_s, red_s) = p.change_s;
            let is_held = cycle.is_some_and(|cycle| cycle.holds[*index]);
            let more = match (cycle.map(|cycle| cycle.splits_s[*index]), p.recall) {
                (Some(Some(split_s)), _) if is_held => format!(", split {split_s} s, coordinated"),
                (Some(Some(split_s)), _) => format!(", split {split_s} s"),
                (Some(None), _) => ", never called".to_owned(),
                (None, true) => ", recall".to_owned(),
                (None, false) => String::new(),
            };
            format!(
                "{} ({} {}; green {} to {} s, passage {} s, yellow {yellow_s} s, red {red_s} s{more})",
                p.number,
                p.serves,
                self.rings.alone(*index),
                p.min_s,
                p.max_s,
                p.passage_s,
            )
        };
        let ring = |(number, ring): (usize, &Vec<usize>)| {
            let phases: Vec<String> = ring.iter().map(phase).collect();
            (!phases.is_empty()).then(|| format!("ring {}: {}", number + 1, phases.join(", ")))
        };
        let side = |side: &[Vec<usize>; 2]| {
            side.iter().enumerate().filter_map(ring).collect::<Vec<_>>().join("; ")
        };
        let sides: Vec<String> = plan.sides.iter().map(side).collect();
        let kind = match (plan.stages, plan.is_existing) {
            (true, _) => "stages",
            (false, true) => "existing plan",
            (false, false) => "two rings",
        };
        let within = cycle.map_or_else(String::new, |cycle| {
            let yields_s = cycle.yields_s.unwrap_or_default();
            format!(
                " in a cycle of {} s, coordinated phases may end at {yields_s} s",
                cycle.cycle_s
            )
        });
        format!("{kind}{within}: {}", sides.join(" | barrier | "))
    }
}

/// Returns the states of a cycle of stages, the changes between them included, with their durations, seconds.
pub fn cycle_of(stages: &RingStages, timing: &Timing) -> Vec<(String, f64)> {
    let next = stages.greens.iter().cycle().skip(1);
    let with_change = |(green, next): (&ProgramPhase, &ProgramPhase)| {
        let change = timing.between(&green.state, &next.state).into_iter();
        let change = change.map(|(state, s)| (state, f64::from(s)));
        std::iter::once((green.state.clone(), green.duration_s)).chain(change)
    };
    stages.greens.iter().zip(next).flat_map(with_change).collect()
}

/// Returns the phases of a signal as they follow from its programs, whatever drives it.
fn planned(
    scene: &Scene,
    signal: &SignalInfo,
    derived: &DerivedSignal,
    config: &Config,
) -> (Links, Plan) {
    let timing = &derived.timing;
    let witnesses = signal
        .programs
        .iter()
        .filter(|program| program.id == signal.active_program || program.id == PHASES_PROGRAM);
    let greens = |program: &crate::sim::Program| -> Vec<String> {
        let phases = program.phases();
        timing.greens(&phases).into_iter().map(|i| phases[i].0.to_owned()).collect()
    };
    let mut links = Links::new(scene, signal, witnesses.flat_map(greens).collect());
    // Only programs that were made with the setting say by their arrows who has one.
    let is_generated = signal.programs.iter().any(|program| program.id == PHASES_PROGRAM);
    links.arrows_only = timing.says_left_turns() && is_generated;
    links.has_inner = derived.spec.movements.iter().any(|movement| !movement.inner.is_empty());
    let plan = Plan::new(&links, &derived.own_greens, timing, config);
    (links, plan)
}
