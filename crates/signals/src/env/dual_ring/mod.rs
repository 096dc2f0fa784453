//! Dual-ring control of one signal: phases from its links, rings that go on every second.
//!
//! `links` says what may be green together, `plan` makes phases of it, or `existing` those of a plan that
//! somebody brings, `coordination` puts phases into a cycle; `rings` plays them. All are pure; this file joins them to a scene.

mod coordination;
mod existing;
mod links;
mod plan;
mod rings;
#[cfg(test)]
mod testing;
#[cfg(test)]
mod tests;

use crate::control::dual_ring::Config;
use crate::existing::ExistingPlan;
use crate::program::{ProgramKind, ProgramPhase, RingPhase, RingStages, SignalProgram};
use crate::sim::{Scene, SignalInfo};
use crate::vocabulary::listed;

use self::coordination::coordinate;
pub use self::existing::fixed_cycle;
use self::links::Links;
use self::plan::{Phase, Plan};
use self::rings::{Rings, Seen};
use super::derive::{DerivedSignal, PHASES_PROGRAM, greens};
use super::pedestrians::Pedestrians;
use crate::timing::{Change, Timing, WALK_S};

/// Dual-ring control of one signal.
#[derive(Debug, Clone)]
pub struct DualRing {
    rings: Rings,
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

    /// Returns the control of a signal that is about to begin within a cycle, at a time in seconds; `None` where two rings cannot
    /// follow its stages.
    pub fn coordinated(
        scene: &Scene,
        signal: &SignalInfo,
        derived: &DerivedSignal,
        (config, stages): (&Config, &RingStages),
        now_s: f64,
    ) -> Option<Self> {
        let (links, plan) = planned(scene, signal, derived, config);
        let plan = coordinate(stages, plan, &links, &derived.timing, now_s.round() as u32)?;
        let cycle = cycle_of(stages, &derived.timing).into_iter();
        let cycle = cycle.map(|(state, s)| ProgramPhase::fixed(state, s)).collect();
        Some(Self { stages: Some(stages.clone()), cycle, ..Self::of(links, plan, derived) })
    }

    /// Returns the control of a signal that runs an existing plan and sees vehicles.
    pub fn existing(
        scene: &Scene,
        signal: &SignalInfo,
        derived: &DerivedSignal,
        plan: &ExistingPlan,
    ) -> Result<Self, String> {
        let (links, plan) = existing::rings(plan, scene, signal, &derived.timing)?;
        Ok(Self::of(links, plan, derived))
    }

    fn of(links: Links, plan: Plan, derived: &DerivedSignal) -> Self {
        let rings = Rings::new(links, plan, derived.timing.clone());
        Self { rings, stages: None, cycle: Vec::new() }
    }

    /// Returns what is shown now.
    pub fn shown(&self) -> &str {
        &self.rings.shown
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
        mut pedestrians: Option<(f64, &mut Pedestrians)>,
    ) -> Option<&str> {
        if let Some((now_s, pedestrians)) = &mut pedestrians {
            pedestrians.arrive(*now_s);
        }
        let waits = |crossing: usize| pedestrians.as_ref().is_some_and(|(_, p)| p.waits(crossing));
        let seen = |phase: &Phase| {
            let mut on =
                phase.detectors.iter().filter(|d| nearest_m[d.lane] <= d.reach_m).peekable();
            let extends = phase.is_full || on.peek().is_some();
            let is_called = on.any(|d| {
                let is_green = |link: &usize| self.rings.green.contains(*link);
                d.calls && (d.served_by.is_empty() || !d.served_by.iter().all(is_green))
            });
            let waiting = phase.crossings.iter().filter(|(crossing, _)| waits(*crossing));
            let walk_s = waiting.map(|(_, takes_s)| *takes_s).max();
            Seen { calls: is_called || walk_s.is_some(), extends, walk_s }
        };
        let seen: Vec<Seen> = self.rings.plan.phases.iter().map(seen).collect();
        let before = self.rings.shown.clone();
        self.rings.second(&seen);
        if let Some((now_s, pedestrians)) = pedestrians {
            let walking = self.rings.walking().map(|phase| &self.rings.plan.phases[phase]);
            for (crossing, _) in walking.flat_map(|phase| &phase.crossings) {
                pedestrians.go(*crossing, now_s);
            }
        }
        (self.rings.shown != before).then_some(&self.rings.shown)
    }

