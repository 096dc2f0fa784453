//! Finds the programs of SUMO and their versions.

use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use super::subprocess::{last_lines, output_of};

/// Longest time in which a program says its version; that takes a hundredth of a second.
const VERSION_LIMIT: Duration = Duration::from_secs(20);

/// Finds a program of SUMO in `SUMO_HOME/bin`, then on `PATH`, and returns its path and version, such as `1.15.0`.
/// The error is the places looked at.
pub fn find(name: &str) -> Result<(PathBuf, String), String> {
    find_in(name, env::var_os("SUMO_HOME").map(PathBuf::from), env::var_os("PATH"))
}

/// Returns the version at the end of what SUMO says of itself, such as `1.15.0` for `SUMO v1_15_0`.
pub fn version_in(said: &str) -> Option<String> {
    let version = said.split_whitespace().last()?;
    Some(version.trim_start_matches(['v', 'V']).replace('_', "."))
}

pub(super) fn find_in(
    name: &str,
    sumo_home: Option<PathBuf>,
    path: Option<OsString>,
) -> Result<(PathBuf, String), String> {
    let file = format!("{name}{}", env::consts::EXE_SUFFIX);
    let home = sumo_home.filter(|home| !home.as_os_str().is_empty());
    let mut tried = match &home {
        Some(home) => home.join("bin").join(&file).display().to_string(),
        None => "SUMO_HOME is not set".to_owned(),
    };
    tried.push_str(", PATH");
    let in_home = home.map(|home| home.join("bin"));
    let on_path = path.iter().flat_map(env::split_paths);
    for candidate in in_home.into_iter().chain(on_path).map(|folder| folder.join(&file)) {
        if candidate.is_file() {
            match version(name, &candidate) {
                Ok(version) => return Ok((candidate, version)),
                Err(reason) => tried = format!("{tried}; {}: {reason}", candidate.display()),
            }
        }
    }
    Err(tried)
}

/// Returns the version that a program prints.
fn version(name: &str, path: &Path) -> Result<String, String> {
    let mut command = Command::new(path);
    command.arg("--version");
    let output = output_of(command, VERSION_LIMIT).map_err(|e| e.to_string())?;
    let (_, text, said) = output.ok_or("does not end")?;
    text.lines()
        .find(|line| line.starts_with(&format!("Eclipse SUMO {name}")))
        .and_then(version_in)
        .ok_or_else(|| format!("does not run: {}", last_lines(&said)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_that_is_no_program_is_passed_over_with_its_reason() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("netconvert"), "").unwrap();
        let e = find_in("netconvert", None, Some(folder.path().into())).unwrap_err();
        assert!(e.starts_with("SUMO_HOME is not set, PATH; "), "{e}");
    }

    #[test]
    fn versions_are_the_same_however_they_are_written() {
        for said in ["Eclipse SUMO netconvert Version 1.15.0", "SUMO 1.15.0", "SUMO v1_15_0"] {
            assert_eq!(version_in(said).as_deref(), Some("1.15.0"), "{said}");
        }
        assert_eq!(version_in(""), None);
    }
}
