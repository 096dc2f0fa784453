//! Worker processes: one task and one simulation each.
//!
//! A worker is a program's subcommand `worker DIR --task K`. It reads the plan and commits one record;
//! nothing else passes between the two but [`WorkerLine`]s on its standard output. Its standard error,
//! where simulators give their reasons, goes to a log that is quoted when the worker fails. A failed task
//! is tried once more, unless its input is at fault, then recorded as failed; one that was disturbed from outside
//! is tried once more, then left undone; the run goes on. The machine's fault ends the run. A worker that uses more memory
//! than it may is ended and its task recorded as failed, because another attempt would need as much. Its memory is
//! watched from here: a limit on addresses (`RLIMIT_AS`) would count what threads and libraries reserve and do not use.

use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::os::unix::process::CommandExt;
use std::path::{PathBuf, absolute};
use std::process::{Child, ChildStdout, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process, kill_process_group};

use super::verdict::{last_error, verdict};
use super::{Event, Launcher};
use crate::run::error::RunError;
use crate::run::progress::{Failure, Fault, WorkerLine};
use crate::store::Layout;
use crate::store::manifest::{GIT, Task};
use crate::store::record::Record;
use crate::store::wall::Wall;
use basics::files::{FileError, make_folder_beneath, new_beneath};
use basics::machine;

/// Attempts at a task that fail before it is recorded as failed, and that are disturbed before it is left undone.
const ATTEMPTS: u32 = 2;

/// Time that a worker has to write a checkpoint when the run is to stop, unless something else is said.
pub const GRACE: Duration = Duration::from_secs(5);

/// Times the stall timeout after which a worker that says nothing is ended.
const SILENCE: u32 = 2;

/// How often a waiting thread looks whether it has been interrupted.
const POLL: Duration = Duration::from_millis(5);

/// Waits between two looks at the memory of a worker.
const MEMORY_EVERY: u32 = 20;

/// Starts worker processes, several at a time.
#[derive(Debug, Clone)]
pub struct Local {
    /// The results directory.
    pub layout: Layout,
    /// sha256 of the manifest.
    pub manifest: String,
    /// What to start.
    pub launcher: Launcher,
    /// Folder of what was prepared; empty where nothing was.
    pub prepared: PathBuf,
    /// Workers at the same time.
    pub jobs: usize,
    /// Time without a step of the simulation after which a task is given up.
    pub stall_timeout: Duration,
    /// Time that workers have to write a checkpoint when the run is to stop.
    pub grace: Duration,
    /// Memory that a worker with all that it starts may use, MB; `None` for any.
    pub memory_per_worker_mb: Option<u64>,
}

/// How a worker ended.
#[derive(Debug)]
enum Ended {
    /// By itself, or asked to.
    With(ExitStatus),
    /// It was ended, because nothing was heard of it.
    Silent,
    /// It was ended, because it used so much memory, MB.
    Large(u64),
}

impl Local {
    /// Does all tasks, in any order, and reports events as they happen, each ending in a record or as [`Event::Undone`]; returns
    /// early, without a record for the tasks in progress, when `interrupted` becomes true.
    pub fn run(
        &self,
        tasks: &[Task],
        interrupted: &AtomicBool,
        on_event: &mut dyn FnMut(Event),
    ) -> Result<(), RunError> {
        let next = AtomicUsize::new(0);
        let stop = AtomicBool::new(false);
        let halt = || interrupted.load(Ordering::Relaxed) || stop.load(Ordering::Relaxed);
        let (sender, receiver) = channel();
        let work = |sender: Sender<Event>| {
            while let Some(task) = tasks.get(next.fetch_add(1, Ordering::Relaxed))
                && !halt()
            {
                if let Err(e) = self.task(task, &halt, &sender) {
                    stop.store(true, Ordering::Relaxed);
                    return Err(e);
                }
            }
            Ok(())
        };
        let work = &work;
        thread::scope(|scope| {
            let threads = (0..self.jobs.min(tasks.len())).map(|_| {
                let sender = sender.clone();
                scope.spawn(move || work(sender))
            });
            let threads: Vec<_> = threads.collect();
            drop(sender);
            receiver.into_iter().for_each(on_event);
            threads.into_iter().try_for_each(|t| t.join().expect("a thread here does not panic"))
        })
    }

