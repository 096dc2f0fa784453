//! Why a run cannot be planned or a task not be done.

use std::path::PathBuf;

use crate::family::FamilyError;
use crate::files::FileError;
use crate::sample::SampleError;
use crate::store::StoreError;
use crate::traffic::control::ControlError;
use crate::traffic::env::episode::EpisodeError;
use crate::traffic::network::error::NetworkError;
use crate::traffic::sim::SimError;

/// Why a run cannot be planned or a task not be done.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum EvalError {
    /// The scenario or family is unusable.
    #[error(transparent)]
    Family(#[from] FamilyError),
    /// A network cannot be built or used.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The simulation failed.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// A method is unknown or failed.
    #[error(transparent)]
    Control(#[from] ControlError),
    /// The point MDPs cannot be chosen.
    #[error(transparent)]
    Sample(#[from] SampleError),
    /// The results directory cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// Two imported scenarios of one name.
    #[error("two --sumocfg files are named {0:?}; rename one, the name is the point MDP's id")]
    DoubledPoint(String),
    /// A task that the plan does not have.
    #[error("{} has no task {task}; its plan has {count}", .path.display())]
    NoTask {
        /// The results directory.
        path: PathBuf,
        /// What was asked for.
        task: usize,
        /// Tasks in the plan.
        count: usize,
    },
    /// A file that is no model, or a model that cannot be used.
    #[error("{}: {reason}", .path.display())]
    Model {
        /// The file.
        path: PathBuf,
        /// What is wrong and the way out.
        reason: String,
    },
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
    /// A worker found something that would make every other task fail as well.
    #[error("{reason}; nothing is lost, run the same command again once this is mended")]
    Stopped {
        /// What the worker said.
        reason: String,
        /// Whether SUMO is missing.
        no_sumo: bool,
    },
    /// A file that differs from the manifest.
    #[error(
        "{}: the file {what} since the run was planned; restore it, or start a new run with \
         another --out",
        .path.display()
    )]
    Altered {
        /// The file.
        path: PathBuf,
        /// `was deleted` or `was altered`.
        what: &'static str,
    },
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] FileError),
}

impl From<EpisodeError> for EvalError {
    fn from(error: EpisodeError) -> Self {
        match error {
            EpisodeError::Sim(e) => Self::Sim(e),
            EpisodeError::Control(e) => Self::Control(e),
        }
    }
}
