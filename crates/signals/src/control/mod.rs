//! Controllers: what decides a signal's phases.
//!
//! A controller sees [`SignalSpec`]s once and [`Observation`]s afterwards, nothing else: it names
//! neither the simulator nor the environment. One file per method.

pub mod actuated;
pub mod baseline;
pub mod coordinated;
pub mod deep_q;
pub mod dual_ring;
pub mod existing;
pub mod fixed_time;
mod heads;
pub mod idqn;
pub mod ippo;
mod learner;
pub mod max_pressure;
pub mod max_pressure_resco;
pub mod mplight;
pub mod mplight_star;
pub mod nema;
pub mod phase_sets;
pub mod program;
pub mod registry;
pub mod retime;
pub mod senses;
pub mod state;
pub mod streets;
#[cfg(test)]
pub(crate) mod testing;
pub mod webster;

use std::collections::{BTreeMap, BTreeSet};

use osm_signals::Turn;
use serde::{Serialize, Serializer};

use learners::nn::archive::{Archive, ArchiveError};

use crate::needs::{Need, least_greens_s};
use crate::program::RingStages;
pub use crate::vocabulary::Light;
use senses::Senses;

/// Index into [`SignalSpec::phases`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct GreenPhase(pub usize);

/// Vehicles that come from one approach and turn the same way.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Movement {
    /// RESCO's number: three times the slot of the approach, plus 0 right, 1 through, 2 left.
    /// Approaches of up to four arms take the slots of their headings S, W, N, E; with more arms
    /// they are numbered clockwise from the arm nearest to north. Where lanes of one approach and turn
    /// are not served together, they are several movements; all but one have slots after the arms'.
    pub index: usize,
    /// `right`, `through` or `left`; U-turns count as left turns.
    #[serde(serialize_with = "by_name")]
    #[cfg_attr(test, schemars(with = "String"))]
    pub turn: Turn,
    /// Positions of its lanes in the signal's; lanes are shared between movements.
    pub lanes: Vec<usize>,
    /// Positions in `downstream_queue` of the lanes that it leads to at other signals.
    pub downstream: Vec<usize>,
    /// Indices into [`SignalSpec::lanes`] of those lanes downstream that are this signal's own: where it controls several
    /// nodes, a vehicle passes more than one of its stop lines.
    #[serde(skip)]
    pub inner: Vec<usize>,
    /// Share of the approach's vehicles that make the movement, where the demand says so.
    pub share: Option<f64>,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
fn by_name<S: Serializer>(turn: &Turn, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(turn.name())
}

/// A green phase a controller can choose.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Phase {
    /// SUMO's state, one letter per link.
    pub state: String,
    /// The movements the phase is named by and that count for its pressure, one or two unless the
    /// phases of the signal would not be told apart: indices into [`SignalSpec::movements`],
    /// ascending.
    pub pair: Vec<usize>,
    /// How each movement is served, in the order of [`SignalSpec::movements`].
    pub service: Vec<Light>,
}

/// An incoming lane.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema), schemars(rename = "Lane"))]
pub struct LaneSpec {
    /// SUMO's id.
    pub id: String,
    /// Length, metres.
    pub length_m: f64,
}

/// What a controller may know of a signal before the first observation.
#[derive(Debug, Clone, PartialEq)]
pub struct SignalSpec {
    /// SUMO's id of the signal.
    pub id: String,
    /// Incoming lanes, in the order in which they first appear in the movements.
    pub lanes: Vec<LaneSpec>,
    /// Movements that exist, by ascending index.
    pub movements: Vec<Movement>,
    /// Green phases, the actions of the signal.
    pub phases: Vec<Phase>,
    /// Lanes of other signals to which its vehicles come next.
    pub onward: Vec<Onward>,
    /// How long phases may and must be shown.
    pub limits: Limits,
}

