//! What `run`, `evaluate` and `resume` do on this machine: the tasks that are missing, and the report.

use std::sync::atomic::{AtomicBool, Ordering};

use super::executors::LimitsArgs;
use super::folder::Target;
use super::monitor::Monitor;
use super::output::note;
use super::report::print;
use crate::cli::exit;
use crate::domains;
use crate::report::format;
use crate::report::{self, Report};
use crate::run::domain::Domain;
use crate::run::effort::Efforts;
use crate::run::executor::Launcher;
use crate::run::session::Session;
use crate::store::manifest::{GIT, Manifest, Task};
use crate::store::results::Results;

/// Tasks and report of a run that is open.
pub(super) struct LocalRun<'a> {
    pub(super) session: &'a Session<'a>,
    pub(super) domain: &'a dyn Domain,
    pub(super) launcher: Launcher,
    pub(super) limits: &'a LimitsArgs,
    /// Method to divide by in a second report.
    pub(super) against: Option<&'a str>,
    /// Whether lines of JSON are printed.
    pub(super) json: bool,
    /// Whether nothing but errors is.
    pub(super) quiet: bool,
}

impl LocalRun<'_> {
    /// Does the tasks that results lack; returns the exit code when it ends here, because of an interruption or of tasks
    /// that are left undone.
    pub(super) fn work_on(
        &self,
        results: &Results,
        interrupted: &AtomicBool,
    ) -> anyhow::Result<Option<u8>> {
        let left = self.work(results, interrupted)?;
        let tasks = format::count(left, "task");
        if left == 0 {
            return Ok(None);
        }
        if interrupted.load(Ordering::Relaxed) {
            if !self.quiet {
                note(format!("interrupted with {tasks} to do; run the same command to continue"));
            }
            return Ok(Some(exit::INTERRUPTED));
        }
        if let Err(e) = self.summarise() {
            note(format!("there is no report yet: {e}"));
        }
        note(format!(
            "{tasks} without a record, for other reasons than the task (see above); run the same command again"
        ));
        Ok(Some(exit::INCOMPLETE))
    }

    /// Does the tasks that results lack; returns how many are left.
    fn work(&self, results: &Results, interrupted: &AtomicBool) -> anyhow::Result<usize> {
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
        let efforts = todo.iter().map(effort).collect::<anyhow::Result<Vec<_>>>()?;
        let mut monitor = Monitor::new(efforts, self.domain, self.json, self.quiet);
        let local = self.session.local(self.launcher.clone(), self.limits.here());
        let executor = self.limits.applied(local)?;
        let outcome = executor.run(&todo, interrupted, &mut |event| monitor.handle(event));
        monitor.close();
        outcome?;
        Ok(todo.len() - monitor.finished())
    }

    /// Reports the finished run.
    pub(super) fn summarise(&self) -> anyhow::Result<u8> {
        let layout = &self.session.layout;
        let results = Results::load(layout)?;
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
        Ok(failures(&results))
    }
}

/// Says how many tasks failed, and returns the exit code.
fn failures(results: &Results) -> u8 {
    let (failed, tasks) = (results.failed().count(), results.plan().len());
    let Some((task, record)) = results.failed().next() else { return exit::DONE };
    let reason = record.summary.reason.as_deref().unwrap_or("no reason is known");
    note(format!(
        "error: {failed} of {tasks} tasks failed; the first, {} on {}: {reason}; all reasons are in the report, the same \
         command with --retry-failed tries them again",
        task.method, task.point
    ));
    exit::SOME_FAILED
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
