//! A plan: what a signal runs for ever.

use std::collections::BTreeMap;

use super::super::{Drive, GreenPhase, SignalSpec};

/// What is said of a plan that is the network's own.
pub const OWN: &str = "the network's own program";

/// Start of the names of details that are plans; the signal follows.
pub const PLAN: &str = "plan ";

/// Name of the detail that counts the episodes of tuning.
pub(in crate::control) const SIMULATIONS: &str = "simulations";

/// Name of the detail that says what became of tuning, and what it then says.
pub(in crate::control) const TUNING: &str = "tuning";
pub(in crate::control) const KEPT: &str = "kept the plans that it started from";

/// Returns whether tuning kept the plans that it started from, by the details of its record; `None` where nothing was
/// tuned.
pub fn kept_start(details: &BTreeMap<String, String>) -> Option<bool> {
    details.get(SIMULATIONS)?;
    let mut plans = details.iter().filter(|(name, _)| name.starts_with(PLAN)).peekable();
    plans.peek()?;
    let says = details.get(TUNING).is_some_and(|text| text == KEPT);
    Some(says || plans.all(|(_, text)| text == OWN))
}

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
        Plan::Own => OWN.to_owned(),
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
