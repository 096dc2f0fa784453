//! Traffic signals as a domain of evaluation.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Map, Value, json};

use super::control::Controller;
use super::control::baseline;
use super::control::existing;
use super::control::program;
use super::control::registry::METHODS;
use super::controllers::effort;
use super::controllers::{create, setup};
use super::environment::{environment, folder_of, planned_demand, planned_world};
use super::model::{BUILT_ON, SignalModel};
use super::network_files::GENERATED;
use super::own::{Create, Own, Play};
use super::settings::Scenario;
use super::settings::failure;
use super::sim::libsumo::SumoSim;
use super::sim::net_file::signals_in;
use super::trial::{DELAY, SignalTrial, VEHICLES};
use basics::files::FileError;
use basics::hash::sha256_file;
use evaluation::run::RunError;
use evaluation::run::domain::{Domain, EffortOf, Objective, Site, Spoilt, Trial};
use evaluation::run::fault::TrialError;
use evaluation::run::method::{Method, Training, find};
use evaluation::run::model::SavedModel;
use evaluation::run::together::{TOGETHER, Together};
use evaluation::stats::{Direction, Limit};
use evaluation::store::input_files::InputFiles;
use evaluation::store::manifest::PointRow;
use evaluation::store::own::OwnMethod;

/// Traffic signals in SUMO, judged by the mean delay per vehicle.
pub struct Traffic {
    methods: Vec<Method>,
    /// The methods after those that this library has.
    own: Vec<Own>,
}

impl Default for Traffic {
    fn default() -> Self {
        Self { methods: METHODS.to_vec(), own: Vec::new() }
    }
}

impl Traffic {
    /// Name of the domain.
    pub const NAME: &str = "traffic";

    /// Adds a method that is compiled into this program. Its controller gets a seed and the episodes that learners are
    /// trained for; other settings are the caller's own. Another build of the program is another method to a run.
    ///
    /// # Panics
    ///
    /// When there is a method of that name: records would not tell the two apart.
    #[must_use]
    pub fn with(self, method: Method, create: Create) -> Self {
        let learns = method.training == Training::Learned;
        self.with_own(method, Own::compiled(method.name, method.summary, learns, create))
    }

    /// Adds a method of somebody's own.
    ///
    /// # Panics
    ///
    /// As [`Self::with`].
    #[must_use]
    pub fn with_own(mut self, method: Method, own: Own) -> Self {
        let known = self.methods.iter().any(|m| m.name == method.name);
        assert!(!known, "there is a method {:?} already; give yours another name", method.name);
        self.methods.push(method);
        self.own.push(own);
        self
    }

    /// Returns the files that a method of somebody's own consists of, by name; none for another one.
    pub fn files_of(&self, method: &str) -> BTreeMap<String, PathBuf> {
        self.own_of(method).map(|own| own.files.clone()).unwrap_or_default()
    }

    /// Returns a controller.
    fn controller(
        &self,
        method: &str,
        scenario: &Scenario,
        imported: bool,
        seed: u64,
    ) -> Result<Box<dyn Controller>, RunError> {
        match self.own_of(method).map(|own| &own.play) {
            Some(Play::Controller(create)) => Ok(create(&setup(scenario, imported, seed))),
            Some(Play::Learner { learner, senses }) => {
                let mut controller = create(learner, scenario, imported, seed)?;
                let name = find(&self.methods, method)?.name;
                let senses = senses(&setup(scenario, imported, seed));
                let set = controller.set_senses(name, senses);
                set.expect("that the method learns was looked up when it was added");
                Ok(controller)
            }
            Some(Play::Plan) => create(existing::METHOD.name, scenario, imported, seed),
            Some(Play::Model { file, learner }) => {
                let model = SignalModel::new(SavedModel::read(file)?, &self.methods)?;
                let name = find(&self.methods, method)?.name;
                model.controller(name, scenario, |scenario, seed| {
                    self.controller(learner, scenario, imported, seed)
                })
            }
            _ => create(method, scenario, imported, seed),
        }
    }

    /// Returns a method of somebody's own.
    fn own_of(&self, method: &str) -> Option<&Own> {
        let own = self.methods[METHODS.len()..].iter().position(|m| m.name == method)?;
        Some(&self.own[own])
    }
}

impl Domain for Traffic {
    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn objective(&self) -> Objective {
        Objective::new(DELAY, "delay", "s", Direction::Lower)
    }

