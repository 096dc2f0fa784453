//! A scenario of a control task: settings and a family; those that the program carries, and files that say which task they
//! are of.

use std::collections::BTreeSet;
use std::marker::PhantomData;
use std::path::Path;

use serde_json::Value;

use crate::context::{self, ContextError};
use crate::domain::TaskDomain;
use crate::task::scenario::{FamilySettings, Preset, Settings};
use crate::task::{self, Task};
use basics::hash::sha256;
use evaluation::family::points::{self, Kind};
use evaluation::family::{FamilyError, MdpFamily};
use evaluation::run::domain::{Prepared, PreparedPoint, Problem};
use evaluation::run::entry::Entry;
use evaluation::run::fault::Cause;
use evaluation::settings::named::Named;
use evaluation::settings::overrides::Override;
use evaluation::settings::setting::{self, Setting};
use evaluation::settings::source::{file_of, read_scenario, read_text, unreadable};

#[derive(Debug, Clone)]
pub(crate) struct TaskProblem<T: Task> {
    scenario: T::Scenario,
    family: MdpFamily,
}

impl<T: Task> TaskProblem<T> {
    /// `family`: whose features are those of the task, or some; `None` takes the task's own.
    /// Fails with [`ContextError`] when a point MDP is none of the task.
    fn new(scenario: T::Scenario, family: Option<MdpFamily>) -> Result<Self, ContextError> {
        let mut family = family.unwrap_or_else(|| task::family::<T>(scenario.head().1));
        for point in &family.points {
            context::context::<T>(&scenario, &family.features, point)?;
        }
        let without = T::without_effect(&scenario);
        if !without.is_empty() {
            family.describing = left_out(&family, without);
        }
        Ok(Self { scenario, family })
    }
}

fn left_out(family: &MdpFamily, without: &[&str]) -> Vec<Vec<f64>> {
    let acts = |f: &usize| !without.contains(&family.features[*f].name.as_str());
    let acting: Vec<usize> = (0..family.features.len()).filter(acts).collect();
    let row =
        |point: &evaluation::family::PointMdp| acting.iter().map(|f| point.features[*f]).collect();
    if acting.is_empty() { Vec::new() } else { family.points.iter().map(row).collect() }
}

impl<T: Task> Problem for TaskProblem<T> {
    fn family(&self) -> &MdpFamily {
        &self.family
    }

    fn settings(&self) -> Value {
        let of = |scenario: &T::Scenario| {
            serde_json::to_value(scenario).expect("a scenario is plain data")
        };
        let (mut settings, default) = (of(&self.scenario), of(&T::Scenario::default()));
        let all = settings.as_object_mut().expect("a scenario is a table");
        all.retain(|name, value| !T::LATER.contains(&name.as_str()) || default[name] != *value);
        settings
    }

    fn prepare(
        &self,
        chosen: &BTreeSet<&str>,
        done: &(dyn Fn(&str) + Sync),
    ) -> Result<Prepared, Cause> {
        let mut prepared = Prepared { simulator: T::simulator()?, ..Prepared::default() };
        for point in self.family.points.iter().filter(|p| chosen.contains(p.id.as_str())) {
            let context = context::context::<T>(&self.scenario, &self.family.features, point)?;
            let environment = context::text::<T>(&context);
            let content = sha256(format!("{} {environment}", T::NAME).as_bytes());
            let made = PreparedPoint { environment, content, ..PreparedPoint::default() };
            prepared.points.insert(point.id.clone(), made);
            done(&point.id);
        }
        Ok(prepared)
    }
}

impl<T: Task> TaskDomain<T> {
    /// What the command line reads scenarios of the task by.
    pub const ENTRY: Entry = Entry {
        domain: &Self(PhantomData),
        scenarios: &[T::NAME],
        presets: &Preset::NAMES,
        names: <T::Scenario as Named>::names,
        setting: setting_of::<T>,
        load: |scenario, overrides| Ok(Box::new(load::<T>(scenario, overrides)?)),
    };
}

fn setting_of<T: Task>(name: &str) -> Option<&'static Setting> {
    setting::find(&T::Scenario::default().sections(), name)
}

