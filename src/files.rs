//! Files that are either as before or complete.

use std::fs::Permissions;
use std::io::Write;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;

use crate::error::FileError;

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
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut draft = tempfile::Builder::new()
        .permissions(readable())
        .tempfile_in(folder)
        .map_err(FileError::at("create", folder))?;
    draft
        .write_all(bytes)
        .and_then(|()| draft.as_file().sync_all())
        .map_err(FileError::at("write", path))?;
    draft.persist(path).map_err(|e| FileError::at("write", path)(e.error))?;
    Ok(())
}
