//! Worker processes: one task and one simulation each.
//!
//! A worker is a program's subcommand `worker DIR --task K`. It reads the plan and commits one record;
//! nothing else passes between the two but [`WorkerLine`]s on its standard output. Its standard error,
//! where simulators give their reasons, goes to a log that is quoted when the worker fails. A failed task
//! is tried once more, unless its input is at fault, then recorded as failed; the run goes on.

use std::cell::RefCell;
use std::ffi::OsStr;
use std::io::{BufRead, BufReader, ErrorKind};
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use super::crew::{Crew, Member, Queue, with_way_out};
use super::log::reason;
use super::{Event, Executor};
use crate::files::beneath::open_beneath;
use crate::files::{FileError, make_folder_beneath};
use crate::run::error::RunError;
use crate::run::progress::{Failure, Fault, WorkerLine};
use crate::store::Layout;
use crate::store::manifest::Task;
use crate::store::record::{Record, Wall};

/// Attempts at a task before it is recorded as failed.
const ATTEMPTS: u32 = 2;

/// How often a waiting thread looks whether it has been interrupted.
const POLL: Duration = Duration::from_millis(5);

/// Starts worker processes, several at a time.
#[derive(Debug, Clone)]
pub struct Local {
    /// The results directory.
    pub layout: Layout,
    /// sha256 of the manifest.
    pub manifest: String,
    /// The program to start.
    pub program: PathBuf,
    /// Folder of what was prepared; empty where nothing was.
    pub prepared: PathBuf,
    /// Workers at the same time.
    pub jobs: usize,
}

impl Executor for Local {
    fn run(
        &self,
        tasks: &[Task],
        interrupted: &AtomicBool,
        on_event: &mut dyn FnMut(Event),
    ) -> Result<(), RunError> {
        let queue = Queue::new(tasks.len());
        let stop = AtomicBool::new(false);
        let halt = || interrupted.load(Ordering::Relaxed) || stop.load(Ordering::Relaxed);
        // A second round is for a task that was given back when all others had left.
        while !queue.is_empty() && !halt() {
            self.round(tasks, &queue, &halt, &stop, on_event)?;
        }
        Ok(())
    }
}

impl Local {
    /// Hires as many as the machine lets work at a time, and does tasks until none is left.
    fn round(
        &self,
        tasks: &[Task],
        queue: &Queue,
        halt: &(dyn Fn() -> bool + Sync),
        stop: &AtomicBool,
        on_event: &mut dyn FnMut(Event),
    ) -> Result<(), RunError> {
        let crew = Crew::default();
        let (sender, receiver): (Sender<Event>, Receiver<Event>) = channel();
        thread::scope(|scope| {
            let mut threads = Vec::new();
            let asked = self.jobs.min(tasks.len());
            let (mut no_more, mut dismissed) = (None, 0);
            while threads.len() < asked && no_more.is_none() {
                let (hired, is_hired) = channel();
                let (member, sender) = (Member::new(&crew, hired), sender.clone());
                let work = move || {
                    let done = self.member(tasks, queue, &member, halt, &sender);
                    if done.is_err() {
                        stop.store(true, Ordering::Relaxed);
                    }
                    done
                };
                match thread::Builder::new().spawn_scoped(scope, work) {
                    Ok(thread) => threads.push(thread),
                    Err(e) => no_more = Some(e),
                }
                match is_hired.recv() {
                    Ok(Ok(())) => {}
                    Ok(Err(e)) => (no_more, dismissed) = (Some(e), 1),
                    // Nothing was left to do, or the run stops.
                    Err(_) => break,
                }
            }
            drop(sender);
            if threads.is_empty() {
                let reason = no_more.unwrap_or_else(|| ErrorKind::WouldBlock.into());
                return Err(FileError::at("start", &self.program)(with_way_out(reason)).into());
            }
            if let Some(reason) = no_more {
                let workers = threads.len() - dismissed;
                on_event(Event::Fewer { workers, asked, reason: with_way_out(reason).to_string() });
            }
            for event in receiver {
                on_event(event);
            }
            threads.into_iter().try_for_each(|t| t.join().expect("a thread here does not panic"))
        })
    }

    /// Does one task after the other.
    fn member(
        &self,
        tasks: &[Task],
        queue: &Queue,
        member: &Member<'_>,
        halt: &dyn Fn() -> bool,
        sender: &Sender<Event>,
    ) -> Result<(), RunError> {
        while let Some(position) = queue.take().filter(|_| !halt()) {
            if !self.task(&tasks[position], member, halt, sender)? {
                queue.give_back(position);
                break;
            }
        }
        Ok(())
    }

