//! The simulator behind one small trait, so that everything above runs without SUMO in tests.
//!
//! Choices:
//! - **Indices, not names, in the loop.** [`Sim::start`] returns the signals, links and lanes of
//!   the scenario once; afterwards signals, lanes and vehicles are numbers.
//! - **One simulation per process.** libsumo keeps its state in statics. `SumoSim` is therefore
//!   not `Send`, and a second simulation in the same process is [`SimError::AlreadyRunning`].

pub mod error;
pub mod intake;
pub mod libsumo;
pub mod net_file;
pub mod obstacle;
pub mod options;
pub mod scan;
pub mod sources;
pub mod sumocfg;
#[cfg(test)]
pub mod testing;
pub mod topology;
pub mod trace;
pub mod tripinfo;

use std::path::PathBuf;

pub use error::SimError;

pub use crate::program::ProgramKind;

/// Direction of a link as SUMO classifies it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Direction {
    /// `s`: straight on.
    Straight,
    /// `t`: U-turn.
    Turn,
    /// `l`: left.
    Left,
    /// `L`: partially left.
    PartLeft,
    /// `r`: right.
    Right,
    /// `R`: partially right.
    PartRight,
}

impl Direction {
    /// Returns the direction that SUMO's letter stands for (`s t l L r R`).
    pub fn from_letter(letter: char) -> Option<Self> {
        Some(match letter {
            's' => Self::Straight,
            't' | 'T' => Self::Turn,
            'l' => Self::Left,
            'L' => Self::PartLeft,
            'r' => Self::Right,
            'R' => Self::PartRight,
            _ => return None,
        })
    }
}

/// One connection through a signal: a vehicle may drive from `from_lane` to `to_lane`.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Index of the incoming lane in [`Scene::lanes`].
    pub from_lane: usize,
    /// SUMO's id of the outgoing lane.
    pub to_lane: String,
    /// Length of the way through the junction, metres.
    pub length_m: f64,
    /// Indices in [`Scene::lanes`] of the incoming lanes of signals to which the outgoing lane leads,
    /// or which it is itself: the downstream queues.
    pub downstream: Vec<usize>,
    /// The stop lines of signals that come next, whatever the detection distance: indices in [`Scene::lanes`], and metres
    /// from this stop line.
    pub onward: Vec<(usize, f64)>,
    /// SUMO's direction of the turn.
    pub direction: Direction,
}

impl Link {
    /// Returns a link of which nothing else is known.
    pub fn new(from_lane: usize, to_lane: impl Into<String>, direction: Direction) -> Self {
        Self {
            from_lane,
            to_lane: to_lane.into(),
            length_m: 0.0,
            downstream: vec![],
            onward: vec![],
            direction,
        }
    }
}

/// An incoming lane of a signal.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Lane {
    /// SUMO's lane id, `EDGE_INDEX`; index 0 is the rightmost.
    pub id: String,
    /// Length of the lane, metres.
    pub length_m: f64,
    /// Speed limit, metres per second.
    pub speed_mps: f64,
    /// Direction of travel at the stop line, degrees clockwise from north.
    pub heading_deg: f64,
    /// Width of the street at the stop line, both directions together, metres; see
    /// [`topology::Topology::street_width_m`].
    pub street_width_m: f64,
    /// Lanes in that width which have SUMO's, because nobody said another.
    pub plain_lanes: u32,
    /// Lanes upstream that belong to it, the nearest first; see [`topology`].
    pub pieces: Vec<Piece>,
}

/// A lane from which vehicles come to a signal's lane.
#[derive(Debug, Clone, PartialEq)]
pub struct Piece {
    /// SUMO's lane id.
    pub id: String,
    /// Length, metres.
    pub length_m: f64,
    /// Shortest way from its end to the stop line, metres.
    pub beyond_m: f64,
}

/// A signal program as SUMO stores it.
#[derive(Debug, Clone, PartialEq)]
pub struct Program {
    /// Program id, unique per signal.
    pub id: String,
    /// How SUMO goes on from phase to phase. What is neither static nor actuated can be left running but not installed.
    pub kind: ProgramKind,
    /// The phases, in the order in which SUMO runs them.
    pub phases: Vec<ProgramPhase>,
    /// Gap between vehicles that ends a green of an actuated program, seconds; absent where it is SUMO's default.
    pub max_gap_s: Option<f64>,
}

impl Program {
    /// Returns a program with SUMO's default gap.
    pub fn new(id: impl Into<String>, kind: ProgramKind, phases: Vec<ProgramPhase>) -> Self {
        Self { id: id.into(), kind, phases, max_gap_s: None }
    }

    /// Returns state and duration in seconds of every phase that it comes to.
    pub fn phases(&self) -> Vec<(&str, f64)> {
        let reached = self.phases.iter().filter(|phase| phase.is_reached);
        reached.map(|phase| (phase.state.as_str(), phase.duration_s)).collect()
    }
}

/// One phase of a [`Program`].
#[derive(Debug, Clone, PartialEq)]
pub struct ProgramPhase {
    /// Nominal duration, seconds.
    pub duration_s: f64,
    /// Shortest duration, seconds; equal to `duration_s` for static programs.
    pub min_s: f64,
    /// Longest duration, seconds; equal to `duration_s` for static programs.
    pub max_s: f64,
    /// One letter per link index: `G` protected, `g` permissive, `y` yellow, `r` red, ...
    pub state: String,
    /// Whether the program comes to it from its first phase: by SUMO's `next`, else to the following one.
    pub is_reached: bool,
}

impl ProgramPhase {
    /// Returns a phase of fixed duration.
    pub fn fixed(state: impl Into<String>, duration_s: f64) -> Self {
        let state = state.into();
        Self { duration_s, min_s: duration_s, max_s: duration_s, state, is_reached: true }
    }
}