/// A lane of another signal to which a movement leads, with no signal between.
#[derive(Debug, Clone, PartialEq)]
pub struct Onward {
    /// Index into [`SignalSpec::movements`].
    pub movement: usize,
    /// Position of the other signal.
    pub signal: usize,
    /// Index into the other signal's lanes.
    pub lane: usize,
    /// From stop line to stop line, metres.
    pub distance_m: f64,
    /// The same at the speed limit of the other signal's lane, seconds.
    pub travel_s: f64,
}

/// How long the phases of a signal may and must be shown, seconds; whole numbers.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Limits {
    /// Shortest green, per phase, if what follows serves nothing of it.
    pub min_green_s: Vec<f64>,
    /// What greens must be long enough for, over greens in a row; by phase as the others.
    pub needs: Vec<Need>,
    /// Longest green, per phase; infinite where there is no limit.
    pub max_green_s: Vec<f64>,
    /// Yellow and all-red from one phase (row) to another (column); 0 where no green ends.
    pub change_s: Vec<Vec<f64>>,
    /// Shortest fixed cycle.
    pub min_cycle_s: f64,
    /// Longest fixed cycle, unless the shortest greens make it longer.
    pub max_cycle_s: f64,
    /// Whether the greens and changes of the network's own program keep to these limits.
    pub own_program: bool,
    /// Whether a cycle has the arrow of every left turn that has one in some phase.
    pub arrows: bool,
}

impl Limits {
    /// Returns the shortest greens of a cycle of phases, seconds.
    pub fn least_s(&self, phases: &[usize]) -> Vec<f64> {
        let change_s = |from: usize, to: usize| self.change_s[from][to] as u32;
        least_greens_s(&self.needs, phases, &change_s).into_iter().map(f64::from).collect()
    }

    /// Returns the yellow and all-red of a cycle of phases, each followed by the next, seconds.
    fn lost_s(&self, phases: &[usize]) -> f64 {
        (0..phases.len()).map(|i| self.change_s[phases[i]][phases[(i + 1) % phases.len()]]).sum()
    }
}

impl SignalSpec {
    /// Returns the lanes that a phase serves, ascending.
    pub fn served_lanes(&self, phase: usize) -> Vec<usize> {
        let served = self.movements.iter().zip(&self.phases[phase].service);
        let served = served.filter(|(_, light)| **light != Light::Red);
        let lanes: BTreeSet<usize> = served.flat_map(|(m, _)| m.lanes.iter().copied()).collect();
        lanes.into_iter().collect()
    }

    /// Returns the ids of lanes that have no green in any phase.
    fn unserved_lanes(&self) -> Vec<&str> {
        let served: BTreeSet<usize> =
            (0..self.phases.len()).flat_map(|phase| self.served_lanes(phase)).collect();
        (0..self.lanes.len())
            .filter(|l| !served.contains(l))
            .map(|l| self.lanes[l].id.as_str())
            .collect()
    }
}

/// What a signal's detectors tell of one lane, within the detection distance.
///
/// Source: RESCO; "queue" means that the vehicle has halted at least once within the zone, not
/// that it is halted now.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LaneObservation {
    /// Vehicles with a waiting time.
    pub queue: f64,
    /// The other vehicles.
    pub approach: f64,
    /// Sum of waiting times, seconds.
    pub total_wait_s: f64,
    /// Longest waiting time, seconds.
    pub max_wait_s: f64,
    /// Sum of the speeds of all vehicles, metres per second.
    pub total_speed_mps: f64,
}

/// What a controller sees of one signal at a decision.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Observation {
    /// SUMO's current phase index; while a controller decides, the index of its green phase.
    pub phase: usize,
    /// One entry per lane, in the order of [`SignalSpec::lanes`].
    pub lanes: Vec<LaneObservation>,
    /// Queues of the lanes that movements lead to at other signals.
    pub downstream_queue: Vec<f64>,
    /// Vehicles that have come to the signal so far in the episode, per movement, in the order of
    /// [`SignalSpec::movements`]; a vehicle counts once, as soon as it is on a lane of the signal or
    /// traced to one.
    pub seen: Vec<f64>,
}

