//! Files that are read: regular ones only.

use std::path::Path;

use super::error::OsmError;

/// Returns the bytes of a regular file.
pub fn bytes(path: &Path) -> Result<Vec<u8>, OsmError> {
    sheet::file::read(path, sheet::file::TABLE_BYTES).map_err(OsmError::unreadable(path))
}