    /// Does a task; returns whether a worker could be started for it.
    fn task(
        &self,
        task: &Task,
        member: &Member<'_>,
        halt: &dyn Fn() -> bool,
        sender: &Sender<Event>,
    ) -> Result<bool, RunError> {
        let start = Instant::now();
        for attempt in 1..=ATTEMPTS {
            let Some((status, failure)) = self.attempt(task, attempt, member, halt, sender)? else {
                return Ok(false);
            };
            if let Some(record) = Record::read(&self.layout, task, &self.manifest)? {
                send(sender, Event::Finished(Box::new(record)));
                return Ok(true);
            }
            // A worker that ends just when the run stops was ended by it.
            if halt() {
                return Ok(true);
            }
            let fault = failure.as_ref().map(|f| f.fault);
            if let (Some(failure), Some(Fault::Machine | Fault::Simulator)) = (&failure, fault) {
                let (reason, no_simulator) =
                    (failure.reason.clone(), failure.fault == Fault::Simulator);
                return Err(RunError::Stopped { reason, no_simulator });
            }
            let reason = reason(&status, &self.layout.log(task.task));
            // What is wrong with the input is still wrong at the next attempt.
            if attempt < ATTEMPTS && fault != Some(Fault::Input) {
                send(sender, Event::Retry { task: task.task, reason });
                continue;
            }
            let wall_s = start.elapsed().as_secs_f64();
            let wall = Wall { wall_s, simulator_s: 0.0, attempts: attempt };
            let record = Record::failed(task, &self.manifest, reason, wall);
            record.commit(&self.layout)?;
            send(sender, Event::Finished(Box::new(record)));
            break;
        }
        Ok(true)
    }

    /// Has a worker try a task; `None` where none was started.
    fn attempt(
        &self,
        task: &Task,
        attempt: u32,
        member: &Member<'_>,
        halt: &dyn Fn() -> bool,
        sender: &Sender<Event>,
    ) -> Result<Option<(ExitStatus, Option<Failure>)>, RunError> {
        let log = self.layout.log(task.task);
        let folder = log.parent().expect("a log lies in a folder");
        make_folder_beneath(self.layout.root(), folder)?;
        let stderr = open_beneath(self.layout.root(), &log, true)?;
        let prepared = Some(&self.prepared).filter(|folder| !folder.as_os_str().is_empty());
        let mut command = Command::new(&self.program);
        command
            .arg("worker")
            .arg(self.layout.root())
            .args(["--task", &task.task.to_string()])
            .args(prepared.iter().flat_map(|folder| [OsStr::new("--prepared"), folder.as_os_str()]))
            .args(["--attempt", &attempt.to_string()])
            .arg("--watch-stdin")
            // The pipe closes when this process ends, however it ends, and the worker with it.
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(stderr)
            // A group of its own: Ctrl-C goes to this process only, which then ends its workers.
            .process_group(0);
        let command = RefCell::new(command);
        let start = || {
            let mut child = command.borrow_mut().spawn()?;
            let stdout = child.stdout.take().expect("the standard output is piped");
            let (sender, task) = (sender.clone(), task.task);
            match thread::Builder::new().spawn(move || listen(stdout, task, &sender)) {
                Ok(reader) => Ok((child, reader)),
                Err(e) => {
                    // It may have ended by itself meanwhile.
                    let _ = child.kill();
                    child.wait()?;
                    Err(e)
                }
            }
        };
        let started = member.start(halt, &start).map_err(FileError::at("start", &self.program))?;
        let Some(((mut child, reader), _at_work)) = started else { return Ok(None) };
        let status = wait(&mut child, halt).map_err(FileError::at("wait for", &self.program))?;
        let failure = reader.join().expect("a thread here does not panic");
        Ok(Some((status, failure)))
    }
}

/// Passes on what a worker says while it works, and returns what it says of its failure.
fn listen(stdout: ChildStdout, task: usize, sender: &Sender<Event>) -> Option<Failure> {
    let mut failure = None;
    for line in BufReader::new(stdout).lines().map_while(Result::ok) {
        match serde_json::from_str(&line) {
            Ok(WorkerLine::Progress(progress)) => send(sender, Event::Progress { task, progress }),
            Ok(WorkerLine::Failed(last)) => failure = Some(last),
            // A simulator may write there too.
            Ok(WorkerLine::Done) | Err(_) => {}
        }
    }
    failure
}

/// Waits for a worker, and ends it when the run is to stop.
fn wait(child: &mut Child, halt: &dyn Fn() -> bool) -> std::io::Result<ExitStatus> {
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        if halt() {
            // It may have ended by itself meanwhile.
            let _ = child.kill();
            return child.wait();
        }
        thread::sleep(POLL);
    }
}

