//! Files that are read: regular ones only.

use std::fs::{self, Metadata};
use std::io::{Error, ErrorKind};
use std::path::Path;

use super::error::OsmError;

/// Returns the bytes of a regular file.
///
/// # Errors
///
/// [`OsmError::Unreadable`] with its name.
pub fn bytes(path: &Path) -> Result<Vec<u8>, OsmError> {
    regular(path)?;
    fs::read(path).map_err(OsmError::unreadable(path))
}

/// Returns what is known of a regular file. Others are refused before they are opened: a pipe
/// without a writer would block, and what a pipe holds can be read only once.
///
/// # Errors
///
/// [`OsmError::Unreadable`] with its name and the way out.
pub(crate) fn regular(path: &Path) -> Result<Metadata, OsmError> {
    let about = fs::metadata(path).map_err(OsmError::unreadable(path))?;
    let refused = |kind, reason| Err(OsmError::unreadable(path)(Error::new(kind, reason)));
    if about.is_dir() {
        return refused(ErrorKind::IsADirectory, "it is a folder; give a regular file");
    }
    if !about.is_file() {
        return refused(ErrorKind::InvalidInput, "it is a pipe or device; give a regular file");
    }
    Ok(about)
}
