//! Handing tasks over to a batch system: what `run --executor` and `resume` have in common.

use crate::cli::exit::{refuse, without_effect};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::thread::available_parallelism;
use std::time::Duration;

use anyhow::Context;

use super::output::{duration, line};
use super::values::{at_least_a_second, at_least_one_worker, megabytes, number};
use crate::files::quoted;
use crate::machine::memory_per_worker_mb;
use crate::report::format;
use crate::run::batch::pack::packs;
use crate::run::batch::{self, Submission, absolute, slurm};
use crate::run::domain::Domain;
use crate::run::effort::Efforts;
use crate::run::error::RunError;
use crate::run::executor::{Launcher, Local};
use crate::run::session::Session;
use crate::run::watchdog::STALL_TIMEOUT_S;
use crate::store::manifest::{Manifest, Task};
use crate::store::results::Results;

/// Processor time of a task of which nothing is known, seconds: it gets a pack of its own.
const UNKNOWN_S: f64 = 1800.0;

/// Memory of a worker where none was measured, MB.
const MEMORY_MB: u64 = 1000;

/// Times the largest measured memory that a worker may need, and MB on top of that.
const ROOM: (f64, u64) = (1.5, 200);

/// Who does the tasks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Executes {
    /// Worker processes of this machine
    Local,
    /// Slurm, as a job array
    Slurm,
    /// Scripts that GNU parallel, PBS, Kubernetes or another program starts
    Script,
}

/// How the tasks of a run are done.
#[derive(Debug, clap::Args)]
pub struct WorkersArgs {
    /// File of `#SBATCH` lines for the jobs, such as partition and account
    #[arg(long, value_name = "FILE")]
    pub sbatch: Option<PathBuf>,
    /// Processor time of a job in a batch system, in minutes [default: from 1 to 30, more for longer runs]
    #[arg(long, value_name = "MINUTES", value_parser = number(0.001, 1e6))]
    pub job_minutes: Option<f64>,
    /// How many there are, and what each may take
    #[command(flatten)]
    pub limits: LimitsArgs,
}

impl WorkersArgs {
    pub(super) fn lines(&self) -> Result<Vec<String>, RunError> {
        Ok(self.sbatch.as_deref().map(slurm::lines).transpose()?.unwrap_or_default())
    }

    /// Refuses what has no effect where tasks are done by somebody.
    pub(super) fn check(&self, executor: Executes) -> anyhow::Result<()> {
        without_effect(&[
            ("--sbatch", self.sbatch.is_some() && executor != Executes::Slurm, "it is for slurm"),
            (
                "--job-minutes",
                self.job_minutes.is_some() && executor == Executes::Local,
                "this machine needs no jobs",
            ),
        ])
    }
}

/// What workers may take.
#[derive(Debug, clap::Args)]
pub struct LimitsArgs {
    /// Worker processes at the same time [default: one per processor; one per job of a batch system]
    #[arg(long, short, value_name = "J", value_parser = at_least_one_worker)]
    pub jobs: Option<NonZeroUsize>,
    /// Time without a simulated step after which a task fails
    #[arg(long, value_name = "SECONDS", default_value_t = STALL_TIMEOUT_S, value_parser = at_least_a_second())]
    pub stall_timeout: u64,
    /// Memory in MB beyond which a worker is ended and its task fails [default: an equal share of 90% of the machine's]
    #[arg(long, value_name = "MB", value_parser = megabytes())]
    pub memory_per_worker: Option<u64>,
}

impl LimitsArgs {
    /// Returns how many workers this machine has.
    pub(super) fn here(&self) -> usize {
        self.jobs.or_else(|| available_parallelism().ok()).map_or(1, NonZeroUsize::get)
    }

    /// Returns the memory that each of so many workers of this machine may use, MB; `None` where the system does not tell how
    /// much there is.
    pub(super) fn memory_mb(&self, jobs: usize) -> anyhow::Result<Option<u64>> {
        let usual = memory_per_worker_mb(jobs);
        let is_vain = self.memory_per_worker.is_some() && usual.is_none();
        without_effect(&[("--memory-per-worker", is_vain, "this system has no /proc")])?;
        Ok(self.memory_per_worker.or(usual))
    }