fn send(sender: &Sender<Event>, event: Event) {
    // The receiver lives as long as the scope of the threads that send.
    let _ = sender.send(event);
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::run::progress::Progress;
    use crate::store::record::Outcome;

    fn task() -> Task {
        Task { task: 0, method: "m".into(), point: "p".into(), replicate: 0, seed: 1 }
    }

    /// Workers which workers are a shell script.
    fn local(dir: &Path, script: &str) -> Local {
        let program = dir.join("worker.sh");
        // Another process writes it: a descriptor that is open for writing here could be inherited by
        // the worker of another test, and a file that is open for writing cannot be started.
        let status = Command::new("sh")
            .args(["-c", "printf '#!/bin/sh\\n%s\\n' \"$1\" > \"$0\" && chmod +x \"$0\""])
            .arg(&program)
            .arg(script)
            .status()
            .unwrap();
        assert!(status.success());
        Local {
            layout: Layout::new(dir),
            manifest: "abc".into(),
            program,
            prepared: "prepared".into(),
            jobs: 2,
        }
    }

    /// A script of a worker that says whose fault its end is.
    fn says(fault: Fault, reason: &str) -> String {
        let line = WorkerLine::Failed(Failure { fault, reason: reason.to_owned() });
        format!("echo '{}'; exit 1", serde_json::to_string(&line).unwrap())
    }

    fn events(local: &Local, interrupted: &AtomicBool) -> Vec<Event> {
        let mut events = Vec::new();
        local.run(&[task()], interrupted, &mut |e| events.push(e)).unwrap();
        events
    }

    #[test]
    fn a_worker_that_fails_twice_becomes_a_failed_record_with_its_reason() {
        let dir = tempfile::tempdir().unwrap();
        let local = local(dir.path(), "echo 'Error: no such edge' >&2; exit 7");
        let events = events(&local, &AtomicBool::new(false));
        assert!(matches!(&events[0], Event::Retry { task: 0, .. }));
        let Event::Finished(record) = &events[1] else { panic!("{events:?}") };
        assert_eq!(record.summary.outcome, Outcome::Failed);
        assert_eq!(
            record.summary.reason.as_deref(),
            Some("the worker ended with exit code 7: Error: no such edge")
        );
        assert_eq!(record.summary.wall.attempts, 2);
    }

    #[test]
    fn a_worker_whose_input_is_wrong_is_not_tried_again() {
        let dir = tempfile::tempdir().unwrap();
        let script = says(Fault::Input, "no such method");
        let events = events(&local(dir.path(), &script), &AtomicBool::new(false));
        let [Event::Finished(record)] = events.as_slice() else { panic!("{events:?}") };
        assert_eq!(record.summary.outcome, Outcome::Failed);
        assert_eq!(record.summary.wall.attempts, 1);
    }

    #[test]
    fn a_full_disk_stops_the_run_and_leaves_no_record() {
        let dir = tempfile::tempdir().unwrap();
        let script = says(Fault::Machine, "cannot write x: no space");
        let local = local(dir.path(), &script);
        let e = local.run(&[task()], &AtomicBool::new(false), &mut |_| {}).unwrap_err();
        assert!(e.to_string().starts_with("cannot write x: no space; nothing is lost"), "{e}");
        assert!(!local.layout.record(0).exists());
    }

    #[test]
    fn a_killed_worker_is_tried_again() {
        let dir = tempfile::tempdir().unwrap();
        let script = "if [ -e \"$2/again\" ]; then exit 9; fi; touch \"$2/again\"; kill -9 $$";
        let local = local(dir.path(), script);
        let events = events(&local, &AtomicBool::new(false));
        let Event::Retry { reason, .. } = &events[0] else { panic!("{events:?}") };
        assert_eq!(reason, "the worker was killed by signal 9");
    }

    #[test]
    fn an_interrupted_run_leaves_no_record() {
        let dir = tempfile::tempdir().unwrap();
        let local = local(
            dir.path(),
            "echo '{\"progress\":{\"episodes\":1,\"objective\":9.5}}'; exec sleep 60",
        );
        let interrupted = AtomicBool::new(false);
        let start = Instant::now();
        local
            .run(&[task()], &interrupted, &mut |event| {
                let Event::Progress { task: 0, progress } = event else { panic!("{event:?}") };
                assert_eq!(progress, Progress { episodes: 1, objective: 9.5 });
                interrupted.store(true, Ordering::Relaxed);
            })
            .unwrap();
        assert!(start.elapsed() < Duration::from_secs(30));
        assert!(!local.layout.record(0).exists());
    }
}