    /// Does a task.
    fn task(
        &self,
        task: &Task,
        halt: &dyn Fn() -> bool,
        sender: &Sender<Event>,
    ) -> Result<(), RunError> {
        let start = Instant::now();
        let (mut failed, mut disturbed) = (0, 0);
        for attempt in 1.. {
            let failure = self.attempt(task, attempt, halt, sender)?;
            if let Some(record) = Record::read(&self.layout, task, &self.manifest)? {
                send(sender, Event::Finished(Box::new(record)));
                return Ok(());
            }
            // A worker that ends just when the run stops was ended by it.
            if halt() {
                return Ok(());
            }
            let Failure { fault, reason } = match (failure.fault, self.has_room()) {
                // It may have failed because it could not write, and not have said so.
                (Fault::Task | Fault::Own, Err(e)) => {
                    Failure { fault: Fault::Machine, reason: e.to_string() }
                }
                _ => failure,
            };
            let is_last = match fault {
                Fault::Machine | Fault::Simulator => {
                    let no_simulator = fault == Fault::Simulator;
                    return Err(RunError::Stopped { reason, no_simulator });
                }
                // What is wrong with the input is still wrong at the next attempt.
                Fault::Input => true,
                Fault::Task | Fault::Own => {
                    failed += 1;
                    failed == ATTEMPTS
                }
                Fault::Disturbed => {
                    disturbed += 1;
                    disturbed == ATTEMPTS
                }
            };
            if !is_last {
                send(sender, Event::Retry { task: task.task, reason });
                continue;
            }
            if fault == Fault::Disturbed {
                send(sender, Event::Undone { task: task.task, reason });
                break;
            }
            let wall_s = start.elapsed().as_secs_f64();
            let wall = Wall { wall_s, attempts: attempt, git: GIT.to_owned(), ..Wall::default() };
            let record = Record::failed(task, &self.manifest, reason, wall);
            record.commit(&self.layout)?;
            send(sender, Event::Finished(Box::new(record)));
            break;
        }
        Ok(())
    }

    /// Checks that the results directory can be written.
    fn has_room(&self) -> Result<(), FileError> {
        let tmp = self.layout.tmp();
        make_folder_beneath(self.layout.root(), &tmp)?;
        machine::probe(&tmp)
    }

    /// Has a worker try a task, and returns why it left no record, if it did not.
    fn attempt(
        &self,
        task: &Task,
        attempt: u32,
        halt: &dyn Fn() -> bool,
        sender: &Sender<Event>,
    ) -> Result<Failure, RunError> {
        let log = self.layout.log(task.task);
        let stderr = new_beneath(self.layout.root(), &log, &self.layout.tmp(), b"")?;
        let prepared = Some(&self.prepared).filter(|folder| !folder.as_os_str().is_empty());
        let mut arguments: Vec<OsString> = vec![self.layout.root().into()];
        let prepared = prepared.iter().flat_map(|folder| ["--prepared".into(), folder.into()]);
        arguments.extend(prepared);
        let stall_timeout_s = self.stall_timeout.as_secs().max(1);
        for (name, value) in [
            ("--task", task.task.to_string()),
            ("--manifest", self.manifest.clone()),
            ("--attempt", attempt.to_string()),
            ("--stall-timeout", stall_timeout_s.to_string()),
        ] {
            arguments.extend([name.into(), value.into()]);
        }
        arguments.push("--watch-stdin".into());
        let mut command = self.launcher.command("worker", &arguments, &task.method);
        command
            // The pipe closes when this process ends, however it ends, and the worker with it.
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(stderr)
            // A group of its own: Ctrl-C goes to this process only, which then ends its workers.
            .process_group(0);
        if tempfile::tempfile().is_err() {
            // TMPDIR names a folder that this machine does not have, as it happens on nodes of clusters.
            let tmp = self.layout.tmp();
            command.env("TMPDIR", absolute(&tmp).map_err(FileError::at("find", &tmp))?);
        }
        let is_own = self.launcher.own.iter().any(|(name, _)| **name == *task.method);
        let lines = Arc::new(AtomicU64::new(0));
        let program = &self.launcher.program;
        let mut child = command.spawn().map_err(FileError::at("start", program))?;
        let stdout = child.stdout.take().expect("the standard output is piped");
        let (to, id, counted) = (sender.clone(), task.task, Arc::clone(&lines));
        let reader = thread::spawn(move || listen(stdout, id, &to, &counted));
        // The worker itself says when it stands still; this is for one that cannot.
        let patience = self.stall_timeout.saturating_mul(SILENCE);
        let limit_mb = self.memory_per_worker_mb;
        let ended = wait(&mut child, (patience, self.grace), limit_mb, &lines, halt);
        let ended = ended.map_err(FileError::at("wait for", program))?;
        // A method of somebody's own may have started processes that outlive the worker.
        if is_own {
            let _ = kill_process_group(Pid::from_child(&child), Signal::KILL);
        }
        let failure = reader.join().expect("a thread here does not panic");
        Ok(match ended {
            Ended::With(status) => verdict(status, failure, &log),
            Ended::Large(used_mb) => Failure {
                fault: Fault::Input,
                reason: too_large(used_mb, limit_mb.unwrap_or_default(), last_error(&log)),
            },
            Ended::Silent => {
                let silent_s = patience.as_secs_f64();
                let reason = format!("the worker did not answer for {silent_s} s and was ended");
                Failure { fault: Fault::Disturbed, reason }
            }
        })
    }
}

