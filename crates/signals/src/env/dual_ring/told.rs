//! What is said of a signal in two rings: to cabinets, and in words.

use super::DualRing;
use super::plan::{Coordination, Phase};
use crate::program::{ProgramKind, RingPhase, SignalProgram};
use crate::timing::{Change, WALK_S};
use crate::vocabulary::listed;

impl DualRing {
    /// Returns what a cabinet is told of the signal. Of existing plans, which say it themselves, it has no cycle.
    ///
    /// # Arguments
    ///
    /// * `names` — per link index the names of its movements.
    pub fn program(&self, signal: &str, names: &[Vec<String>]) -> SignalProgram {
        let cycle = self.cycle();
        let (stages, phases) = self.told.clone().unzip();
        let phases = phases.unwrap_or_default();
        SignalProgram {
            offset_s: cycle.map_or(0.0, |(_, yields_s)| f64::from(yields_s)),
            cycle_s: cycle.map(|(cycle, _)| cycle.cycle_s),
            stages,
            rings: self.sheet(names),
            ..SignalProgram::new(signal, ProgramKind::DualRing, phases)
        }
    }

    /// Returns the cycle, and when its coordinated phases may end; `None` of existing plans, which say themselves what it is.
    fn cycle(&self) -> Option<(&Coordination, u32)> {
        self.plan.coordination.as_ref().and_then(|cycle| Some((cycle, cycle.yields_s?)))
    }

    fn sheet(&self, names: &[Vec<String>]) -> Vec<RingPhase> {
        let plan = &self.plan;
        let cycle = self.cycle().map(|(cycle, _)| cycle);
        let is_called = |index: &&usize| cycle.is_none_or(|c| c.splits_s[**index].is_some());
        let phase = |index: usize, other_ring: &[usize], [barrier, ring, position]: [usize; 3]| {
            let phase = &plan.phases[index];
            let is_yielding = |link: &usize| self.yields(*link, index, other_ring);
            let (yielding, own): (Vec<usize>, _) = phase.links.ones().partition(is_yielding);
            let named = |links: Vec<usize>| {
                let of_links = links.into_iter().filter_map(|link| names.get(link));
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
                exact_s: self.exact_s(phase),
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

    /// Returns yellow and all-red of a phase for the cabinet; existing plans say it themselves.
    fn exact_s(&self, phase: &Phase) -> Option<[f64; 2]> {
        let [from, to] = [&phase.links, &self.links.set([])].map(|links| self.links.plain(links));
        let exact_s = self.timing.exact_change_s(&from, &to).filter(|_| !self.plan.is_existing);
        phase.change.unless_exact(exact_s?)
    }

    /// Returns the phases in words, as records keep them.
    pub fn describe(&self) -> String {
        let plan = &self.plan;
        let cycle = self.cycle();
        let phase = |index: &usize| {
            let Phase { number, serves, min_s, max_s, passage_s, .. } = &plan.phases[*index];
            let Change { yellow_s, all_red_s } = plan.phases[*index].change;
            let more = match cycle.map(|(cycle, _)| (cycle.splits_s[*index], cycle.holds[*index])) {
                Some((Some(split_s), true)) => format!(", split {split_s} s, coordinated"),
                Some((Some(split_s), false)) => format!(", split {split_s} s"),
                Some((None, _)) => ", never called".to_owned(),
                None if plan.phases[*index].recall => ", recall".to_owned(),
                None => String::new(),
            };
            let alone = self.links.letters(self.links_of(*index), &self.links.set([]));
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
        let within = cycle.map_or_else(String::new, |(Coordination { cycle_s, .. }, yields_s)| {
            format!(" in a cycle of {cycle_s} s, coordinated phases may end at {yields_s} s")
        });
        format!("{kind}{within}: {}", sides.join(" | barrier | "))
    }
}
