//! Why a scenario of signals cannot be prepared.

use std::path::PathBuf;

use super::network::error::NetworkError;
use super::sim::SimError;
use basics::files::FileError;
use evaluation::family::FamilyError;
use evaluation::run::RunError;

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
    /// A file that was written while it was in use.
    #[error(
        "{}: the file was written while it was simulated, and is as planned again; nothing that came of it counts",
        .0.display()
    )]
    Disturbed(PathBuf),
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] FileError),
}
