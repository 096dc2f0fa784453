//! A scenario of signals: a family whose networks are generated, or SUMO scenarios of somebody's own.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::content;
use super::env::World;
use super::environment::hash_scenario;
use super::error::TrafficError;
use super::family::load::LoadedScenario;
use super::network::build::{BuildOptions, BuildSummary, build_all};
use super::network::error::NetworkError;
use super::network::intersection::{IntersectionSpec, intersections};
use super::network_files::{GENERATED, NetworkFiles};
use super::simulator::{check, signals_in, version};
use crate::family::{Feature, MdpFamily, PointMdp};
use crate::run::domain::{Prepared, PreparedPoint, Problem};
use crate::run::fault::Cause;
use crate::store::Layout;

/// A scenario of signals.
#[derive(Debug, Clone)]
pub struct SignalProblem {
    /// Settings and family of the scenario; the family counts unless SUMO scenarios are given.
    pub loaded: LoadedScenario,
    /// Folder of the scenario's file, where a city's streets lie beside it; `None` for one that the
    /// program carries.
    pub folder: Option<PathBuf>,
    /// Folder of the generated networks.
    pub networks: PathBuf,
    /// SUMO scenarios by the id of their point MDP; empty where networks are generated.
    pub imported: BTreeMap<String, PathBuf>,
    family: MdpFamily,
}

impl SignalProblem {
    /// Returns the problem of a scenario.
    ///
    /// # Arguments
    ///
    /// * `sumocfgs` — SUMO configurations that make up the family instead.
    ///
    /// # Errors
    ///
    /// [`TrafficError`] when one of them cannot be used, or two have one name.
    pub fn new(
        loaded: LoadedScenario,
        folder: Option<PathBuf>,
        networks: PathBuf,
        sumocfgs: &[PathBuf],
    ) -> Result<Self, TrafficError> {
        let (family, imported) = match sumocfgs {
            [] => (loaded.family.clone(), BTreeMap::new()),
            configs => imported_family(configs)?,
        };
        Ok(Self { loaded, folder, networks, imported, family })
    }

    /// Whether the family are SUMO scenarios of somebody's own.
    pub fn is_imported(&self) -> bool {
        !self.imported.is_empty()
    }

    fn generated(
        &self,
        chosen: &BTreeSet<&str>,
        done: &(dyn Fn(&str) + Sync),
    ) -> Result<BTreeMap<String, PreparedPoint>, TrafficError> {
        let networks = networks(&self.loaded, chosen, &self.networks, done)?;
        let point = |(id, files): (String, NetworkFiles)| {
            let index = self.family.position(&id).expect("networks are of point MDPs");
            let place = |m: &usize| {
                let intersection = &self.loaded.intersections[*m];
                [intersection.latitude, intersection.longitude]
            };
            let made = PreparedPoint {
                environment: GENERATED.to_owned(),
                content: content::of_point(&self.loaded, index),
                sha256: files.sha256,
                places: self.loaded.members[index].iter().map(place).collect(),
            };
            (id, made)
        };
        Ok(networks.into_iter().map(point).collect())
    }

    fn own(&self) -> Result<BTreeMap<String, PreparedPoint>, TrafficError> {
        let point = |(id, config): (&String, &PathBuf)| {
            let made = PreparedPoint {
                environment: config.display().to_string(),
                content: content::of_imported(config)?,
                sha256: hash_scenario(config)?,
                places: Vec::new(),
            };
            Ok((id.clone(), made))
        };
        self.imported.iter().map(point).collect()
    }
}

impl Problem for SignalProblem {
    fn family(&self) -> &MdpFamily {
        &self.family
    }

    fn settings(&self) -> Value {
        serde_json::to_value(&self.loaded.scenario).expect("a scenario is plain data")
    }

    fn agents(&self, point: &str) -> u32 {
        self.imported.get(point).map_or(1, |config| signals_in(config))
    }

    fn prepare(
        &self,
        chosen: &BTreeSet<&str>,
        done: &(dyn Fn(&str) + Sync),
    ) -> Result<Prepared, Cause> {
        let generated = match self.is_imported() {
            true => None,
            false => Some(self.generated(chosen, done)?),
        };
        // One that cannot be simulated is refused before anything is written.
        for config in self.imported.values() {
            check(config, &self.loaded.scenario.signal)?;
        }
        let simulator = version()?;
        let points = generated.map_or_else(|| self.own(), Ok)?;
        Ok(Prepared { simulator, folder: self.networks.display().to_string(), points })
    }

    fn write_for_reports(&self, layout: &Layout, stands: &[Option<usize>]) -> Result<(), Cause> {
        if self.is_imported() {
            return Ok(());
        }
        super::write_places::write(layout, &self.loaded, stands, self.folder.as_deref())
    }
}

/// Builds the networks of some point MDPs where they are missing, checks them all, and returns their files
/// by point MDP.
///
/// # Arguments
///
/// * `done` — called with the id of each point MDP that was built.
///
/// # Errors
///
/// [`NetworkError`] when a network cannot be built or was altered.
pub fn networks(
    loaded: &LoadedScenario,
    points: &BTreeSet<&str>,
    folder: &Path,
    done: &(dyn Fn(&str) + Sync),
) -> Result<BTreeMap<String, NetworkFiles>, NetworkError> {
    let mut specs = intersections(loaded)?;
    specs.retain(|s| points.contains(s.point.as_str()));
    Ok(build(loaded, &specs, folder, BuildOptions::default(), done)?.files)
}

/// Builds the networks of intersections with a scenario's settings.
///
/// # Errors
///
/// [`NetworkError`] as of [`build_all`].
pub fn build(
    loaded: &LoadedScenario,
    specs: &[IntersectionSpec],
    folder: &Path,
    options: BuildOptions,
    done: &(dyn Fn(&str) + Sync),
) -> Result<BuildSummary, NetworkError> {
    let scenario = &loaded.scenario;
    let (network, demand, signal) = (&scenario.network, &scenario.demand, &scenario.signal);
    build_all(specs, network, demand, signal, folder, options, done)
}

fn imported_family(
    configs: &[PathBuf],
) -> Result<(MdpFamily, BTreeMap<String, PathBuf>), TrafficError> {
    let mut imported = BTreeMap::new();
    for config in configs {
        World::from_sumocfg(config)?;
        let id = imported_id(config);
        if imported.insert(id.clone(), config.clone()).is_some() {
            return Err(TrafficError::DoubledPoint(id));
        }
    }
    let share = 1.0 / imported.len() as f64;
    let point = |id: &String| PointMdp {
        id: id.clone(),
        title: id.clone(),
        features: vec![],
        importance: share,
        instances: 1,
    };
    let points = imported.keys().map(point).collect();
    let family = MdpFamily::new("imported", Vec::<Feature>::new(), points, "--sumocfg")?;
    Ok((family, imported))
}

/// Returns the id that an imported scenario has as a point MDP.
pub fn imported_id(config: &Path) -> String {
    let stem = config.file_stem().unwrap_or_default().to_string_lossy();
    let safe = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    stem.chars().map(safe).collect()
}
