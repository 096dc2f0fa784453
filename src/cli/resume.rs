//! `tsc-family resume`: what a run that was planned still lacks, done here or handed over.

use std::path::PathBuf;

use super::controllers::{ControllersArgs, manifest_of};
use super::executors::{Executes, WorkersArgs, check_prepared, hand_over};
use super::interrupt::interrupted;
use super::local_run::LocalRun;
use super::output::note;
use super::status::say_who_inspects;
use crate::cli::exit::{self, refuse};
use crate::domains::domains;
use crate::report::format;
use crate::run::batch;
use crate::run::domain::domain_of;
use crate::run::session::reopen;
use crate::run::worker::check_own;
use crate::store::Layout;
use crate::store::results::Results;

/// `tsc-family resume`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  tsc-family resume results/slc
  tsc-family resume results/slc --executor slurm --sbatch cluster.sbatch")]
pub struct ResumeArgs {
    /// Results directory of the run
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Where tasks run [default: slurm with --sbatch, else local]
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

pub(super) fn run(args: &ResumeArgs) -> anyhow::Result<u8> {
    let layout = Layout::new(&args.dir);
    let manifest = manifest_of(&layout)?;
    let known = domains();
    let domain = domain_of(&known, &layout, &manifest.identity)?;
    let own = env!("CARGO_PKG_VERSION");
    let there = &manifest.identity.tsc_family;
    if own != there {
        return refuse(format!(
            "tsc-family {there} planned this run, and this is {own}; use that version"
        ));
    }
    let prepared =
        args.networks.clone().unwrap_or_else(|| PathBuf::from(&manifest.provenance.networks));
    let session = reopen(&known, &layout, manifest, prepared)?;
    let usual = if args.workers.sbatch.is_some() { Executes::Slurm } else { Executes::Local };
    let executor = args.executor.unwrap_or(usual);
    let begun = batch::begun(&layout)?;
    let read = || -> anyhow::Result<Results> {
        Ok(Results::load_known(&layout, &session.manifest)?.under_way(&begun))
    };
    let results = read()?;
    let local = LocalRun {
        session: &session,
        domain,
        launcher: args.controllers.launcher()?,
        limits: &args.workers.limits,
        against: None,
        json: false,
        quiet: args.quiet,
    };
    let again = if args.retry_failed { results.failed().count() } else { 0 };
    let missing = results.missing().count() + again;
    // A look that nobody has begun is none of its tasks.
    let look = results.manifest.identity.sample.look_of();
    let may_grow = look.is_some_and(|(look, looks)| look < looks);
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
    check_prepared(domain, &session.manifest, &session.prepared)?;
    args.workers.lines()?;
    let interrupted = interrupted()?;
    // What failed is forgotten when nothing refuses to try it again.
    let results = if again > 0 {
        session.forget_failed()?;
        read()?
    } else {
        results
    };
    if executor != Executes::Local {
        let launcher = local.launcher.clone();
        hand_over(executor, (&session, domain), &results, &args.workers, launcher)?;
        return Ok(exit::DONE);
    }
    if !args.quiet {
        note(format!("this machine does the missing tasks: {}", format::count(missing, "task")));
    }
    let code = local.work_on(&results, &interrupted)?;
    code.map_or_else(summarise, Ok)
}
