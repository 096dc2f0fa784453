//! A signal's program as records keep it: enough to show it again without the method that made it.

use serde::{Deserialize, Serialize};

/// How a program goes on from phase to phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProgramKind {
    /// Each phase lasts its duration.
    #[default]
    Static,
    /// A phase is prolonged while vehicles follow each other closely.
    Actuated,
    /// Another kind of SUMO's that an imported scenario brings.
    Other,
    /// Phases in two rings, which go on by vehicles and pedestrians: nothing that SUMO runs.
    DualRing,
}

impl ProgramKind {
    /// Returns the name in records and tables, for the first two also SUMO's type.
    pub fn name(self) -> &'static str {
        match self {
            Self::Static => "static",
            Self::Actuated => "actuated",
            Self::Other => "other",
            Self::DualRing => "dual-ring",
        }
    }
}

/// A phase of a program.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
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
    /// Walk, seconds; absent without a crosswalk whose walk begins with it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub walk_s: Option<u32>,
    /// Pedestrian clearance, seconds; absent where the walk is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clearance_s: Option<u32>,
    /// Of a green, yellow and all-red after it for the cabinet, tenths of seconds; absent where they are as simulated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exact_s: Option<[f64; 2]>,
}

impl ProgramPhase {
    /// Returns a phase of fixed duration.
    pub fn fixed(state: impl Into<String>, duration_s: f64) -> Self {
        Self { state: state.into(), duration_s, ..Self::default() }
    }
}

/// A phase of a signal that runs in two rings, with what a cabinet is told of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RingPhase {
    /// Its number.
    pub number: u32,
    /// Its ring, from 1.
    pub ring: u32,
    /// The barrier that it comes before, from 1.
    pub barrier: u32,
    /// Its place in the ring before that barrier, from 1.
    pub position: u32,
    /// Its movements, such as `NBT`, that have the right of way where nobody else says so.
    pub movements: Vec<String>,
    /// Its movements that yield to what is green beside it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub yielding: Vec<String>,
    /// Shortest green, seconds.
    pub min_green_s: u32,
    /// Time without a vehicle after which the green may end, seconds.
    pub passage_s: u32,
    /// Longest green while another phase is called, seconds.
    pub max_green_s: u32,
    /// Yellow, seconds.
    pub yellow_s: u32,
    /// Red clearance, seconds.
    pub all_red_s: u32,
    /// Both for the cabinet, tenths of seconds; absent where they are as simulated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exact_s: Option<[f64; 2]>,
    /// Walk, seconds; absent without a crosswalk.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub walk_s: Option<u32>,
    /// Pedestrian clearance, seconds; absent without a crosswalk.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub clearance_s: Option<u32>,
    /// Whether it is served in every cycle.
    pub recall: bool,
    /// Its green, yellow and red in the common cycle, seconds; absent in free operation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub split_s: Option<u32>,
    /// Whether it holds its green until it may end in the common cycle.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub coordinated: bool,
}

/// The stages that two rings follow within a cycle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RingStages {
    /// Their greens in order, without yellow and red.
    pub greens: Vec<ProgramPhase>,
    /// When the first one begins, seconds after time 0 and its multiples of the cycle.
    pub offset_s: u32,
    /// The one in which the coordinated street is green, from 0.
    pub coordinated: usize,
}

/// The program that a signal ran in the evaluation episodes of a task.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SignalProgram {
    /// SUMO's id of the signal.
    pub signal: String,
    /// Whether it is the network's own program, untouched, so that there is nothing to load.
    pub own: bool,
    /// How it goes on from phase to phase.
    pub kind: ProgramKind,
    /// When its first phase begins, seconds after time 0 and its multiples of the cycle; of the network's own the network has
    /// it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub offset_s: f64,
    /// Gap between vehicles that ends a green of an actuated program, seconds; absent where it is SUMO's default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_gap_s: Option<f64>,
    /// Its phases, in order; a fixed cycle begins with its first one. Of two rings the stages that they follow within a cycle,
    /// with what is shown between them, and nothing in free operation.
    pub phases: Vec<ProgramPhase>,
    /// The cycle that two rings keep to, seconds; absent in free operation. `offset_s` then says when the coordinated phases
    /// may end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cycle_s: Option<u32>,
    /// The stages that the rings follow within the cycle; absent in free operation.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stages: Option<RingStages>,
    /// Phases in two rings; empty for other kinds.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rings: Vec<RingPhase>,
    /// Greens that `retime` chose for the phases of the plan that it began with, in its order, seconds; none where it kept its own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub greens_s: Vec<f64>,
    /// Names of the movements of each link of a SUMO scenario, such as `NBT`, with spaces between several; absent where results
    /// by movement have them, and for rings, whose phases do.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub links: Vec<String>,
}

impl SignalProgram {
    /// Returns a program of these phases, which is not the network's own and begins at time 0.
    pub fn new(signal: impl Into<String>, kind: ProgramKind, phases: Vec<ProgramPhase>) -> Self {
        Self { signal: signal.into(), kind, phases, ..Self::default() }
    }
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
