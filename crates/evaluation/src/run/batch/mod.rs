//! Batch systems that users have already: a run hands its tasks over in packs and goes away.
//!
//! What was handed over lies in `jobs/N/` of the results directory ([`submission`]). Every job of a batch system does one
//! pack by `tsc-family work DIR --submission N --pack K`, wherever it runs: the directory is shared or shipped, and
//! nothing else is, neither clock nor lock. What is done is what has a record, so that a job that runs twice, on a node
//! that was believed dead and on the next one, changes nothing.

pub mod cost;
mod error;
pub mod pack;
pub mod script;
pub mod slurm;
pub mod submission;

use submission::{Place, Submission};

pub use error::BatchError;
pub use script::Script;
pub use slurm::Slurm;

/// Times that a job which was stopped at a checkpoint is queued again by itself.
pub const RESTARTS: u32 = 20;

/// What a batch system says of a pack that is not over.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Standing {
    /// Somebody works on it.
    Running,
    /// It waits for its turn.
    Queued,
    /// It waits for somebody to release it.
    Held,
    /// It was done or taken back, and what is left of it ends.
    Ending,
}

/// A pack that a batch system has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Waiting {
    /// Which pack of the submission.
    pub pack: usize,
    /// How it stands.
    pub standing: Standing,
    /// Why it waits, in it's words; empty where it does not.
    pub reason: String,
}

/// A batch system.
pub trait BatchSystem {
    /// Name, as in `--executor`.
    fn name(&self) -> &'static str;

    /// Hands all packs of a submission over, and returns the ids that it knows them by.
    ///
    /// # Errors
    ///
    /// [`BatchError`] when it does not take them.
    fn submit(&self, submission: &Submission, place: &Place) -> Result<Vec<String>, BatchError>;

    /// Returns the packs of submissions that are not over, of each in their order; nothing where only people know.
    ///
    /// # Errors
    ///
    /// [`BatchError`] when it does not answer.
    fn waiting(&self, submissions: &[Submission]) -> Result<Vec<Vec<Waiting>>, BatchError>;

    /// Lets packs go on that are held.
    ///
    /// # Errors
    ///
    /// [`BatchError`] when it does not answer.
    fn release(&self, submission: &Submission) -> Result<(), BatchError>;

    /// Takes a submission back.
    ///
    /// # Errors
    ///
    /// [`BatchError`] when it does not answer.
    fn cancel(&self, submission: &Submission) -> Result<(), BatchError>;

    /// Returns what people are to do, in their words; empty where it does everything.
    fn how(&self, submission: &Submission, place: &Place) -> String;
}
