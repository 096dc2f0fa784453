//! A scenario of signals: a family whose networks are generated, or SUMO scenarios of somebody's own.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use serde_json::Value;

use super::control::existing;
use super::environment::hash_scenario;
use super::error::TrafficError;
use super::existing::Plans;
use super::family::load::LoadedScenario;
use super::network::build::{BuildOptions, BuildSummary, build_all};
use super::network::error::NetworkError;
use super::network::intersection::{IntersectionSpec, intersections};
use super::network_files::{GENERATED, NetworkFiles};
use super::placed::{Placed, placed};
use super::point_hash;
use super::sim::SimError;
use super::sim::intake::Intake;
use super::sim::obstacle::{Given, in_words};
use super::simulator::{examine, signals_in, version};
use evaluation::family::{Feature, MdpFamily, PointMdp};
use evaluation::run::domain::{Prepared, PreparedPoint, Problem};
use evaluation::run::fault::Cause;
use evaluation::store::Layout;

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
    pub imported: BTreeMap<String, Intake>,
    family: MdpFamily,
    /// Plans that were given, by the method that runs them: [`existing`] and those of `--plan-file`.
    pub plans: BTreeMap<String, Placed>,
    /// What is to be said of the SUMO scenarios, once they were looked at.
    warnings: OnceLock<Vec<String>>,
}

impl SignalProblem {
    /// Returns the problem of a scenario.
    ///
    /// # Arguments
    ///
    /// * `sumocfgs` — SUMO configurations that make up the family instead.
    /// * `given` — what counts in place of what these say.
    /// * `plans` — further plans of signals, by method.
    ///
    /// # Errors
    ///
    /// [`TrafficError`] when one of them is none, or two have one name. What else is in their way, [`Self::examine`]
    /// says.
    pub fn new(
        loaded: LoadedScenario,
        folder: Option<PathBuf>,
        networks: PathBuf,
        sumocfgs: &[PathBuf],
        given: &Given,
        plans: &[(String, Plans)],
    ) -> Result<Self, TrafficError> {
        let (family, imported) = match sumocfgs {
            [] => (loaded.family.clone(), BTreeMap::new()),
            configs => imported_family(configs, given)?,
        };
        let today = loaded.plans.iter().filter(|_| imported.is_empty());
        let today = today.map(|plans| (existing::METHOD.name, plans));
        let plans = today
            .chain(plans.iter().map(|(method, plans)| (method.as_str(), plans)))
            .map(|(method, plans)| Ok((method.to_owned(), placed(&loaded, plans)?.whole(plans)?)))
            .collect::<Result<BTreeMap<_, _>, TrafficError>>()?;
        let warnings = OnceLock::new();
        Ok(Self { loaded, folder, networks, imported, family, plans, warnings })
    }

    /// Returns which of some point MDPs have no plan that a method could run.
    pub fn without_plan(&self, method: &str, points: &BTreeSet<&str>) -> Vec<String> {
        let plans = self.plans.get(method);
        let lacks = |point: &&&str| !plans.is_some_and(|p| p.of_point.contains_key(**point));
        points.iter().filter(lacks).map(|point| (*point).to_owned()).collect()
    }

    /// Looks at the SUMO scenarios, once: loads each and derives its signals, and returns what is to be said of them. Of a
    /// family whose networks are generated there is nothing to say.
    ///
    /// # Errors
    ///
    /// [`SimError::Obstacles`] with all that is in the way of all of them, and what keeps SUMO from being used.
    pub fn examine(&self) -> Result<&[String], SimError> {
        if let Some(warnings) = self.warnings.get() {
            return Ok(warnings);
        }
        let (mut obstacles, mut warnings, mut unusable) = (Vec::new(), Vec::new(), None);
        for intake in self.imported.values() {
            obstacles.extend(intake.obstacles.iter().cloned().chain(intake.lacks_vehicles()));
            match examine(intake, &self.loaded.scenario.signal) {
                Ok((found, said)) => {
                    obstacles.extend(found);
                    warnings.extend(said);
                }
                Err(e) => unusable = Some(e),
            }
        }
        match unusable {
            _ if !obstacles.is_empty() => Err(SimError::Obstacles(in_words(&obstacles))),
            Some(e) => Err(e),
            None => Ok(self.warnings.get_or_init(|| warnings)),
        }
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
                let place = [intersection.latitude, intersection.longitude];
                place.iter().all(|degrees| degrees.is_finite()).then_some(place)
            };
            let made = PreparedPoint {
                environment: GENERATED.to_owned(),
                content: point_hash::of_point(&self.loaded, index),
                sha256: files.sha256,
                places: self.loaded.members[index].iter().filter_map(place).collect(),
                given: (self.plans.iter())
                    .filter_map(|(method, plans)| Some((method, plans.of_point.get(&id)?)))
                    .map(|(method, plan)| {
                        (method.clone(), serde_json::to_value(plan).expect("plain data"))
                    })
                    .collect(),
            };
            (id, made)
        };
        Ok(networks.into_iter().map(point).collect())
    }

    fn own(&self) -> Result<BTreeMap<String, PreparedPoint>, TrafficError> {
        let point = |(id, intake): (&String, &Intake)| {
            let given = serde_json::to_value(&intake.given).expect("plain data");
            let given = given.as_object().into_iter().flatten();
            let made = PreparedPoint {
                environment: intake.path.display().to_string(),
                content: point_hash::of_imported(intake)?,
                sha256: hash_scenario(intake)?,
                given: given.map(|(name, value)| (name.clone(), value.clone())).collect(),
                ..PreparedPoint::default()
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
        self.imported.get(point).map_or(1, |intake| signals_in(&intake.path))
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
        self.examine()?;
        let simulator = version()?;
        let points = generated.map_or_else(|| self.own(), Ok)?;
        Ok(Prepared { simulator, folder: self.networks.display().to_string(), points })
    }

    fn warnings(&self) -> Vec<String> {
        self.warnings.get().cloned().unwrap_or_default()
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
    given: &Given,
) -> Result<(MdpFamily, BTreeMap<String, Intake>), TrafficError> {
    let mut imported = BTreeMap::new();
    let named = |config: &&PathBuf, name: &str| imported_id(config) == name;
    for config in configs {
        let mut id = imported_id(config);
        // Benchmarks have many of one name, each in a folder of its own.
        if configs.iter().filter(|other| named(other, &id)).count() > 1
            && let Some(folder) = std::path::absolute(config).ok().as_deref().and_then(Path::parent)
        {
            id = safe_name(&folder.file_name().unwrap_or_default().to_string_lossy());
        }
        if imported.insert(id.clone(), Intake::read(config, given)?).is_some() {
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

/// Returns the id that an imported scenario has as a point MDP, unless another one has it too.
fn imported_id(config: &Path) -> String {
    safe_name(&config.file_stem().unwrap_or_default().to_string_lossy())
}

fn safe_name(name: &str) -> String {
    let safe = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    name.chars().map(safe).collect()
}
