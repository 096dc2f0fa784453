//! Why a trial failed, and what follows from it.

use crate::store::input_files::Changed;
use basics::files::FileError;
use learners::nn::archive::ArchiveError;

/// Any error, with its causes.
pub type Cause = Box<dyn std::error::Error + Send + Sync>;

/// Why a trial failed, by what follows from it.
#[derive(Debug, thiserror::Error)]
pub enum TrialError {
    /// The training's numbers are no numbers any more; another attempt would end the same.
    #[error("{0}")]
    Diverged(String),
    /// A model or checkpoint that does not fit.
    #[error("the model does not fit: {0}")]
    Model(#[source] ArchiveError),
    /// Something that the user gave cannot be used; another attempt would end the same.
    #[error(transparent)]
    Input(Cause),
    /// The simulator is missing.
    #[error(transparent)]
    Simulator(Cause),
    /// The machine is at fault, such as a full disk; other tasks would fail too.
    #[error(transparent)]
    Machine(Cause),
    /// The task was asked to stop; another attempt goes on from its checkpoint.
    #[error("it was asked to stop and continues from its checkpoint")]
    Stopped,
    /// Something from outside came between; another attempt may end well, and there is no record of this one.
    #[error(transparent)]
    Disturbed(Cause),
    /// The episode failed.
    #[error(transparent)]
    Failed(Cause),
    /// A method that is somebody's own failed, and says itself what happened.
    #[error(transparent)]
    Own(Cause),
}

/// Why a training does not go on after a checkpoint.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The task was asked to stop, and goes on from the checkpoint another time.
    #[error("it was asked to stop")]
    Stopped,
    /// The checkpoint could not be written.
    #[error(transparent)]
    Io(#[from] FileError),
}

impl From<CheckpointError> for TrialError {
    fn from(error: CheckpointError) -> Self {
        match error {
            CheckpointError::Stopped => Self::Stopped,
            CheckpointError::Io(e) => e.into(),
        }
    }
}

/// Altered files would spoil other tasks too.
impl From<Changed> for TrialError {
    fn from(error: Changed) -> Self {
        match error {
            Changed::Disturbed(_) => Self::Disturbed(error.into()),
            _ => Self::Machine(error.into()),
        }
    }
}

impl From<FileError> for TrialError {
    fn from(error: FileError) -> Self {
        Self::Machine(error.into())
    }
}
