//! From a city's map to its family: approaches, scenario, networks and what to think of them.
//!
//! [`derive`](derive::derive) does all of it. What is on the ground comes from the crate [`osm_signals`];
//! [`sites`] leaves out the intersections that no network can be built for,
//! [`quality`] and [`surroundings`] what the page on quality shows.

pub mod config;
pub mod counted;
pub mod derive;
pub mod quality;
pub mod sites;
pub mod surroundings;

use std::path::{Path, PathBuf};

use osm_signals::OsmError;
use serde::Serialize;
use toml::{Table, Value};

use crate::family::load::LoadedScenario;
use crate::network::error::NetworkError;
use crate::settings::Preset;
use crate::turning::Period;
use basics::files::{self, FileError, limits};
use basics::hash::sha256_file;
use evaluation::family::error::FamilyError;

/// Name of the scenario file within a city's folder.
const SCENARIO_FILE: &str = "scenario.toml";

/// Name of the table of approaches within a city's folder.
pub const APPROACHES_FILE: &str = "approaches.csv";

/// Name of the table of existing plans within a city's folder.
const EXISTING_FILE: &str = "existing.csv";

/// Name of the file that says what a scenario's folder without a map was made from.
const SOURCES_FILE: &str = "sources.json";

/// Why no city can be derived from what was given.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CityError {
    /// The extract, or a file that says more of its city, cannot be used.
    #[error(transparent)]
    Input(#[from] OsmError),
    /// A file does not fit: settings, a place elsewhere, a table that was edited.
    #[error("{}: {reason}", .path.display())]
    Unfit {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and the way out.
        reason: String,
    },
    /// The family that was derived is unusable.
    #[error(transparent)]
    Family(#[from] FamilyError),
    /// A network cannot be built.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] FileError),
}

impl CityError {
    fn unfit(path: &Path, reason: impl Into<String>) -> Self {
        Self::Unfit { path: path.to_path_buf(), reason: reason.into() }
    }
}

/// A file that went in.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct InputFile {
    /// What it is: `extract`, `signals`, `aadt`, `boundary`, `config`.
    pub role: &'static str,
    /// Its name, without its folder.
    pub name: String,
    /// Hash of its bytes.
    pub sha256: String,
}

impl InputFile {
    fn read(role: &'static str, path: &Path) -> Result<Self, FileError> {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { role, name, sha256: sha256_file(path)? })
    }
}

/// Returns the name of the folder of a city's networks, beside its scenario; with another preset than the
/// default one of its own, because the default programs differ.
pub fn networks_folder(preset: Preset) -> String {
    of_preset("networks", preset)
}

fn of_preset(name: &str, preset: Preset) -> String {
    match preset == Preset::default() {
        true => name.to_owned(),
        false => format!("{name}-{}", preset.name()),
    }
}

/// Returns where a scenario's networks are: `FOLDER/networks` of one that is given as a folder or as
/// the `scenario.toml` within it, as `--osm` writes it, else `networks/NAME`; with another preset than
/// the default in a folder of its own beside it, because the default programs differ.
pub fn default_folder(scenario: &str, loaded: &LoadedScenario) -> PathBuf {
    let preset = loaded.scenario.preset;
    let path = Path::new(scenario);
    if path.is_dir() {
        return path.join(networks_folder(preset));
    }
    match (path.file_name(), path.parent()) {
        (Some(name), Some(folder)) if name == SCENARIO_FILE => folder.join(networks_folder(preset)),
        _ => Path::new("networks").join(of_preset(&loaded.scenario.name, preset)),
    }
}

/// Refuses to overwrite tables in a folder that were not derived, or that were edited since.
fn check(out: &Path) -> Result<(), CityError> {
    let known = ["quality.json", SOURCES_FILE].map(|name| -> serde_json::Value {
        let bytes = files::read(&out.join(name), limits::DOCUMENT).unwrap_or_default();
        serde_json::from_slice(&bytes).unwrap_or_default()
    });
    for name in [APPROACHES_FILE, SCENARIO_FILE, EXISTING_FILE] {
        let path = out.join(name);
        let known = known.each_ref().map(|file| file["written"][name].clone());
        if path.exists() && !known.contains(&sha256_file(&path)?.into()) {
            let reason =
                "not as this command wrote it; give another --out, or --force to replace it";
            return Err(CityError::unfit(&path, reason));
        }
    }
    Ok(())
}

/// Returns the name of an extract without its endings.
fn stem(extract: &Path) -> String {
    let name = extract.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let endings = [".osm.pbf", ".osm.gz", ".pbf", ".osm", ".xml"];
    let stem = endings.iter().find_map(|ending| name.strip_suffix(ending)).unwrap_or(&name);
    named(stem, |c| !c.is_control())
}

/// Returns the name of the scenario in a folder.
fn scenario_name(out: &Path) -> String {
    let name = out.file_name().unwrap_or_default().to_string_lossy();
    named(&name, |c| c.is_ascii_alphanumeric() || "-_".contains(c))
}

fn named(name: &str, is_kept: fn(char) -> bool) -> String {
    let name: String = name.chars().map(|c| if is_kept(c) { c } else { '-' }).collect();
    if name.is_empty() { "city".to_owned() } else { name }
}

/// Returns the hours per year of periods, as the setting `family.periods` has them; `None` where they are not given.
fn hours(periods: &[Period]) -> Option<Value> {
    let hours = periods.iter().map(|p| Some((p.name.clone(), Value::Float(p.hours?))));
    let hours: Option<Table> = hours.collect();
    hours.filter(|hours| !hours.is_empty()).map(Value::Table)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_city_is_called_after_its_folder() {
        assert_eq!(scenario_name(Path::new("networks/Salt Lake.City")), "Salt-Lake-City");
        assert_eq!(scenario_name(Path::new("..")), "city");
        assert_eq!(stem(Path::new("a/utah-latest.osm.pbf")), "utah-latest");
        assert_eq!(stem(Path::new("city.north.osm")), "city.north");
        assert_eq!(stem(Path::new("a\nb.osm")), "a-b");
    }
}
