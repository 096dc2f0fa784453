//! `tsc-family evaluate`: a saved model and the baseline, side by side.

use std::num::NonZeroU32;
use std::path::PathBuf;

use comfy_table::{CellAlignment, LineStyle, Table, TableStyle};
use serde_json::json;

use super::build_networks::network;
use super::effects::Use;
use super::output::{Progress, line, note};
use super::point::unknown_point;
use super::scenario::ScenarioArg;
use super::sumocfg_options::SumocfgArgs;
use super::values::{from_one_to, parse_seed};
use crate::cli::exit;
use crate::cli::refused::Refused;
use crate::run::model::SavedModel;
use crate::store::most;
use crate::store::record::Row;
use crate::traffic::city::folder::default_folder;
use crate::traffic::contest::{Arena, Standing};
use crate::traffic::control::baseline;
use crate::traffic::env::World;
use crate::traffic::environment::generated_world;
use crate::traffic::family::load::LoadedScenario;
use crate::traffic::model::SignalModel;
use crate::traffic::point_hash;
use crate::traffic::problem::imported_id;
use crate::traffic::report::level_of_service::letter;
use crate::traffic::settings::Scenario;
use crate::traffic::sim::SimError;
use crate::traffic::sim::intake::Intake;
use crate::traffic::sim::obstacle::{Obstacle, in_words};
use crate::traffic::simulator;

/// Columns of the table: heading, and metric and decimals where it is one.
const COLUMNS: [(&str, Option<(&str, usize)>); 7] = [
    ("method", None),
    ("delay (s)", Some(("delay_s", 1))),
    ("waiting (s)", Some(("waiting_s", 1))),
    ("queue (veh)", Some(("queue_veh", 1))),
    ("unfinished (veh)", Some(("unfinished_veh", 1))),
    ("level of service", None),
    ("score", None),
];

/// `tsc-family evaluate`.
#[derive(Debug, clap::Args)]
#[command(group = clap::ArgGroup::new("place").required(true))]
#[command(after_help = "\
The model and the baseline get the same vehicles. Method, hyper-parameters and timing of the signals
come from the model, everything else from the scenario. Nothing is trained. The score is the model's
mean delay divided by the baseline's.

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
    /// What counts in place of what it says
    #[command(flatten)]
    pub given: SumocfgArgs,
    /// Evaluation episodes of the model and of the baseline
    #[arg(long, value_name = "K", default_value = "5", value_parser = from_one_to::<{ most::MOST_EVALUATION_SEEDS }>)]
    pub eval_seeds: NonZeroU32,
    /// Seed from which the seeds of the episodes are derived, as in `run`
    #[arg(long, default_value_t = 0, value_parser = parse_seed)]
    pub seed: u64,
    /// Folder of the networks [default: networks/NAME of the scenario]
    #[arg(long, value_name = "DIR")]
    pub networks: Option<PathBuf>,
    /// Print JSON lines: one per method
    #[arg(long)]
    pub json: bool,
}

pub(super) fn run(args: &EvaluateArgs) -> anyhow::Result<u8> {
    let model = SignalModel::new(SavedModel::read(&args.model)?)?;
    // Demand and networks are of the model's preset, unless another one is asked for.
    let settings = args.scenario.settings_on(model.preset);
    let mut loaded = args.scenario.signals(&settings)?;
    let scenario = model.scenario(&loaded.scenario, &args.scenario.settings())?;
    // The baseline is timed as the model is.
    loaded.scenario.signal = scenario.signal.clone();
    check(args, &loaded, &model.saved.card.method)?;
    let arena = arena(args, &loaded)?;
    let seeds = arena.evaluation_seeds(args.seed, args.eval_seeds.get());
    if !args.json {
        let card = &model.saved.card;
        note(format!(
            "{}, trained on {} for {} episodes, evaluated on {} with {} seeds",
            card.method,
            card.point,
            card.training_episodes,
            arena.point,
            seeds.len()
        ));
    }
    let point = arena.point.clone();
    let mut progress = Progress::new(2 * seeds.len() as u64, Some("episodes"), args.json);
    let mut done = 0;
    let standings = play(&model, &scenario, arena, &seeds, &mut |_| {
        done += 1;
        progress.set(done, "");
    });
    progress.finish();
    let standings = standings?;
    if args.json {
        for standing in &standings {
            line(json_line(standing, &point, seeds.len()))?;
        }
    } else {
        line(table(&standings))?;
    }
    Ok(exit::DONE)
}

/// Refuses what has no effect.
fn check(args: &EvaluateArgs, loaded: &LoadedScenario, method: &str) -> anyhow::Result<()> {
    let imported = args.sumocfg.is_some();
    args.given.check(imported)?;
    if imported && args.networks.is_some() {
        return Err(
            Refused("--networks has no effect: a SUMO configuration is given".into()).into()
        );
    }
    let settings = args.scenario.settings();
    if settings.iter().flat_map(|s| s.keys()).any(|key| key.starts_with("training.")) {
        return Err(Refused("training.* has no effect: nothing is trained here".into()).into());
    }
    let methods = [baseline::METHOD.name.to_owned(), method.to_owned()];
    let used = Use {
        family: !imported,
        networks: !imported,
        simulation: true,
        methods: Some(&methods),
        ..Use::BUILD
    };
    used.check(loaded, &settings)
}

