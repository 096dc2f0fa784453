//! `tsc-family evaluate`: saved models and the baseline on point MDPs or SUMO scenarios, or all models of a run.
//!
//! It is a run in which the models are methods that do not learn, so that workers, pairing, intervals and page are those of
//! `run`.

mod models;

use crate::cli::exit::refuse;
use std::collections::BTreeSet;
use std::num::NonZeroU32;
use std::path::PathBuf;

use super::controllers::ControllersArgs;
use super::executors::LimitsArgs;
use super::folder::{NETWORKS, RESULTS};
use super::interrupt::interrupted;
use super::local_run::{LocalRun, failures};
use super::output::note;
use super::point::unknown_point;
use super::report::show;
use super::scenario::{ScenarioArg, SumocfgArgs};
use super::values::{Budget, from_one_to, parse_budget};
use crate::cli::method_arguments::named_model;
use crate::domains;
use crate::run::domain::Problem;
use crate::run::plan::{Draft, Request, draft};
use crate::run::session::{Session, open};
use crate::sample::{Choice, Draw, SamplePlan, Sampling};
use crate::store::most;
use crate::store::results::Results;
use crate::traffic::city::default_folder;
use crate::traffic::control::baseline;
use crate::traffic::model::SignalModel;
use crate::traffic::problem::SignalProblem;
use crate::traffic::settings::Scenario;

/// `tsc-family evaluate`.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("place").required(true))]
#[command(after_help = "\
Models and baseline get the same vehicles, and the baseline runs once. Method, hyper-parameters and timing \
of the signals come from the models, everything else from the scenario. Nothing is trained. The ranking and the \
page are those of `run`. With --from, point MDPs, seeds, baseline and own training are those of a run, and only its \
models are simulated: the first one's of several trainings on a point MDP. That writes OUT/transfer/transfer.csv, too.

Examples:
  tsc-family evaluate --model results/smoke/models/000/1.safetensors --point busy smoke
  tsc-family evaluate --model a=a.safetensors --model b=b.safetensors --budget all --out results/ab
  tsc-family evaluate --model m.safetensors --sumocfg city/a.sumocfg --eval-seeds 10
  tsc-family evaluate --model m.safetensors --controller mine=mine.py:Learner --point quiet,busy smoke
  tsc-family evaluate --from results/mplight --out results/mplight-transfer")]
pub struct EvaluateArgs {
    /// Model: a file of the folder `models` of a results directory; its name as a method is METHOD-of-POINT unless you give
    /// one (repeatable)
    #[arg(long = "model", value_name = "[NAME=]FILE", required_unless_present = "from")]
    pub models: Vec<String>,
    /// Results directory whose models are evaluated, each on all its point MDPs
    #[arg(long, value_name = "DIR", group = "place", conflicts_with = "models", requires = "out")]
    pub from: Option<PathBuf>,
    /// Methods whose models are taken [default: all with models]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', requires = "from")]
    pub methods: Vec<String>,
    /// Point MDPs of whose trainings the models are taken [default: all with models]
    #[arg(long, value_name = "ID,...", value_delimiter = ',', requires = "from")]
    pub trained_on: Vec<String>,
    /// Class of your own that a model is of, as it was given to the run that trained it (repeatable)
    #[arg(long = "controller", value_name = "NAME=FILE.py:CLASS")]
    pub classes: Vec<String>,
    /// Scenario that has the point MDPs; with --sumocfg only its settings count
    #[command(flatten)]
    pub scenario: ScenarioArg,
    /// Ids of point MDPs, separated by commas; networks are built if they are missing
    #[arg(long, value_name = "ID,...", value_delimiter = ',', group = "place")]
    pub point: Vec<String>,
    /// Number of point MDPs, chosen as `run` does, or `all`
    #[arg(long, value_name = "N|all", value_parser = parse_budget, group = "place")]
    pub budget: Option<Budget>,
    /// SUMO configuration to evaluate on, instead of point MDPs of the scenario (repeatable)
    #[arg(long, value_name = "FILE", group = "place")]
    pub sumocfg: Vec<PathBuf>,
    /// What counts in place of what it says
    #[command(flatten)]
    pub given: SumocfgArgs,
    /// Evaluation episodes of each model and of the baseline, per point MDP
    #[arg(long, value_name = "K", default_value = "5", value_parser = from_one_to::<{ most::MOST_EVALUATION_SEEDS }>)]
    pub eval_seeds: NonZeroU32,
    /// Seed from which the seeds of the episodes are derived, as in `run`
    #[arg(long, default_value_t = 0)]
    pub seed: u64,
    /// Folder of the networks [default: networks/NAME of the scenario]
    #[arg(long, value_name = "DIR", conflicts_with = "sumocfg")]
    pub networks: Option<PathBuf>,
    /// How many workers there are, and what each may take
    #[command(flatten)]
    pub limits: LimitsArgs,
    /// Results directory, which `report`, `compare` and `check` read; the same command continues it [default: none is kept]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print JSON lines: one per finished task, then one per method
    #[arg(long)]
    pub json: bool,
}

impl EvaluateArgs {
    /// Returns models and classes as `run` takes them.
    pub(super) fn controllers(&self) -> anyhow::Result<ControllersArgs> {
        let models = match &self.from {
            Some(from) => models::given(self, from)?,
            None => {
                let mut names: Vec<String> = Vec::new();
                let mut models = Vec::new();
                for given in &self.models {
                    let named = named_model(given, &names)?;
                    names.extend(named.split_once('=').map(|(name, _)| name.to_owned()));
                    models.push(named);
                }
                models
            }
        };
        Ok(ControllersArgs { models, ..ControllersArgs::of_classes(&self.classes) })
    }
}

