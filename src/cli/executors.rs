//! Handing tasks over to a batch system: what `run --executor`, `submit` and `resume` have in common.

use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;
use clap::ValueEnum;

use super::output::{duration, line, note};
use super::values::{at_least_a_second, at_least_one_worker, megabytes, minutes};
use crate::cli::refused::Refused;
use crate::files::quoted;
use crate::machine::memory_per_worker_mb;
use crate::report::format;
use crate::run::batch::cost::Costs;
use crate::run::batch::pack::packs;
use crate::run::batch::submission::{self, Packs, Place, Submission, absolute};
use crate::run::batch::{BatchError, BatchSystem, Script, Slurm, Standing, slurm};
use crate::run::domain::Domain;
use crate::run::error::RunError;
use crate::run::executor::Launcher;
use crate::run::session::Session;
use crate::run::watchdog::STALL_TIMEOUT_S;
use crate::store::Layout;
use crate::store::manifest::Task;
use crate::store::results::Results;

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

impl Executes {
    /// Returns the batch system; `None` for this machine.
    pub(super) fn batch_system(self) -> Option<&'static dyn BatchSystem> {
        match self {
            Self::Local => None,
            Self::Slurm => Some(&Slurm),
            Self::Script => Some(&Script),
        }
    }

    /// Returns the executor whose batch system has this name; `None` for one that this program does not know.
    pub(super) fn of(name: &str) -> Option<Self> {
        let mut all = Self::value_variants().iter().copied();
        all.find(|e| e.batch_system().is_some_and(|system| system.name() == name))
    }
}

/// How the tasks of a run are done.
#[derive(Debug, clap::Args)]
pub struct WorkersArgs {
    /// File of `#SBATCH` lines for the jobs, such as partition and account
    #[arg(long, value_name = "FILE")]
    pub sbatch: Option<PathBuf>,
    /// Processor time of a job in a batch system, in minutes [default: from 1 to 30, more for longer runs]
    #[arg(long, value_name = "MINUTES", value_parser = minutes)]
    pub job_minutes: Option<f64>,
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

impl WorkersArgs {
    /// Returns how many workers this machine is to have, which has so many processors.
    pub(super) fn here(&self, processors: usize) -> usize {
        self.jobs.map_or(processors, NonZeroUsize::get)
    }

    /// Returns the memory that each of so many workers of this machine may use, MB; `None` where the system does not tell
    /// how much there is.
    ///
    /// # Errors
    ///
    /// When a limit was asked for that cannot be watched.
    pub(super) fn memory_mb(&self, jobs: usize) -> anyhow::Result<Option<u64>> {
        limit_mb(self.memory_per_worker, jobs)
    }

    /// Returns the lines for the jobs.
    ///
    /// # Errors
    ///
    /// When their file cannot be read, or has something else in it.
    pub(super) fn lines(&self) -> Result<Vec<String>, RunError> {
        Ok(self.sbatch.as_deref().map(slurm::lines).transpose()?.unwrap_or_default())
    }

    /// Refuses what has no effect where tasks are done by somebody.
    pub(super) fn check(&self, executor: Executes) -> anyhow::Result<()> {
        let refuse = |flag: &str, reason: &str| -> anyhow::Result<()> {
            Err(Refused(format!("{flag} has no effect: {reason}; leave it out")).into())
        };
        if self.sbatch.is_some() && executor != Executes::Slurm {
            return refuse("--sbatch", "only --executor slurm takes lines");
        }
        if self.job_minutes.is_some() && executor == Executes::Local {
            return refuse("--job-minutes", "this machine needs no jobs");
        }
        Ok(())
    }
}

/// Returns the memory that each of so many workers of this machine may use, MB.
///
/// # Errors
///
/// When a limit was asked for that cannot be watched.
pub(super) fn limit_mb(asked: Option<u64>, jobs: usize) -> anyhow::Result<Option<u64>> {
    let usual = memory_per_worker_mb(jobs);
    if asked.is_some() && usual.is_none() {
        let reason = "--memory-per-worker has no effect: this system does not tell how much memory a process uses (there \
                      is no /proc); leave it out";
        return Err(Refused(reason.to_owned()).into());
    }
    Ok(asked.or(usual))
}

/// What batch systems have of a run.
#[derive(Debug, Default)]
pub(super) struct Abroad {
    /// Tasks that somebody works on or that wait.
    pub(super) tasks: BTreeSet<usize>,
    /// Submissions with packs that are not over, and how these stand.
    pub(super) submissions: Vec<(Submission, Vec<Count>)>,
    /// The last submission, if it was taken back and nothing of it is left.
    pub(super) cancelled: Option<Submission>,
    /// The last submission, if its script waits for somebody to start it.
    pub(super) script: Option<Submission>,
    /// Results directories of submissions that came along when one of these was copied to here.
    pub(super) of_another: BTreeSet<PathBuf>,
}

impl Abroad {
    /// Says which submissions are left alone.
    pub(super) fn say_of_another(&self) {
        for results in &self.of_another {
            note(format!(
                "this directory is a copy: jobs that were submitted from {} write there, not here",
                results.display()
            ));
        }
    }
}

/// Returns the batch system that has a submission.
///
/// # Errors
///
/// [`Refused`] for one that this program does not know.
pub(super) fn system_of(submission: &Submission) -> Result<&'static dyn BatchSystem, Refused> {
    let name = &submission.executor;
    Executes::of(name).and_then(Executes::batch_system).ok_or_else(|| {
        let number = submission.number;
        let way_out = "this version does not know that executor; use the version that submitted it";
        Refused(format!("submission {number} is of {name:?}: {way_out}"))
    })
}

