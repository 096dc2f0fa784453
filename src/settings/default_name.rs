//! The name of a scenario whose file gives none.

use std::path::{Path, PathBuf};

/// Returns the name of a scenario that says none: that of its file, of a `scenario.toml` that of its
/// folder, with hyphens for what names may not have.
pub fn name_of(file: &str) -> String {
    let path = std::path::absolute(file).unwrap_or_else(|_| PathBuf::from(file));
    let folder = path.parent().and_then(Path::file_name);
    let named = match path.file_stem() {
        Some(stem) if stem == "scenario" => folder.or(Some(stem)),
        stem => stem,
    };
    let named = named.unwrap_or_default().to_string_lossy();
    named.chars().map(|c| if c.is_ascii_alphanumeric() || c == '_' { c } else { '-' }).collect()
}

/// Checks the name of a scenario, which folders are called by.
///
/// # Errors
///
/// What is expected.
pub fn check(name: &str) -> Result<(), &'static str> {
    let safe = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
    match !name.is_empty() && name.chars().all(safe) {
        true => Ok(()),
        false => Err("expected letters, digits, `-` and `_`"),
    }
}

#[cfg(test)]
mod tests {
    use crate::traffic::family::load::from_text;

    #[test]
    fn a_scenario_without_a_name_has_its_file_s_or_its_folder_s() {
        let table = "point,intersections,lanes,speed_mph,length_m,inflow_vph,left_turn_lanes,\
            right_turn_lanes\na,1,2,25,200,250,0,0\n";
        let name = |text: &str, file| {
            let loaded = from_text(text, file, &[], &|_| Ok(table.to_owned()));
            loaded.map(|l| l.scenario.name).map_err(|e| e.to_string())
        };
        let text = "[family]\npoints = \"points.csv\"\n";
        assert_eq!(name(text, "towns/my-town.toml").unwrap(), "my-town");
        assert_eq!(name(text, "towns/St. Paul.toml").unwrap(), "St--Paul");
        assert_eq!(name(text, "towns/mine/scenario.toml").unwrap(), "mine");
        let text = format!("preset = \"field\"\n{text}");
        assert_eq!(name(&text, "my-town.toml").unwrap(), "my-town");
        assert!(name(&format!("name = \"\"\n{text}"), "a.toml").unwrap_err().contains("name"));
    }
}
