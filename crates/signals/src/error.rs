//! Why a scenario of signals cannot be prepared.

use super::control::ControlError;
use super::env::episode::EpisodeError;
use super::network::error::NetworkError;
use super::sim::SimError;
use basics::files::FileError;
use evaluation::family::FamilyError;
use evaluation::run::RunError;
use evaluation::run::fault::TrialError;
use evaluation::store::input_files::Changed;

/// Why a scenario of signals, or a point MDP of it, cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TrafficError {
    /// The scenario or family is unusable.
    #[error(transparent)]
    Family(#[from] FamilyError),
    /// A network cannot be built or used.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The simulation failed.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// A model or its evaluation failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// Two imported scenarios of one name.
    #[error(
        "two --sumocfg files, or their folders, are named {0:?}; rename one, the name is the point MDP's id"
    )]
    DoubledPoint(String),
    /// A point MDP that the scenario does not have.
    #[error("scenario {scenario} has no point MDP {point:?}; it has {some}")]
    NoPoint {
        /// Name of the scenario.
        scenario: String,
        /// What was asked for.
        point: String,
        /// Some that exist, and where to see them all.
        some: String,
    },
    /// A file that is not the planned one.
    #[error(transparent)]
    Changed(#[from] Changed),
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] FileError),
}

/// Altered files would spoil other tasks too.
impl From<TrafficError> for TrialError {
    fn from(error: TrafficError) -> Self {
        match error {
            TrafficError::Network(e) => e.into(),
            TrafficError::Sim(e) => e.into(),
            TrafficError::Changed(e) => e.into(),
            TrafficError::Io(_) => Self::Machine(error.into()),
            other => Self::Input(other.into()),
        }
    }
}

impl From<NetworkError> for TrialError {
    fn from(error: NetworkError) -> Self {
        match error {
            NetworkError::Io(_) => Self::Machine(error.into()),
            NetworkError::Intersection { .. } | NetworkError::Altered { .. } => {
                Self::Input(error.into())
            }
            _ => Self::Failed(error.into()),
        }
    }
}

impl From<SimError> for TrialError {
    fn from(error: SimError) -> Self {
        match error {
            SimError::Unavailable(_) | SimError::Absent(_) => Self::Simulator(error.into()),
            SimError::Io(_) | SimError::CutOff(_) => Self::Machine(error.into()),
            SimError::Signal { .. }
            | SimError::NoVehicles(_)
            | SimError::Config { .. }
            | SimError::Obstacles(_)
            | SimError::NoConfig(_) => Self::Input(error.into()),
            _ => Self::Failed(error.into()),
        }
    }
}

impl From<ControlError> for TrialError {
    fn from(error: ControlError) -> Self {
        match error {
            ControlError::Diverged { .. } => Self::Diverged(error.to_string()),
            ControlError::Model(e) => Self::Model(e),
            ControlError::Checkpoint(e) => e.into(),
            ControlError::Validation(e) => *e,
            ControlError::Own { .. } => Self::Own(error.into()),
            // A training episode fails for reasons of the simulation, not of what was given.
            ControlError::Episode(e) => match e.downcast::<Changed>() {
                Ok(e) => Self::from(*e),
                Err(e) => match e.downcast_ref() {
                    Some(EpisodeError::Sim(SimError::Io(_) | SimError::CutOff(_))) => {
                        Self::Machine(ControlError::Episode(e).into())
                    }
                    _ => Self::Failed(ControlError::Episode(e).into()),
                },
            },
            _ => Self::Input(error.into()),
        }
    }
}