/// A traffic light of the scenario.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SignalInfo {
    /// SUMO's id of the traffic light.
    pub id: String,
    /// Links by link index; an index can steer several links, or none.
    pub links: Vec<Vec<Link>>,
    /// All programs that the scenario defines, in SUMO's order.
    pub programs: Vec<Program>,
    /// Id of the program that runs at the start.
    pub active_program: String,
    /// Shape `[link index, link index]`: whether vehicles on the two may meet within the junction, as SUMO has it, or nothing
    /// is known of that. Empty where nothing at all is known.
    pub meets: Vec<Vec<bool>>,
}

impl SignalInfo {
    /// Whether vehicles on two links may meet, as far as is known.
    pub fn may_meet(&self, a: usize, b: usize) -> bool {
        self.meets.get(a).and_then(|row| row.get(b)).is_none_or(|meets| *meets)
    }
}

/// What does not change during an episode.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Scene {
    /// Incoming vehicle lanes of all signals, each once, in the order of the signals' links.
    pub lanes: Vec<Lane>,
    /// The signals, sorted by id.
    pub signals: Vec<SignalInfo>,
}

/// A vehicle on an incoming lane or upstream of it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct VehicleState {
    /// Index in [`Scene::lanes`] of the lane that it is on or comes to; see [`trace`].
    pub lane: u32,
    /// Link index at the signal of that lane that the vehicle will use; `None` when the next signal on
    /// its route is another.
    pub link: Option<u32>,
    /// Which of the links of that index it uses: number of the first between its edges.
    pub way: u32,
    /// Number of the vehicle: in order of first sight, the same for the whole episode.
    pub vehicle: u32,
    /// Front bumper's distance from the start of the lane or piece that it is on, metres.
    pub position_m: f64,
    /// Speed, metres per second.
    pub speed_mps: f64,
    /// Time since the vehicle last drove faster than 0.1 m/s, seconds.
    pub waiting_s: f64,
    /// Distance to the next signal on the vehicle's route, metres; infinite when its route ends
    /// before one.
    pub distance_m: f64,
}

/// All vehicles that come to signals and the phase of every signal; the buffers are reused.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Snapshot {
    /// Vehicles on incoming lanes ordered by lane, then as SUMO lists them (from the start of the
    /// lane); after them those on pieces upstream.
    pub vehicles: Vec<VehicleState>,
    /// SUMO's phase index per signal, the one that governed the last step: SUMO switches at the
    /// beginning of a step.
    pub phases: Vec<u32>,
}

/// What happened during some simulation steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StepCounts {
    /// Vehicles that SUMO teleported.
    pub teleports: u32,
    /// Vehicles that were part of a collision, usually two for each.
    pub collisions: u32,
}

impl std::ops::AddAssign for StepCounts {
    fn add_assign(&mut self, other: Self) {
        self.teleports += other.teleports;
        self.collisions += other.collisions;
    }
}

/// What a simulation is started with.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StartOptions {
    /// SUMO's configuration file.
    pub config: PathBuf,
    /// Further command-line options; they override the configuration.
    pub args: Vec<String>,
    /// How far lanes are traced upstream and downstream of signals, metres; with 0 not beyond their
    /// edges.
    pub trace_m: f64,
    /// File that SUMO writes one row per vehicle to when the simulation is closed.
    pub tripinfo: PathBuf,
}

/// A microscopic traffic simulation with signals.
pub trait Sim {
    /// Starts an episode and describes its signals; closes one that is still running.
    /// Fails with [`SimError`] when the scenario cannot be loaded or has no signal.
    fn start(&mut self, options: &StartOptions) -> Result<Scene, SimError>;

    /// Simulates `steps` steps of the configured length (1 s unless the scenario says otherwise).
    /// Fails with [`SimError`] when SUMO fails or nothing runs.
    fn step(&mut self, steps: u32) -> Result<StepCounts, SimError>;

    /// Installs a program on a signal (index in [`Scene::signals`]) and runs it from its first
    /// phase.
    /// Fails with [`SimError`] when SUMO rejects the program.
    fn install(&mut self, signal: usize, program: &Program) -> Result<(), SimError>;

    /// Enters a phase of a signal's running program and ends it after `left_s` seconds.
    /// Fails with [`SimError`] when SUMO rejects the phase.
    fn enter(&mut self, signal: usize, phase: u32, left_s: f64) -> Result<(), SimError>;

    /// Switches a signal to another of its own programs.
    /// Fails with [`SimError`] when the signal has no program of that id.
    fn select(&mut self, signal: usize, program_id: &str) -> Result<(), SimError>;

    /// Lets a signal show a state, one letter per link index, until it is told otherwise; its programs stand still.
    /// Fails with [`SimError`] when SUMO rejects the state.
    fn show(&mut self, signal: usize, state: &str) -> Result<(), SimError>;

    /// Sets the phase of every signal and restarts its timer; `None` leaves a signal alone.
    /// Fails with [`SimError`] when SUMO rejects a phase or the slice has another length than the signals.
    fn set_phases(&mut self, phases: &[Option<u32>]) -> Result<(), SimError>;

    /// Reads all vehicles that come to signals and all phases into `snapshot`.
    /// Fails with [`SimError`] when nothing runs.
    fn observe(&mut self, snapshot: &mut Snapshot) -> Result<(), SimError>;

    /// Ends the episode; the tripinfo file is complete afterwards.
    /// Fails with [`SimError`] when SUMO fails to finish its outputs.
    fn close(&mut self) -> Result<(), SimError>;
}
