//! `tsc-family evaluate`: saved models and the baseline, side by side, on point MDPs or SUMO scenarios.
//!
//! It is a run in which the models are methods that do not learn, so that workers, pairing and intervals are those of `run`.

use std::collections::BTreeSet;
use std::num::{NonZeroU32, NonZeroUsize};
use std::path::PathBuf;

use comfy_table::{CellAlignment, LineStyle, Table, TableStyle};
use serde_json::{Value, json};

use super::controllers::ControllersArgs;
use super::folder::{NETWORKS, RESULTS};
use super::local_run::LocalRun;
use super::output::{line, note};
use super::point::unknown_point;
use super::scenario::ScenarioArg;
use super::sumocfg_options::SumocfgArgs;
use super::values::{Budget, at_least_one_worker, from_one_to, parse_budget, parse_seed};
use crate::analysis::{Analysis, MethodSummary};
use crate::cli::exit;
use crate::cli::refused::Refused;
use crate::domains;
use crate::report::format::interval;
use crate::run::domain::Problem;
use crate::run::method::{Training, find};
use crate::run::plan::{Draft, Request, draft};
use crate::run::session::open;
use crate::sample::{Choice, Draw, SamplePlan, Sampling};
use crate::store::most;
use crate::store::record::Metrics;
use crate::store::results::Results;
use crate::traffic::city::folder::default_folder;
use crate::traffic::control::baseline;
use crate::traffic::method_arguments::named_model;
use crate::traffic::model::SignalModel;
use crate::traffic::problem::SignalProblem;
use crate::traffic::report::level_of_service::letter;
use crate::traffic::settings::Scenario;

/// Columns of the table: heading, and metric and decimals where it is one.
const COLUMNS: [(&str, Option<(&str, usize)>); 8] = [
    ("method", None),
    ("delay (s)", Some(("delay_s", 1))),
    ("waiting (s)", Some(("waiting_s", 1))),
    ("queue (veh)", Some(("queue_veh", 1))),
    ("unfinished (veh)", Some(("unfinished_veh", 1))),
    ("level of service", None),
    ("score", None),
    ("95% interval", None),
];

/// Most failures that are named.
const MOST_NAMED: usize = 20;

/// `tsc-family evaluate`.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("place").required(true))]
#[command(after_help = "\
Models and baseline get the same vehicles, and the baseline runs once. Method, hyper-parameters and timing \
of the signals come from the models, everything else from the scenario. Nothing is trained. The score is the \
mean delay divided by the baseline's; over several point MDPs it is weighted by importance.

Examples:
  tsc-family evaluate --model results/smoke/models/000/1.safetensors --point busy smoke
  tsc-family evaluate --model a=a.safetensors --model b=b.safetensors --budget all --out results/ab
  tsc-family evaluate --model m.safetensors --sumocfg city/a.sumocfg --eval-seeds 10
  tsc-family evaluate --model m.safetensors --controller mine=mine.py:Learner --point quiet,busy smoke")]
pub struct EvaluateArgs {
    /// Model: a file of the folder `models` of a results directory; its name as a method is METHOD-of-POINT unless you give
    /// one (repeatable)
    #[arg(long = "model", value_name = "[NAME=]FILE", required = true)]
    pub models: Vec<String>,
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
    #[arg(long, default_value_t = 0, value_parser = parse_seed)]
    pub seed: u64,
    /// Folder of the networks [default: networks/NAME of the scenario]
    #[arg(long, value_name = "DIR")]
    pub networks: Option<PathBuf>,
    /// Worker processes at the same time [default: one per processor]
    #[arg(long, short, value_name = "J", value_parser = at_least_one_worker)]
    pub jobs: Option<NonZeroUsize>,
    /// Results directory, which `report`, `compare` and `check` read; the same command continues it [default: none is kept]
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print JSON lines: one per method and point MDP, then one per method
    #[arg(long)]
    pub json: bool,
}