impl Observation {
    /// Returns the queue of a movement less the queue it would run into.
    pub fn pressure(&self, movement: &Movement) -> f64 {
        let upstream: f64 = movement.lanes.iter().map(|l| self.lanes[*l].queue).sum();
        let downstream: f64 = movement.downstream.iter().map(|l| self.downstream_queue[*l]).sum();
        upstream - downstream
    }
}

/// What drives a signal during an episode.
#[derive(Debug, Clone, PartialEq)]
pub enum Drive {
    /// The controller decides every `delta_time_s`.
    Decisions,
    /// The network's own program, untouched.
    OwnProgram,
    /// The greens of the network's own program, each for the same time, seconds, within the limits.
    OwnEqualSplit(f64),
    /// The greens of the network's own program, prolonged by SUMO while vehicles follow closely, up to
    /// so many seconds, within the limits; the second number is the gap between them that ends a green, seconds.
    OwnActuated(f64, f64),
    /// Dual-ring control, which decides every second; see [`nema`].
    DualRing(dual_ring::Config),
    /// Dual-ring control within a cycle; see [`coordinated`]. Where two rings cannot follow the stages, they are a fixed
    /// cycle.
    CoordinatedRings(dual_ring::Config, RingStages),
    /// The plan that the signal has today, with its own times; see [`existing`].
    Existing,
    /// The existing plan where there is one, else dual-ring control, with these greens of its phases, seconds; none keeps its
    /// own. See [`retime`].
    Retimed(dual_ring::Config, Vec<f64>),
    /// A cycle of green phases with their durations, seconds, without the yellows in between.
    Cycle(Vec<(GreenPhase, f64)>),
    /// A fixed cycle as a record has it: every state with its duration, seconds, yellow and all-red included, and the offset.
    Recorded(Vec<(String, f64)>, f64),
}

/// Figures of a finished episode that training can use.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EpisodeOutcome {
    /// Mean delay of all vehicles, seconds.
    pub delay_s: f64,
    /// Vehicles seen per hour, per signal and lane.
    pub lane_flow_vph: Vec<Vec<f64>>,
    /// Per signal the greens of [`Drive::Retimed`] without any; absent of others.
    pub rings: Vec<Option<RingGreens>>,
}

impl EpisodeOutcome {
    /// Returns the signals, those with most vehicles first.
    fn busiest(&self) -> Vec<usize> {
        let vehicles: Vec<f64> = self.lane_flow_vph.iter().map(|flow| flow.iter().sum()).collect();
        let mut busiest: Vec<usize> = (0..vehicles.len()).collect();
        busiest.sort_by(|a, b| vehicles[*b].total_cmp(&vehicles[*a]));
        busiest
    }
}

/// The greens of the phases of a signal in two rings, as a method may choose them; seconds, by phase.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RingGreens {
    /// Per side and ring the phases in their order.
    pub sides: Vec<[Vec<usize>; 2]>,
    /// The greens; of phases that end by vehicles the longest.
    pub green_s: Vec<f64>,
    /// The shortest that may be chosen.
    pub least_s: Vec<f64>,
    /// The longest that may be chosen, infinite without a limit.
    pub most_s: Vec<f64>,
    /// Yellow and all-red after them.
    pub change_s: Vec<f64>,
    /// Lanes whose vehicles call them, positions in [`SignalSpec::lanes`].
    pub lanes: Vec<Vec<usize>>,
    /// The shortest and the longest cycle, which the splits have to fill; absent where phases end by vehicles alone.
    pub cycle_s: Option<[f64; 2]>,
}

