//! `tsc-family submit` and `tsc-family resume`: what a run that was planned still lacks, done by somebody else or here.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::thread::available_parallelism;

use super::handover::{Executes, Order, abroad, hand_over};
use super::interrupt::interrupted;
use super::labour::Labour;
use super::output::note;
use super::values::{at_least_a_second, at_least_one_worker, minutes};
use crate::cli::exit;
use crate::cli::refused::Refused;
use crate::domains::domains;
use crate::run::batch::{BatchSystem, Script, Slurm, Standing, submission};
use crate::run::domain::domain_of;
use crate::run::error::RunError;
use crate::run::session::reopen;
use crate::run::watchdog::STALL_TIMEOUT_S;
use crate::store::Layout;
use crate::store::kept::Keep;
use crate::store::manifest::Manifest;
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
    /// Who does the tasks [default: who had them last, or this machine]
    #[arg(long, value_enum)]
    pub executor: Option<Executes>,
    /// File of `#SBATCH` lines for the jobs, such as partition and account
    #[arg(long, value_name = "FILE")]
    pub sbatch: Option<PathBuf>,
    /// Folder of the networks or whatever was prepared [default: where the run had it]
    #[arg(long, value_name = "DIR")]
    pub networks: Option<PathBuf>,
    /// Processor time that a job of a batch system is to take, minutes [default: 1 to 30, more for longer runs]
    #[arg(long, value_name = "MINUTES", value_parser = minutes)]
    pub job_minutes: Option<f64>,
    /// Worker processes at the same time [default: one per processor of this machine, one per job]
    #[arg(long, short, value_name = "J", value_parser = at_least_one_worker)]
    pub jobs: Option<NonZeroUsize>,
    /// Time without a step of the simulation after which a task is given up
    #[arg(long, value_name = "SECONDS", default_value_t = STALL_TIMEOUT_S, value_parser = at_least_a_second())]
    pub stall_timeout: u64,
    /// Print nothing but errors while this machine works
    #[arg(long, short)]
    pub quiet: bool,
}

/// Hands over what is missing; this machine is no batch system.
pub(super) fn submit(args: &SubmitArgs) -> anyhow::Result<u8> {
    if args.executor == Some(Executes::Local) {
        let reason = "this machine is no batch system: `resume` works here";
        return Err(Refused(reason.to_owned()).into());
    }
    go_on(args)
}

/// Does what is missing, where it was done last.
pub(super) fn resume(args: &SubmitArgs) -> anyhow::Result<u8> {
    go_on(args)
}

fn go_on(args: &SubmitArgs) -> anyhow::Result<u8> {
    let layout = Layout::new(&args.dir);
    let manifest = Manifest::read(&layout)?;
    let known = domains();
    let domain = domain_of(&known, &layout, &manifest.identity)?;
    let own = env!("CARGO_PKG_VERSION");
    let there = &manifest.identity.tsc_family;
    if own != there {
        let reason = format!(
            "tsc-family {there} planned this run, and this is {own}; go on with that version"
        );
        return Err(Refused(reason).into());
    }
    let prepared =
        args.networks.clone().unwrap_or_else(|| PathBuf::from(&manifest.provenance.networks));
    let session = reopen(&known, &layout, prepared)?;
    let submissions = submission::all(&layout).map_err(RunError::from)?;
    let last = submissions.last();
    let executor = args.executor.unwrap_or(match last.map(|s| s.executor.as_str()) {
        Some(name) if name == Slurm.name() => Executes::Slurm,
        Some(name) if name == Script.name() => Executes::Script,
        _ => Executes::Local,
    });
    let results = Results::load_all(&layout, |_| Keep::nothing())?.so_far();
    let jobs = |default: usize| args.jobs.map_or(default, NonZeroUsize::get);
    let labour = Labour {
        session: &session,
        domain,
        jobs: jobs(available_parallelism().map_or(1, |j| j.get())),
        stall_timeout_s: args.stall_timeout,
        against: None,
        json: false,
        quiet: args.quiet,
    };
    if results.missing().next().is_none() {
        return labour.summarise();
    }
    if executor == Executes::Local {
        let without =
            [("--sbatch", args.sbatch.is_some()), ("--job-minutes", args.job_minutes.is_some())];
        if let Some((flag, _)) = without.iter().find(|(_, is_given)| *is_given) {
            let reason = format!("{flag} has no effect: this machine does the tasks; leave it out");
            return Err(Refused(reason).into());
        }
        let code = labour.work_on(&results, interrupted()?.as_ref())?;
        return code.map_or_else(|| labour.summarise(), Ok);
    }
    let had_lines = last.is_some_and(|s| s.has_lines && s.executor == Slurm.name());
    if executor == Executes::Slurm && had_lines && args.sbatch.is_none() {
        let reason = "the jobs before had #SBATCH lines; give them again with --sbatch FILE, or an empty file";
        return Err(Refused(reason.to_owned()).into());
    }
    for (submission, counts) in &abroad(&layout).map_err(RunError::from)?.submissions {
        if counts.iter().any(|(standing, ..)| *standing == Standing::Held) {
            Slurm.release(submission).map_err(RunError::from)?;
            note(format!("jobs of submission {} that were held may go on", submission.number));
        }
    }
    let order = Order {
        executor,
        sbatch: args.sbatch.as_deref(),
        workers: jobs(1),
        job_minutes: args.job_minutes,
        stall_timeout_s: args.stall_timeout,
    };
    hand_over(&session, domain, &results, &order)?;
    Ok(exit::DONE)
}
