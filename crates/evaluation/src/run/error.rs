//! Why a run cannot be planned or a task not be done.

use std::path::PathBuf;

use super::fault::{Cause, TrialError};
use crate::family::FamilyError;
use crate::sample::SampleError;
use crate::store::StoreError;
use basics::files::FileError;

/// Why a run cannot be planned or a task not be done.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The scenario or family is unusable.
    #[error(transparent)]
    Family(#[from] FamilyError),
    /// The point MDPs cannot be chosen.
    #[error(transparent)]
    Choice(#[from] SampleError),
    /// More tasks or episodes than are taken, or a results directory where tasks cannot run.
    #[error("{0}")]
    Refused(String),
    /// The results directory cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A name that no method has.
    #[error("unknown method {name:?}; known are {known}{meant}")]
    Method {
        /// What was asked for.
        name: String,
        /// Names that exist.
        known: String,
        /// What may have been meant.
        meant: String,
    },
    /// What trials need could not be made.
    #[error(transparent)]
    Prepare(Cause),
    /// A point MDP for which nothing was made, which is a mistake in a domain.
    #[error("point {0} is not listed among what was prepared; please report this")]
    Unprepared(String),
    /// A trial failed.
    #[error(transparent)]
    Trial(#[from] TrialError),
    /// A method of somebody's own that is not the one that was planned.
    #[error(
        "{}: {difference}; restore the changed file, or start a new run with another --out",
        .path.display()
    )]
    Controller {
        /// The manifest.
        path: PathBuf,
        /// What differs.
        difference: String,
        /// Whether it was given, and is another.
        given: bool,
    },
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
    /// A manifest of a kind of task that this program does not know.
    #[error("{}: it is of domain {domain:?}, which this tsc-family does not have", .path.display())]
    Domain {
        /// The results directory.
        path: PathBuf,
        /// What the manifest says.
        domain: String,
    },
    /// A file that is no model, or a model that cannot be used.
    #[error("{}: {reason}", .path.display())]
    Model {
        /// The file.
        path: PathBuf,
        /// What is wrong and the way out.
        reason: String,
    },
    /// A worker found something that would make every other task fail as well.
    #[error("{reason}; nothing is lost: correct this and run the same command again")]
    Stopped {
        /// What the worker said.
        reason: String,
        /// Whether the simulator is missing.
        no_simulator: bool,
    },
    /// A batch system did not do what was asked.
    #[error("{0}")]
    Batch(String),
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] FileError),
}
