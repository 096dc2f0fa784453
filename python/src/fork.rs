//! Notices what a controller's code does to its process: processes that it was forked into and that come back into ours,
//! and another working folder.
//!
//! Such a copy of the worker would go on with the same task. It ends at once, and leaves a mark in a file that both
//! processes have, so that the task fails with a reason. In another working folder the run would not find its files.

use std::fs::File;
use std::io::Write;
use std::path::PathBuf;
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
    /// The working folder; `None` where it cannot be told.
    folder: Option<PathBuf>,
}

impl Guard {
    /// Returns a guard of this process.
    pub(crate) fn new() -> std::io::Result<Self> {
        let forks = AtomicU32::new(FORKS.load(Ordering::Relaxed));
        let folder = std::env::current_dir().ok();
        Ok(Self { pid: getpid(), mark: tempfile::tempfile()?, forks, folder })
    }

    /// Looks around after a call of a controller's code; a process that it was forked into ends here.
    ///
    /// # Errors
    ///
    /// That such a process has come back, or that the working folder is another one.
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
                return self.check_folder(method);
            }
            thread::sleep(NAP);
        }
    }

    /// Goes back to the working folder, if the code has left it.
    fn check_folder(&self, method: &str) -> Result<(), String> {
        let Some(folder) = &self.folder else { return Ok(()) };
        let now = std::env::current_dir();
        if now.as_ref().is_ok_and(|now| now == folder) {
            return Ok(());
        }
        let to = now.map_or_else(
            |e| format!("one that cannot be told ({e})"),
            |now| now.display().to_string(),
        );
        let back = std::env::set_current_dir(folder)
            .map_or_else(|e| format!("; it cannot go back: {e}"), |()| String::new());
        Err(format!(
            "{method}() changed the working folder to {to}, where the run would not find its files; use paths that begin at \
             os.path.dirname(os.path.abspath(__file__)), or change back within {method}(){back}"
        ))
    }
}
