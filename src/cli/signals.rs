//! `tsc-family signals`: what is derived of a scenario's signals, as text or JSON lines.

mod look;
mod text;

use std::path::{Path, PathBuf};

use self::look::look;
use super::build_networks::network;
use super::output::{line, note};
use super::point::unknown_point;
use super::scenario::ScenarioArg;
use super::sumocfg_options::SumocfgArgs;
use crate::cli::exit;
use crate::cli::refused::Refused;
use crate::traffic::city::folder::default_folder;

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
    if imported && args.networks.is_some() {
        return Err(
            Refused("--networks has no effect: a SUMO configuration is given".into()).into()
        );
    }
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
    for number in 0..look.signals.len() {
        if args.json {
            line(look.json(number))?;
        } else {
            line(text::text(&look, number))?;
        }
    }
    for left_alone in look.left_alone() {
        // A line of JSON is a signal.
        match args.json {
            true => note(left_alone),
            false => line(left_alone)?,
        }
    }
    Ok(exit::DONE)
}