    /// Returns what a cabinet is told of the signal. Of existing plans, which say it themselves, it has no cycle.
    ///
    /// # Arguments
    ///
    /// * `names` — per link index the names of its movements.
    pub fn program(&self, signal: &str, names: &[Vec<String>]) -> SignalProgram {
        let coordination = self.rings.plan.coordination.as_ref();
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
        let plan = &self.rings.plan;
        // An existing plan says itself what its cycle is.
        let cycle = plan.coordination.as_ref().filter(|cycle| cycle.yields_s.is_some());
        let is_called = |index: &&usize| cycle.is_none_or(|c| c.splits_s[**index].is_some());
        let phase = |index: usize, other_ring: &[usize], [barrier, ring, position]: [usize; 3]| {
            let phase = &plan.phases[index];
            let is_yielding = |link: &&usize| self.rings.yields(**link, index, other_ring);
            let (yielding, own): (Vec<&usize>, _) = phase.links.iter().partition(is_yielding);
            let named = |links: Vec<&usize>| {
                let of_links = links.into_iter().filter_map(|link| names.get(*link));
                listed(of_links.flatten().map(String::as_str))
            };
            let (movements, mut yielding) = (named(own), named(yielding));
            // A movement whose links differ has the right of way on some of its lanes.
            yielding.retain(|name| !movements.contains(name));
            let people_s = phase.crossings.iter().map(|crossing| crossing.1).max();
            RingPhase {
                number: phase.number,
                ring: ring as u32 + 1,
                barrier: barrier as u32 + 1,
                position: position as u32 + 1,
                movements,
                yielding,
                min_green_s: phase.min_s,
                passage_s: phase.passage_s,
                max_green_s: phase.max_s,
                yellow_s: phase.change.yellow_s,
                all_red_s: phase.change.all_red_s,
                walk_s: people_s.map(|all_s| all_s.min(WALK_S)),
                clearance_s: people_s.map(|all_s| all_s.saturating_sub(WALK_S)),
                recall: phase.recall,
                split_s: cycle.and_then(|cycle| cycle.splits_s[index]),
                coordinated: cycle.is_some_and(|cycle| cycle.holds[index]),
            }
        };
        let mut sheet = Vec::new();
        for (barrier, side) in plan.sides.iter().enumerate() {
            for (ring, phases) in side.iter().enumerate() {
                let called = phases.iter().filter(is_called).enumerate();
                let at = |(position, index): (usize, &usize)| {
                    phase(*index, &side[1 - ring], [barrier, ring, position])
                };
                sheet.extend(called.map(at));
            }
        }
        sheet
    }

    /// Returns the phases in words, as records keep them.
    pub fn describe(&self) -> String {
        let plan = &self.rings.plan;
        let cycle = plan.coordination.as_ref().filter(|cycle| cycle.yields_s.is_some());
        let phase = |index: &usize| {
            let Phase { number, serves, min_s, max_s, passage_s, .. } = &plan.phases[*index];
            let Change { yellow_s, all_red_s } = plan.phases[*index].change;
            let more = match cycle.map(|cycle| (cycle.splits_s[*index], cycle.holds[*index])) {
                Some((Some(split_s), true)) => format!(", split {split_s} s, coordinated"),
                Some((Some(split_s), false)) => format!(", split {split_s} s"),
                Some((None, _)) => ", never called".to_owned(),
                None if plan.phases[*index].recall => ", recall".to_owned(),
                None => String::new(),
            };
            let alone = self.rings.alone(*index);
            format!(
                "{number} ({serves} {alone}; green {min_s} to {max_s} s, passage {passage_s} s, yellow {yellow_s} s, red \
                 {all_red_s} s{more})"
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
        let within = cycle.and_then(|cycle| Some((cycle.cycle_s, cycle.yields_s?)));
        let within = within.map_or_else(String::new, |(cycle_s, yields_s)| {
            format!(" in a cycle of {cycle_s} s, coordinated phases may end at {yields_s} s")
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
    let programs = || signal.programs.iter();
    let witnesses = programs()
        .filter(|program| [signal.active_program.as_str(), PHASES_PROGRAM].contains(&&*program.id));
    let states = witnesses.flat_map(|program| greens(program, timing)).collect();
    let mut links = Links::new(scene, signal, states);
    // Only programs that were made with the setting say by their arrows who has one.
    let is_generated = programs().any(|program| program.id == PHASES_PROGRAM);
    links.arrows_only = !timing.settings.left_turns.is_network() && is_generated;
    links.has_inner = derived.spec.movements.iter().any(|movement| !movement.inner.is_empty());
    let plan = Plan::new(&links, &derived.own_greens, timing, config);
    (links, plan)
}
