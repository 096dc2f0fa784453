//! `tsc-family submit` and `tsc-family resume`: what a run that was planned still lacks, done by somebody else or here.

use std::path::PathBuf;
use std::thread::available_parallelism;

use super::controllers::{ControllersArgs, manifest_of};
use super::executors::{
    Executes, WorkersArgs, abroad, check_prepared_folder, hand_over, note_doubled, system_of,
};
use super::interrupt::interrupted;
use super::local_run::LocalRun;
use super::output::note;
use super::status::say_who_inspects;
use crate::cli::exit;
use crate::cli::refused::Refused;
use crate::domains::domains;
use crate::report::format;
use crate::run::batch::Standing;
use crate::run::batch::submission::{self, Submission};
use crate::run::domain::domain_of;
use crate::run::error::RunError;
use crate::run::session::reopen;
use crate::run::worker::check_own;
use crate::sample::SamplePlan;
use crate::store::Layout;
use crate::store::results::Results;

/// `tsc-family submit` and `tsc-family resume`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  tsc-family submit results/slc --executor slurm --sbatch cluster.sbatch
  tsc-family submit results/slc --executor script
  tsc-family resume results/slc
  tsc-family resume results/slc --executor local")]
pub struct SubmitArgs {
    /// Results directory with manifest and plan
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Where tasks run [default: where they ran last; else `resume` takes this machine, and `submit` needs a value]
    #[arg(long, value_enum)]
    pub executor: Option<Executes>,
    /// Folder of the networks [default: that of the run]
    #[arg(long, value_name = "DIR")]
    pub networks: Option<PathBuf>,
    /// Try failed tasks again
    #[arg(long)]
    pub retry_failed: bool,
    /// Methods that are not the program's own, as they were given to the run
    #[command(flatten)]
    pub controllers: ControllersArgs,
    /// How they are done
    #[command(flatten)]
    pub workers: WorkersArgs,
    /// Print nothing but errors while this machine works
    #[arg(long, short)]
    pub quiet: bool,
}

/// Hands over what is missing; this machine is no batch system.
pub(super) fn submit(args: &SubmitArgs) -> anyhow::Result<u8> {
    if args.executor == Some(Executes::Local) {
        let reason = "this machine is no batch system; `resume` does tasks here";
        return Err(Refused(reason.to_owned()).into());
    }
    if args.executor.is_none() && asked_last(&Layout::new(&args.dir))?.is_none() {
        let reason = "name the executor: --executor slurm or --executor script; `resume` does the tasks here";
        return Err(Refused(reason.to_owned()).into());
    }
    go_on(args)
}

/// Does what is missing, where it was done last.
pub(super) fn resume(args: &SubmitArgs) -> anyhow::Result<u8> {
    go_on(args)
}

/// Returns the batch system that was asked last, and the submission.
fn asked_last(layout: &Layout) -> anyhow::Result<Option<(Executes, Submission)>> {
    let last = submission::all(layout).map_err(RunError::from)?.pop();
    Ok(last.and_then(|last| Some((Executes::of(&last.executor)?, last))))
}

fn go_on(args: &SubmitArgs) -> anyhow::Result<u8> {
    let layout = Layout::new(&args.dir);
    let manifest = manifest_of(&layout)?;
    let known = domains();
    let domain = domain_of(&known, &layout, &manifest.identity)?;
    let own = env!("CARGO_PKG_VERSION");
    let there = &manifest.identity.tsc_family;
    if own != there {
        let reason =
            format!("tsc-family {there} planned this run, and this is {own}; use that version");
        return Err(Refused(reason).into());
    }
    let prepared =
        args.networks.clone().unwrap_or_else(|| PathBuf::from(&manifest.provenance.networks));
    let session = reopen(&known, &layout, manifest, prepared)?;
    let last = asked_last(&layout)?;
    let asked = last.as_ref().map_or(Executes::Local, |(executor, _)| *executor);
    let executor = args.executor.unwrap_or(asked);
    let grows = session.manifest.identity.sample.growth.is_some();
    let handed = grows.then(|| submission::tasks(&layout)).transpose().map_err(RunError::from)?;
    let begun = submission::begun(&layout, handed.unwrap_or_default());
    let read = || -> anyhow::Result<Results> {
        Ok(Results::load_known(&layout, &session.manifest)?.under_way(&begun))
    };
    let results = read()?;
    let jobs = args.workers.here(available_parallelism().map_or(1, |j| j.get()));
    let local = LocalRun {
        session: &session,
        domain,
        launcher: args.controllers.launcher()?,
        jobs,
        stall_timeout_s: args.workers.stall_timeout,
        memory_per_worker_mb: args.workers.memory_mb(jobs)?,
        against: None,
        json: false,
        quiet: args.quiet,
    };
    let again = if args.retry_failed { results.failed().count() } else { 0 };
    let missing = results.missing().count() + again;
    // A look that nobody has begun is none of its tasks.
    let may_grow = has_later_look(&results.manifest.identity.sample);
    let summarise = || -> anyhow::Result<u8> {
        let code = local.summarise()?;
        if may_grow && !args.quiet {
            say_who_inspects(&session.manifest);
        }
        Ok(code)
    };
    if missing == 0 {
        return summarise();
    }
    let identity = &session.manifest.identity;
    let mut methods = identity.methods.iter();
    methods.try_for_each(|method| check_own(domain, &layout, identity, method))?;
    args.workers.check(executor)?;
    check_prepared_folder(&session)?;
    let had_lines = last.is_some_and(|(last, s)| last == Executes::Slurm && s.has_lines);
    if executor == Executes::Slurm && had_lines && args.workers.sbatch.is_none() {
        let reason = "the jobs before had #SBATCH lines; give them again with --sbatch FILE, or an empty file";
        return Err(Refused(reason.to_owned()).into());
    }
    args.workers.lines()?;
    let system = executor.batch_system();
    let there = system.map(|_| abroad(&layout)).transpose().map_err(RunError::from)?;
    let interrupted = interrupted()?;
    // What failed is forgotten when nothing refuses to try it again.
    let results = if again > 0 {
        session.forget_failed()?;
        read()?
    } else {
        results
    };
    let (Some(system), Some(there)) = (system, there) else {
        if !args.quiet {
            note(format!(
                "this machine does the missing tasks: {}",
                format::count(missing, "task")
            ));
            note_doubled(&layout);
        }
        let code = local.work_on(&results, &interrupted)?;
        return code.map_or_else(summarise, Ok);
    };
    there.say_of_another();
    for (submission, counts) in &there.submissions {
        if counts.iter().any(|(standing, ..)| *standing == Standing::Held) {
            system_of(submission)?.release(submission).map_err(RunError::from)?;
            note(format!("held jobs of submission {} are released", submission.number));
        }
    }
    let launcher = local.launcher.clone();
    hand_over(system, (&session, domain), &results, &there, &args.workers, launcher)?;
    Ok(exit::DONE)
}

/// Returns whether a sample may grow by another look.
fn has_later_look(sample: &SamplePlan) -> bool {
    let looks = sample.growth.as_ref().map_or(0, |growth| growth.looks.len());
    sample.look().is_some_and(|look| look + 1 < looks)
}
