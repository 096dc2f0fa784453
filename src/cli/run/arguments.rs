//! Arguments of `tsc-family run`.

use std::num::{NonZeroU32, NonZeroUsize};
use std::path::PathBuf;

use crate::cli::controllers::ControllersArgs;
use crate::cli::executors::{Executes, WorkersArgs};
use crate::cli::scenario::{ScenarioArg, SumocfgArgs};
use crate::cli::values::{Budget, from_one_to, number, parse_budget};
use crate::sample::Sampling;
use crate::store::most::{MOST_EVALUATION_SEEDS, MOST_REPLICATES};

/// `tsc-family run`.
#[derive(Debug, clap::Args)]
#[command(mut_arg("plans", |plans| plans.conflicts_with("sumocfg")))]
#[command(after_help = "\
The same command continues an interrupted run and keeps finished tasks. With more methods, a larger budget \
or more replicates it adds to the run, whose records stay. Another run in the same directory is refused.

Examples:
  tsc-family run --budget 20 --out results/slc
  tsc-family run --budget all --eval-seeds 10 --out results/all
  tsc-family run smoke --methods max-pressure,actuated --out results/smoke
  tsc-family run --budget 20 --tune max-pressure,actuated,nema --out results/tuned
  tsc-family run smoke --methods idqn --episodes 20 --set signal.delta_time_s=5 --out results/short
  tsc-family run --sumocfg city/a.sumocfg --sumocfg city/b.sumocfg --methods program,max-pressure
  tsc-family run cartpole --preset tuned --budget 40 --methods ppo,dqn
  tsc-family run networks/my-network --existing plans.csv --against existing --out results/today
  tsc-family run --budget 40 --assist results/all --methods idqn --out results/idqn
  tsc-family run --budget 80 --until-decided --methods idqn,mplight --out results/decided
  tsc-family run --budget 80 --executor slurm --sbatch cluster.sbatch --out results/slc
  tsc-family run --budget 20 --controller mine=exec:./cmd --out results/mine
  tsc-family run --budget 80 --dry-run")]
pub struct RunArgs {
    /// Scenario: path or embedded name; with --sumocfg only its settings count
    #[command(flatten)]
    pub scenario: ScenarioArg,
    /// SUMO configuration to take as a point MDP, instead of the scenario's family (repeatable)
    #[arg(long, value_name = "FILE")]
    pub sumocfg: Vec<PathBuf>,
    /// What counts in place of what they say
    #[command(flatten)]
    pub given: SumocfgArgs,
    /// Number of point MDPs to evaluate, or `all` [default: those of the run that is in --out, else all]
    #[arg(long, value_name = "N|all", value_parser = parse_budget)]
    pub budget: Option<Budget>,
    /// How the sample is chosen [default: balanced; bayesian-quadrature where scores assist]
    #[arg(long, value_enum)]
    pub sampling: Option<Sampling>,
    /// Results directory whose point MDPs and weights are taken
    #[arg(long, value_name = "DIR", conflicts_with_all = ["budget", "sampling", "assist", "sumocfg"])]
    pub like: Option<PathBuf>,
    /// Results of the whole family for methods that do not learn; Bayesian quadrature uses their scores [default: published
    /// scores that come with the program, where the settings are theirs]
    #[arg(long, value_name = "DIR", requires = "budget", conflicts_with = "sumocfg")]
    pub assist: Option<PathBuf>,
    /// Choose and weigh the sample without published scores
    #[arg(long, requires = "budget", conflicts_with = "assist")]
    pub no_assist: bool,
    /// Stop at the first look at which it is known which method is the best, or within --within of the best; methods
    /// that are surely behind drop out before
    #[arg(long)]
    pub until_decided: bool,
    /// How much the answer of --until-decided may lose against the best method; 0 asks for one that is ahead of all others
    #[arg(long, value_name = "E", default_value_t = 0.03, value_parser = number(0.0, 1e9), requires = "until_decided")]
    pub within: f64,
    /// Numbers of point MDPs at which the run inspects its results [default: the budget, half of it, and so on down
    /// to 20]
    #[arg(long, value_name = "N,...", value_delimiter = ',', requires = "until_decided")]
    pub looks: Vec<NonZeroUsize>,
    /// Plans that the signals have today, for the method existing: a table with a row per phase, or UTDF
    /// [default: those of the scenario]
    #[arg(long, value_name = "FILE", conflicts_with = "sumocfg")]
    pub existing: Option<PathBuf>,
    /// Methods, separated by commas, or `all`; for signals `baseline` always runs [default: those of the run that is in
    /// --out, else baseline,fixed-time,max-pressure,actuated,nema, with --sumocfg also program, with plans also existing;
    /// for control tasks ppo, and dqn or sac where the task has it]
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub methods: Vec<String>,
    /// Methods that run as they are, and with settings that are tuned on every point MDP as NAME-tuned: max-pressure,
    /// actuated, nema
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub tune: Vec<String>,
    /// Methods that are not the program's own
    #[command(flatten)]
    pub controllers: ControllersArgs,
    /// Methods of the run in --out whose records are computed again, such as a controller that was changed
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub replace: Vec<String>,
    /// Seed from which all others are derived
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Training episodes of every learner; short for `--set training.episodes=N` [default: the
    /// scenario's]
    #[arg(long, value_name = "N", value_parser = from_one_to::<{ u32::MAX }>)]
    pub episodes: Option<NonZeroU32>,
    /// Independent trainings on every point MDP, for methods that tune or learn [default: those of the run that is in
    /// --out, else 1]
    #[arg(long, visible_alias = "trainings", value_name = "R", value_parser = from_one_to::<MOST_REPLICATES>)]
    pub replicates: Option<NonZeroU32>,
    /// Evaluation episodes per task, the same for all methods [default: those of the run that is in --out, else 5]
    #[arg(long, value_name = "K", value_parser = from_one_to::<MOST_EVALUATION_SEEDS>)]
    pub eval_seeds: Option<NonZeroU32>,
    /// Evaluation seeds, in place of those that follow from --seed: a whole number per line; the page and the manifest of a
    /// run have its seeds
    #[arg(long, value_name = "FILE", conflicts_with = "eval_seeds")]
    pub seeds: Option<PathBuf>,
    /// Where tasks run: on this machine, in a job array of Slurm, or in scripts that another program starts
    #[arg(long, value_enum, default_value_t = Executes::Local)]
    pub executor: Executes,
    /// How they are done
    #[command(flatten)]
    pub workers: WorkersArgs,
    /// Results directory [default: results/NAME of the scenario]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Write into a folder that holds other files
    #[arg(long)]
    pub force: bool,
    /// Folder of the networks; missing ones are built [default: networks/NAME of the scenario]
    #[arg(long, value_name = "DIR", conflicts_with = "sumocfg")]
    pub networks: Option<PathBuf>,
    /// Method to divide by in a second report, beside the one relative to the baseline
    #[arg(long, value_name = "METHOD")]
    pub against: Option<String>,
    /// Try the failed tasks of an earlier run of this command again
    #[arg(long)]
    pub retry_failed: bool,
    /// List the chosen point MDPs, their weights and the estimated time, then stop
    #[arg(long, short = 'n')]
    pub dry_run: bool,
    /// Print JSON lines: one per finished task, then one per method
    #[arg(long, conflicts_with = "quiet")]
    pub json: bool,
    /// Print nothing but warnings and errors
    #[arg(long, short)]
    pub quiet: bool,
}
