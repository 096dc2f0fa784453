//! `tsc-family routes`: the vehicles of a recorded episode, for plain `sumo`.

use std::collections::BTreeSet;
use std::path::Path;

use super::RoutesArgs;
use super::build_networks::{default_folder, prepare};
use super::evaluate::unknown_point;
use super::osm::quoted;
use super::output::{line, note};
use crate::exit;
use crate::family::load::load_with;
use crate::network::demand::DemandSpec;
use crate::network::index::file;

pub(super) fn run(args: &RoutesArgs) -> anyhow::Result<u8> {
    let loaded = load_with(&args.scenario.scenario, &args.scenario.set)?;
    let point = &args.point;
    if loaded.family.position(point).is_none() {
        return Err(unknown_point(point, &loaded, &args.scenario.scenario).into());
    }
    let networks =
        args.networks.clone().unwrap_or_else(|| default_folder(&args.scenario.scenario, &loaded));
    prepare(&loaded, &BTreeSet::from([point.as_str()]), &networks, true)?;
    let demand = DemandSpec::read(&file(&networks, point, "demand.json"))?;
    let vehicles = demand.write_routes(args.seed, &args.out)?;
    let config = file(&networks, point, "sumocfg");
    line(command(&config, args, loaded.scenario.simulation.time_to_teleport_s))?;
    note(format!("{vehicles} vehicles in {}", args.out.display()));
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
