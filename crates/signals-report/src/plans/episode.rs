//! A single episode for plain `sumo` and `sumo-gui`: what signals showed, second by second, with the vehicles.
//!
//! Each state that a signal showed becomes one phase of a program, which runs once. So `sumo-gui` shows an episode of any
//! method, and plain `sumo` repeats its delay. What the scenario's files write, and programs that change by the clock, are
//! left out of copies, as they are in a run.

use std::path::Path;

use super::beside::{Beside, is_refused};
use super::config::{Show, configuration, set_by_run, way_to};
use super::program_xml::additional;
use basics::files::{self, limits};
use evaluation::store::manifest::{Identity, PointRow};
use signals::environment::planned_demand;
use signals::error::TrafficError;
use signals::network_files::{GENERATED, NetworkFiles};
use signals::program::SignalProgram;
use signals::sim::SimError;
use signals::sim::net_file::mutual;
use signals::sim::sumocfg::SumoConfig;

/// Name of the file with the programs.
const PROGRAMS: &str = "states.add.xml";

/// Name of the file with the vehicles, of a generated network.
const VEHICLES: &str = "vehicles.rou.xml";

/// Name of the folder with copies of a scenario's files.
const COPIES: &str = "scenario";

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
    /// Returns names and texts of the files that show it, for a folder that exists. Copies of the scenario's files are
    /// written into it, where they are needed.
    ///
    /// # Errors
    ///
    /// A file of the scenario that cannot be read, a copy that cannot be written.
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
        let way = way_to(&own, folder)?;
        let wrong = |reason| SimError::Config { path: own.clone(), reason };
        let mut written = Vec::new();
        let mut replaced = set_by_run(identity, point, seed)?;
        let mut program = additional(method, programs, false, &comment);
        if point.environment == GENERATED {
            let demand = planned_demand(point, networks)?;
            written.push((VEHICLES, demand.routes(seed).1));
            replaced.push(("route-files".to_owned(), VEHICLES.to_owned()));
        } else {
            let beside = Beside { own: &own, point, folder, copies: COPIES };
            let mutual = mutual(&SumoConfig::read(&own)?)?;
            let is_refused = is_refused(&mutual, programs);
            let handed = beside.write(program.as_deref().filter(|_| is_refused))?;
            replaced.extend(handed.replaced);
            program = program.filter(|_| !handed.is_inside);
        }
        let has_programs = program.is_some();
        written.extend(program.map(|text| (PROGRAMS, text)));
        let text = files::read_text(&own, limits::NETWORK)?;
        let show = Show {
            text: &text,
            way: &way,
            additional: has_programs.then_some(PROGRAMS),
            replaced: &replaced,
            comment: &comment,
        };
        let text = configuration(&show).map_err(wrong)?;
        written.push((CONFIGURATION, text));
        Ok(written)
    }
}
