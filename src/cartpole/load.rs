//! Finds scenarios of carts and poles: the one that the program carries, and files that say so.

use std::path::Path;

use serde::Deserialize;

use super::family::{FEATURES, NAME};
use super::problem::CartPoleProblem;
use super::settings::Scenario;
use crate::family::FamilyError;
use crate::family::points::{self, Kind};
use crate::files::FileError;
use crate::settings::overrides::Override;

/// The scenario that the program carries.
const EMBEDDED: &str = include_str!("../../scenarios/cartpole.toml");

/// What says which domain reads a file.
#[derive(Deserialize)]
struct Named {
    domain: Option<String>,
}

/// Whether a scenario, by path or name, is one of carts and poles.
pub fn is_of_poles(name: &str) -> bool {
    let named = |text: String| toml::from_str::<Named>(&text).is_ok_and(|n| n.domain.is_some());
    name == NAME || std::fs::read_to_string(name).is_ok_and(named)
}

/// Loads a scenario by path or name, with some settings replaced.
///
/// # Errors
///
/// [`FamilyError`] when a setting does not exist or is out of range, or the table has other features than a cart
/// and pole.
pub fn load(name: &str, overrides: &[Override]) -> Result<CartPoleProblem, FamilyError> {
    let path = Path::new(name);
    let read = |path: &Path| -> Result<String, FamilyError> {
        Ok(std::fs::read_to_string(path).map_err(FileError::at("read", path))?)
    };
    let (text, file) = match name == NAME {
        true => (EMBEDDED.to_owned(), format!("{name}.toml (embedded)")),
        false => (read(path)?, name.to_owned()),
    };
    let scenario = Scenario::read(&text, &file, overrides)?;
    let mut own = None;
    if let Some(table) = &scenario.family.points {
        let path = match name == NAME {
            true => Path::new(table).to_path_buf(),
            false => path.parent().unwrap_or(Path::new("")).join(table),
        };
        let kind = Kind { needed: &[], counts: "instances", units: &FEATURES, check: &|_| Ok(()) };
        let table = path.display().to_string();
        own = Some((points::read(&scenario.name, &read(&path)?, &table, &kind)?, table));
    }
    let table = own.as_ref().map_or(file, |(_, table)| table.clone());
    CartPoleProblem::new(scenario, own.map(|(family, _)| family))
        .map_err(|e| FamilyError::Toml { file: table, message: e.to_string() })
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::run::domain::Problem;

    #[test]
    fn the_carried_scenario_is_the_family_of_576() {
        let problem = load(NAME, &["ppo.gamma=0.9".parse().unwrap()]).unwrap();
        assert_eq!((problem.family().points.len(), problem.family().name.as_str()), (576, NAME));
        assert!((problem.settings()["ppo"]["gamma"].as_f64().unwrap() - 0.9).abs() < 1e-6);
        assert!(is_of_poles(NAME) && !is_of_poles("smoke"));
    }

    #[test]
    fn a_file_names_a_table_of_some_features() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("poles.toml");
        let name = path.display().to_string();
        fs::write(&path, "domain = \"cartpole\"\nname = \"heavy\"\nfamily.points = \"p.csv\"")
            .unwrap();
        fs::write(dir.path().join("p.csv"), "point,instances,masspole_kg\na,3,0.2\nb,1,0.7\n")
            .unwrap();
        assert!(is_of_poles(&name));
        let problem = load(&name, &[]).unwrap();
        let family = problem.family();
        assert_eq!((family.name.as_str(), family.importance()), ("heavy", vec![0.75, 0.25]));
        assert_eq!(
            (family.features[0].name.as_str(), family.features[0].unit.as_str()),
            ("masspole_kg", "kg")
        );
        fs::write(dir.path().join("p.csv"), "importance,wind_mps\n1,3\n").unwrap();
        let e = load(&name, &[]).unwrap_err().to_string();
        assert!(
            e.contains("p.csv: a cart and pole has no feature \"wind_mps\", only length_m"),
            "{e}"
        );
        fs::write(&path, "domain = \"swimmer\"").unwrap();
        let e = load(&name, &[]).unwrap_err().to_string();
        assert!(e.contains("domain") && e.contains("expected \"cartpole\""), "{e}");
    }
}
