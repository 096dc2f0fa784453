//! The command line: arguments and work of each subcommand are in its own file.

mod across;
mod build_networks;
mod check;
mod compare;
mod controllers;
mod doctor;
mod estimate;
mod evaluate;
mod executors;
pub mod exit;
mod export;
mod folder;
mod interrupt;
mod list;
mod local_run;
mod method_arguments;
mod monitor;
mod osm;
mod output;
pub mod point;
mod report;
mod resume;
mod routes;
mod run;
mod scenario;
mod sensitivity;
mod shell;
mod signals;
mod status;
mod subject;
mod train;
mod values;
mod work;
mod worker;

use std::borrow::Cow;
use std::ffi::{OsStr, OsString};
use std::path::Path;
use std::process::ExitCode;

use basics::plain::plain;

use clap::{Arg, CommandFactory, Parser, Subcommand};
use clap_complete::Shell;
use controllers::ControllersArgs;

use crate::files::FileError;
use crate::traffic::domain::Traffic;
use crate::traffic::own::Host;

/// Evaluate traffic signal controllers over all intersections of a city
#[derive(Debug, Parser)]
#[command(name = "tsc-family", version, after_help = AFTER_HELP, max_term_width = 100)]
pub struct Cli {
    /// What to do
    #[command(subcommand)]
    pub command: Command,
}

const AFTER_HELP: &str = "\
Examples:
  tsc-family list                            the embedded family of Salt Lake City
  tsc-family run smoke --out results/smoke   a first run, in seconds
  tsc-family run --budget 20 --out results/slc
  tsc-family report results/slc

Exit codes:
  0 done, 1 unexpected, 2 usage or input, 3 some tasks failed, 4 SUMO or MuJoCo missing,
  5 DIR holds another run or is in use, 6 some tasks have no record,
  75 stopped at a checkpoint, 130 interrupted";

/// Subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Show the point MDPs of a family and their importance
    List(list::ListArgs),
    /// Build the SUMO networks of a family
    BuildNetworks(Box<build_networks::BuildNetworksArgs>),
    /// Evaluate controllers on a sample of a family
    Run(Box<run::RunArgs>),
    /// Train one network on several point MDPs
    Train(Box<train::TrainArgs>),
    /// Evaluate all models of a results directory on all its point MDPs
    Evaluate(Box<evaluate::EvaluateArgs>),
    /// Write the vehicles of a recorded episode for plain `sumo`
    Routes(routes::RoutesArgs),
    /// Show the lanes, movements and phases derived from a scenario's signals, with warnings
    Signals(signals::SignalsArgs),
    /// Write the tables, figures and HTML page of a results directory
    Report(report::ReportArgs),
    /// Pack a results directory into one small file, as runs are published
    Export(export::ExportArgs),
    /// Find damaged files in a results directory
    Check(check::CheckArgs),
    /// Show the progress of a run
    Status(status::StatusArgs),
    /// Do the missing tasks of a run
    Resume(resume::ResumeArgs),
    /// Measure the error of samples at several budgets, on results of a whole family
    Estimate(estimate::EstimateArgs),
    /// Rank the methods of several results directories together
    Compare(compare::CompareArgs),
    /// Rank methods over every combination of one point MDP from each of several families
    Across(across::AcrossArgs),
    /// Rank the methods of a results directory with other importance of the point MDPs
    Sensitivity(sensitivity::SensitivityArgs),
    /// Check SUMO and this machine, and say what is wrong
    Doctor {
        /// Print one JSON object
        #[arg(long)]
        json: bool,
    },
    /// Do one task of a plan; used by `run`
    #[command(hide = true)]
    Worker(worker::WorkerArgs),
    /// Do a pack of tasks; used by jobs of batch systems
    #[command(hide = true)]
    Work(work::WorkArgs),
    /// Print a completion script for a shell
    #[command(after_help = "\
Examples:
  tsc-family completions bash > ~/.local/share/bash-completion/completions/tsc-family
  echo 'source <(tsc-family completions zsh)' >> ~/.zshrc
  tsc-family completions fish > ~/.config/fish/completions/tsc-family.fish")]
    Completions {
        /// The shell
        shell: Shell,
    },
}

/// A program that is this command line with something of its own.
#[derive(Default)]
pub struct Program {
    /// Signals, with further methods.
    pub traffic: Traffic,
    /// How the program is started again, as workers are: program and first arguments. Empty for its executable alone.
    pub start: Vec<OsString>,
    /// What opens controllers in another language.
    pub host: Option<Box<dyn Host>>,
}

/// Runs the command line of this process with further methods of signals, and returns its exit code. Workers are the
/// same program, so that they have them too.
///
/// ```no_run
/// use tsc_family::{Traffic, cli};
///
/// fn main() -> std::process::ExitCode {
///     cli::main_with(Traffic::default())
/// }
/// ```
pub fn main_with(traffic: Traffic) -> ExitCode {
    // It answers the script of a shell and ends the process, if it is that which asks.
    shell::complete(Cli::command);
    let program = Program { traffic, ..Program::default() };
    ExitCode::from(main_of(program, std::env::args_os().collect()))
}