    fn baseline(&self) -> Option<&'static str> {
        Some(baseline::METHOD.name)
    }

    fn failure(&self) -> Option<Limit> {
        Some(failure())
    }

    fn volume(&self) -> Option<&'static str> {
        Some("inflow_vph")
    }

    fn episode_sections(&self) -> &'static [&'static str] {
        &["demand"]
    }

    fn methods(&self) -> &[Method] {
        &self.methods
    }

    fn own(&self, method: &str) -> Result<Option<OwnMethod>, FileError> {
        self.own_of(method).map_or(Ok(None), Own::described)
    }

    fn trial(
        &self,
        site: &Site<'_>,
        method: &str,
        seed: u64,
    ) -> Result<Box<dyn Trial>, TrialError> {
        let scenario = scenario_of(site.settings).map_err(|e| TrialError::Input(e.into()))?;
        let own = method == program::METHOD.name;
        let input = |e: String| TrialError::Input(e.into());
        let together = Together::of(site.point).map_err(input)?;
        let alone = together.members.is_empty();
        let rows = if alone { std::slice::from_ref(site.point) } else { &together.members };
        let (mut envs, mut held) = (Vec::new(), InputFiles::default());
        for row in rows {
            let (world, files) = planned_world(row, site.prepared, own, method)?;
            held.join(files);
            let scratch = if alone { site.scratch.into() } else { site.scratch.join(&row.point) };
            fs::create_dir_all(&scratch).map_err(FileError::at("create", &scratch))?;
            envs.push(environment(SumoSim::new()?, world, &scenario, &scratch));
        }
        let imported = rows[0].environment != GENERATED;
        let create = |method| self.controller(method, &scenario, imported, seed);
        let controller = create(method).map_err(|e| TrialError::Input(e.into()))?;
        for path in self.own_of(method).into_iter().flat_map(Own::read) {
            held.hold(path)?;
        }
        let mut trial = SignalTrial::new(envs, controller, held);
        let tuned = METHODS.iter().find(|m| m.name == method && m.is_tuned());
        if !alone {
            let baseline =
                create(baseline::METHOD.name).map_err(|e| TrialError::Input(e.into()))?;
            trial.share(together, (baseline, scenario.training.reward_scale))?;
        }
        trial.tuned = tuned.map(|method| (*method, scenario, imported, seed));
        Ok(Box::new(trial))
    }

    /// SUMO takes a colon in the name of an output for a port to connect to, a comma in the name of an input for the end of
    /// it, and other bytes than UTF-8 for other characters.
    fn check_path(&self, path: &Path) -> Result<(), String> {
        let is_plain = |c: char| c != ':' && c != ',' && !c.is_control();
        match path.to_str().is_some_and(|text| text.chars().all(is_plain)) {
            true => Ok(()),
            false => Err(format!(
                "{}: SUMO takes a colon, a comma, a control character and bytes that are no UTF-8 for something else in a \
                 path; give another folder",
                path.display()
            )),
        }
    }

    fn spoilt(&self, point: &PointRow, prepared: &Path) -> Vec<Spoilt> {
        if let Ok(Together { members, .. }) = Together::of(point)
            && !members.is_empty()
        {
            return members.iter().flat_map(|member| self.spoilt(member, prepared)).collect();
        }
        let (is_made, folder) = (point.environment == GENERATED, folder_of(point, prepared));
        let as_planned =
            |path: &Path, sha256: &str| sha256_file(path).is_ok_and(|found| found == sha256);
        let files = point.sha256.iter().map(|(name, sha256)| (folder.join(name), sha256));
        // What is made lies in one folder; a manifest may come from a stranger, and what is spoilt may be removed.
        let files = files.filter(|(path, _)| !is_made || path.parent() == Some(folder.as_path()));
        files
            .filter(|(path, sha256)| !as_planned(path, sha256))
            .map(|(path, _)| Spoilt { is_there: path.exists(), path, is_made })
            .collect()
    }

    /// Of generated networks the number of vehicles follows from the demand; SUMO scenarios bring theirs.
    fn episode_extent(
        &self,
        point: &PointRow,
        prepared: &Path,
        seed: u64,
    ) -> Result<Option<(&'static str, f64)>, TrialError> {
        if point.environment != GENERATED {
            return Ok(None);
        }
        let demand = planned_demand(point, prepared)?;
        Ok(Some((VEHICLES, f64::from(demand.routes(seed).0))))
    }

    /// Returns the number of signals.
    fn agents(&self, point: &PointRow) -> u32 {
        match [GENERATED, TOGETHER].contains(&point.environment.as_str()) {
            true => 1,
            false => signals_in(Path::new(&point.environment)),
        }
    }

    fn efforts(&self, settings: &Value) -> Result<Box<EffortOf>, String> {
        let scenario = scenario_of(settings)?;
        Ok(Box::new(move |method, signals, feature| effort(&scenario, method, signals, feature)))
    }

    fn card(&self, settings: &Value, method: &str) -> Result<Map<String, Value>, String> {
        let mut card = Map::new();
        let mut section = find(&self.methods, method).map_err(|e| e.to_string())?.section();
        if let Some(learner) = self.own_of(method).and_then(|own| own.about.learner.as_deref()) {
            section = find(&self.methods, learner).map_err(|e| e.to_string())?.section();
            card.insert(BUILT_ON.to_owned(), learner.into());
        }
        // A method without settings has no section.
        let of_method = settings.get(&section).cloned().unwrap_or_else(|| json!({}));
        card.insert("settings".to_owned(), of_method);
        for name in ["preset", "signal"] {
            let value = settings.get(name).cloned();
            card.insert(name.to_owned(), value.ok_or_else(|| format!("no settings of {name}"))?);
        }
        Ok(card)
    }
}

/// Returns the scenario of a manifest's settings.
/// The error is what is wrong with them.
pub fn scenario_of(settings: &Value) -> Result<Scenario, String> {
    serde_json::from_value(settings.clone()).map_err(|e| format!("manifest.json: settings: {e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_that_sumo_takes_for_something_else_is_refused() {
        use std::os::unix::ffi::OsStrExt;

        let traffic = Traffic::default();
        let wrong = ["a:b", "results/a,b", "a\n"].map(Path::new);
        let bytes = std::ffi::OsStr::from_bytes(b"a\xff");
        for path in wrong.into_iter().chain([Path::new(bytes)]) {
            let e = traffic.check_path(path).unwrap_err();
            assert!(e.contains("give another folder"), "{e}");
        }
        for path in ["results/a b", "/r/\u{e9}t\u{e9}", ""] {
            assert_eq!(traffic.check_path(Path::new(path)), Ok(()));
        }
    }

    #[test]
    #[should_panic(expected = "there is a method \"actuated\" already")]
    fn a_second_method_of_a_name_is_refused() {
        let method = Method::new("actuated", "another", Training::None);
        let _ = Traffic::default().with(method, Box::new(|_| unreachable!("nothing runs")));
    }
}
