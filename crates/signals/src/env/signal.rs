//! The programs that make SUMO show what a controller decides.

use crate::control::actuated::SUMO_GAP_S;
use crate::control::{Drive, GreenPhase};
use crate::sim::error::SimError;
use crate::sim::{Program, ProgramKind, ProgramPhase};
use crate::timing::Timing;

use super::derive::DerivedSignal;

/// Id of the programs installed here.
const INSTALLED: &str = "tsc-family";

/// Duration of a phase that only a decision ends, seconds.
///
/// Deviation: RESCO's published runs gave greens the length of a decision interval, its present
/// version keeps the network's own durations, so that a short green ends by itself.
const UNTIL_DECISION_S: f64 = 100_000.0;

/// How the lights get from one green to another: yellow, and all-red after it if there is any, each as a
/// phase of a [`DecisionProgram`] and how long it lasts, seconds.
pub type Transition = Vec<(u32, u32)>;

/// A program with every green and every change between two greens, and where they stand in it.
#[derive(Debug, Clone, PartialEq)]
pub struct DecisionProgram {
    /// Greens first, in the order of the signal's phases, then the changes.
    pub program: Program,
    changes: Vec<Vec<Transition>>,
}

impl DecisionProgram {
    /// Returns the program of a signal.
    pub fn new(signal: &DerivedSignal) -> Self {
        let greens: Vec<&str> = signal.spec.phases.iter().map(|p| p.state.as_str()).collect();
        let mut phases: Vec<_> =
            greens.iter().map(|g| ProgramPhase::fixed(*g, UNTIL_DECISION_S)).collect();
        let mut change = |from: &&str, to: &&str| {
            let mut transition = Transition::new();
            for (state, seconds) in signal.timing.between(from, to) {
                transition.push((phases.len() as u32, seconds));
                phases.push(ProgramPhase::fixed(state, UNTIL_DECISION_S));
            }
            transition
        };
        let changes =
            greens.iter().map(|from| greens.iter().map(|to| change(from, to)).collect()).collect();
        let program = Program::new(INSTALLED, ProgramKind::Static, phases);
        Self { program, changes }
    }

    /// Returns the way from one green to another; without phases when no light turns red.
    pub fn change(&self, from: GreenPhase, to: GreenPhase) -> &Transition {
        &self.changes[from.0][to.0]
    }
}

/// Returns the program that a drive needs; `None` for the network's own, for decisions, whose program
/// the signal's cabinet has, for dual rings, which are no program, and for existing plans, which the world has.
pub fn program(signal: &DerivedSignal, drive: &Drive) -> Result<Option<Program>, SimError> {
    let timing = &signal.timing;
    let own = |green: &dyn Fn(&str, f64, f64) -> ProgramPhase| {
        let states: Vec<&str> = signal.own_greens.iter().map(String::as_str).collect();
        let green = |(state, least_s): (&&str, u32)| {
            let most_s = timing.max_green_s(state).map_or(f64::INFINITY, f64::from);
            green(state, f64::from(least_s), most_s)
        };
        let least_s = timing.least_greens_s(&states);
        cycle(&states.iter().zip(least_s).map(green).collect::<Vec<_>>(), timing)
    };
    let make = |kind, phases| Some(Program::new(INSTALLED, kind, phases));
    Ok(match drive {
        Drive::OwnProgram
        | Drive::Decisions
        | Drive::DualRing(_)
        | Drive::CoordinatedRings(..)
        | Drive::Existing
        | Drive::Retimed(..) => None,
        Drive::OwnEqualSplit(green_s) => make(
            ProgramKind::Static,
            own(&|state, least_s, most_s| {
                ProgramPhase::fixed(state, green_s.clamp(least_s, most_s))
            }),
        ),
        Drive::OwnActuated(max_green_s, gap_s) => {
            let phases = own(&|state, least_s, most_s| ProgramPhase {
                max_s: max_green_s.clamp(least_s, most_s),
                ..ProgramPhase::fixed(state, least_s)
            });
            let max_gap_s = Some(*gap_s).filter(|gap_s| *gap_s != SUMO_GAP_S);
            Some(Program { max_gap_s, ..Program::new(INSTALLED, ProgramKind::Actuated, phases) })
        }
        Drive::Cycle(greens) => {
            let phases = greens
                .iter()
                .map(|(phase, green_s)| {
                    let phase =
                        signal.spec.phases.get(phase.0).ok_or_else(|| SimError::Signal {
                            signal: signal.spec.id.clone(),
                            reason: format!("it has no phase {}", phase.0),
                        })?;
                    Ok(ProgramPhase::fixed(&phase.state, *green_s))
                })
                .collect::<Result<Vec<_>, SimError>>()?;
            make(ProgramKind::Static, cycle(&phases, timing))
        }
        Drive::Recorded(phases, _) => {
            let phase = |(state, s): &(String, f64)| ProgramPhase::fixed(state.as_str(), *s);
            make(ProgramKind::Static, phases.iter().map(phase).collect())
        }
    })
}

/// Returns a program of phases of fixed durations.
pub fn fixed(phases: Vec<ProgramPhase>) -> Program {
    Program::new(INSTALLED, ProgramKind::Static, phases)
}