/// Runs a command line and returns its exit code; to be called once in a process.
///
/// # Arguments
///
/// * `args` — the program's name and its arguments.
pub fn main_of(program: Program, args: Vec<OsString>) -> u8 {
    let cli = match parse(&args) {
        Ok(cli) => cli,
        Err(code) => return code,
    };
    let Program { traffic, start, host } = program;
    let known = cli.command.controllers().and_then(|(given, dir)| {
        controllers::set_up((given.as_deref(), dir), traffic, start, host)
    });
    let done = known.and_then(|()| run(cli));
    done.unwrap_or_else(|error| {
        complain(&error, &args);
        exit::code(error.as_ref())
    })
}

/// Runs a command and returns its exit code.
fn run(cli: Cli) -> anyhow::Result<u8> {
    if let Command::BuildNetworks(args) = &cli.command
        && let Some(jobs) = args.jobs
    {
        rayon::ThreadPoolBuilder::new().num_threads(jobs.get()).build_global()?;
    }
    match cli.command {
        Command::List(args) => list::run(&args),
        Command::BuildNetworks(args) => build_networks::run(&args),
        Command::Run(args) => run::run(&args),
        Command::Train(args) => train::run(*args),
        Command::Evaluate(args) => evaluate::run(&args),
        Command::Routes(args) => routes::run(&args),
        Command::Signals(args) => signals::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Export(args) => export::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Estimate(args) => estimate::run(&args),
        Command::Compare(args) => compare::run(&args),
        Command::Across(args) => across::run(&args),
        Command::Sensitivity(args) => sensitivity::run(&args),
        Command::Doctor { json } => doctor::run(json),
        Command::Status(args) => status::run(&args),
        Command::Resume(args) => resume::run(&args),
        Command::Work(args) => work::run(&args),
        Command::Worker(args) => worker::run(&args),
        Command::Completions { shell } => shell::completions(shell),
    }
}

/// Reads the command line, or says what is wrong with it and returns the exit code.
fn parse(args: &[OsString]) -> Result<Cli, u8> {
    Cli::try_parse_from(args).map_err(|e| {
        let is_plain = args.iter().all(|arg| {
            let arg = arg.to_string_lossy();
            plain(&arg) == arg
        });
        if is_plain {
            // A closed pipe is no reason to complain.
            let _ = e.print();
        } else {
            // What was given is quoted.
            output::note(e.render());
        }
        u8::try_from(e.exit_code()).unwrap_or(exit::USAGE)
    })
}

impl Command {
    /// Returns what the command line says of methods that are not the program's own, and the results directory that may
    /// have some.
    fn controllers(&self) -> anyhow::Result<(Option<Cow<'_, ControllersArgs>>, Option<&Path>)> {
        let given = |args| Some(Cow::Borrowed(args));
        Ok(match self {
            Self::Run(args) => (given(&args.controllers), None),
            Self::Train(args) => (given(&args.run.controllers), None),
            Self::Worker(args) => (given(&args.controllers), None),
            Self::Work(args) => (given(&args.controllers), None),
            Self::Evaluate(args) => (Some(Cow::Owned(args.controllers()?)), None),
            Self::Resume(args) => (given(&args.controllers), Some(&args.dir)),
            Self::Status(args) => (None, Some(&args.dir)),
            _ => (None, None),
        })
    }
}

/// Returns a folder for the files of a simulation that belongs to no results directory; it is removed when it is dropped.
fn temporary_folder() -> Result<tempfile::TempDir, FileError> {
    tempfile::tempdir().map_err(FileError::at("create", &std::env::temp_dir()))
}

/// Says why a command could not do its work, and which option named a file that cannot be read.
fn complain(error: &anyhow::Error, args: &[OsString]) {
    let why = format!("{error:#}");
    let file = why.strip_prefix("cannot read ").and_then(|rest| Some(rest.split_once(": ")?.0));
    let option = file.and_then(|file| naming(args, file)).unwrap_or_default();
    output::note(format_args!("error: {option}{why}"));
}

/// Returns the option that names a file, with the file, as messages begin.
fn naming(args: &[OsString], file: &str) -> Option<String> {
    let command = Cli::command();
    let matches = command.clone().try_get_matches_from(args).ok()?;
    let (name, matches) = matches.subcommand()?;
    let is_it = |value: &OsStr| {
        let value = value.to_string_lossy();
        value.strip_suffix(file).is_some_and(|name| name.is_empty() || name.ends_with('='))
    };
    let names = |arg: &&Arg| {
        let values = matches.try_get_raw(arg.get_id().as_str()).ok().flatten();
        values.into_iter().flatten().any(is_it)
    };
    let option = command.find_subcommand(name)?.get_arguments().find(names)?;
    Some(format!("--{} {file}: ", option.get_long()?))
}
