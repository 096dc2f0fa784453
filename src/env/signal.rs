//! The programs that make SUMO show what a controller decides.

use crate::control::{Drive, GreenPhase};
use crate::error::SimError;
use crate::sim::{Program, ProgramKind, ProgramPhase};

use super::derive::DerivedSignal;

/// Id of the programs installed here.
const INSTALLED: &str = "tsc-family";

/// Duration of a phase that only a decision ends, seconds.
///
/// Deviation: RESCO's published runs gave greens the length of a decision interval, its present
/// version keeps the network's own durations, so that a short green ends by itself.
const UNTIL_DECISION_S: f64 = 100_000.0;

/// A program with every green and every yellow between two greens, and where they stand in it.
#[derive(Debug, Clone, PartialEq)]
pub struct DecisionProgram {
    /// Greens first, in the order of the signal's phases, then yellows.
    pub program: Program,
    yellows: Vec<Vec<Option<u32>>>,
}

impl DecisionProgram {
    /// Returns the program of a signal.
    pub fn new(signal: &DerivedSignal) -> Self {
        let greens: Vec<&str> = signal.spec.phases.iter().map(|p| p.state.as_str()).collect();
        let mut phases: Vec<_> =
            greens.iter().map(|g| ProgramPhase::fixed(*g, UNTIL_DECISION_S)).collect();
        let mut yellows = vec![vec![None; greens.len()]; greens.len()];
        for (i, from) in greens.iter().enumerate() {
            for (j, to) in greens.iter().enumerate() {
                if let Some(state) = yellow(from, to) {
                    yellows[i][j] = Some(phases.len() as u32);
                    phases.push(ProgramPhase::fixed(state, UNTIL_DECISION_S));
                }
            }
        }
        let program = Program { id: INSTALLED.into(), kind: ProgramKind::Static, phases };
        Self { program, yellows }
    }

    /// Returns the index of the yellow between two greens; `None` when no light turns red.
    pub fn yellow(&self, from: GreenPhase, to: GreenPhase) -> Option<u32> {
        self.yellows[from.0][to.0]
    }
}

/// Returns the yellow state between two greens: links that are green and will be red turn yellow,
/// all others stay as they are. `None` when no link turns red.
///
/// Source: RESCO, traffic_signal.py, yellow phases.
pub fn yellow(from: &str, to: &str) -> Option<String> {
    let mut any = false;
    let state = from
        .chars()
        .zip(to.chars())
        .map(|(a, b)| {
            let ends = matches!(a, 'G' | 'g') && matches!(b, 'r' | 's');
            any |= ends;
            if ends { 'y' } else { a }
        })
        .collect();
    any.then_some(state)
}

/// Returns the program that a drive needs; `None` for the network's own.
///
/// # Errors
///
/// [`SimError::Signal`] when the drive names a phase that the signal does not have.
pub fn program(signal: &DerivedSignal, drive: &Drive) -> Result<Option<Program>, SimError> {
    let own = |green: &dyn Fn(&str) -> ProgramPhase| {
        let greens: Vec<_> = signal.own_greens.iter().map(|state| green(state)).collect();
        cycle(&greens, signal.spec.yellow_time_s)
    };
    let make = |kind, phases| Some(Program { id: INSTALLED.into(), kind, phases });
    Ok(match drive {
        Drive::OwnProgram => None,
        Drive::Decisions => Some(DecisionProgram::new(signal).program),
        Drive::OwnEqualSplit(green_s) => {
            make(ProgramKind::Static, own(&|state| ProgramPhase::fixed(state, *green_s)))
        }
        Drive::OwnActuated { min_green_s, max_green_s } => make(
            ProgramKind::Actuated,
            own(&|state| ProgramPhase {
                duration_s: *min_green_s,
                min_s: *min_green_s,
                max_s: *max_green_s,
                state: state.to_owned(),
            }),
        ),
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
            make(ProgramKind::Static, cycle(&phases, signal.spec.yellow_time_s))
        }
    })
}

