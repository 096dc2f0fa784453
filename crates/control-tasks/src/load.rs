//! Reads scenarios of control tasks: those that the program carries, and files that say which task they are of.

use std::marker::PhantomData;
use std::path::Path;

use crate::domain::TaskDomain;
use crate::problem::TaskProblem;
use crate::task::Task;
use crate::task::scenario::{Preset, Settings};
use evaluation::family::points::{self, Kind};
use evaluation::family::{FamilyError, MdpFamily};
use evaluation::run::entry::Entry;
use evaluation::settings::named::Named;
use evaluation::settings::overrides::Override;
use evaluation::settings::setting::{self, Setting};
use evaluation::settings::source::{file_of, read_scenario, read_text, unreadable};

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

/// Returns what a setting is.
fn setting_of<T: Task>(name: &str) -> Option<&'static Setting> {
    setting::find(&T::Scenario::default().sections(), name)
}

/// Loads a scenario by path or name, with some settings replaced.
///
/// # Errors
///
/// [`FamilyError`] when a setting does not exist or is out of range, or the table has other features than the task.
pub fn load<T: Task>(
    scenario: &str,
    overrides: &[Override],
) -> Result<TaskProblem<T>, FamilyError> {
    let embedded = scenario == T::NAME;
    let path = file_of(scenario);
    let (text, file) = match embedded {
        true => (T::EMBEDDED.to_owned(), format!("{}.toml (embedded)", T::NAME)),
        false => (read_scenario(&path)?, path.display().to_string()),
    };
    let scenario = T::Scenario::read(&text, &file, overrides)?;
    let Some(table) = scenario.family().points.clone() else {
        return problem(scenario, None, file);
    };
    let beside = if embedded { None } else { path.parent() };
    let path = beside.unwrap_or(Path::new("")).join(&table);
    let text = read_text(&path).map_err(|e| unreadable(e, &file, "family.points", &table))?;
    let file = path.display().to_string();
    let units: Vec<(&str, &str)> = T::FEATURES.iter().map(|f| (f.name, f.unit)).collect();
    let kind =
        Kind { needed: &[], counts: "instances", large: &[], units: &units, check: &|_| Ok(()) };
    let family = points::read(scenario.name(), &text, &file, &kind)?;
    problem(scenario, Some(family), file)
}

/// Returns the problem of a family, which stands in a file.
fn problem<T: Task>(
    scenario: T::Scenario,
    family: Option<MdpFamily>,
    file: String,
) -> Result<TaskProblem<T>, FamilyError> {
    let problem = TaskProblem::new(scenario, family);
    problem.map_err(|e| FamilyError::Toml { file, message: e.to_string() })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::cartpole::{CartPoles, NAME};
    use evaluation::run::domain::Problem;

    #[test]
    fn the_carried_scenario_is_the_family_of_576() {
        let problem = load::<CartPoles>(NAME, &["ppo.gamma=0.9".parse().unwrap()]).unwrap();
        assert_eq!((problem.family().points.len(), problem.family().name.as_str()), (576, NAME));
        assert!((problem.settings()["ppo"]["gamma"].as_f64().unwrap() - 0.9).abs() < 1e-6);
    }

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

    #[test]
    fn every_setting_is_said_what_it_is() {
        assert_eq!(setting_of::<CartPoles>("ppo.gamma").map(|s| s.name), Some("gamma"));
        for name in (TaskDomain::<CartPoles>::ENTRY.names)()
            .iter()
            .filter(|n| n.contains('.') && *n != "family.points")
        {
            assert!(setting_of::<CartPoles>(name).is_some(), "{name}");
        }
    }
}
