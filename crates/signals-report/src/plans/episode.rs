//! A single episode for plain `sumo` and `sumo-gui`: what signals showed, second by second, with the vehicles.
//!
//! Each state that a signal showed becomes one phase of a program, which runs once. So `sumo-gui` shows an episode of any
//! method, and plain `sumo` repeats its delay.

use std::path::Path;

use super::config::{Show, configuration, time_to_teleport_s, way_to};
use super::program_xml::additional;
use basics::files::{self, limits};
use evaluation::store::manifest::{Identity, PointRow};
use signals::environment::{given, planned_demand};
use signals::error::TrafficError;
use signals::network_files::{GENERATED, NetworkFiles};
use signals::program::SignalProgram;
use signals::sim::SimError;

/// Name of the file with the programs.
const PROGRAMS: &str = "states.add.xml";

/// Name of the file with the vehicles, of a generated network.
const VEHICLES: &str = "vehicles.rou.xml";

/// Name of the configuration.
pub const CONFIGURATION: &str = "episode.sumocfg";

/// An episode that was played.
#[derive(Debug, Clone, Copy)]
pub struct Episode<'a> {
    /// What the run was.
    pub identity: &'a Identity,
    /// Its point MDP.
    pub point: &'a PointRow,
    /// The folder of the run's networks.
    pub networks: &'a Path,
    /// The method.
    pub method: &'a str,
    /// Its seed.
    pub seed: u64,
    /// What each signal showed.
    pub programs: &'a [SignalProgram],
}

impl Episode<'_> {
    /// Returns names and texts of the files that show it, for a folder that exists.
    ///
    /// # Errors
    ///
    /// A file of the scenario that cannot be read.
    pub fn files(&self, folder: &Path) -> Result<Vec<(&'static str, String)>, TrafficError> {
        let Self { identity, point, networks, method, seed, programs } = *self;
        let comment = vec![
            format!("{method} on {}, seed {seed}", point.point),
            "every state of one episode; open it with: sumo-gui -c episode.sumocfg".to_owned(),
        ];
        let own = match point.environment.as_str() {
            GENERATED => NetworkFiles::new(networks, &point.point, point.sha256.clone()).sumocfg,
            environment => environment.into(),
        };
        let mut written = Vec::new();
        let mut replaced = Vec::new();
        if point.environment == GENERATED {
            let demand = planned_demand(point, networks)?;
            written.push((VEHICLES, demand.routes(seed).1));
            replaced.push(("route-files", VEHICLES.to_owned()));
        } else {
            let given = given(point)?;
            for (name, value) in [
                ("begin", given.begin_s),
                ("end", given.end_s),
                ("step-length", given.step_length_s),
            ] {
                replaced.extend(value.map(|value| (name, value.to_string())));
            }
        }
        let program = additional(method, programs, false, &comment);
        let has_programs = program.is_some();
        written.extend(program.map(|text| (PROGRAMS, text)));
        let text = files::read_text(&own, limits::NETWORK)?;
        let show = Show {
            text: &text,
            way: &way_to(&own, folder)?,
            additional: has_programs.then_some(PROGRAMS),
            replaced: &replaced,
            seed,
            time_to_teleport_s: time_to_teleport_s(identity),
            comment: &comment,
        };
        let wrong = |reason| SimError::Config { path: own.clone(), reason };
        let text = configuration(&show).map_err(wrong)?;
        written.push((CONFIGURATION, text));
        Ok(written)
    }
}
