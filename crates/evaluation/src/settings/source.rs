//! Files of scenarios and of the tables that they name.

use std::path::{Path, PathBuf};

use toml::Table;

use crate::family::columns::at;
use crate::family::error::FamilyError;
use basics::files::{self, limits};

/// Returns the file of a scenario: of a folder, the `scenario.toml` in it.
pub fn file_of(scenario: &str) -> PathBuf {
    let path = Path::new(scenario);
    if path.is_dir() { path.join("scenario.toml") } else { path.to_path_buf() }
}

/// Returns the text of a table, whatever its encoding.
pub fn read_text(path: &Path) -> Result<String, FamilyError> {
    read(path, limits::TABLE)
}

/// Returns the text of the file of a scenario, whatever its encoding.
pub fn read_scenario(path: &Path) -> Result<String, FamilyError> {
    read(path, limits::SCENARIO)
}

fn read(path: &Path, most: u64) -> Result<String, FamilyError> {
    let bytes = files::read(path, most)?;
    let text = sheet::decode(&bytes).map_err(|fault| at(&path.display().to_string(), fault))?;
    Ok(text.into_owned())
}

/// Returns the domain that the text of a scenario names, if it names one.
pub fn domain_of(text: &str) -> Option<String> {
    let settings: Table = text.parse().ok()?;
    settings.get("domain")?.as_str().map(str::to_owned)
}

/// Says which field of a scenario names a table that cannot be read.
///
/// # Arguments
///
/// * `path` — the table, as the scenario has it.
pub fn unreadable(error: FamilyError, file: &str, field: &str, path: &str) -> FamilyError {
    match error {
        FamilyError::Io(e) => {
            let way_out = "the path is relative to the scenario file, of an embedded scenario to the current folder";
            FamilyError::setting(file, field, format!("{path:?}"), format!("{e}; {way_out}"))
        }
        other => other,
    }
}
