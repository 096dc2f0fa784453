//! Notices processes that a controller's code was forked into and that come back into ours.
//!
//! Such a copy of the worker would go on with the same task. It ends at once, and leaves a mark in a file that both
//! processes have, so that the task fails with a reason.

use std::fs::File;
use std::io::Write;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use pyo3::prelude::*;
use rustix::process::{Pid, Signal, getpid, kill_process};

/// How often Python code of this process has forked.
static FORKS: AtomicU32 = AtomicU32::new(0);

/// Time that a forked process has to come back before the task goes on.
const PATIENCE: Duration = Duration::from_millis(300);

/// How often it is looked for the mark meanwhile.
const NAP: Duration = Duration::from_millis(5);

/// Counts a fork; Python calls it in the process that has forked.
#[pyfunction]
pub(crate) fn forked() {
    FORKS.fetch_add(1, Ordering::Relaxed);
}

/// Guards the calls of a controller's code.
#[derive(Debug)]
pub(crate) struct Guard {
    pid: Pid,
    mark: File,
    forks: AtomicU32,
}

impl Guard {
    /// Returns a guard of this process.
    pub(crate) fn new() -> std::io::Result<Self> {
        let forks = AtomicU32::new(FORKS.load(Ordering::Relaxed));
        Ok(Self { pid: getpid(), mark: tempfile::tempfile()?, forks })
    }

    /// Looks around after a call of a controller's code; a process that it was forked into ends here.
    ///
    /// # Errors
    ///
    /// That such a process has come back.
    pub(crate) fn check(&self, method: &str) -> Result<(), String> {
        if getpid() != self.pid {
            // Nothing is left to tell but this, and nobody else to tell it to.
            let _ = (&self.mark).write_all(b"1");
            let _ = kill_process(getpid(), Signal::KILL);
            loop {
                thread::park();
            }
        }
        let forks = FORKS.load(Ordering::Relaxed);
        let patience = if self.forks.swap(forks, Ordering::Relaxed) == forks {
            Duration::ZERO
        } else {
            PATIENCE
        };
        let start = Instant::now();
        loop {
            if self.mark.metadata().is_ok_and(|mark| mark.len() > 0) {
                return Err(format!(
                    "{method}() forked, and the new process came back from it; one that is forked has to end within \
                     {method}(), with os._exit()"
                ));
            }
            if start.elapsed() >= patience {
                return Ok(());
            }
            thread::sleep(NAP);
        }
    }
}
