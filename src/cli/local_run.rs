//! What `run` and `resume` do on this machine: the tasks that are missing, and the report.

use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::available_parallelism;
use std::time::Duration;

use super::interrupt::interrupted;
use super::monitor::Monitor;
use super::output::note;
use super::report::print;
use super::target::Target;
use crate::cli::exit;
use crate::domains;
use crate::machine::memory_per_worker_mb;
use crate::report::format;
use crate::report::{self, Report};
use crate::run::domain::Domain;
use crate::run::effort::Efforts;
use crate::run::executor::{Launcher, Local};
use crate::run::session::Session;
use crate::run::watchdog::STALL_TIMEOUT_S;
use crate::store::manifest::{GIT, Manifest, Task};
use crate::store::results::Results;

/// Tasks and report of a run that is open.
pub(super) struct LocalRun<'a> {
    /// The run.
    pub(super) session: &'a Session<'a>,
    /// What is evaluated.
    pub(super) domain: &'a dyn Domain,
    /// How workers are started.
    pub(super) launcher: Launcher,
    /// Workers at the same time.
    pub(super) jobs: usize,
    /// Time without a simulated step after which a task fails, seconds.
    pub(super) stall_timeout_s: u64,
    /// Memory that a worker may use, MB; `None` for any.
    pub(super) memory_per_worker_mb: Option<u64>,
    /// Method to divide by in a second report.
    pub(super) against: Option<&'a str>,
    /// Whether lines of JSON are printed.
    pub(super) json: bool,
    /// Whether nothing but errors is.
    pub(super) quiet: bool,
}

impl LocalRun<'_> {
    /// Does the tasks of saved models that a results directory lacks; returns the exit code when it ends here, because of an
    /// interruption or of tasks that are left undone.
    pub(super) fn of_models(
        session: &Session<'_>,
        launcher: Launcher,
        jobs: Option<NonZeroUsize>,
        quiet: bool,
        then: &str,
    ) -> anyhow::Result<Option<u8>> {
        let jobs = jobs.or_else(|| available_parallelism().ok()).map_or(1, NonZeroUsize::get);
        let run = LocalRun {
            session,
            domain: domains::traffic(),
            launcher,
            jobs,
            stall_timeout_s: STALL_TIMEOUT_S,
            memory_per_worker_mb: memory_per_worker_mb(jobs),
            against: None,
            json: false,
            quiet,
        };
        let interrupted = interrupted()?;
        let left = run.work(&Results::load(&session.layout)?, &interrupted)?;
        if left > 0 && interrupted.load(Ordering::Relaxed) {
            note(format!("interrupted with {} to do; {then}", format::count(left, "task")));
            return Ok(Some(exit::INTERRUPTED));
        }
        if left > 0 {
            note(format!("{}, see above; {then}", without_record(left)));
            return Ok(Some(exit::INCOMPLETE));
        }
        Ok(None)
    }

    /// Does the tasks that results lack; returns the exit code when it ends here, because of an interruption or of tasks
    /// that are left undone.
    pub(super) fn work_on(
        &self,
        results: &Results,
        interrupted: &AtomicBool,
    ) -> anyhow::Result<Option<u8>> {
        let left = self.work(results, interrupted)?;
        if left > 0 && interrupted.load(Ordering::Relaxed) {
            if !self.quiet {
                note(format!(
                    "interrupted with {} to do; run the same command to continue",
                    format::count(left, "task")
                ));
            }
            return Ok(Some(exit::INTERRUPTED));
        }
        if left > 0 {
            return self.incomplete(left).map(Some);
        }
        Ok(None)
    }

    /// Does the tasks that results lack; returns how many are left.
    pub(super) fn work(
        &self,
        results: &Results,
        interrupted: &AtomicBool,
    ) -> anyhow::Result<usize> {
        let todo: Vec<Task> = results.missing().cloned().collect();
        let talk = !self.quiet && !self.json;
        if talk && todo.len() < results.plan().len() {
            let (done, all) = (results.done().count(), results.plan().len());
            note(format!("{done} of {all} tasks are already done"));
            if !todo.is_empty() {
                other_build(&self.session.manifest).into_iter().for_each(note);
            }
        }
        let efforts = Efforts::of_run(self.domain, &self.session.manifest.identity)?;
        let effort = |t: &Task| Ok((t.clone(), efforts.task(&t.method, &t.point)?));
        let mut monitor = Monitor::new(
            todo.iter().map(effort).collect::<anyhow::Result<Vec<_>>>()?,
            self.domain,
            results.done(),
            self.json,
            self.quiet,
        );
        let stall_timeout = Duration::from_secs(self.stall_timeout_s);
        let executor = Local {
            stall_timeout,
            memory_per_worker_mb: self.memory_per_worker_mb,
            ..self.session.local(self.launcher.clone(), self.jobs)
        };
        let outcome = self.session.work(&todo, &executor, interrupted, &mut |event| {
            monitor.handle(event);
        });
        monitor.close();
        outcome?;
        Ok(todo.len() - monitor.finished())
    }

    /// Reports a run that some tasks are missing from.
    fn incomplete(&self, left: usize) -> anyhow::Result<u8> {
        if let Err(e) = self.summarise() {
            note(format!("there is no report yet: {e}"));
        }
        let (own, them) = if left == 1 { ("its own", "it") } else { ("their own", "them") };
        note(format!(
            "{}, for reasons that are not {own} (see above); run the same command again to do {them}",
            without_record(left)
        ));
        Ok(exit::INCOMPLETE)
    }

    /// Reports the finished run.
    pub(super) fn summarise(&self) -> anyhow::Result<u8> {
        let layout = &self.session.layout;
        let results = Results::load(layout)?;
        let (failed, tasks) = (results.failed().count(), results.plan().len());
        let first = results.failed().next().and_then(|(task, record)| {
            let reason = record.summary.reason.as_ref()?;
            Some(format!("; the first, {} on {}: {reason}", task.method, task.point))
        });
        let sections = || domains::sections(layout, &results);
        let own = sections()?;
        let other = match self.against {
            None => None,
            // Where tasks failed, some results are missing: the run is no less complete for that.
            Some(method) => Report::against(&results, method, sections()?).map_err(note).ok(),
        };
        for data in [Report::new(&results, own)].iter().chain(&other) {
            if self.quiet {
                report::write(layout, data)?;
            } else {
                let target = Target::new(layout.root(), layout.report(), None);
                report::write_models(layout, (&target.root, &target.folder), data)?;
                print(&target, data, self.json, !self.json)?;
            }
        }
        if failed > 0 {
            note(format!(
                "error: {failed} of {tasks} tasks failed{}; all reasons are in the report, the same command with \
                 --retry-failed tries them again",
                first.unwrap_or_default()
            ));
            return Ok(exit::SOME_FAILED);
        }
        Ok(exit::DONE)
    }
}

/// Says how many tasks have no record.
fn without_record(tasks: usize) -> String {
    format!(
        "{} {} no record",
        format::count(tasks, "task"),
        if tasks == 1 { "has" } else { "have" }
    )
}

/// Returns a warning where another build began a run than goes on with it.
pub(super) fn other_build(manifest: &Manifest) -> Option<String> {
    let begun = manifest.provenance.git.as_str();
    (begun != GIT).then(|| {
        format!(
            "warning: this run was begun by the build {begun} and goes on with {GIT}; where they measure otherwise, \
             its records are of both (each says its build); another --out has records of this one alone"
        )
    })
}