pub(super) fn run(args: &EvaluateArgs) -> anyhow::Result<u8> {
    if let (Some(from), Some(out)) = (&args.from, &args.out) {
        return models::run(args, from, out);
    }
    let controllers = args.controllers()?;
    let names: Vec<String> = controllers.model_names();
    let problem = problem(args, &controllers)?;
    let choice = match args.budget.and_then(|budget| budget.0) {
        Some(budget) => {
            let sampling = Sampling::DEFAULT;
            Choice::Budget { budget, sampling, design: None, assisting: None }
        }
        None => Choice::All,
    };
    let request = Request {
        choice: &choice,
        base_seed: args.seed,
        evaluation_seeds: args.eval_seeds.get(),
        ..Request::new(domains::traffic(), &problem, &names)
    };
    let draft = match args.point.is_empty() {
        true => draft(&request)?,
        false => of_points(args, &problem, &names)?,
    };
    let warnings = problem.examine()?;
    warnings.iter().for_each(|warning| note(format!("warning: {warning}")));
    if let Some(out) = &args.out {
        RESULTS.check(out, "--out", None)?;
    }
    if !problem.is_imported() {
        NETWORKS.check(&problem.networks, "--networks", None)?;
    }
    let scratch = super::temporary_folder()?;
    let out = args.out.clone().unwrap_or_else(|| scratch.path().join("results"));
    let session = open(&request, &draft, &out, &|_| {})?;
    finish(args, &session, &controllers)
}

/// Does what is missing, shows what came of it and returns the exit code.
fn finish(
    args: &EvaluateArgs,
    session: &Session<'_>,
    controllers: &ControllersArgs,
) -> anyhow::Result<u8> {
    let local = LocalRun {
        session,
        domain: domains::traffic(),
        launcher: controllers.launcher()?,
        limits: &args.limits,
        against: None,
        json: args.json,
        quiet: false,
    };
    if let Some(code) = local.work_on(&Results::load(&session.layout)?, interrupted()?.as_ref())? {
        return Ok(code);
    }
    if args.out.is_some() {
        return local.summarise();
    }
    let results = Results::load(&session.layout)?;
    show(&domains::report(&session.layout, &results)?, args.json)?;
    Ok(failures(&results))
}

/// Reads the scenario, with the settings of the models.
fn problem(args: &EvaluateArgs, controllers: &ControllersArgs) -> anyhow::Result<SignalProblem> {
    // Demand and networks are of the models' preset, unless another one is asked for.
    let models = controllers.read_models()?;
    let (first, model) = models.first().expect("the command line asks for one");
    let settings = args.scenario.settings_on(model.preset);
    let mut loaded = args.scenario.signals(&settings)?;
    // The baseline is timed as the models are.
    let plain = loaded.scenario;
    loaded.scenario = model.scenario(&plain, &args.scenario.settings())?;
    models[1..].iter().try_for_each(|(_, model)| model.scenario(&plain, &[]).map(drop))?;
    let other = |(name, other): &(String, SignalModel)| {
        let difference = (other.preset != model.preset)
            .then(|| format!("preset {} there, {} here", model.preset.name(), other.preset.name()));
        let of_first = Scenario { signal: model.signal.clone(), ..loaded.scenario.clone() };
        Some((name.clone(), difference.or_else(|| other.difference(&of_first))?))
    };
    if let Some((name, difference)) = models.iter().find_map(other) {
        return refuse(format!(
            "{first} and {name} were trained with another timing of signals ({difference}); evaluate them one by one, or \
             as methods of `run --model`, which says how signals are timed"
        ));
    }
    args.given.check(!args.sumocfg.is_empty())?;
    let networks =
        args.networks.clone().unwrap_or_else(|| default_folder(&args.scenario.scenario, &loaded));
    Ok(SignalProblem::new(loaded, None, networks, &args.sumocfg, &args.given.given(), &[])?)
}

/// Returns the point MDPs that were asked for by their ids, with their importance among these as weights.
fn of_points(
    args: &EvaluateArgs,
    problem: &SignalProblem,
    names: &[String],
) -> anyhow::Result<Draft> {
    let family = problem.family();
    let mut chosen = BTreeSet::new();
    for point in &args.point {
        let Some(index) = family.position(point) else {
            return Err(unknown_point(point, &problem.loaded, &args.scenario.scenario).into());
        };
        chosen.insert(index);
    }
    let total: f64 = chosen.iter().map(|i| family.points[*i].importance).sum();
    let equal = 1.0 / chosen.len() as f64;
    let draw = |i: &usize| Draw {
        point: family.points[*i].id.clone(),
        weight: if total > 0.0 { family.points[*i].importance / total } else { equal },
        count: 1,
        inclusion: None,
    };
    let draws: Vec<Draw> = chosen.iter().map(draw).collect();
    // They are all that the result is about.
    let sample = SamplePlan {
        sampling: Sampling::All,
        budget: draws.len(),
        family_size: draws.len(),
        seed: args.seed,
        draws,
        design: String::new(),
        growth: None,
    };
    let mut methods = vec![baseline::METHOD.name.to_owned()];
    methods.extend_from_slice(names);
    Ok(Draft { sample, methods, replicated: vec![], design: None, memory_per_worker_mb: None })
}
