//! The environment of a point MDP: its files, checked, and the signals they describe.

use std::path::{Path, PathBuf};

use crate::env::world::TurnShare;
use crate::env::{SignalEnv, World};
use crate::error::EvalError;
use crate::family::scenario::Scenario;
use crate::hash::sha256_file;
use crate::network::demand::DemandSpec;
use crate::network::index::file;
use crate::sim::Sim;
use crate::store::manifest::PointRow;

use super::plan::{GENERATED, scenario_files};

/// Returns the environment of a world with a scenario's settings; `scratch` is a folder for the
/// files of the running episode.
pub fn environment<S: Sim>(
    sim: S,
    world: World,
    scenario: &Scenario,
    scratch: &Path,
) -> SignalEnv<S> {
    let (signal, simulation) = (scenario.signal.clone(), scenario.simulation.clone());
    SignalEnv::new(sim, world, signal, simulation, scratch.to_path_buf())
}

/// Returns the world of a point MDP whose network lies in the folder of networks.
///
/// # Errors
///
/// [`EvalError`] when a file is missing or cannot be understood.
pub fn generated_world(networks: &Path, point: &str) -> Result<World, EvalError> {
    let demand = DemandSpec::read(&file(networks, point, "demand.json"))?;
    let mut world = World::from_sumocfg(&file(networks, point, "sumocfg"))?;
    world.turn_shares = demand
        .streams
        .iter()
        .flat_map(|stream| {
            stream.routes.iter().map(|route| TurnShare {
                from: stream.from.clone(),
                to: route.to.clone(),
                share: route.share,
            })
        })
        .collect();
    world.routes = Some(Box::new(move |seed, path| demand.write_routes(seed, path).map(drop)));
    Ok(world)
}

/// Returns the world of a planned point MDP after checking that its files are those of the plan.
///
/// # Errors
///
/// [`EvalError::Altered`] when they are not, and whatever makes them unreadable.
pub fn planned_world(point: &PointRow, networks: &Path) -> Result<World, EvalError> {
    if point.environment != GENERATED {
        let config = PathBuf::from(&point.environment);
        let world = World::from_sumocfg(&config)?;
        for (name, file) in scenario_files(&config)? {
            check(&file, point.sha256.get(&name))?;
        }
        return Ok(world);
    }
    let folder = networks.join(&point.point);
    for (name, sha256) in &point.sha256 {
        check(&folder.join(name), Some(sha256))?;
    }
    generated_world(networks, &point.point)
}

fn check(path: &Path, sha256: Option<&String>) -> Result<(), EvalError> {
    let altered = |what| Err(EvalError::Altered { path: path.to_path_buf(), what });
    if !path.exists() {
        return altered("was deleted");
    }
    if Some(&sha256_file(path)?) != sha256 {
        return altered("was altered");
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #[test]
    fn networks_are_built_with_the_program_that_environments_look_for() {
        assert_eq!(crate::network::phases::PHASES_PROGRAM, crate::env::derive::PHASES_PROGRAM);
    }
}