/// Fails with [`FamilyError`] when a setting does not exist or is out of range, or the table has other features than the task.
fn load<T: Task>(scenario: &str, overrides: &[Override]) -> Result<TaskProblem<T>, FamilyError> {
    let embedded = scenario == T::NAME;
    let path = file_of(scenario);
    let (text, file) = match embedded {
        true => (T::EMBEDDED.to_owned(), format!("{}.toml (embedded)", T::NAME)),
        false => (read_scenario(&path)?, path.display().to_string()),
    };
    let toml = |e: ContextError, file| FamilyError::Toml { file, message: e.to_string() };
    let scenario = T::Scenario::read(&text, &file, overrides)?;
    let (_, name, FamilySettings { points }) = scenario.head();
    let Some(table) = points.clone() else {
        return TaskProblem::new(scenario, None).map_err(|e| toml(e, file));
    };
    let beside = if embedded { None } else { path.parent() };
    let path = beside.unwrap_or(Path::new("")).join(&table);
    let text = read_text(&path).map_err(|e| unreadable(e, &file, "family.points", &table))?;
    let file = path.display().to_string();
    let units: Vec<(&str, &str)> = T::FEATURES.iter().map(|f| (f.name, f.unit)).collect();
    let kind =
        Kind { needed: &[], counts: "instances", large: &[], units: &units, check: &|_| Ok(()) };
    let family = points::read(name, &text, &file, &kind)?;
    TaskProblem::new(scenario, Some(family)).map_err(|e| toml(e, file))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cartpole::{CartPoles, Scenario};
    use evaluation::family::{Feature, PointMdp};

    type CartPoleProblem = TaskProblem<CartPoles>;

    fn problem(preset: &str) -> CartPoleProblem {
        let scenario = Scenario::read(&format!("preset = {preset:?}"), "a.toml", &[]).unwrap();
        CartPoleProblem::new(scenario, None).unwrap()
    }

    #[test]
    fn a_manifest_has_later_methods_only_where_somebody_set_them() {
        let with = |setting: &str| {
            let scenario = Scenario::read("", "a.toml", &[setting.parse().unwrap()]).unwrap();
            CartPoleProblem::new(scenario, None).unwrap().settings()
        };
        let settings = with("trpo.gamma=0.9");
        assert!((settings["trpo"]["gamma"].as_f64().unwrap() - 0.9).abs() < 1e-6);
        assert!(settings.get("ars").is_none() && settings.get("dqn").is_some());
        let read: Scenario = serde_json::from_value(with("trpo.gamma=0.99")).unwrap();
        assert_eq!(read.trpo, Scenario::default().trpo);
    }

    #[test]
    fn samples_look_at_the_mass_of_the_cart_where_it_acts() {
        let carl = problem("sb3");
        assert_eq!(carl.family().describing[0], [0.05, 0.01, 1.0, 0.1]);
        let physical = "environment.dynamics = \"physical\"";
        let scenario = Scenario::read(physical, "a.toml", &[]).unwrap();
        assert!(CartPoleProblem::new(scenario, None).unwrap().family().describing.is_empty());
    }

    #[test]
    fn what_is_prepared_is_the_context_whatever_the_point_is_called() {
        let chosen = BTreeSet::from(["l0.5-c1-p0.1-f50-g9.8"]);
        let prepared = problem("sb3").prepare(&chosen, &|_| {}).unwrap();
        let text = "length_m=0.5 masscart_kg=1 masspole_kg=0.1 force_n=50 gravity_mps2=9.8";
        let (id, made) = prepared.points.first_key_value().unwrap();
        assert_eq!((id.as_str(), made.environment.as_str()), ("l0.5-c1-p0.1-f50-g9.8", text));
        assert_eq!(prepared.points.len(), 1);
        let feature = Feature { name: "force_n".into(), unit: "N".into() };
        let own = PointMdp {
            id: "strong".into(),
            title: "strong".into(),
            features: vec![50.0],
            importance: 1.0,
            instances: 1,
        };
        let family = MdpFamily::new("own", vec![feature], vec![own], "p.csv").unwrap();
        let problem = CartPoleProblem::new(Scenario::default(), Some(family)).unwrap();
        let same = problem.prepare(&BTreeSet::from(["strong"]), &|_| {}).unwrap();
        assert_eq!(same.points["strong"], *made);
    }
}

#[cfg(test)]
mod loading {
    use std::fs;

    use super::*;
    use crate::cartpole::CartPoles;
    use evaluation::run::domain::Problem;

    #[test]
    fn a_file_names_a_table_of_some_features() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("heavy.toml");
        let name = path.display().to_string();
        fs::write(&path, "domain = \"cartpole\"\nfamily.points = \"p.csv\"").unwrap();
        let e = load::<CartPoles>(&name, &[]).err().unwrap().to_string();
        assert!(e.contains("heavy.toml: family.points = \"p.csv\": cannot read"), "{e}");
        fs::write(dir.path().join("p.csv"), "point;instances;masspole_kg\na;3;0,2\nb;1;0,7\n")
            .unwrap();
        let problem = load::<CartPoles>(&name, &[]).unwrap();
        let family = problem.family();
        assert_eq!((family.name.as_str(), family.importance()), ("heavy", vec![0.75, 0.25]));
        assert_eq!(
            (family.features[0].name.as_str(), family.features[0].unit.as_str()),
            ("masspole_kg", "kg")
        );
        fs::write(dir.path().join("p.csv"), "importance,wind_mps\n1,3\n").unwrap();
        let e = load::<CartPoles>(&name, &[]).err().unwrap().to_string();
        assert!(
            e.contains("p.csv: a cart and pole has no feature \"wind_mps\", only length_m"),
            "{e}"
        );
    }
}
