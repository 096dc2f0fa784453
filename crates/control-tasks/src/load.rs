//! Reads scenarios of control tasks: those that the program carries, and files that say which task they are of.

use std::marker::PhantomData;
use std::path::Path;

use crate::context::ContextError;
use crate::domain::TaskDomain;
use crate::problem::TaskProblem;
use crate::task::Task;
use crate::task::scenario::{FamilySettings, Preset, Settings};
use evaluation::family::FamilyError;
use evaluation::family::points::{self, Kind};
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