impl EvaluateArgs {
    /// Returns models and classes as `run` takes them.
    pub(super) fn controllers(&self) -> anyhow::Result<ControllersArgs> {
        let mut models: Vec<String> = Vec::new();
        let mut names: Vec<String> = Vec::new();
        for given in &self.models {
            let named = named_model(given, &names)?;
            names.extend(named.split_once('=').map(|(name, _)| name.to_owned()));
            models.push(named);
        }
        Ok(ControllersArgs { models, ..ControllersArgs::of_classes(&self.classes) })
    }
}

pub(super) fn run(args: &EvaluateArgs) -> anyhow::Result<u8> {
    let controllers = args.controllers()?;
    let names: Vec<String> = controllers.model_names();
    let problem = problem(args, &controllers)?;
    let seeds = args.eval_seeds.get();
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
        evaluation_seeds: seeds,
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
    let scratch;
    let out = match &args.out {
        Some(out) => out.clone(),
        None => {
            scratch = super::temporary_folder()?;
            scratch.path().join("results")
        }
    };
    let session = open(&request, &draft, &out, &|_| {})?;
    let then = if args.out.is_some() { "the same command does them" } else { "nothing is kept" };
    let launcher = controllers.launcher()?;
    if let Some(code) = LocalRun::of_models(&session, launcher, args.jobs, args.json, then)? {
        return Ok(code);
    }
    let results = Results::load(&session.layout)?;
    let analysis = domains::analysis(&session.layout, &results)?;
    say(args, &analysis, &results)
}

/// Reads the scenario, with the settings of the models.
fn problem(args: &EvaluateArgs, controllers: &ControllersArgs) -> anyhow::Result<SignalProblem> {
    let imported = !args.sumocfg.is_empty();
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
        return Err(Refused(format!(
            "{first} and {name} were trained with another timing of signals ({difference}); evaluate them one by one, or \
             as methods of `run --model`, which says how signals are timed"
        ))
        .into());
    }
    args.given.check(imported)?;
    if imported && args.networks.is_some() {
        return Err(
            Refused("--networks has no effect: a SUMO configuration is given".into()).into()
        );
    }
    if args
        .scenario
        .settings()
        .iter()
        .flat_map(|s| s.keys())
        .any(|key| key.starts_with("training."))
    {
        return Err(Refused("training.* has no effect: nothing is trained here".into()).into());
    }
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
    let (methods, known) = (std::iter::once(baseline::METHOD.name), domains::traffic().methods());
    let methods = methods.chain(names.iter().map(String::as_str));
    let methods: Vec<String> = methods.map(str::to_owned).collect();
    for method in &methods {
        debug_assert!(find(known, method).is_ok_and(|m| m.training == Training::None));
    }
    Ok(Draft { sample, methods, replicated: vec![], design: None, memory_per_worker_mb: None })
}

/// Prints what came of it and returns the exit code.
fn say(args: &EvaluateArgs, analysis: &Analysis, results: &Results) -> anyhow::Result<u8> {
    let identity = &results.manifest.identity;
    let failed: Vec<String> = (results.failed())
        .map(|(task, record)| {
            let reason = record.summary.reason.as_deref().unwrap_or("it failed");
            format!("{} on {}: {reason}", task.method, task.point)
        })
        .collect();
    let models = analysis.methods.iter().filter(|m| !m.is_reference);
    if let Some(first) = failed.first().filter(|_| models.clone().all(|m| m.overall.is_none())) {
        let more = if failed.len() > 1 {
            format!("; and {} more", failed.len() - 1)
        } else {
            String::new()
        };
        return Err(Refused(format!("no model has a score: {first}{more}")).into());
    }
    if args.json {
        json_lines(analysis, identity.evaluation_seeds.len())?;
    } else {
        if let [point] = &identity.points[..] {
            note(format!("{}, {} seeds", point.name(), identity.evaluation_seeds.len()));
        } else {
            let (points, seeds) = (identity.points.len(), identity.evaluation_seeds.len());
            note(format!("{points} point MDPs, {seeds} seeds each; means are weighted"));
        }
        for own in &identity.controllers {
            note(format!("{}: {} ({})", own.name, own.summary, own.source));
        }
        line(table(analysis))?;
    }
    for text in failed.iter().take(MOST_NAMED) {
        note(format!("error: {text}"));
    }
    if failed.len() > MOST_NAMED {
        note(format!("error: {} more", failed.len() - MOST_NAMED));
    }
    if let Some(out) = &args.out {
        let out = crate::files::quoted(out);
        note(format!("results: {out}; tsc-family report {out} writes tables and figures"));
    }
    Ok(if failed.is_empty() { exit::DONE } else { exit::SOME_FAILED })
}

