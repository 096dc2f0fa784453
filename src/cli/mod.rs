//! The command line: types here, the work of each subcommand in its own file.

mod build_networks;
mod doctor;
mod effects;
mod estimate;
mod evaluate;
pub mod exit;
mod folder;
mod forecast;
mod list;
mod monitor;
mod osm;
mod output;
mod places;
pub mod refused;
mod report;
mod routes;
mod run;
mod shell;
mod signals;
mod worker;

use std::num::{NonZeroU32, NonZeroUsize};
use std::path::PathBuf;

use clap::{Parser, Subcommand};

use crate::run::checkpoint::CHECKPOINT_EVERY_S;
use crate::sample::Sampling;
use crate::settings::overrides::Override;
use crate::traffic::settings::Preset;
use osm::OsmArgs;
pub use shell::complete;

/// Evaluate traffic signal controllers over the whole family of a city's intersections
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
  0 done, 1 unexpected, 2 usage or input, 3 some tasks failed, 4 SUMO missing,
  5 results of another run or in use, 130 interrupted";

/// Subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Show the point MDPs of a family and their importance
    List(ListArgs),
    /// Build the SUMO networks of a family
    BuildNetworks(BuildNetworksArgs),
    /// Evaluate controllers on a sample of a family
    Run(RunArgs),
    /// Evaluate a model that `run` trained on another point MDP or SUMO scenario
    Evaluate(EvaluateArgs),
    /// Write the vehicles of a recorded episode for plain `sumo`
    Routes(routes::RoutesArgs),
    /// Show what is derived of a scenario's signals, and what may be wrong with them
    Signals(signals::SignalsArgs),
    /// Write the tables, figures and HTML page of a results directory
    Report(ReportArgs),
    /// Check SUMO and this machine, and say what is wrong
    Doctor(DoctorArgs),
    /// Do one task of a plan; used by `run`
    #[command(hide = true)]
    Worker(WorkerArgs),
    /// Print a completion script for a shell
    Completions(CompletionsArgs),
    /// Print the manual page
    Man,
}

/// Scenario of a subcommand.
#[derive(Debug, clap::Args)]
pub struct ScenarioArg {
    /// Path of a scenario, or the name of an embedded one: `salt-lake-city`,
    /// `salt-lake-city-peak`, `smoke`
    #[arg(value_name = "SCENARIO", default_value = "salt-lake-city")]
    pub scenario: String,
    /// Setting of the scenario file to replace, such as `demand.horizon_s=600` (repeatable)
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<Override>,
    /// Limits of timing and demand: `resco`, the literature's, or `field`, what a cabinet in the street
    /// allows [default: the scenario's, else `resco`]
    #[arg(long, value_name = "PRESET", value_enum, hide_possible_values = true)]
    preset: Option<Preset>,
}

impl ScenarioArg {
    /// Returns what replaces settings: the preset first, so that a setting counts more.
    fn settings(&self) -> Vec<Override> {
        self.preset.map(Override::preset).into_iter().chain(self.set.iter().cloned()).collect()
    }

    /// Returns the same with a preset where none is given.
    fn settings_on(&self, preset: Preset) -> Vec<Override> {
        let preset = self.preset.unwrap_or(preset);
        std::iter::once(Override::preset(preset)).chain(self.set.iter().cloned()).collect()
    }
}

/// `tsc-family list`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  tsc-family list
  tsc-family list --features
  tsc-family list --set family.detail=per-approach
  tsc-family list my-city.toml --json | head")]
pub struct ListArgs {
    /// The scenario
    #[command(flatten)]
    pub scenario: ScenarioArg,
    /// Show mean and standard deviation of each feature, beside the paper's table
    #[arg(long)]
    pub features: bool,
    /// Print one JSON line per point MDP
    #[arg(long)]
    pub json: bool,
}

