//! What a worker says to its parent, on a pipe that nothing else writes to.

use std::fs::File;
use std::io::{self, Write};
use std::sync::{Arc, Mutex, PoisonError};

use rustix::io::fcntl_dupfd_cloexec;
use rustix::stdio::{dup2_stdout, stderr, stdout};

use crate::run::progress::WorkerLine;

/// First descriptor that the pipe may get, beyond the three standard ones.
const BEYOND_STANDARD: i32 = 3;

/// The pipe to the parent.
#[derive(Debug, Clone)]
pub(super) struct Protocol(Arc<Mutex<File>>);

impl Protocol {
    /// Takes over standard output; what is written there from now on, by simulators and methods of somebody's own, goes
    /// to standard error, which is the log. Processes that they start do not inherit the pipe.
    pub(super) fn begin() -> io::Result<Self> {
        let pipe = fcntl_dupfd_cloexec(stdout(), BEYOND_STANDARD)?;
        dup2_stdout(stderr())?;
        Ok(Self(Arc::new(Mutex::new(File::from(pipe)))))
    }

    /// Says something; a parent that has gone away is noticed by its closed pipe.
    pub(super) fn say(&self, what: &WorkerLine) {
        let mut line = serde_json::to_string(what).expect("plain data");
        line.push('\n');
        let mut pipe = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let _ = pipe.write_all(line.as_bytes());
    }
}
