//! Worker processes: one task and one simulation each.
//!
//! A worker is a program's subcommand `worker DIR --task K`. It reads the plan and commits one record;
//! nothing else passes between the two but [`WorkerLine`]s on its standard output. Its standard error,
//! where simulators give their reasons, goes to a log that is quoted when the worker fails. A failed task
//! is tried once more, unless its input is at fault, then recorded as failed; the run goes on.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;
use std::time::{Duration, Instant};

use super::{Event, Executor};
use crate::files::FileError;
use crate::run::error::RunError;
use crate::run::progress::{Failure, Fault, WorkerLine};
use crate::store::Layout;
use crate::store::manifest::Task;
use crate::store::record::{Record, Wall};

/// Attempts at a task before it is recorded as failed.
const ATTEMPTS: u32 = 2;

/// Lines of a worker's log that a failure quotes.
const QUOTED_LINES: usize = 6;

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
        let next = AtomicUsize::new(0);
        let stop = AtomicBool::new(false);
        let (sender, receiver): (Sender<Event>, Receiver<Event>) = channel();
        thread::scope(|scope| {
            let threads: Vec<_> = (0..self.jobs.min(tasks.len()))
                .map(|_| {
                    let sender = sender.clone();
                    let (next, stop) = (&next, &stop);
                    scope.spawn(move || -> Result<(), RunError> {
                        loop {
                            let halt = || {
                                interrupted.load(Ordering::Relaxed) || stop.load(Ordering::Relaxed)
                            };
                            let index = next.fetch_add(1, Ordering::Relaxed);
                            if index >= tasks.len() || halt() {
                                return Ok(());
                            }
                            if let Err(e) = self.task(&tasks[index], &halt, &sender) {
                                stop.store(true, Ordering::Relaxed);
                                return Err(e);
                            }
                        }
                    })
                })
                .collect();
            drop(sender);
            for event in receiver {
                on_event(event);
            }
            threads.into_iter().try_for_each(|t| t.join().expect("a thread here does not panic"))
        })
    }
}

impl Local {
    fn task(
        &self,
        task: &Task,
        halt: &dyn Fn() -> bool,
        sender: &Sender<Event>,
    ) -> Result<(), RunError> {
        let start = Instant::now();
        for attempt in 1..=ATTEMPTS {
            let (status, failure) = self.attempt(task, attempt, halt, sender)?;
            if let Some(record) = Record::read(&self.layout, task, &self.manifest)? {
                send(sender, Event::Finished(Box::new(record)));
                return Ok(());
            }
            // A worker that ends just when the run stops was ended by it.
            if halt() {
                return Ok(());
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
        Ok(())
    }

    fn attempt(
        &self,
        task: &Task,
        attempt: u32,
        halt: &dyn Fn() -> bool,
        sender: &Sender<Event>,
    ) -> Result<(ExitStatus, Option<Failure>), RunError> {
        let log = self.layout.log(task.task);
        let folder = log.parent().expect("a log lies in a folder");
        fs::create_dir_all(folder).map_err(FileError::at("create", folder))?;
        let stderr = File::create(&log).map_err(FileError::at("create", &log))?;
        let prepared = Some(&self.prepared).filter(|folder| !folder.as_os_str().is_empty());
        let mut child = Command::new(&self.program)
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
            .process_group(0)
            .spawn()
            .map_err(FileError::at("start", &self.program))?;
        let stdout = child.stdout.take().expect("the standard output is piped");
        let reader = thread::spawn({
            let (sender, task) = (sender.clone(), task.task);
            move || {
                let mut failure = None;
                for line in BufReader::new(stdout).lines().map_while(Result::ok) {
                    match serde_json::from_str(&line) {
                        Ok(WorkerLine::Progress(progress)) => {
                            send(&sender, Event::Progress { task, progress });
                        }
                        Ok(WorkerLine::Failed(last)) => failure = Some(last),
                        // A simulator may write there too.
                        Ok(WorkerLine::Done) | Err(_) => {}
                    }
                }
                failure
            }
        });
        let status = wait(&mut child, halt).map_err(FileError::at("wait for", &self.program))?;
        let failure = reader.join().expect("a thread here does not panic");
        Ok((status, failure))
    }
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

fn reason(status: &ExitStatus, log: &Path) -> String {
    let how = match (status.code(), status.signal()) {
        (Some(code), _) => format!("the worker ended with exit code {code}"),
        (None, Some(signal)) => format!("the worker was killed by signal {signal}"),
        (None, None) => "the worker ended".to_owned(),
    };
    let quoted = last_lines(log, QUOTED_LINES);
    if quoted.is_empty() { how } else { format!("{how}: {quoted}") }
}

fn last_lines(log: &Path, count: usize) -> String {
    let text = fs::read(log).map(|b| String::from_utf8_lossy(&b).into_owned()).unwrap_or_default();
    let lines: Vec<&str> = text.lines().map(str::trim).filter(|l| !l.is_empty()).collect();
    lines[lines.len().saturating_sub(count)..].join(" | ")
}

#[cfg(test)]
mod tests {
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
