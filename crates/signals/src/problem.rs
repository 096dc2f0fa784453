//! A scenario of signals: a family whose networks are generated, or SUMO scenarios of somebody's own.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use serde_json::{Value, json};

use crate::control::{coordinated, existing, program, retime};
use crate::environment::hash_scenario;
use crate::error::TrafficError;
use crate::existing::Plans;
use crate::family::load::LoadedScenario;
use crate::network::build::{BuildOptions, build_all};
use crate::network::error::NetworkError;
use crate::network_files::{GENERATED, NetworkFiles};
use crate::placed::{Placed, placed, with_plans};
use crate::places::legal;
use crate::settings::Detail;
use crate::sim::SimError;
use crate::sim::intake::Intake;
use crate::sim::obstacle::{Given, in_words};
use crate::simulator::{examine, signals_in, version};
use basics::hash::{sha256, sha256_file};
use evaluation::family::{Feature, MdpFamily, PointMdp};
use evaluation::run::domain::{Prepared, PreparedPoint, Problem};
use evaluation::run::fault::Cause;
use evaluation::run::method::Method;
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
    /// * `sumocfgs` — SUMO configurations that make up the family instead.
    /// * `given` — what counts in place of what these say.
    /// * `plans` — further plans of signals, by method.
    ///
    /// Fails with [`TrafficError`] when one of them is none, or two have one name. What else is in their way, [`Self::examine`]
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
        let mut plans = today
            .chain(plans.iter().map(|(method, plans)| (method.as_str(), plans)))
            .map(|(method, plans)| Ok((method.to_owned(), placed(&loaded, plans)?.whole(plans)?)))
            .collect::<Result<BTreeMap<_, _>, TrafficError>>()?;
        let legal_clearances = loaded.scenario.retime.legal_clearances;
        let today = plans.get(existing::METHOD.name).filter(|_| legal_clearances);
        let legal = today.map(|today| legal(&loaded, today)).transpose()?;
        plans.extend(legal.map(|legal| (retime::METHOD.name.to_owned(), legal)));
        let warnings = OnceLock::new();
        Ok(Self { loaded, folder, networks, imported, family, plans, warnings })
    }

    /// Looks at the SUMO scenarios, once: loads each and derives its signals, and returns what is to be said of them. Of a
    /// family whose networks are generated there is nothing to say.
    /// Fails with [`SimError::Obstacles`] with all that is in the way of all of them, and what keeps SUMO from being used.
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
                content: of_point(&self.loaded, index),
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
                content: of_imported(intake)?,
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

    fn today(&self) -> Option<&'static str> {
        let all = self.family.points.iter().map(|point| point.id.as_str()).collect();
        match self.is_imported() {
            true => Some(program::METHOD.name),
            false if self.lacking(existing::METHOD.name, &all).is_none() => {
                Some(existing::METHOD.name)
            }
            false => None,
        }
    }

    fn can_run(&self, method: &Method) -> bool {
        let mut signals = self.family.points.iter().map(|point| self.agents(&point.id));
        match method.name {
            name if [existing::METHOD.name, program::METHOD.name].contains(&name) => {
                self.today() == Some(name)
            }
            name if name == coordinated::METHOD.name => signals.all(|signals| signals > 1),
            _ => true,
        }
    }

    fn lacking(&self, method: &str, chosen: &BTreeSet<&str>) -> Option<String> {
        let plans = self.plans.get(method);
        if plans.is_none() && method != existing::METHOD.name || method == retime::METHOD.name {
            return None;
        }
        let has = |point: &str| plans.is_some_and(|plans| plans.of_point.contains_key(point));
        let lacking: Vec<&str> = chosen.iter().copied().filter(|point| !has(point)).collect();
        let first = lacking.first()?;
        Some(format!(
            "no plan was given, or none that can be shown, for {} of {} point MDPs, such as {first}, which the method {method} \
             needs; complete the table, leave them out of the sample (--budget, --like), or leave the method out",
            lacking.len(),
            chosen.len()
        ))
    }

    fn warnings(&self) -> Result<Vec<String>, Cause> {
        Ok(self.examine()?.to_vec())
    }

    fn write_for_reports(&self, layout: &Layout, stands: &[Option<usize>]) -> Result<(), Cause> {
        if self.is_imported() {
            return Ok(());
        }
        super::places::write(layout, &self.loaded, stands, self.folder.as_deref())
    }
}

