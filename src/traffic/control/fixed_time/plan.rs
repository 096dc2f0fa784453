//! A plan: what a signal runs for ever.

use super::super::{Drive, GreenPhase, SignalSpec};

/// A fixed cycle of one signal.
#[derive(Debug, Clone, PartialEq)]
pub enum Plan {
    /// The network's own program.
    Own,
    /// Greens in their order, seconds.
    Cycle(Vec<(GreenPhase, f64)>),
}

impl Plan {
    /// Returns what drives the signal.
    pub(super) fn drive(&self) -> Drive {
        match self {
            Self::Own => Drive::OwnProgram,
            Self::Cycle(greens) => Drive::Cycle(greens.clone()),
        }
    }
}

/// Returns a plan in words, with its cycle and the greens of its phases.
pub(super) fn describe(signal: &SignalSpec, plan: &Plan) -> String {
    match plan {
        Plan::Own => "the network's own program".to_owned(),
        Plan::Cycle(greens) => {
            let phases: Vec<usize> = greens.iter().map(|(phase, _)| phase.0).collect();
            let cycle_s =
                greens.iter().map(|(_, g)| g).sum::<f64>() + signal.limits.lost_s(&phases);
            let greens: Vec<_> = greens
                .iter()
                .map(|(phase, green)| format!("{} {green} s", signal.phases[phase.0].state))
                .collect();
            format!("cycle {cycle_s} s: {}", greens.join(", "))
        }
    }
}