/// Returns the phase that a fixed cycle is in at a time, and how long it still lasts, seconds, as
/// if the cycle had run since its offset: what SUMO does with a program in a network file.
///
/// The position in the cycle matters: on RESCO's Ingolstadt, where vehicles arrive in platoons, the
/// mean delay of one and the same cycle is 42 to 48 s depending on its offset.
pub fn aligned(program: &Program, offset_s: f64, time_s: f64) -> Option<(u32, f64)> {
    let cycle_s: f64 = program.phases.iter().map(|p| p.duration_s).sum();
    if program.kind != ProgramKind::Static || cycle_s <= 0.0 || cycle_s >= UNTIL_DECISION_S {
        return None;
    }
    let mut position_s = (time_s - offset_s).rem_euclid(cycle_s);
    for (i, phase) in program.phases.iter().enumerate() {
        if position_s < phase.duration_s {
            return Some((i as u32, phase.duration_s - position_s));
        }
        position_s -= phase.duration_s;
    }
    None
}

/// Returns greens with the changes between them.
fn cycle(greens: &[ProgramPhase], timing: &Timing) -> Vec<ProgramPhase> {
    let mut phases = Vec::with_capacity(3 * greens.len());
    for (i, green) in greens.iter().enumerate() {
        phases.push(green.clone());
        let next = &greens[(i + 1) % greens.len()];
        for (state, seconds) in timing.between(&green.state, &next.state) {
            phases.push(ProgramPhase::fixed(state, f64::from(seconds)));
        }
    }
    phases
}

#[cfg(test)]
pub(super) mod testing {
    use super::super::derive::DerivedSignal;
    use osm_signals::Turn;

    use crate::control::testing::two_phase_signal;
    use crate::env::pairs::Naming;
    use crate::settings::SignalSettings;
    use crate::timing::{Approach, Timing, Way};

    /// Two crossing lanes with a phase each.
    pub(in crate::env) fn signal(settings: &SignalSettings) -> DerivedSignal {
        let spec = two_phase_signal();
        let own_greens = vec!["Gr".to_owned(), "rG".to_owned()];
        let approach =
            |heading_deg| Approach { heading_deg, width_m: 12.8, plain_lanes: 4, speed_mps: 13.4 };
        let way = |approach| vec![Way { approach, turn: Turn::Through }];
        let approaches = vec![approach(180.0), approach(270.0)];
        let timing = Timing::new(settings, approaches, vec![way(0), way(1)]);
        DerivedSignal {
            spec,
            lanes: vec![0, 1],
            downstream: vec![],
            movement_links: vec![vec![0], vec![1]],
            movement_ways: vec![vec![(0, 0)], vec![(1, 0)]],
            own_greens,
            timing,
            left_out: vec![],
            naming: Naming::Main,
            seen_m: vec![200.0; 2],
            own_kind: crate::sim::ProgramKind::Static,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::testing::signal as limited;
    use super::*;
    use crate::settings::SignalSettings;

    fn signal() -> DerivedSignal {
        limited(&SignalSettings::default())
    }

    fn states(program: &Program) -> Vec<(&str, f64)> {
        program.phases.iter().map(|p| (p.state.as_str(), p.duration_s)).collect()
    }

    #[test]
    fn the_change_between_two_greens_is_found_by_both() {
        let table = DecisionProgram::new(&signal());
        let change = |from, to| table.change(GreenPhase(from), GreenPhase(to)).clone();
        assert_eq!([change(0, 1), change(1, 0)], [vec![(2, 3)], vec![(3, 3)]]);
        assert_eq!(change(1, 1), []);
        assert_eq!(table.program.phases[3].state, "ry");
        let settings = SignalSettings { all_red_s: 2, ..SignalSettings::default() };
        let table = DecisionProgram::new(&limited(&settings));
        assert_eq!(*table.change(GreenPhase(0), GreenPhase(1)), [(2, 3), (3, 2)]);
        assert_eq!(table.program.phases[3].state, "rr");
    }

    #[test]
    fn greens_of_a_cycle_are_followed_by_yellow_unless_there_is_one() {
        let split = program(&signal(), &Drive::OwnEqualSplit(35.0)).unwrap().unwrap();
        assert_eq!(states(&split), [("Gr", 35.0), ("yr", 3.0), ("rG", 35.0), ("ry", 3.0)]);
        let cycle = |phase| program(&signal(), &Drive::Cycle(vec![(GreenPhase(phase), 20.0)]));
        assert_eq!(states(&cycle(1).unwrap().unwrap()), [("rG", 20.0)]);
        assert!(cycle(7).is_err(), "there is no such phase");
    }

    #[test]
    fn own_programs_keep_to_the_limits() {
        let settings = SignalSettings { max_green_s: Some(30), ..SignalSettings::default() };
        let signal = limited(&settings);
        let greens = |drive: &Drive| {
            let program = program(&signal, drive).unwrap().unwrap();
            (program.phases[0].min_s, program.phases[0].max_s)
        };
        assert_eq!(greens(&Drive::OwnEqualSplit(35.0)), (30.0, 30.0));
        assert_eq!(greens(&Drive::OwnEqualSplit(2.0)), (7.0, 7.0));
        assert_eq!(greens(&Drive::OwnActuated(50.0, 3.0)), (7.0, 30.0));
    }

    #[test]
    fn a_cycle_is_aligned_with_its_offset() {
        let program = program(&signal(), &Drive::OwnEqualSplit(35.0)).unwrap().unwrap();
        assert_eq!(aligned(&program, 0.0, 0.0), Some((0, 35.0)));
        assert_eq!(aligned(&program, 0.0, 76.0 * 10.0 + 36.0), Some((1, 2.0)));
        assert_eq!(aligned(&program, 30.0, 66.0), Some((1, 2.0)));
        assert_eq!(aligned(&program, 30.0, 0.0), Some((2, 27.0)));
        assert_eq!(aligned(&DecisionProgram::new(&signal()).program, 0.0, 7.0), None);
    }
}