/// Builds the networks of some point MDPs where they are missing, checks them all, and returns their files
/// by point MDP.
/// * `done` — called with the id of each point MDP that was built.
///
/// Fails with [`NetworkError`] when a network cannot be built or was altered.
pub fn networks(
    loaded: &LoadedScenario,
    points: &BTreeSet<&str>,
    folder: &Path,
    done: &(dyn Fn(&str) + Sync),
) -> Result<BTreeMap<String, NetworkFiles>, NetworkError> {
    let mut specs = with_plans(loaded)?;
    specs.retain(|s| points.contains(s.point.as_str()));
    Ok(build_all(&specs, &loaded.scenario, folder, BuildOptions::default(), done)?.files)
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

/// Returns the hash of the `index`-th point MDP of a scenario's family.
pub fn of_point(loaded: &LoadedScenario, index: usize) -> String {
    let content = match loaded.scenario.family.detail {
        Detail::SixFeatures => {
            let (family, point) = (&loaded.family, &loaded.family.points[index]);
            let named = family.features.iter().map(|f| &f.name).zip(&point.features);
            json!(named.collect::<Vec<_>>())
        }
        Detail::PerApproach => {
            let arms = loaded.members[index].iter().flat_map(|i| &loaded.intersections[*i].arms);
            let nameless = arms.map(|arm| {
                let mut row = serde_json::to_value(arm).expect("an approach is plain data");
                row["intersection"] = Value::Null;
                row["arm"] = Value::Null;
                row.as_object_mut().map(|row| row.remove("period"));
                row
            });
            json!(nameless.collect::<Vec<_>>())
        }
    };
    hash(&content)
}

/// Returns the hash of an imported scenario.
/// Fails with [`TrafficError`] when a file that is read with it cannot be read.
fn of_imported(intake: &Intake) -> Result<String, TrafficError> {
    let files: Result<Vec<String>, _> =
        intake.sources.named().map(|(_, file)| sha256_file(file)).collect();
    Ok(hash(&json!([intake.begin_s, intake.end_s, files?])))
}

fn hash(content: &Value) -> String {
    sha256(content.to_string().as_bytes())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::fs;

    use super::*;
    use crate::family::load::{load, load_with};

    fn all(loaded: &LoadedScenario) -> Vec<String> {
        (0..loaded.family.points.len()).map(|i| of_point(loaded, i)).collect()
    }

    #[test]
    fn every_point_mdp_of_salt_lake_city_differs_with_and_without_its_own_arms() {
        for detail in ["six-features", "per-approach"] {
            let detail = format!("family.detail={detail}").parse().unwrap();
            let hashes = all(&load_with("salt-lake-city", &[detail]).unwrap());
            assert_eq!(hashes.iter().collect::<BTreeSet<_>>().len(), hashes.len());
        }
    }

    #[test]
    fn neither_names_nor_settings_count() {
        let loaded = load("smoke").unwrap();
        let mut other = loaded.clone();
        other.family.points[0].id = "renamed".into();
        other.scenario.demand.peak_hour_factor = 0.9;
        assert_eq!(all(&loaded), all(&other));
        other.family.points[0].features[0] += 1.0;
        assert_ne!(all(&loaded), all(&other));
        let own = "family.detail=per-approach".parse().unwrap();
        let mut arms = load_with("salt-lake-city", &[own]).unwrap();
        let before = of_point(&arms, 0);
        let first = arms.members[0][0];
        arms.intersections[first].arms.iter_mut().for_each(|a| a.intersection = "x".into());
        assert_eq!(before, of_point(&arms, 0));
    }

    #[test]
    fn a_copy_of_a_sumo_scenario_under_other_names_is_the_same() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, routes: &str, end: u32| {
            let path = |ending: &str| folder.path().join(format!("{name}.{ending}"));
            fs::write(path("net"), "<net/>").unwrap();
            fs::write(path("rou"), routes).unwrap();
            let text = format!(
                "<configuration><net-file value=\"{name}.net\"/>\
                 <route-files value=\"{name}.rou\"/><end value=\"{end}\"/></configuration>"
            );
            fs::write(path("sumocfg"), text).unwrap();
            let given = crate::sim::obstacle::Given::default();
            of_imported(&Intake::read(&path("sumocfg"), &given).unwrap()).unwrap()
        };
        let a = write("a", "<routes/>", 60);
        assert_eq!(a, write("b", "<routes/>", 60));
        assert_ne!(a, write("c", "<routes></routes>", 60));
        assert_ne!(a, write("d", "<routes/>", 61));
    }
}