/// Returns where the model is to be evaluated; the network is built if it is missing.
fn arena(args: &EvaluateArgs, loaded: &LoadedScenario) -> anyhow::Result<Arena> {
    if let Some(config) = &args.sumocfg {
        let intake = Intake::read(config, &args.given.given())?;
        let (found, warnings) = simulator::examine(&intake, &loaded.scenario.signal)?;
        let obstacles: Vec<Obstacle> = intake.obstacles.iter().cloned().chain(found).collect();
        if !obstacles.is_empty() {
            return Err(SimError::Obstacles(in_words(&obstacles)).into());
        }
        warnings.iter().for_each(|warning| note(format!("warning: {warning}")));
        let (point, content) = (imported_id(config), point_hash::of_imported(&intake)?);
        let world = World::of(intake)?;
        return Ok(Arena { point, content, world, imported: true });
    }
    let point = args.point.clone().unwrap_or_default();
    let Some(index) = loaded.family.position(&point) else {
        return Err(unknown_point(&point, loaded, &args.scenario.scenario).into());
    };
    let point = loaded.family.points[index].id.clone();
    let networks =
        args.networks.clone().unwrap_or_else(|| default_folder(&args.scenario.scenario, loaded));
    let world = generated_world(&network(loaded, &point, &networks)?)?;
    let content = point_hash::of_point(loaded, index);
    Ok(Arena { point, content, world, imported: false })
}

#[cfg(feature = "libsumo")]
fn play(
    model: &SignalModel,
    scenario: &Scenario,
    arena: Arena,
    seeds: &[u64],
    done: &mut dyn FnMut(&Row),
) -> anyhow::Result<[Standing; 2]> {
    use crate::cli::scratch::Scratch;
    use crate::traffic::contest::contest;
    use crate::traffic::sim::libsumo::SumoSim;

    let sim = SumoSim::new()?;
    let scratch = Scratch::new(&std::env::temp_dir())?;
    Ok(contest(sim, model, scenario, arena, seeds, scratch.path(), done)?)
}

#[cfg(not(feature = "libsumo"))]
fn play(
    _: &SignalModel,
    _: &Scenario,
    _: Arena,
    _: &[u64],
    _: &mut dyn FnMut(&Row),
) -> anyhow::Result<[Standing; 2]> {
    Err(crate::traffic::sim::SimError::Unavailable("built without the feature `libsumo`".into())
        .into())
}

fn json_line(standing: &Standing, point: &str, episodes: usize) -> serde_json::Value {
    let metric = |name: &str| standing.metrics.get(name);
    json!({
        "event": "evaluation",
        "method": standing.method,
        "point": point,
        "episodes": episodes,
        "delay_s": metric("delay_s"),
        "waiting_s": metric("waiting_s"),
        "queue_veh": metric("queue_veh"),
        "unfinished_veh": metric("unfinished_veh"),
        "level_of_service": metric("delay_s").map(|d| letter(*d)),
        "score": standing.score,
    })
}

fn table(standings: &[Standing]) -> String {
    let mut table = Table::new();
    let rule = LineStyle::none().fill('-').junction('-');
    table.load_style(TableStyle::new().header_separator(rule)).set_header(COLUMNS.map(|c| c.0));
    for (i, (heading, _)) in COLUMNS.iter().enumerate() {
        if let Some(column) = table.column_mut(i).filter(|_| *heading != "method") {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    for standing in standings {
        table.add_row(COLUMNS.map(|(heading, metric)| cell(standing, heading, metric)));
    }
    table.trim_fmt()
}

fn cell(standing: &Standing, heading: &str, metric: Option<(&str, usize)>) -> String {
    let value = |name: &str| standing.metrics.get(name).copied();
    let text = match (heading, metric) {
        (_, Some((name, decimals))) => value(name).map(|v| format!("{v:.decimals$}")),
        ("score", _) => standing.score.map(|s| format!("{s:.2}")),
        ("level of service", _) => value("delay_s").map(|d| letter(d).to_string()),
        _ => Some(standing.method.clone()),
    };
    text.unwrap_or_else(|| "-".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::store::record::Metrics;

    fn standing(method: &str, delay_s: f64, score: Option<f64>) -> Standing {
        let metrics = [
            ("delay_s", delay_s),
            ("waiting_s", 20.04),
            ("queue_veh", 12.25),
            ("unfinished_veh", 31.6),
        ];
        let metrics: Metrics = metrics.into_iter().map(|(n, v)| (n.to_owned(), v)).collect();
        Standing { method: method.into(), metrics, score }
    }

    #[test]
    fn the_table_has_a_row_per_method() {
        let rows = [standing("baseline", 44.3, Some(1.0)), standing("idqn", 22.15, Some(0.5))];
        let words = |line: &str| line.split_whitespace().collect::<Vec<_>>().join(" ");
        let lines: Vec<String> = table(&rows).lines().map(words).collect();
        assert_eq!(
            lines[0],
            "method delay (s) waiting (s) queue (veh) unfinished (veh) level of service score"
        );
        assert_eq!(
            lines[2..],
            ["baseline 44.3 20.0 12.2 31.6 D 1.00", "idqn 22.1 20.0 12.2 31.6 C 0.50"]
        );
    }

    #[test]
    fn without_vehicles_there_is_no_score() {
        let text = table(&[standing("baseline", 0.0, None)]);
        assert!(text.ends_with(" -"), "{text}");
        assert_eq!(
            json_line(&standing("idqn", 0.0, None), "p", 1)["score"],
            serde_json::Value::Null
        );
    }
}