/// How packs stand, why they wait, and how many do.
pub(super) type Count = (Standing, String, usize);

/// Asks what batch systems have of a run; of scripts only people know.
///
/// # Errors
///
/// [`BatchError`] when one does not answer or a submission cannot be read.
pub(super) fn abroad(layout: &Layout) -> Result<Abroad, BatchError> {
    let mut abroad = Abroad::default();
    let submissions = submission::all(layout)?;
    let last = submissions.last().map_or(0, |last| last.number);
    abroad.script = submissions.last().filter(|last| last.executor == Script.name()).cloned();
    // Nobody can be asked about what has no id, such as a script.
    let (asked, copied): (Vec<Submission>, Vec<Submission>) = submissions
        .into_iter()
        .filter(|s| Executes::of(&s.executor).is_some() && !s.ids.is_empty())
        .partition(|submission| submission.is_of(layout));
    abroad.of_another = copied.into_iter().filter_map(|submission| submission.results).collect();
    let mut all = Vec::new();
    for system in Executes::value_variants().iter().filter_map(|e| e.batch_system()) {
        let own = asked.iter().filter(|s| s.executor == system.name()).cloned();
        let own: Vec<Submission> = own.collect();
        let waiting = system.waiting(&own)?;
        all.extend(own.into_iter().zip(waiting));
    }
    for (submission, waiting) in all {
        if waiting.is_empty() {
            abroad.cancelled =
                Some(submission).filter(|s| s.number == last && s.cancelled.is_some());
            continue;
        }
        let packs = Packs::read(layout, submission.number)?;
        let there = waiting.iter().map(|w| w.pack).collect();
        abroad.tasks.extend(packs.tasks(&there)?.into_iter().flatten());
        let mut counts: Vec<Count> = Vec::new();
        for pack in waiting {
            let same = |(standing, reason, _): &&mut Count| {
                (*standing, reason.as_str()) == (pack.standing, pack.reason.as_str())
            };
            match counts.iter_mut().find(same) {
                Some((.., count)) => *count += 1,
                None => counts.push((pack.standing, pack.reason, 1)),
            }
        }
        abroad.submissions.push((submission, counts));
    }
    Ok(abroad)
}

