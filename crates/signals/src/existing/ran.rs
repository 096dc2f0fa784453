//! Plans from what signals ran: dual rings as they are, and programs as phases of ring 1, one after the other.
//!
//! A stage is a green with the change after it. A movement of several stages has several phases. The passage time of SUMO's
//! `actuated` is the program's `max-gap`, else SUMO's default of 3 s.

use std::collections::BTreeMap;

use super::{Control, ExistingPlan, PlanPhase, Recall, Timed, schedule};
use crate::control::actuated::SUMO_GAP_S;
use crate::program::{ProgramKind, ProgramPhase, RingPhase, SignalProgram};
use crate::settings::SignalSettings;
use crate::timing::{Timing, tenths};
use crate::vocabulary::listed;

/// A green with the change after it.
#[derive(Debug, Clone, PartialEq)]
pub struct Green {
    /// Its state.
    pub state: String,
    /// Its duration, of actuated programs the shortest, seconds.
    pub green_s: f64,
    /// Longest duration of actuated programs, seconds.
    pub max_s: Option<f64>,
    /// Yellow after it, seconds.
    pub yellow_s: f64,
    /// All-red after it, seconds.
    pub all_red_s: f64,
    /// Yellow and all-red for the cabinet where the two are rounded, tenths of seconds.
    pub exact_s: Option<[f64; 2]>,
    /// Walk and clearance beside it, seconds.
    pub walk_s: Option<[f64; 2]>,
}

/// Returns the plan of a signal that ran in two rings, by vehicles.
pub fn of_rings(signal: &SignalProgram) -> ExistingPlan {
    let phase = |p: &RingPhase| {
        let [yellow_s, all_red_s] = p.exact_s.unwrap_or([p.yellow_s, p.all_red_s].map(f64::from));
        PlanPhase {
            number: p.number,
            ring: p.ring,
            barrier: p.barrier,
            position: p.position,
            movements: p.movements.clone(),
            yielding: p.yielding.clone(),
            min_green_s: p.min_green_s.into(),
            max_green_s: match p.split_s {
                Some(split_s) => tenths(f64::from(split_s) - yellow_s - all_red_s).max(0.0),
                None => p.max_green_s.into(),
            },
            passage_s: p.passage_s.into(),
            yellow_s,
            all_red_s,
            walk_s: p.walk_s.zip(p.clearance_s).and_then(|(walk, clear)| people(walk, clear)),
            recall: if p.recall { Recall::Min } else { Recall::None },
            dual_entry: p.number.is_multiple_of(2),
            // A force-off ends a phase that began early, not the length of its split.
            inhibit_max: p.split_s.is_some(),
            ..PlanPhase::default()
        }
    };
    let phases = signal.rings.iter().map(phase).collect();
    let Some(cycle_s) = signal.cycle_s.map(f64::from) else {
        return ExistingPlan::new(Control::Actuated, phases);
    };
    let held = || signal.rings.iter().filter(|p| p.coordinated);
    let reference = held().map(|p| p.number).collect();
    let mut plan = ExistingPlan {
        cycle_s: Some(cycle_s),
        reference,
        ..ExistingPlan::new(Control::Coordinated, phases)
    };
    // Plans count from the beginning of the first coordinated green, rings from the end of the first that ends.
    let (timed, _) = schedule(&plan);
    let coordinated = plan.coordinated();
    let of = |time: fn(&Timed) -> u32| coordinated.iter().map(|p| time(&timed[*p])).min();
    let begin_s = of(|t| t.begin_s).unwrap_or_default();
    let end_s = of(|t| t.begin_s + t.green_s).unwrap_or_default();
    let before_s = f64::from(end_s) - f64::from(begin_s);
    plan.offset_s = Some((signal.offset_s - before_s).rem_euclid(cycle_s));
    plan
}

/// Returns walk and clearance as plans have them: both or none.
fn people(walk_s: u32, clearance_s: u32) -> Option<[f64; 2]> {
    (walk_s > 0 && clearance_s > 0).then(|| [walk_s, clearance_s].map(f64::from))
}

/// Returns the stages of a program as phases of one ring; `None` for kinds that are no list of phases.
///
/// # Arguments
///
/// * `names` — of the movements, by link, with spaces between several; a link without one is passed over.
pub fn of_program(
    program: &SignalProgram,
    names: &BTreeMap<usize, String>,
) -> Option<ExistingPlan> {
    let is_fixed = program.kind == ProgramKind::Static;
    if !is_fixed && program.kind != ProgramKind::Actuated {
        return None;
    }
    let of = |state: &str, letter: char| {
        let links = state.char_indices().filter(|(_, c)| *c == letter);
        let of_links = links.filter_map(|(link, _)| names.get(&link));
        listed(of_links.flat_map(|names| names.split_whitespace()))
    };
    let phases: Vec<PlanPhase> = (1u32..)
        .zip(greens(program))
        .map(|(number, green)| {
            let movements = of(&green.state, 'G');
            let mut yielding = of(&green.state, 'g');
            yielding.retain(|name| !movements.contains(name));
            let shown_s = [green.yellow_s, green.all_red_s];
            let [yellow_s, all_red_s] = green.exact_s.unwrap_or(shown_s);
            // The cycle stays.
            let rest_s = shown_s.iter().sum::<f64>() - yellow_s - all_red_s;
            let green_s = if is_fixed { tenths(green.green_s + rest_s) } else { green.green_s };
            PlanPhase {
                number,
                ring: 1,
                barrier: 1,
                position: number,
                movements,
                yielding,
                min_green_s: green_s,
                max_green_s: green.max_s.unwrap_or(green_s),
                passage_s: if is_fixed { 0.0 } else { program.max_gap_s.unwrap_or(SUMO_GAP_S) },
                yellow_s,
                all_red_s,
                walk_s: green.walk_s,
                recall: if is_fixed { Recall::Max } else { Recall::Min },
                dual_entry: true,
                ..PlanPhase::default()
            }
        })
        .collect();
    let cycle_s = is_fixed.then(|| tenths(phases.iter().map(PlanPhase::split_s).sum()));
    let control = if is_fixed { Control::Pretimed } else { Control::Actuated };
    let reference = if is_fixed { vec![1] } else { Vec::new() };
    let offset_s = Some(program.offset_s);
    Some(ExistingPlan { cycle_s, offset_s, reference, ..ExistingPlan::new(control, phases) })
}