/// Returns the phase that a fixed cycle is in at a time, and how long it still lasts, seconds, as
/// if the cycle had run since time 0: what SUMO does with a program of offset 0 in a network file.
///
/// The position in the cycle matters: on RESCO's Ingolstadt, where vehicles arrive in platoons, the
/// mean delay of one and the same cycle is 42 to 48 s depending on its offset.
pub fn aligned(program: &Program, time_s: f64) -> Option<(u32, f64)> {
    let cycle_s: f64 = program.phases.iter().map(|p| p.duration_s).sum();
    if program.kind != ProgramKind::Static || cycle_s <= 0.0 || cycle_s >= UNTIL_DECISION_S {
        return None;
    }
    let mut position_s = time_s.rem_euclid(cycle_s);
    for (i, phase) in program.phases.iter().enumerate() {
        if position_s < phase.duration_s {
            return Some((i as u32, phase.duration_s - position_s));
        }
        position_s -= phase.duration_s;
    }
    None
}

/// Returns greens with the yellows between them.
fn cycle(greens: &[ProgramPhase], yellow_time_s: f64) -> Vec<ProgramPhase> {
    let mut phases = Vec::with_capacity(2 * greens.len());
    for (i, green) in greens.iter().enumerate() {
        phases.push(green.clone());
        let next = &greens[(i + 1) % greens.len()];
        if let Some(state) = yellow(&green.state, &next.state) {
            phases.push(ProgramPhase::fixed(state, yellow_time_s));
        }
    }
    phases
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::testing::two_phase_signal;
    use crate::env::pairs::Naming;

    fn signal() -> DerivedSignal {
        let spec = two_phase_signal();
        let own_greens = vec!["Gr".to_owned(), "rG".to_owned()];
        DerivedSignal {
            spec,
            lanes: vec![0, 1],
            downstream: vec![],
            movement_links: vec![vec![0], vec![1]],
            own_greens,
            left_out: vec![],
            naming: Naming::Main,
            seen_m: vec![200.0; 2],
        }
    }

    fn states(program: &Program) -> Vec<(&str, f64)> {
        program.phases.iter().map(|p| (p.state.as_str(), p.duration_s)).collect()
    }

    #[test]
    fn yellow_shows_only_where_green_ends() {
        assert_eq!(yellow("GGgrr", "GrGrG").as_deref(), Some("Gygrr"));
        assert_eq!(yellow("GGgrr", "GGGrr"), None);
    }

    #[test]
    fn the_yellow_between_two_greens_is_found_by_both() {
        let table = DecisionProgram::new(&signal());
        assert_eq!(table.yellow(GreenPhase(0), GreenPhase(1)), Some(2));
        assert_eq!(table.yellow(GreenPhase(1), GreenPhase(0)), Some(3));
        assert_eq!(table.yellow(GreenPhase(1), GreenPhase(1)), None);
        assert_eq!(table.program.phases[3].state, "ry");
    }

    #[test]
    fn an_equal_split_has_yellow_after_each_green() {
        let program = program(&signal(), &Drive::OwnEqualSplit(35.0)).unwrap().unwrap();
        assert_eq!(states(&program), [("Gr", 35.0), ("yr", 3.0), ("rG", 35.0), ("ry", 3.0)]);
    }

    #[test]
    fn a_cycle_is_aligned_with_time_zero() {
        let program = program(&signal(), &Drive::OwnEqualSplit(35.0)).unwrap().unwrap();
        assert_eq!(aligned(&program, 0.0), Some((0, 35.0)));
        assert_eq!(aligned(&program, 76.0 * 10.0 + 36.0), Some((1, 2.0)));
        assert_eq!(aligned(&DecisionProgram::new(&signal()).program, 7.0), None);
    }

    #[test]
    fn a_cycle_of_one_phase_has_no_yellow() {
        let drive = Drive::Cycle(vec![(GreenPhase(1), 20.0)]);
        assert_eq!(states(&program(&signal(), &drive).unwrap().unwrap()), [("rG", 20.0)]);
    }

    #[test]
    fn a_cycle_of_a_phase_that_is_not_there_is_refused() {
        assert!(program(&signal(), &Drive::Cycle(vec![(GreenPhase(7), 20.0)])).is_err());
    }
}
