//! What is heard of a task while it goes on, and in which words a worker process says how it ended.

use serde::{Deserialize, Serialize};

use super::error::RunError;
use super::fault::TrialError;

/// What is heard of a task while it goes on.
#[derive(Debug, Clone, PartialEq)]
pub enum News {
    /// An episode is over.
    Episode(Progress),
    /// Something that people should know.
    Note(String),
}

/// How far a task is.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Progress {
    /// Episodes of the task that are done, those of an earlier attempt that it went on from included.
    pub episodes: u32,
    /// The objective in the last episode.
    pub objective: f64,
}

/// A line on a worker's standard output, as JSON. The last one says how it ended; without one the
/// worker was killed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum WorkerLine {
    /// After every episode.
    Progress(Progress),
    /// Every now and then, with the steps of the simulation so far: the process works.
    Alive(u64),
    /// The task has its record.
    Done,
    /// The task has none.
    Failed(Failure),
}

/// Why a task has no record.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Failure {
    /// Whose fault it is.
    pub fault: Fault,
    /// In words.
    pub reason: String,
}

/// Whose fault a failure is, which decides what follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Fault {
    /// What the user gave: another attempt would end the same.
    Input,
    /// The task's: it is tried again, and fails for good if that ends the same.
    Task,
    /// A method's that is somebody's own: as the task's, and its words say why, so that a log adds nothing.
    Own,
    /// Something from outside came between, such as a signal: it is tried again, and left undone if that happens
    /// once more.
    Disturbed,
    /// The machine's: other tasks would fail too, so that the run stops.
    Machine,
    /// There is no simulator, so that the run stops.
    Simulator,
}

impl Failure {
    /// Returns what a task's error means for the run.
    pub fn of(error: &RunError) -> Self {
        let fault = match error {
            RunError::Trial(TrialError::Simulator(_)) => Fault::Simulator,
            // Other tasks of it would be of another one too.
            RunError::Trial(TrialError::Machine(_))
            | RunError::Store(_)
            | RunError::Io(_)
            | RunError::Controller { .. } => Fault::Machine,
            RunError::Trial(TrialError::Failed(_) | TrialError::Model(_)) => Fault::Task,
            RunError::Trial(TrialError::Own(_)) => Fault::Own,
            RunError::Trial(TrialError::Disturbed(_) | TrialError::Stopped) => Fault::Disturbed,
            _ => Fault::Input,
        };
        Self { fault, reason: error.to_string() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use basics::files::FileError;

    #[test]
    fn a_full_disk_is_the_machine_s_fault_and_a_failed_episode_the_task_s() {
        let full = FileError::at("write", "x".as_ref())(std::io::Error::other("no space is left"));
        assert_eq!(Failure::of(&RunError::Trial(full.into())).fault, Fault::Machine);
        let failed = RunError::Trial(TrialError::Failed("collision".into()));
        let failure = Failure::of(&failed);
        assert_eq!((failure.fault, failure.reason.as_str()), (Fault::Task, "collision"));
    }
}
