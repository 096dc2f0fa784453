//! `tsc-family signals`: what is derived of a scenario's signals, as text or JSON lines.

mod look;

use std::path::{Path, PathBuf};

use osm_signals::DrivingSide;
use serde_json::Value;

use self::look::{Look, look};
use super::build_networks::network;
use super::output::{line, note};
use super::point::unknown_point;
use super::scenario::{ScenarioArg, SumocfgArgs};
use crate::cli::exit;
use crate::report::table::Columns;
use crate::traffic::city::default_folder;
use crate::traffic::env::warnings::{folded, warnings};

/// The tables of a signal: where its rows are in JSON, and its columns.
const TABLES: [(&str, &[&str]); 3] = [
    ("lanes", &["lane", "length_m", "seen_m", "street_width_m", "upstream"]),
    ("movements", &["movement", "from", "turn", "lanes", "links", "downstream"]),
    ("phases", &["phase", "state", "counts", "right_of_way", "yielding"]),
];

/// `tsc-family signals`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Shows for each signal:
  its lanes, and how far upstream they are seen, through nodes without a signal;
  its movements, with their links and the lanes to which they lead at the next signals;
  the phases to choose from, with the movements whose pressure they have;
  warnings, which `run --dry-run` prints too.

Examples:
  tsc-family signals city/a.sumocfg
  tsc-family signals busy smoke --json")]
pub struct SignalsArgs {
    /// SUMO configuration, or id of a point MDP; its network is built if it is missing
    #[arg(value_name = "SUMOCFG|POINT")]
    pub place: String,
    /// Scenario that has the point MDP; of a SUMO configuration only its settings count
    #[command(flatten)]
    pub scenario: ScenarioArg,
    /// What counts in place of what a SUMO configuration says
    #[command(flatten)]
    pub given: SumocfgArgs,
    /// Folder of the networks [default: networks/NAME of the scenario]
    #[arg(long, value_name = "DIR")]
    pub networks: Option<PathBuf>,
    /// Print JSON lines: one per signal
    #[arg(long)]
    pub json: bool,
}

pub(super) fn run(args: &SignalsArgs) -> anyhow::Result<u8> {
    let loaded = args.scenario.signals(&args.scenario.settings())?;
    let path = Path::new(&args.place);
    let imported = path.is_file() || path.extension().is_some_and(|e| e == "sumocfg");
    args.given.check(imported)?;
    let config = if imported {
        path.to_path_buf()
    } else if let Some(index) = loaded.family.position(&args.place) {
        let point = &loaded.family.points[index].id;
        let folder = || default_folder(&args.scenario.scenario, &loaded);
        let networks = args.networks.clone().unwrap_or_else(folder);
        network(&loaded, point, &networks)?.sumocfg
    } else {
        return Err(unknown_point(&args.place, &loaded, &args.scenario.scenario).into());
    };
    let look = look(&config, &args.given.given(), &loaded.scenario.signal)?;
    if imported {
        look.notes.iter().for_each(|text| note(format!("warning: {text}")));
    }
    for number in 0..look.loaded.signals.len() {
        if args.json {
            line(look.json(number))?;
        } else {
            line(text(&look, number))?;
        }
    }
    for left_alone in look.loaded.left_alone() {
        // A line of JSON is a signal.
        match args.json {
            true => note(left_alone),
            false => line(left_alone)?,
        }
    }
    Ok(exit::DONE)
}

/// Returns a signal in words.
fn text(look: &Look, number: usize) -> String {
    let (signal, json) = (&look.loaded.signals[number], look.json(number));
    let side = match look.side {
        DrivingSide::Right => "",
        DrivingSide::Left => " (left-hand traffic; movements are numbered as in the mirror image)",
    };
    let mut text = format!("signal {}{side}", signal.spec.id);
    for (name, keys) in TABLES {
        let mut columns = Columns::<&Value>::new();
        for key in keys {
            columns = columns.text(key, key, move |row| cell(&row[*key]));
        }
        let table = columns.table(json[name].as_array().into_iter().flatten());
        text.push_str(&format!("\n{}", table.plain()));
    }
    for warning in folded(warnings(signal)) {
        text.push_str(&format!("\n  warning: {warning}"));
    }
    text
}

/// Returns a value; of several with spaces between them.
fn cell(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(values) => values.iter().map(cell).collect::<Vec<_>>().join(" "),
        Value::Number(number) if number.is_f64() => {
            format!("{:.1}", number.as_f64().unwrap_or_default())
        }
        other => other.to_string(),
    }
}
