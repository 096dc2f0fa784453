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
