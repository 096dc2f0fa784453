//! `tsc-family routes`: the vehicles of a recorded episode, for plain `sumo`.

use std::path::{Path, PathBuf};

use super::build_networks::network;
use super::folder::check_file;
use super::output::{line, note};
use super::point::unknown_point;
use super::scenario::ScenarioArg;
use super::values::parse_seed;
use crate::cli::exit;
use crate::files::{quoted, write_atomically};
use crate::hash::sha256;
use crate::traffic::city::folder::default_folder;
use crate::traffic::network::demand::DemandSpec;

/// `tsc-family routes`.
#[derive(Debug, clap::Args)]
#[command(after_help = "\
Records have the seed of every episode, for vehicles and SUMO. `routes` prints a command that simulates the \
episode under the network's own signal program, as the baseline does. The delay of a record is the mean of \
timeLoss + departDelay over all vehicles in trips.xml.

Example:
  tsc-family routes --point busy smoke --seed 1889785958 --out busy.rou.xml")]
pub struct RoutesArgs {
    /// Scenario that has the point MDP
    #[command(flatten)]
    pub scenario: ScenarioArg,
    /// Id of the point MDP; its network is built if it is missing
    #[arg(long, value_name = "ID")]
    pub point: String,
    /// Seed of the episode
    #[arg(long, value_name = "S", value_parser = parse_seed)]
    pub seed: u64,
    /// Route file to write
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Folder of the networks [default: networks/NAME of the scenario]
    #[arg(long, value_name = "DIR")]
    pub networks: Option<PathBuf>,
}

pub(super) fn run(args: &RoutesArgs) -> anyhow::Result<u8> {
    check_file(&args.out, "--out", &[b"<routes"], "route file")?;
    let loaded = args.scenario.signals(&args.scenario.settings())?;
    let Some(index) = loaded.family.position(&args.point) else {
        return Err(unknown_point(&args.point, &loaded, &args.scenario.scenario).into());
    };
    let point = &loaded.family.points[index].id;
    let networks =
        args.networks.clone().unwrap_or_else(|| default_folder(&args.scenario.scenario, &loaded));
    let files = network(&loaded, point, &networks)?;
    let demand = DemandSpec::read(&files.demand)?;
    let (vehicles, text) = demand.routes(args.seed);
    write_atomically(&args.out, text.as_bytes())?;
    line(command(&files.sumocfg, args, loaded.scenario.simulation.time_to_teleport_s))?;
    let sha256 = sha256(text.as_bytes());
    note(format!("{vehicles} vehicles in {}, sha256 {sha256}", args.out.display()));
    Ok(exit::DONE)
}

/// Returns the command that simulates the episode under the network's own signal program, as the
/// baseline does.
fn command(config: &Path, args: &RoutesArgs, time_to_teleport_s: f64) -> String {
    let (config, routes, seed) = (quoted(config), quoted(&args.out), args.seed);
    format!(
        "sumo -c {config} --route-files {routes} --seed {seed} --time-to-teleport \
         {time_to_teleport_s} --tripinfo-output trips.xml --tripinfo-output.write-unfinished \
         --tripinfo-output.write-undeparted"
    )
}
