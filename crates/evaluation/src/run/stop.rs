//! How a task is asked to stop where it can go on later.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Exit code of a process that was stopped at a checkpoint; who started it is to start it again.
pub const STOPPED: u8 = 75;

/// Whether a task is asked to stop, and whether it has anything to keep before it does.
///
/// Signals set one flag and read the other, and may come at any time.
#[derive(Debug, Clone)]
pub struct Stop {
    asked: Arc<AtomicBool>,
    at_once: Arc<AtomicBool>,
}

impl Default for Stop {
    /// One that nobody has asked for.
    fn default() -> Self {
        Self { asked: Arc::default(), at_once: Arc::new(AtomicBool::new(true)) }
    }
}

impl Stop {
    /// The flag to set: the task ends at its next checkpoint, which is written then.
    pub fn asked(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.asked)
    }

    /// Whether the process may end as it is: nothing would be kept.
    pub fn at_once(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.at_once)
    }

    pub(super) fn is_asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }

    /// Notes that a training can be kept from here on, or that none can any more.
    pub(super) fn keeps(&self, keeps: bool) {
        self.at_once.store(!keeps, Ordering::Relaxed);
    }
}