fn json_lines(analysis: &Analysis, episodes: usize) -> anyhow::Result<()> {
    let fields = |metric: &dyn Fn(&str) -> Option<f64>| {
        json!({
            "episodes": episodes,
            "delay_s": metric("delay_s"),
            "waiting_s": metric("waiting_s"),
            "queue_veh": metric("queue_veh"),
            "unfinished_veh": metric("unfinished_veh"),
            "level_of_service": metric("delay_s").map(letter),
        })
    };
    let with = |mut value: Value, more: Value| {
        super::json::merge(&mut value, &more);
        value
    };
    for point in &analysis.points {
        for (m, method) in analysis.manifest.identity.methods.iter().enumerate() {
            let Some(result) = &point.results[m] else { continue };
            let head = json!({"event": "evaluation", "method": method, "point": point.row.point});
            let metric = |name: &str| result.metrics.get(name).copied();
            line(with(head, with(fields(&metric), json!({"score": result.score}))))?;
        }
    }
    for method in &analysis.methods {
        let head = json!({"event": "method", "method": method.method, "points": method.points});
        let metric = |name: &str| metric_of(method, name);
        let score = json!({"score": method.overall, "interval": method.interval});
        line(with(head, with(fields(&metric), score)))?;
    }
    Ok(())
}

/// Returns the mean of a metric of a method, over all point MDPs.
fn metric_of(method: &MethodSummary, name: &str) -> Option<f64> {
    if name == "delay_s" { method.objective } else { Metrics::get(&method.metrics, name).copied() }
}

fn table(analysis: &Analysis) -> String {
    let several = analysis.points.len() > 1;
    let mut table = Table::new();
    let rule = LineStyle::none().fill('-').junction('-');
    let headings =
        COLUMNS.iter().map(|(heading, _)| *heading).chain(several.then_some("point MDPs"));
    let headings: Vec<&str> = headings.collect();
    table.load_style(TableStyle::new().header_separator(rule)).set_header(&headings);
    for (i, heading) in headings.iter().enumerate() {
        if let Some(column) = table.column_mut(i).filter(|_| *heading != "method") {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    for method in &analysis.methods {
        let mut cells: Vec<String> =
            COLUMNS.iter().map(|(heading, metric)| cell(method, heading, *metric)).collect();
        cells.extend(several.then(|| method.points.to_string()));
        table.add_row(cells);
    }
    table.trim_fmt()
}

fn cell(method: &MethodSummary, heading: &str, metric: Option<(&str, usize)>) -> String {
    let text = match (heading, metric) {
        (_, Some((name, decimals))) => metric_of(method, name).map(|v| format!("{v:.decimals$}")),
        ("score", _) => method.overall.map(|s| format!("{s:.2}")),
        ("95% interval", _) => method.interval.filter(|_| !method.is_reference).map(interval),
        ("level of service", _) => method.objective.map(|d| letter(d).to_string()),
        _ => Some(method.method.clone()),
    };
    text.unwrap_or_else(|| "-".to_owned())
}
