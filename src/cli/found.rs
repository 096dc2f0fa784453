//! Results directories below folders.

use std::fs;
use std::path::{Path, PathBuf};

use crate::cli::refused::Refused;
use crate::files::FileError;
use crate::store::Layout;

/// How deep results directories may lie below a folder that is given: family, then run.
const DEPTH: usize = 2;

/// Returns the results directories that folders are or have in them, those of a folder in the order of their names.
///
/// # Errors
///
/// [`Refused`] for a folder without any.
pub(super) fn found(dirs: &[PathBuf]) -> anyhow::Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for dir in dirs {
        let before = found.len();
        find(dir, DEPTH, &mut found)?;
        if found.len() == before {
            let dir = dir.display();
            return Err(Refused(format!(
                "{dir} is no results directory, and has none in it; give a folder that `run --out` wrote"
            ))
            .into());
        }
    }
    Ok(found)
}

/// Returns whether a folder is a results directory itself.
pub(super) fn is_run(dir: &Path) -> bool {
    let layout = Layout::new(dir);
    let files = [layout.manifest(), layout.adding(), layout.packed()];
    files.iter().any(|path| path.exists())
}

fn find(dir: &Path, depth: usize, found: &mut Vec<PathBuf>) -> anyhow::Result<()> {
    if is_run(dir) {
        found.push(dir.to_path_buf());
        return Ok(());
    }
    if depth == 0 || !dir.is_dir() {
        return Ok(());
    }
    let entries = fs::read_dir(dir).map_err(FileError::at("read", dir))?;
    let folders = entries.flatten().map(|entry| entry.path()).filter(|path| path.is_dir());
    let mut folders: Vec<PathBuf> = folders.collect();
    folders.sort();
    folders.iter().try_for_each(|folder| find(folder, depth - 1, found))
}