    /// Returns the executor of this machine with these limits, for so many workers.
    pub(super) fn applied(&self, local: Local) -> anyhow::Result<Local> {
        Ok(Local {
            stall_timeout: Duration::from_secs(self.stall_timeout),
            memory_per_worker_mb: self.memory_mb(local.jobs)?,
            ..local
        })
    }
}

/// Hands the tasks that results lack over, and says what happened.
pub(super) fn hand_over(
    executor: Executes,
    (session, domain): (&Session<'_>, &dyn Domain),
    results: &Results,
    args: &WorkersArgs,
    launcher: Launcher,
) -> anyhow::Result<()> {
    let (layout, manifest) = (&session.layout, &session.manifest);
    let lines = args.lines()?;
    let own = absolute(layout.root())?;
    if executor == Executes::Slurm {
        let jobs = slurm::in_queue(&own)?;
        if jobs > 0 {
            let (jobs, name) = (format::count(jobs, "job"), slurm::name(&own));
            return refuse(format!(
                "Slurm has {jobs} of this run; wait, or cancel: scancel --name={name}"
            ));
        }
    }
    let prepared = match session.prepared.as_os_str().is_empty() {
        true => PathBuf::new(),
        false => absolute(&session.prepared)?,
    };
    check_prepared(domain, manifest, &prepared)?;
    let efforts = Efforts::of_run(domain, &manifest.identity)?;
    let seconds = |task: &Task| {
        let effort = efforts.task(&task.method, &task.point)?;
        let seconds = if effort.is_informed { effort.whole_seconds() } else { UNKNOWN_S };
        Ok((task.task, seconds))
    };
    let tasks = results.missing().map(seconds).collect::<Result<Vec<_>, RunError>>()?;
    let packs = packs(tasks, args.job_minutes.map(|minutes| minutes * 60.0));
    let whole: f64 = packs.iter().map(|pack| pack.seconds).sum();
    let workers = args.limits.jobs.map_or(1, NonZeroUsize::get);
    let peak_mb = results.done().filter_map(|(_, record)| record.summary.wall.peak_memory_mb);
    let memory_mb = peak_mb.max().map_or(MEMORY_MB, |mb| (mb as f64 * ROOM.0) as u64 + ROOM.1);
    let submission = Submission {
        number: batch::begin(layout, &packs)?,
        results: own,
        from: absolute(&std::env::current_dir().context("cannot find this folder")?)?,
        prepared,
        launcher,
        lines,
        packs: packs.len(),
        longest_s: packs.iter().map(|pack| pack.time_s(workers)).fold(0.0, f64::max),
        workers,
        memory_mb: memory_mb.max(args.limits.memory_per_worker.unwrap_or(0)),
        memory_per_worker_mb: args.limits.memory_per_worker,
        stall_timeout_s: args.limits.stall_timeout,
    };
    let how = match executor {
        Executes::Slurm => {
            let ids = slurm::submit(&submission)?.join(", ");
            let output = submission.output();
            format!("Slurm has it as job {ids}; what jobs print is in {}", output.display())
        }
        _ => {
            submission.write_script()?;
            let (script, last) = (quoted(&submission.script()), packs.len().saturating_sub(1));
            format!("{script} does one pack, from 0 to {last}: seq 0 {last} | parallel {script}")
        }
    };
    let dir = quoted(layout.root());
    line(format!(
        "{} in {}, about {} of processor time in all",
        format::count(results.missing().count(), "task"),
        format::count(packs.len(), "pack"),
        duration(Duration::from_secs_f64(whole))
    ))?;
    line(how)?;
    line(format!(
        "next: tsc-family status {dir}; resume does the missing tasks, report shows the finished ones"
    ))?;
    Ok(())
}

/// Checks that the files which tasks read are as planned, before workers find out one by one.
pub(super) fn check_prepared(
    domain: &dyn Domain,
    manifest: &Manifest,
    prepared: &Path,
) -> anyhow::Result<()> {
    let mut spoilt = manifest.identity.points.iter().flat_map(|p| domain.spoilt(p, prepared));
    let Some(first) = spoilt.next() else { return Ok(()) };
    refuse(format!(
        "{} is missing or not as planned, as are {} other files; go to where the run was started, say with --networks where they \
         are now, or repeat its command, which makes them: {}",
        quoted(&first.path),
        spoilt.count(),
        manifest.provenance.command
    ))
}
