//! A signal's program as records keep it: enough to show it again without the method that made it.

use serde::{Deserialize, Serialize};

/// Start of the names of a record's details that are the phases of a signal in words; the signal follows.
pub const PHASES: &str = "phases ";

/// How a program goes on from phase to phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProgramKind {
    /// Each phase lasts its duration.
    Static,
    /// A phase is prolonged while vehicles follow each other closely.
    Actuated,
    /// Another kind of SUMO's that an imported scenario brings.
    Other,
}

impl ProgramKind {
    /// Returns the name in records and tables, for the first two also SUMO's type.
    pub fn name(self) -> &'static str {
        match self {
            Self::Static => "static",
            Self::Actuated => "actuated",
            Self::Other => "other",
        }
    }
}

/// A phase of a program.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProgramPhase {
    /// SUMO's state, one letter per link.
    pub state: String,
    /// Nominal duration, seconds.
    pub duration_s: f64,
    /// Shortest duration, seconds; absent where it is fixed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min_s: Option<f64>,
    /// Longest duration, seconds; absent where it is fixed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_s: Option<f64>,
}

/// The program that a signal ran in the evaluation episodes of a task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SignalProgram {
    /// SUMO's id of the signal.
    pub signal: String,
    /// Whether it is the network's own program, untouched, so that there is nothing to load.
    pub own: bool,
    /// How it goes on from phase to phase.
    pub kind: ProgramKind,
    /// Its phases, in order; a fixed cycle is in its first one at time 0 and its multiples.
    pub phases: Vec<ProgramPhase>,
}