/// Returns the greens of a program with what comes after each; phases before the first green belong to
/// the last.
pub fn greens(program: &SignalProgram) -> Vec<Green> {
    let phases = &program.phases;
    let is_actuated = program.kind == ProgramKind::Actuated;
    let green = |p: &ProgramPhase| Green {
        state: p.state.clone(),
        green_s: p.min_s.filter(|_| is_actuated).unwrap_or(p.duration_s),
        max_s: p.max_s.filter(|_| is_actuated),
        yellow_s: 0.0,
        all_red_s: 0.0,
        exact_s: p.exact_s,
        walk_s: p.walk_s.zip(p.clearance_s).and_then(|(walk, clear)| people(walk, clear)),
    };
    let starts = starts(program);
    let mut greens: Vec<Green> = starts.iter().map(|i| green(&phases[*i])).collect();
    for (k, start) in starts.iter().enumerate() {
        let next = starts[(k + 1) % starts.len()];
        let steps = (next + phases.len() - start - 1) % phases.len();
        for i in (1..=steps).map(|step| (start + step) % phases.len()) {
            let is_yellow = phases[i].state.contains(['y', 'Y', 'u']);
            let time_s = if is_yellow { &mut greens[k].yellow_s } else { &mut greens[k].all_red_s };
            *time_s += phases[i].duration_s;
        }
    }
    greens
}

/// Returns the indices of the phases that are greens.
pub fn starts(program: &SignalProgram) -> Vec<usize> {
    let timing = Timing::new(&SignalSettings::default(), Vec::new(), Vec::new());
    let pairs = program.phases.iter().map(|p| (p.state.as_str(), p.duration_s));
    timing.greens(&pairs.collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn program(phases: &[(&str, f64)]) -> SignalProgram {
        let phases = phases.iter().map(|(state, s)| ProgramPhase::fixed(*state, *s)).collect();
        SignalProgram::new("c", ProgramKind::Static, phases)
    }

    fn found(phases: &[(&str, f64)]) -> Vec<(String, [f64; 3])> {
        let greens = greens(&program(phases));
        greens.into_iter().map(|g| (g.state, [g.green_s, g.yellow_s, g.all_red_s])).collect()
    }

    #[test]
    fn a_green_has_the_change_after_it_also_across_the_end_of_the_cycle() {
        let cycle =
            [("rr", 1.0), ("Gr", 30.0), ("yr", 4.0), ("rr", 2.0), ("rG", 20.0), ("ry", 3.0)];
        let expected = [("Gr".to_owned(), [30.0, 4.0, 2.0]), ("rG".to_owned(), [20.0, 3.0, 1.0])];
        assert_eq!(found(&cycle), expected);
    }

    #[test]
    fn stages_of_a_program_are_phases_one_after_the_other() {
        let mut program =
            program(&[("Gg", 20.0), ("yy", 4.0), ("rr", 1.0), ("rG", 10.0), ("ry", 3.0)]);
        (program.phases[0].walk_s, program.phases[0].clearance_s) = (Some(7), Some(12));
        let names = BTreeMap::from([(0, "NBT".to_owned()), (1, "NBL".to_owned())]);
        let plan = of_program(&program, &names).unwrap();
        let told: Vec<_> = (plan.phases.iter())
            .map(|p| (p.position, p.movements.join(" "), p.yielding.join(" "), p.split_s()))
            .collect();
        let text = |s: &str| s.to_owned();
        assert_eq!(told, [(1, text("NBT"), text("NBL"), 25.0), (2, text("NBL"), text(""), 13.0)]);
        assert_eq!((plan.cycle_s, plan.check()), (Some(38.0), Ok(vec![])));
        assert_eq!([0, 1].map(|p: usize| plan.phases[p].walk_s), [Some([7.0, 12.0]), None]);
    }

    #[test]
    fn an_actuated_program_has_its_shortest_and_longest_green_and_its_gap() {
        let mut program = program(&[("Gr", 28.0), ("yr", 3.0), ("rG", 20.0), ("ry", 3.0)]);
        program.kind = ProgramKind::Actuated;
        (program.phases[0].min_s, program.phases[0].max_s) = (Some(5.0), Some(40.0));
        let names = BTreeMap::from([(0, "NBT".to_owned()), (1, "EBT".to_owned())]);
        let told = |program: &SignalProgram| {
            let plan = of_program(program, &names).unwrap();
            let of = |p: &PlanPhase| [p.min_green_s, p.max_green_s, p.passage_s];
            plan.phases.iter().map(of).collect::<Vec<_>>()
        };
        assert_eq!(told(&program), [[5.0, 40.0, 3.0], [20.0, 20.0, 3.0]]);
        program.max_gap_s = Some(2.5);
        assert_eq!(told(&program), [[5.0, 40.0, 2.5], [20.0, 20.0, 2.5]]);
    }
}