/// Why a controller cannot work.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ControlError {
    /// A signal that the method cannot control.
    #[error("{method} cannot control signal {signal}: {reason}")]
    Signal {
        /// The method.
        method: &'static str,
        /// SUMO's id of the signal.
        signal: String,
        /// What is missing.
        reason: String,
    },
    /// An episode of training failed.
    #[error("training episode failed: {0}")]
    Episode(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// A training whose numbers are no numbers any more.
    #[error(
        "training diverged in episode {episode}: {what} is no number any more; try a smaller \
         learning rate"
    )]
    Diverged {
        /// Episode of training, from 0.
        episode: u32,
        /// What is not finite.
        what: &'static str,
    },
    /// A model or checkpoint that does not fit the method or the signals.
    #[error("the model does not fit: {0}")]
    Model(#[from] ArchiveError),
    /// A saved model on signals that it was not made for.
    #[error(
        "the model does not fit these signals: {reason}; it was trained on {trained_on}, choose an intersection with as many lanes and phases"
    )]
    Unfit {
        /// What does not fit.
        reason: ArchiveError,
        /// Id of the point MDP of its training.
        trained_on: String,
    },
    /// A method failed, which may be somebody's own.
    #[error("{method}: {reason}")]
    Own {
        /// The method.
        method: &'static str,
        /// What happened, with the traceback where there is one.
        reason: String,
    },
    /// An episode of validation failed.
    #[error(transparent)]
    Validation(Box<evaluation::run::fault::TrialError>),
    /// A checkpoint could not be written, or the training is to stop after it.
    #[error(transparent)]
    Checkpoint(#[from] evaluation::run::fault::CheckpointError),
}

/// What a controller is set up with, beside the settings of its method.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Setup {
    /// Of everything random in it.
    pub seed: u64,
    /// Episodes that a learner is trained for.
    pub episodes: u32,
    /// Whether the network is an imported one.
    pub imported: bool,
    /// Seconds from one decision to the next.
    pub decision_s: u32,
    /// Waiting time after which a learner must serve a phase, seconds; 0 for none.
    pub longest_wait_s: f64,
    /// Settings of `nema`.
    pub nema: dual_ring::Config,
    /// Settings of `fixed-time`.
    pub fixed_time: fixed_time::Config,
}

/// Runs episodes for a controller that learns or tunes itself.
pub trait Trainer {
    /// Runs one episode on the `seed`-th training seed and returns what came of it.
    ///
    /// # Errors
    ///
    /// [`ControlError::Episode`] when the simulation fails.
    fn episode(
        &mut self,
        controller: &mut dyn Controller,
        seed: u32,
    ) -> Result<EpisodeOutcome, ControlError>;

    /// Returns how many decisions an episode has.
    fn decisions_per_episode(&self) -> u32;

    /// Returns the state that an earlier attempt at this training left; `None` starts anew.
    fn saved(&mut self) -> Option<Archive> {
        None
    }

    /// Offers the policy for validation: plays it on validation seeds when that is due. Called after every training
    /// episode, before [`Self::checkpoint`]; the controller neither explores nor learns meanwhile.
    ///
    /// # Errors
    ///
    /// [`ControlError::Validation`] when an episode of it fails.
    fn validate(&mut self, controller: &mut dyn Controller) -> Result<(), ControlError> {
        let _ = controller;
        Ok(())
    }

    /// Returns whether validation has found nothing better for so long that training ends here; asked before every
    /// training episode.
    fn stops(&self) -> bool {
        false
    }

    /// Returns how often the training has started again, by which the learner's seed is derived anew.
    fn restarts(&self) -> u32 {
        0
    }

    /// Says after a training episode whether the network is alive, and returns whether training starts again.
    fn starts_again(&mut self, is_alive: bool) -> bool {
        let _ = is_alive;
        false
    }

    /// Offers the state of a training that can go on from here, at the end of an episode; it is
    /// only asked for when it is time to keep it.
    ///
    /// # Errors
    ///
    /// [`ControlError::Checkpoint`] when it cannot be written.
    fn checkpoint(&mut self, state: &dyn Fn() -> Archive) -> Result<(), ControlError> {
        let _ = state;
        Ok(())
    }
}

/// A signal control method, learned or not.
///
/// Decisions must depend only on `self` and what the controller is given, so that two runs with
/// the same seed make the same decisions.
pub trait Controller {
    /// Its name in errors and models, such as `max-pressure`: that of its [`Method`](evaluation::run::method::Method), by
    /// which records and figures know it.
    fn name(&self) -> &'static str;