/// `tsc-family build-networks`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  tsc-family build-networks
  tsc-family build-networks my-city.toml --out networks/my-city
  tsc-family build-networks --osm utah-latest.osm.pbf --boundary=-112.1,40.7,-111.8,40.8 \
      --signals signals.csv --aadt counts.geojson --out networks/my-city
  sumo-gui -c networks/salt-lake-city/L4-S30-D300-Q500-l0-r0/*.sumocfg")]
pub struct BuildNetworksArgs {
    /// The scenario
    #[command(flatten)]
    pub scenario: ScenarioArg,
    /// Folder to write to [default: networks/NAME of the scenario or extract]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Build all networks again, also those that are up to date or were altered, and write into a
    /// folder that holds other things
    #[arg(long)]
    pub force: bool,
    /// Processors to use [default: all]
    #[arg(long, short, value_name = "J", value_parser = at_least_one_worker)]
    pub jobs: Option<NonZeroUsize>,
    /// Print no progress
    #[arg(long, short)]
    pub quiet: bool,
    /// Family from OpenStreetMap instead
    #[command(flatten)]
    pub osm: OsmArgs,
}

/// `tsc-family run`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
A run is resumable: the same command continues it, finished tasks are kept. Another run in the
same directory is refused.

Examples:
  tsc-family run --budget 20 --out results/slc
  tsc-family run --budget all --eval-seeds 10 --out results/all
  tsc-family run smoke --methods max-pressure,actuated --out results/smoke
  tsc-family run smoke --methods idqn --episodes 20 --set signal.delta_time_s=5 --out results/short
  tsc-family run --sumocfg city/a.sumocfg --sumocfg city/b.sumocfg --methods program,max-pressure
  tsc-family run --budget 80 --dry-run")]
pub struct RunArgs {
    /// Scenario: path or embedded name; with --sumocfg only its settings count
    #[command(flatten)]
    pub scenario: ScenarioArg,
    /// SUMO configuration to take as a point MDP, instead of the scenario's family (repeatable)
    #[arg(long, value_name = "FILE")]
    pub sumocfg: Vec<PathBuf>,
    /// Number of point MDPs to evaluate, or `all`
    #[arg(long, value_name = "N|all", default_value = "all", value_parser = parse_budget)]
    pub budget: Budget,
    /// How the point MDPs of a budget are chosen [default: k-means]
    #[arg(long, value_enum)]
    pub sampling: Option<Sampling>,
    /// Methods, separated by commas, or `all`; `baseline` always runs
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        default_value = "baseline,fixed-time,max-pressure,actuated"
    )]
    pub methods: Vec<String>,
    /// Seed from which all others are derived
    #[arg(long, default_value_t = 0, value_parser = parse_seed)]
    pub seed: u64,
    /// Training episodes of every learner; short for `--set training.episodes=N` [default: the
    /// scenario's]
    #[arg(long, value_name = "N", value_parser = at_least_one)]
    pub episodes: Option<NonZeroU32>,
    /// Independent trainings on every point MDP, for methods that tune or learn
    #[arg(long, value_name = "R", default_value = "1", value_parser = at_least_one)]
    pub replicates: NonZeroU32,
    /// Evaluation episodes per task, the same for all methods
    #[arg(long, value_name = "K", default_value = "5", value_parser = at_least_one)]
    pub eval_seeds: NonZeroU32,
    /// Worker processes at the same time [default: one per processor]
    #[arg(long, short, value_name = "J", value_parser = at_least_one_worker)]
    pub jobs: Option<NonZeroUsize>,
    /// Results directory [default: results/NAME of the scenario]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Write into a folder that holds other things than results
    #[arg(long)]
    pub force: bool,
    /// Folder of the networks; missing ones are built [default: networks/NAME of the scenario]
    #[arg(long, value_name = "DIR")]
    pub networks: Option<PathBuf>,
    /// Method to divide by in a second report, besides that against the baseline
    #[arg(long, value_name = "METHOD")]
    pub against: Option<String>,
    /// Try tasks again that failed in an earlier run of the same command
    #[arg(long)]
    pub retry_failed: bool,
    /// List the chosen point MDPs, their weights and the estimated time, then stop
    #[arg(long, short = 'n')]
    pub dry_run: bool,
    /// Print JSON lines: one per finished task, then one per method
    #[arg(long, conflicts_with = "quiet")]
    pub json: bool,
    /// Print nothing but errors
    #[arg(long, short)]
    pub quiet: bool,
}

/// `tsc-family evaluate`.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("place").required(true))]
#[command(after_help = "\
The model and the baseline get the same vehicles. Method, hyper-parameters and timing of the
signals are the model's, everything else is the scenario's; nothing is trained. The score is the
model's mean delay divided by the baseline's.

Examples:
  tsc-family evaluate --model results/smoke/models/000/1.safetensors --point busy smoke
  tsc-family evaluate --model m.safetensors --sumocfg city/a.sumocfg --eval-seeds 10")]
pub struct EvaluateArgs {
    /// Model: a file of the folder `models` of a results directory
    #[arg(long, value_name = "FILE")]
    pub model: PathBuf,
    /// Scenario that has the point MDP; with --sumocfg only its settings count
    #[command(flatten)]
    pub scenario: ScenarioArg,
    /// Id of the point MDP; its network is built if it is missing
    #[arg(long, value_name = "ID", group = "place")]
    pub point: Option<String>,
    /// SUMO configuration to evaluate on, instead of a point MDP of the scenario
    #[arg(long, value_name = "FILE", group = "place")]
    pub sumocfg: Option<PathBuf>,
    /// Evaluation episodes of each
    #[arg(long, value_name = "K", default_value = "5", value_parser = at_least_one)]
    pub eval_seeds: NonZeroU32,
    /// Seed from which those of the episodes are derived, as in `run`
    #[arg(long, default_value_t = 0, value_parser = parse_seed)]
    pub seed: u64,
    /// Folder of the networks [default: networks/NAME of the scenario]
    #[arg(long, value_name = "DIR")]
    pub networks: Option<PathBuf>,
    /// Print JSON lines: one per method
    #[arg(long)]
    pub json: bool,
}

/// `tsc-family report`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Needs no SUMO. Writes DIR/report/index.html, scores.csv, summary.csv, episodes.csv and the figures
as SVG.

Examples:
  tsc-family report results/slc
  tsc-family report results/slc --against fixed-time")]
pub struct ReportArgs {
    /// Results directory that `run` wrote
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Method to divide by instead of the baseline; the report goes to DIR/report/against-METHOD
    #[arg(long, value_name = "METHOD")]
    pub against: Option<String>,
    /// Print JSON lines instead of the table: one per method
    #[arg(long)]
    pub json: bool,
}

/// `tsc-family doctor`.
#[derive(Debug, clap::Args)]
pub struct DoctorArgs {
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// `tsc-family worker`.
#[derive(Debug, clap::Args)]
pub struct WorkerArgs {
    /// Results directory with manifest and plan
    #[arg(value_name = "DIR")]
    pub dir: PathBuf,
    /// Row of the plan
    #[arg(long, value_name = "K")]
    pub task: usize,
    /// Folder of the networks [default: the manifest's]
    #[arg(long, value_name = "DIR")]
    pub networks: Option<PathBuf>,
    /// Which attempt at the task this is
    #[arg(long, default_value_t = 1)]
    pub attempt: u32,
    /// End when standard input closes
    #[arg(long)]
    pub watch_stdin: bool,
    /// Wall time between two checkpoints of a training, at least
    #[arg(long, value_name = "SECONDS", default_value_t = CHECKPOINT_EVERY_S)]
    pub checkpoint_every_s: u64,
}

/// `tsc-family completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Examples:
  tsc-family completions bash > ~/.local/share/bash-completion/completions/tsc-family
  echo 'source <(tsc-family completions zsh)' >> ~/.zshrc
  tsc-family completions fish > ~/.config/fish/completions/tsc-family.fish")]
pub struct CompletionsArgs {
    /// The shell
    pub shell: clap_complete::Shell,
}

/// Number of point MDPs: `None` is `all`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Budget(pub Option<usize>);

fn parse_budget(text: &str) -> Result<Budget, String> {
    if text == "all" {
        return Ok(Budget(None));
    }
    // A budget of 0 is refused with the family's size, once that is known.
    let number = text.parse().map_err(|_| "expected a whole number or `all`".to_owned())?;
    Ok(Budget(Some(number)))
}

fn at_least_one(text: &str) -> Result<NonZeroU32, String> {
    text.parse().map_err(|_| format!("expected a whole number from 1 to {}", u32::MAX))
}

fn at_least_one_worker(text: &str) -> Result<NonZeroUsize, String> {
    text.parse().map_err(|_| "expected a whole number, 1 or more".to_owned())
}

/// Reads a seed.
///
/// # Errors
///
/// What is expected.
pub(super) fn parse_seed(text: &str) -> Result<u64, String> {
    text.parse().map_err(|_| format!("expected a whole number from 0 to {}", u64::MAX))
}

/// Runs a command and returns its exit code.
///
/// # Errors
///
/// Whatever made the command impossible; [`exit::code`] tells its exit code.
pub fn run(cli: Cli) -> anyhow::Result<u8> {
    match cli.command {
        Command::List(args) => list::run(&args),
        Command::BuildNetworks(args) => build_networks::run(&args),
        Command::Run(args) => run::run(&args),
        Command::Evaluate(args) => evaluate::run(&args),
        Command::Routes(args) => routes::run(&args),
        Command::Signals(args) => signals::run(&args),
        Command::Report(args) => report::run(&args),
        Command::Doctor(args) => doctor::run(&args),
        Command::Worker(args) => worker::run(&args),
        Command::Completions(args) => shell::completions(&args),
        Command::Man => shell::man(),
    }
    .or_else(|error| if is_broken_pipe(&error) { Ok(exit::DONE) } else { Err(error) })
}

/// Whether the reader of our standard output went away, as `head` does; no reason to complain.
fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error
        .chain()
        .filter_map(|e| e.downcast_ref::<std::io::Error>())
        .any(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}
