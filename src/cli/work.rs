//! `tsc-family work`: what a job of a batch system does, one pack of tasks.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::time::Duration;

use super::controllers::ControllersArgs;
use super::executors::LimitsArgs;
use super::interrupt::interrupted;
use super::local_run::other_build;
use super::output::{line, note};
use super::values::at_least_a_second;
use crate::cli::exit::{self, refuse};
use crate::report::format;
use crate::run::batch::packs_of;
use crate::run::executor::{Event, Local};
use crate::run::worker::task_of;
use crate::store::Layout;
use crate::store::manifest::{Manifest, Task};
use crate::store::record::Outcome;

/// `tsc-family work`.
#[derive(Debug, clap::Args)]
pub struct WorkArgs {
    /// Results directory with manifest and plan
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Submission that has the packs
    #[arg(long, value_name = "N")]
    pub submission: usize,
    /// Pack to do
    #[arg(long, value_name = "K")]
    pub pack: usize,
    /// Folder of the networks or whatever was prepared [default: the manifest's]
    #[arg(long, value_name = "DIR")]
    pub prepared: Option<PathBuf>,
    /// How many workers there are, and what each may take
    #[command(flatten)]
    pub limits: LimitsArgs,
    /// Methods that are not the program's own
    #[command(flatten)]
    pub controllers: ControllersArgs,
    /// Time that a training has to be kept when this is asked to stop
    #[arg(long, value_name = "SECONDS", default_value_t = 60, value_parser = at_least_a_second())]
    pub grace: u64,
}

/// No lock is taken: whoever does the same task at the same time leaves the same record, once.
pub(super) fn run(args: &WorkArgs) -> anyhow::Result<u8> {
    let interrupted = interrupted()?;
    let layout = Layout::new(&args.dir);
    let manifest = Manifest::read(&layout)?;
    let packs = packs_of(&layout, args.submission)?.unwrap_or_default();
    let Some(pack) = packs.get(args.pack) else {
        let (number, count) = (args.submission, packs.len());
        return refuse(format!(
            "submission {number} has {count} packs, from 0, and no pack {}",
            args.pack
        ));
    };
    let task = |row: &usize| task_of(&args.dir, &manifest.identity, *row);
    let tasks = pack.iter().map(task).collect::<Result<Vec<Task>, _>>()?;
    // The name itself is looked up, not the folder, which a network's file system may remember.
    let has_none = |task: &&Task| !layout.record(task.task).exists();
    let todo: Vec<Task> = tasks.iter().filter(has_none).cloned().collect();
    note(format!("pack {}: {} of {} tasks to do", args.pack, todo.len(), tasks.len()));
    if !todo.is_empty() {
        other_build(&manifest).into_iter().for_each(note);
    }
    let executor = args.limits.applied(Local {
        manifest: manifest.sha256(),
        launcher: args.controllers.launcher()?,
        prepared: args.prepared.clone().unwrap_or_default(),
        jobs: args.limits.jobs.map_or(1, NonZeroUsize::get),
        stall_timeout: Duration::ZERO,
        grace: Duration::from_secs(args.grace),
        memory_per_worker_mb: None,
        layout,
    })?;
    let mut left = todo.len();
    executor.run(&todo, &interrupted, &mut |event| match event {
        Event::Finished(record) => {
            left -= 1;
            let s = &record.summary;
            let how = match (&s.outcome, &s.reason) {
                (Outcome::Ok, _) => "done".to_owned(),
                (_, reason) => format!("failed: {}", reason.as_deref().unwrap_or_default()),
            };
            // A closed pipe does not stop the work.
            let _ = line(format!("task {}, {} on {}: {how}", s.task, s.method, s.point));
        }
        Event::Retry { task, reason } => note(format!("task {task} is tried again: {reason}")),
        Event::Undone { task, reason } => note(format!("task {task} is not done: {reason}")),
        Event::Progress { .. } => {}
    })?;
    Ok(match left {
        0 => exit::DONE,
        _ if interrupted.load(Ordering::Relaxed) => {
            let left = format::count(left, "task");
            note(format!("stopped with {left} to do; the same pack continues from there"));
            exit::STOPPED
        }
        _ => exit::INCOMPLETE,
    })
}
