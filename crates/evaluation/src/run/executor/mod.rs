//! Who does the tasks of a plan: this process, or workers.
//!
//! An [`Executor`] of one's own goes to [`Session::work`](super::session::Session::work). A worker is any program that
//! answers `PROGRAM worker DIR --task K [--prepared DIR] [--attempt N] [--stall-timeout S] [--watch-stdin]` with
//! [`serve`](super::worker::serve) and its [lines](super::progress::WorkerLine), one at least every S seconds (see
//! [`Watchdog`](super::watchdog::Watchdog)): `tsc-family` for the methods that it has and those of `--controller`, a
//! program of one's own (`cli::main_with`) for others.

pub mod inline;
mod launcher;
pub mod local;
mod verdict;

use std::sync::atomic::AtomicBool;

use super::error::RunError;
use super::progress::Progress;
use crate::store::manifest::Task;
use crate::store::record::Record;

pub use inline::Inline;
pub use launcher::Launcher;
pub use local::Local;

/// What happens while tasks are done.
#[derive(Debug)]
pub enum Event {
    /// A task has done some more episodes.
    Progress {
        /// The task.
        task: usize,
        /// How far it is.
        progress: Progress,
    },
    /// An attempt failed and the task is tried again.
    Retry {
        /// The task.
        task: usize,
        /// Why.
        reason: String,
    },
    /// A task has no record for reasons that are not its own, and is not tried again now.
    Undone {
        /// The task.
        task: usize,
        /// Why.
        reason: String,
    },
    /// A task has its record, successful or failed.
    Finished(Box<Record>),
}

/// Does tasks of a plan, in any order; each leaves a record in the results directory.
pub trait Executor {
    /// Does all tasks and reports events as they happen, each ending in a record or as [`Event::Undone`]; returns
    /// early, without a record for the tasks in progress, when `interrupted` becomes true.
    fn run(
        &self,
        tasks: &[Task],
        interrupted: &AtomicBool,
        on_event: &mut dyn FnMut(Event),
    ) -> Result<(), RunError>;
}
