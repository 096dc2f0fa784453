//! Files that are either as before or complete.

use std::fs::{self, Permissions};
use std::io::{self, Write};
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};

/// A file operation that failed, with the file's name.
#[derive(Debug, thiserror::Error)]
#[error("cannot {action} {}: {reason}", .path.display())]
pub struct FileError {
    /// What was tried: `read`, `write`, `create`, ...
    pub action: &'static str,
    /// The file or directory.
    pub path: PathBuf,
    /// The operating system's reason; part of the message, so it is no source of its own.
    pub reason: io::Error,
}

impl FileError {
    /// Returns a closure for `map_err` that adds the action and the path.
    pub fn at(action: &'static str, path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_path_buf();
        move |reason| Self { action, path, reason }
    }
}

/// Returns the permissions of files that others may read, less the user's umask; drafts would be
/// private otherwise, which is of no use on a shared disk.
pub fn readable() -> Permissions {
    Permissions::from_mode(0o666)
}

/// Writes a file so that it is either as before or complete: a draft beside it, synced and renamed.
///
/// # Errors
///
/// [`FileError`] when the folder cannot be written; nothing is left behind.
pub fn write_atomically(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    write_by_way_of(path.parent().unwrap_or(Path::new(".")), path, bytes)
}

/// Writes a file so that it is either as before or complete, with the draft in another folder of
/// the same file system, where one that a killed process leaves is no trouble. Both folders are
/// made where they are missing.
///
/// # Errors
///
/// [`FileError`] when a folder cannot be written; nothing is left behind.
pub fn replace(path: &Path, drafts: &Path, bytes: &[u8]) -> Result<(), FileError> {
    for folder in path.parent().into_iter().chain([drafts]) {
        fs::create_dir_all(folder).map_err(FileError::at("create", folder))?;
    }
    write_by_way_of(drafts, path, bytes)
}

fn write_by_way_of(drafts: &Path, path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let mut draft = tempfile::Builder::new()
        .permissions(readable())
        .tempfile_in(drafts)
        .map_err(FileError::at("create", drafts))?;
    draft
        .write_all(bytes)
        .and_then(|()| draft.as_file().sync_all())
        .map_err(FileError::at("write", path))?;
    draft.persist(path).map_err(|e| FileError::at("write", path)(e.error))?;
    Ok(())
}
