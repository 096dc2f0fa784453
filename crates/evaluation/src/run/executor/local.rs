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
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf, absolute};
use std::process::{Child, ChildStdout, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::mpsc::{Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use rustix::process::{Pid, Signal, kill_process, kill_process_group};

use super::{Event, Launcher};
use crate::run::error::RunError;
use crate::run::progress::{Failure, Fault, WorkerLine};
use crate::store::Layout;
use crate::store::manifest::{GIT, Task};
use crate::store::record::Record;
use crate::store::wall::Wall;
use basics::files::{self, FileError, make_folder_beneath, new_beneath};
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

/// What is on standard error when there was no memory: of Rust's allocator, of C++'s.
const NO_MEMORY: [&str; 2] = ["memory allocation of ", "std::bad_alloc"];

/// Lines of a worker's log that a failure quotes.
const QUOTED_LINES: usize = 6;

/// What stands in the last words of simulators that end for a known reason in their input, and what to do.
const KNOWN: [(&str, &str); 1] = [(
    "MSE2Collector",
    "a detector over several lanes fails, whatever the method: give signals of type delay_based or NEMA another type or \
     a shorter detector range (option tls.delay_based.detector-range), and leave out or shorten laneAreaDetectors",
)];

/// How errors of a simulator begin in a log.
const ERROR: &str = "Error: ";

/// What stands between two of them.
const BETWEEN: &str = " | ";

/// Bytes at the end of a log in which they are looked for; a simulator may have filled it.
const LOOKED_AT: u64 = 1 << 16;

/// Returns why a worker left no record.
fn verdict(status: ExitStatus, said: Option<Failure>, log: &Path) -> Failure {
    let quoted = quoted(log);
    match said {
        Some(said) if !matches!(said.fault, Fault::Input | Fault::Task) => {
            return said;
        }
        // It ended itself, because it hung.
        Some(said) if status.signal().is_some() => return said,
        _ => {}
    }
    let no_memory = NO_MEMORY.iter().any(|text| quoted.contains(text));
    let how = match (status.code(), status.signal()) {
        (Some(code), _) => format!("the worker ended with exit code {code}"),
        (None, Some(signal)) => {
            format!("the worker was killed by signal {signal}{}", meaning(signal))
        }
        (None, None) => "the worker ended".to_owned(),
    };
    let killed = status.signal().is_some_and(machine::is_from_outside);
    let known = KNOWN.iter().find(|(text, _)| said.is_none() && quoted.contains(text));
    let fault = match said {
        None if known.is_some() && !killed => Fault::Input,
        _ if no_memory => Fault::Disturbed,
        _ if machine::is_at_fault(&quoted) => Fault::Machine,
        Some(ref failure) => failure.fault,
        None if killed => Fault::Disturbed,
        None => Fault::Task,
    };
    let own = said.as_ref().map(|said| last_lines(&format!("error: {}", said.reason), usize::MAX));
    let before = own.as_ref().and_then(|own| quoted.strip_suffix(own.as_str()));
    let reason = match (said, before) {
        // There is nothing else to tell, such as what SUMO says of the input.
        (Some(said), Some("")) if fault == Fault::Input => said.reason,
        // What ended it comes first; the lines before may be harmless, or say why.
        (Some(said), Some(before)) if !before.is_empty() => {
            let before = before.trim_end_matches(BETWEEN);
            format!("{how}: error: {}; before that: {before}", said.reason)
        }
        _ if quoted.is_empty() => how,
        _ => format!("{how}: {quoted}"),
    };
    let reason = match known {
        Some((_, way_out)) if fault == Fault::Input => format!("{way_out}; {reason}"),
        _ => reason,
    };
    Failure { fault, reason }
}

/// Returns what people should think of when they read the number of a signal.
fn meaning(signal: i32) -> &'static str {
    match signal {
        9 => " (somebody, or the system for want of memory: fewer --jobs need less)",
        24 => " (a limit of processor time)",
        25 => " (a limit of the size of files)",
        _ => "",
    }
}

/// Returns the last lines of a worker's log.
fn quoted(log: &Path) -> String {
    last_lines(&end(log), QUOTED_LINES)
}

/// Returns the last error that a simulator wrote into a worker's log, without the word itself.
fn last_error(log: &Path) -> Option<String> {
    let text = end(log);
    let error = text.lines().rev().find_map(|line| line.trim().strip_prefix(ERROR))?;
    Some(error.trim().to_owned())
}

/// Returns the end of a log; nothing of one that cannot be read.
fn end(log: &Path) -> String {
    let Ok(mut file) = files::open(log) else { return String::new() };
    let size = file.metadata().map_or(0, |about| about.len());
    let mut bytes = Vec::new();
    let read = file
        .seek(SeekFrom::Start(size.saturating_sub(LOOKED_AT)))
        .and_then(|_| file.take(LOOKED_AT).read_to_end(&mut bytes));
    read.map_or(String::new(), |_| String::from_utf8_lossy(&bytes).into_owned())
}

fn last_lines(text: &str, count: usize) -> String {
    let lines: Vec<&str> = text.lines().map(str::trim).filter(|l| !l.is_empty()).collect();
    lines[lines.len().saturating_sub(count)..].join(BETWEEN)
}

#[cfg(test)]
mod tests;

#[cfg(test)]
mod verdicts {
    use super::*;

    fn of(status: i32, said: Option<Fault>, log: &str) -> (Fault, String) {
        let file = tempfile::NamedTempFile::new().unwrap();
        std::fs::write(file.path(), log).unwrap();
        let said = said.map(|fault| Failure { fault, reason: "its words".into() });
        let Failure { fault, reason } = verdict(ExitStatus::from_raw(status), said, file.path());
        (fault, reason)
    }

    #[test]
    fn a_worker_that_was_killed_was_disturbed_and_one_that_crashed_was_not() {
        for signal in [1, 2, 9, 15, 24, 25] {
            assert_eq!(of(signal, None, "").0, Fault::Disturbed, "{signal}");
        }
        for signal in [4, 5, 6, 8, 11] {
            assert_eq!(of(signal, None, "").0, Fault::Task, "{signal}");
        }
        assert_eq!(of(101 << 8, None, "a panic").0, Fault::Task);
        assert!(of(9, None, "").1.contains("signal 9 (somebody, or the system for want of memory"));
    }

    #[test]
    fn want_of_memory_is_no_fault_of_the_task_s() {
        assert_eq!(of(6, None, "memory allocation of 64 bytes failed").0, Fault::Disturbed);
        let said = Some(Fault::Task);
        assert_eq!(
            of(1 << 8, said, "error: sumo failed in `step`: std::bad_alloc").0,
            Fault::Disturbed
        );
    }

    #[test]
    fn a_simulator_that_crashes_on_its_input_is_not_tried_again_and_the_way_out_comes_first() {
        let log = "sumo: MSE2Collector.cpp:844: Assertion `a == b' failed.";
        let (fault, reason) = of(6, None, log);
        assert_eq!(fault, Fault::Input);
        assert!(reason.starts_with("a detector over several lanes fails"), "{reason}");
        assert!(reason.ends_with(log), "{reason}");
        assert_eq!(of(9, None, log).0, Fault::Disturbed, "somebody ended it");
    }

    #[test]
    fn a_worker_that_quotes_a_full_disk_is_stopped_by_the_machine() {
        let log = "Error: Could not build output file 't.xml' (No space left on device).";
        assert_eq!(of(1 << 8, Some(Fault::Task), log).0, Fault::Machine);
    }

    #[test]
    fn what_a_worker_says_counts_and_the_log_is_quoted() {
        let (fault, reason) =
            of(2 << 8, Some(Fault::Input), "\n Error: no such edge \n\nQuitting\n");
        assert_eq!(fault, Fault::Input);
        assert_eq!(reason, "the worker ended with exit code 2: Error: no such edge | Quitting");
        let alone = of(2 << 8, Some(Fault::Input), "error: its words\n");
        assert_eq!(alone, (Fault::Input, "its words".to_owned()), "the log has nothing else");
        let (_, reason) =
            of(1 << 8, Some(Fault::Task), "Warning: slow\nError: a\nerror: its words\n");
        let expected = "the worker ended with exit code 1: error: its words; before that: Warning: slow | Error: a";
        assert_eq!(reason, expected, "what ended it comes first");
        let (_, reason) = of(1 << 8, Some(Fault::Task), "error: its words\n");
        assert_eq!(reason, "the worker ended with exit code 1: error: its words");
        assert_eq!(of(1 << 8, Some(Fault::Machine), "x"), (Fault::Machine, "its words".to_owned()));
        assert_eq!(of(1 << 8, Some(Fault::Own), "x"), (Fault::Own, "its words".to_owned()));
        assert_eq!(of(9, Some(Fault::Task), "x"), (Fault::Task, "its words".to_owned()));
    }

    #[test]
    fn the_end_of_a_log_is_quoted_however_long_it_is() {
        let folder = tempfile::tempdir().unwrap();
        let log = folder.path().join("0.log");
        let noise = "step\n".repeat(100_000);
        std::fs::write(&log, format!("{noise}Error: no edge\n\n quitting \n")).unwrap();
        assert_eq!(quoted(&log), "step | step | step | step | Error: no edge | quitting");
        assert_eq!(quoted(folder.path()), "");
    }
}