/// Passes on what a worker says while it works, counts its lines, and returns what it says of its failure.
fn listen(
    stdout: ChildStdout,
    task: usize,
    sender: &Sender<Event>,
    lines: &AtomicU64,
) -> Option<Failure> {
    let mut failure = None;
    for line in BufReader::new(stdout).lines().map_while(Result::ok) {
        lines.fetch_add(1, Ordering::Relaxed);
        match serde_json::from_str(&line) {
            Ok(WorkerLine::Progress(progress)) => send(sender, Event::Progress { task, progress }),
            Ok(WorkerLine::Failed(last)) => failure = Some(last),
            // A simulator may write there too.
            Ok(WorkerLine::Alive(_) | WorkerLine::Done) | Err(_) => {}
        }
    }
    failure
}

/// Returns why a worker was ended that used too much memory, and the ways out.
fn too_large(used_mb: u64, limit_mb: u64, said: Option<String>) -> String {
    let way_out = match said {
        None => "if the task needs that much".to_owned(),
        Some(error) => {
            format!(
                "the simulator said before: {error}; mend that first; if the task needs that much without it"
            )
        }
    };
    format!(
        "the worker used {used_mb} MB of memory, more than its limit of {limit_mb} MB, and was ended; {way_out}, \
         --memory-per-worker MB with --retry-failed allows more, and fewer --jobs leave more to each worker"
    )
}

/// Waits for a worker, asks it to stop when the run is to, and ends it when it does not within the grace, when nothing is heard
/// of it, or when it uses more memory than it may.
fn wait(
    child: &mut Child,
    (patience, grace): (Duration, Duration),
    limit_mb: Option<u64>,
    lines: &AtomicU64,
    halt: &dyn Fn() -> bool,
) -> std::io::Result<Ended> {
    let (mut heard, mut silent, mut asked) = (0, Duration::ZERO, None);
    let mut look = 0_u32;
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(Ended::With(status));
        }
        let pid = Pid::from_child(child);
        let used_mb = limit_mb
            .filter(|_| look.is_multiple_of(MEMORY_EVERY))
            .and_then(|_| machine::memory_used_mb(pid.as_raw_nonzero().get()));
        if let Some(used_mb) = used_mb.filter(|used| limit_mb.is_some_and(|limit| *used > limit)) {
            // With all that it started; it may have ended by itself meanwhile.
            let _ = kill_process_group(pid, Signal::KILL);
            let _ = child.kill();
            child.wait()?;
            return Ok(Ended::Large(used_mb));
        }
        let now = lines.load(Ordering::Relaxed);
        silent = if now == heard { silent + POLL } else { Duration::ZERO };
        heard = now;
        let is_silent = silent >= patience;
        if asked.is_none() && halt() {
            // It may have ended by itself meanwhile.
            let _ = kill_process(Pid::from_child(child), Signal::TERM);
            asked = Some(Duration::ZERO);
        }
        let is_late = asked.as_mut().is_some_and(|since: &mut Duration| {
            *since += POLL;
            *since > grace
        });
        if is_silent || is_late {
            // It may have ended by itself meanwhile.
            let _ = child.kill();
            let status = child.wait()?;
            return Ok(if is_silent { Ended::Silent } else { Ended::With(status) });
        }
        look = look.wrapping_add(1);
        thread::sleep(POLL);
    }
}

fn send(sender: &Sender<Event>, event: Event) {
    // The receiver lives as long as the scope of the threads that send.
    let _ = sender.send(event);
}

#[cfg(test)]
mod tests;