/// Hands tasks over that nobody has, and says what happened.
///
/// # Arguments
///
/// * `results` — of the run, whose missing tasks are meant.
/// * `there` — what batch systems have already.
/// * `launcher` — how workers are started.
pub(super) fn hand_over(
    system: &dyn BatchSystem,
    (session, domain): (&Session<'_>, &dyn Domain),
    results: &Results,
    there: &Abroad,
    args: &WorkersArgs,
    launcher: Launcher,
) -> anyhow::Result<()> {
    let (layout, manifest) = (&session.layout, &session.manifest);
    let lines = args.lines()?;
    let (theirs, missing): (Vec<&Task>, Vec<&Task>) =
        results.missing().partition(|task| there.tasks.contains(&task.task));
    if !theirs.is_empty() {
        note(format!("the batch system has {} already", format::count(theirs.len(), "task")));
    }
    if missing.is_empty() {
        return Ok(());
    }
    let prepared = Some(&session.prepared).filter(|folder| !folder.as_os_str().is_empty());
    let prepared = prepared.map(|folder| absolute(folder)).transpose().map_err(RunError::from)?;
    let prepared = prepared.unwrap_or_default();
    check_prepared_files(session, domain, &prepared)?;
    let done: Vec<&Task> = results.done().map(|(task, _)| task).collect();
    let costs = Costs::new(domain, layout, manifest, &done)?;
    let cost = |task: &&Task| Ok((task.task, costs.seconds(task)?));
    let packs = packs(
        missing.iter().map(cost).collect::<Result<Vec<_>, RunError>>()?,
        args.job_minutes.map(|minutes| minutes * 60.0),
    );
    let whole: f64 = packs.iter().map(|pack| pack.seconds).sum();
    let workers = args.here(1);
    let results = absolute(layout.root()).map_err(RunError::from)?;
    let number = submission::begin(layout, &packs)?;
    let mut submission = Submission {
        format_version: Submission::VERSION,
        number,
        executor: system.name().to_owned(),
        manifest: manifest.sha256(),
        results: Some(results.clone()),
        packs: packs.len(),
        tasks: missing.len(),
        longest_s: packs.iter().map(|pack| pack.time_s(workers)).fold(0.0, f64::max),
        memory_mb: costs.memory_mb.max(args.memory_per_worker.unwrap_or(0)),
        workers,
        stall_timeout_s: args.stall_timeout,
        memory_per_worker_mb: args.memory_per_worker,
        has_lines: !lines.is_empty(),
        ids: Vec::new(),
        packs_per_id: slurm::PACKS_PER_ARRAY,
        cancelled: None,
    };
    let place = Place {
        results,
        folder: absolute(&submission::folder(layout, number)).map_err(RunError::from)?,
        from: absolute(&std::env::current_dir().context("cannot find this folder")?)
            .map_err(RunError::from)?,
        prepared,
        launcher,
        lines,
    };
    // Who was asked is known also when the answer is no, so that `resume` asks the same one again.
    submission::write(layout, &submission)?;
    submission.ids = system.submit(&submission, &place).map_err(RunError::from)?;
    submission::write(layout, &submission)?;
    let dir = quoted(layout.root());
    line(format!(
        "{} in {}, about {} of processor time in all",
        format::count(submission.tasks, "task"),
        format::count(submission.packs, "pack"),
        duration(Duration::from_secs_f64(whole))
    ))?;
    line(system.how(&submission, &place))?;
    line(format!(
        "next: tsc-family status {dir}; resume does the missing tasks, report shows the finished ones"
    ))?;
    Ok(())
}

/// Says that tasks are done twice where batch systems have them too. One that does not answer is not waited for.
pub(super) fn note_doubled(layout: &Layout) {
    let there = abroad(layout).unwrap_or_default();
    if !there.tasks.is_empty() {
        note(format!(
            "the batch system also has {} of this run, so these would be done twice; \
             tsc-family cancel {} takes them back",
            format::count(there.tasks.len(), "task"),
            quoted(layout.root())
        ));
    }
}

/// Checks that the folder of what was prepared is there.
pub(super) fn check_prepared_folder(session: &Session<'_>) -> anyhow::Result<()> {
    let folder = &session.prepared;
    if folder.as_os_str().is_empty() || folder.is_dir() {
        return Ok(());
    }
    let command = &session.manifest.provenance.command;
    Err(Refused(format!(
        "there is no folder {} here, in which the run had what its tasks read; go to where it was started, say with \
         --networks where they are now, or repeat its command, which makes them: {command}",
        folder.display()
    ))
    .into())
}

/// Checks that the files which tasks read are there, before jobs find out one by one.
fn check_prepared_files(
    session: &Session<'_>,
    domain: &dyn Domain,
    prepared: &Path,
) -> anyhow::Result<()> {
    let points = &session.manifest.identity.points;
    let spoilt: Vec<PathBuf> =
        points.iter().flat_map(|p| domain.spoilt(p, prepared)).map(|s| s.path).collect();
    let Some(first) = spoilt.first() else { return Ok(()) };
    let command = &session.manifest.provenance.command;
    let others = match spoilt.len() - 1 {
        0 => "is".to_owned(),
        others => format!("and {} are", format::count(others, "other file")),
    };
    Err(Refused(format!(
        "{} {others} not as planned; run the command of the run, which makes them ({command}), or \
         say with --networks where they are",
        first.display()
    ))
    .into())
}
