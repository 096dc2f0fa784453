//! Reads scenarios of carts and poles: the one that the program carries, and files that say so.

use std::path::Path;

use super::domain::CartPoles;
use super::family::{FEATURES, NAME};
use super::problem::CartPoleProblem;
use super::settings::{Preset, Scenario};
use evaluation::family::FamilyError;
use evaluation::family::points::{self, Kind};
use evaluation::run::entry::Entry;
use evaluation::settings::named::Named;
use evaluation::settings::overrides::Override;
use evaluation::settings::setting::{self, Setting};
use evaluation::settings::source::{file_of, read_scenario, read_text, unreadable};

/// The scenario that the program carries.
const EMBEDDED: &str = include_str!("../../../../scenarios/cartpole.toml");

/// What the command line reads scenarios of carts and poles by.
pub const ENTRY: Entry = Entry {
    domain: &CartPoles,
    scenarios: &[NAME],
    presets: &Preset::NAMES,
    names: Scenario::names,
    setting,
    load: |scenario, overrides| Ok(Box::new(load(scenario, overrides)?)),
};

/// Returns what a setting is.
fn setting(name: &str) -> Option<&'static Setting> {
    setting::find(&Scenario::default().sections(), name)
}

/// Loads a scenario by path or name, with some settings replaced.
///
/// # Errors
///
/// [`FamilyError`] when a setting does not exist or is out of range, or the table has other features than a cart
/// and pole.
pub fn load(scenario: &str, overrides: &[Override]) -> Result<CartPoleProblem, FamilyError> {
    let embedded = scenario == NAME;
    let path = file_of(scenario);
    let (text, file) = match embedded {
        true => (EMBEDDED.to_owned(), format!("{NAME}.toml (embedded)")),
        false => (read_scenario(&path)?, path.display().to_string()),
    };
    let scenario = Scenario::read(&text, &file, overrides)?;
    let Some(table) = scenario.family.points.clone() else {
        return problem(scenario, None, file);
    };
    let beside = if embedded { None } else { path.parent() };
    let path = beside.unwrap_or(Path::new("")).join(&table);
    let text = read_text(&path).map_err(|e| unreadable(e, &file, "family.points", &table))?;
    let file = path.display().to_string();
    let kind =
        Kind { needed: &[], counts: "instances", large: &[], units: &FEATURES, check: &|_| Ok(()) };
    let family = points::read(&scenario.name, &text, &file, &kind)?;
    problem(scenario, Some(family), file)
}

/// Returns the problem of a family, which stands in a file.
fn problem(
    scenario: Scenario,
    family: Option<evaluation::family::MdpFamily>,
    file: String,
) -> Result<CartPoleProblem, FamilyError> {
    let problem = CartPoleProblem::new(scenario, family);
    problem.map_err(|e| FamilyError::Toml { file, message: e.to_string() })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use evaluation::run::domain::Problem;

    #[test]
    fn the_carried_scenario_is_the_family_of_576() {
        let problem = load(NAME, &["ppo.gamma=0.9".parse().unwrap()]).unwrap();
        assert_eq!((problem.family().points.len(), problem.family().name.as_str()), (576, NAME));
        assert!((problem.settings()["ppo"]["gamma"].as_f64().unwrap() - 0.9).abs() < 1e-6);
    }

    #[test]
    fn a_file_names_a_table_of_some_features() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("heavy.toml");
        let name = path.display().to_string();
        fs::write(&path, "domain = \"cartpole\"\nfamily.points = \"p.csv\"").unwrap();
        let e = load(&name, &[]).err().unwrap().to_string();
        assert!(e.contains("heavy.toml: family.points = \"p.csv\": cannot read"), "{e}");
        fs::write(dir.path().join("p.csv"), "point;instances;masspole_kg\na;3;0,2\nb;1;0,7\n")
            .unwrap();
        let problem = load(&name, &[]).unwrap();
        let family = problem.family();
        assert_eq!((family.name.as_str(), family.importance()), ("heavy", vec![0.75, 0.25]));
        assert_eq!(
            (family.features[0].name.as_str(), family.features[0].unit.as_str()),
            ("masspole_kg", "kg")
        );
        fs::write(dir.path().join("p.csv"), "importance,wind_mps\n1,3\n").unwrap();
        let e = load(&name, &[]).err().unwrap().to_string();
        assert!(
            e.contains("p.csv: a cart and pole has no feature \"wind_mps\", only length_m"),
            "{e}"
        );
    }

    #[test]
    fn every_setting_is_said_what_it_is() {
        assert_eq!(setting("ppo.gamma").map(|s| s.name), Some("gamma"));
        for name in (ENTRY.names)().iter().filter(|n| n.contains('.') && *n != "family.points") {
            assert!(setting(name).is_some(), "{name}");
        }
    }
}
