//! Processes that a method of somebody's own has started and that outlive its worker. One that leaves the worker's group,
//! as `setsid` does, is known by a variable of its environment, which children inherit.

use std::process::Command;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use rustix::process::{Pid, Signal, kill_process};

/// Name of the variable.
const NAME: &str = "TSC_FAMILY_WORKER";

/// Most looks at all processes: what forks while it is looked for is found by the next look.
const LOOKS: usize = 10;

/// Time from a look that finds nothing to the next. A process that is just executing another program has no environment for
/// a moment, so one such look is not enough.
const PAUSE: Duration = Duration::from_millis(5);

/// What marks the processes of one worker.
#[derive(Debug)]
pub(super) struct Mark(String);

impl Mark {
    /// Marks a worker that is to be started, and what it starts.
    pub(super) fn new(command: &mut Command) -> Self {
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        let value = format!("{}-{count}", std::process::id());
        command.env(NAME, &value);
        Self(format!("{NAME}={value}"))
    }

    /// Ends what has it, once the worker itself has ended. Where the system has no list of processes with their
    /// environments, nothing is done.
    pub(super) fn end_all(&self) {
        let mut was_empty = false;
        for _ in 0..LOOKS {
            let found = self.processes();
            if found.is_empty() {
                if was_empty {
                    return;
                }
                std::thread::sleep(PAUSE);
            }
            was_empty = found.is_empty();
            for pid in found {
                // It may have ended by itself meanwhile.
                let _ = kill_process(pid, Signal::KILL);
            }
        }
    }

    fn processes(&self) -> Vec<Pid> {
        let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
        let pid = |entry: std::fs::DirEntry| {
            let pid = entry.file_name().to_str()?.parse().ok().and_then(Pid::from_raw)?;
            // That of a process that has ended and was not waited for is empty.
            let environment = std::fs::read(entry.path().join("environ")).ok()?;
            let has = environment.split(|byte| *byte == 0).any(|one| one == self.0.as_bytes());
            has.then_some(pid)
        };
        entries.filter_map(pid).collect()
    }
}
