//! Workers do the tasks of a plan: processes, started by [`Local`].
//!
//! A worker is any program that answers `PROGRAM worker DIR --task K [--prepared DIR] [--attempt N] [--stall-timeout S]
//! [--watch-stdin]` with [`serve`](super::worker::serve) and its [lines](super::progress::WorkerLine), one at least every S
//! seconds (see [`Watchdog`](super::watchdog::Watchdog)): `tsc-family` for the methods that it has and those of `--controller`,
//! a program of one's own (`cli::main_with`) for others.

mod launcher;
pub mod local;

use super::progress::Progress;
use crate::store::record::Record;

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