    /// Starts an episode: says what drives each signal.
    ///
    /// # Errors
    ///
    /// [`ControlError::Signal`] when a signal lacks what the method needs.
    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError>;

    /// Chooses the green phase of every signal for the next interval; only called while the
    /// signals are driven by [`Drive::Decisions`].
    ///
    /// # Errors
    ///
    /// [`ControlError::Own`] of methods that are somebody's own.
    fn act(
        &mut self,
        observations: &[Observation],
        phases: &mut [GreenPhase],
    ) -> Result<(), ControlError> {
        let _ = (observations, phases);
        Ok(())
    }

    /// Learns from the interval that has just passed; called once after every [`Self::act`] and its
    /// interval. `truncated` says that the episode ends here; signal control has no terminal state.
    fn observe(&mut self, observations: &[Observation], truncated: bool) {
        let _ = (observations, truncated);
    }

    /// Trains or tunes the method before it is evaluated; others keep the default.
    ///
    /// # Errors
    ///
    /// [`ControlError`] when an episode or the method fails.
    fn train(&mut self, trainer: &mut dyn Trainer) -> Result<(), ControlError> {
        let _ = trainer;
        Ok(())
    }

    /// Replaces what a learner sees and is paid for, which makes it another method; before the first episode.
    ///
    /// # Errors
    ///
    /// [`ControlError::Own`] of methods that do not learn.
    fn set_senses(
        &mut self,
        name: &'static str,
        senses: Box<dyn Senses>,
    ) -> Result<(), ControlError> {
        let _ = name;
        drop(senses);
        let reason = "it does not learn, so that nothing of it can be replaced".to_owned();
        Err(ControlError::Own { method: self.name(), reason })
    }

    /// Says which signals episodes of a training on several point MDPs may have, by point MDP; before the first one.
    ///
    /// # Errors
    ///
    /// [`ControlError::Own`] of learners that cannot share what they learn.
    fn learn_on(&mut self, places: Vec<Vec<SignalSpec>>) -> Result<(), ControlError> {
        drop(places);
        Ok(())
    }

    /// Sets what rewards are multiplied by from here on.
    fn set_reward_scale(&mut self, scale: f32) {
        let _ = scale;
    }

    /// Returns what the method wants recorded of itself, such as the plan that tuning found.
    fn details(&self) -> BTreeMap<String, String> {
        BTreeMap::new()
    }

    /// Returns what a learner measured of itself in the last training episode, by name: `return`,
    /// `loss`, ... Empty for other methods.
    fn figures(&self) -> BTreeMap<String, f64> {
        BTreeMap::new()
    }

    /// Returns what a learner has learned; `None` for other methods and before training.
    fn model(&self) -> Option<Archive> {
        None
    }

    /// Says whether the episodes from now on are validation: played as in evaluation, with random numbers of their own,
    /// so that evaluation and training stay as they are.
    fn set_validation(&mut self, is_validation: bool) {
        let _ = is_validation;
    }

    /// Takes over what [`Self::model`] returned; it is checked against the signals when the next
    /// episode begins.
    ///
    /// # Errors
    ///
    /// [`ControlError::Model`] when the method has no models.
    fn load(&mut self, model: Archive) -> Result<(), ControlError> {
        let _ = model;
        Err(ArchiveError::Card(format!("method: {} does not learn", self.name())).into())
    }
}

/// A method that neither decides nor learns.
pub struct Same<F> {
    /// Its name.
    pub name: &'static str,
    /// What drives a signal.
    pub drive: F,
}

/// Returns the controller of a method of which the same drives every signal.
fn same(name: &'static str, drive: Drive) -> Box<dyn Controller> {
    Box::new(Same { name, drive: move |_: &SignalSpec| Ok(drive.clone()) })
}

impl<F: Fn(&SignalSpec) -> Result<Drive, ControlError>> Controller for Same<F> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn begin(&mut self, signals: &[SignalSpec]) -> Result<Vec<Drive>, ControlError> {
        signals.iter().map(&self.drive).collect()
    }
}
