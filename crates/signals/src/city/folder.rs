//! The folder of a city: what its files are called, and whether they may be replaced; where networks are.

use std::path::{Path, PathBuf};

use super::error::CityError;
use super::quality::InputFile;
use crate::family::load::LoadedScenario;
use crate::settings::Preset;
use basics::files::{self, FileError, limits, write_atomically};
use basics::hash::{sha256, sha256_file};

/// Name of the scenario file within a city's folder.
pub const SCENARIO_FILE: &str = "scenario.toml";

/// Name of the table of approaches within a city's folder.
pub const APPROACHES_FILE: &str = "approaches.csv";

/// Name of the table of existing plans within a city's folder.
pub const EXISTING_FILE: &str = "existing.csv";

/// Name of the table of point MDPs within a city's folder.
pub const FAMILY_FILE: &str = "family.csv";

/// Name of the table of the rows of a signal list within a city's folder.
pub const MATCHES_FILE: &str = "signal-list.csv";

/// Name of the file with all figures on the quality of a city.
pub const QUALITY_FILE: &str = "quality.json";

/// Returns the name of the folder of a city's networks, beside its scenario; with another preset than the
/// default one of its own, because the default programs differ.
pub fn networks_folder(preset: Preset) -> String {
    of_preset("networks", preset)
}

/// Returns a name, with that of a preset behind it unless it is the default.
pub fn of_preset(name: &str, preset: Preset) -> String {
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

/// Name of the file that says what a scenario's folder without a map was made from.
pub const SOURCES_FILE: &str = "sources.json";

/// Writes what a folder was made from, and the hashes of what was written.
pub(super) fn write_sources(
    out: &Path,
    inputs: &[InputFile],
    written: &[(&str, &String)],
) -> Result<(), FileError> {
    let hashes: serde_json::Map<String, serde_json::Value> = written
        .iter()
        .map(|(name, text)| ((*name).to_owned(), sha256(text.as_bytes()).into()))
        .collect();
    let text = serde_json::json!({ "files": inputs, "written": hashes });
    let text = serde_json::to_string_pretty(&text).expect("hashes are plain data") + "\n";
    write_atomically(&out.join(SOURCES_FILE), text.as_bytes())
}

/// Refuses to overwrite tables in a folder that were not derived, or that were edited since.
pub(super) fn check(out: &Path) -> Result<(), CityError> {
    let read = |name: &str| -> serde_json::Value {
        let bytes = files::read(&out.join(name), limits::DOCUMENT).unwrap_or_default();
        serde_json::from_slice(&bytes).unwrap_or_default()
    };
    let (quality, sources) = (read(QUALITY_FILE), read(SOURCES_FILE));
    for name in [APPROACHES_FILE, SCENARIO_FILE, EXISTING_FILE] {
        let path = out.join(name);
        let known = [&quality, &sources].map(|file| file["written"][name].clone());
        if path.exists() && !known.contains(&sha256_file(&path)?.into()) {
            return Err(CityError::Edited { path });
        }
    }
    Ok(())
}

/// Returns the name of an extract without its endings.
pub(super) fn stem(extract: &Path) -> String {
    let name = extract.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let endings = [".osm.pbf", ".osm.gz", ".pbf", ".osm", ".xml"];
    let stem = endings.iter().find_map(|ending| name.strip_suffix(ending)).unwrap_or(&name);
    let stem: String = stem.chars().map(|c| if c.is_control() { '-' } else { c }).collect();
    if stem.is_empty() { "city".to_owned() } else { stem }
}

/// Returns the name of the scenario in a folder.
pub(super) fn scenario_name(out: &Path) -> String {
    let name = out.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let safe = |c: char| if c.is_ascii_alphanumeric() || "-_".contains(c) { c } else { '-' };
    let name: String = name.chars().map(safe).collect();
    if name.is_empty() { "city".to_owned() } else { name }
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
