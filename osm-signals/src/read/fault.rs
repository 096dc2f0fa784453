//! Why a part of a PBF file cannot be used, before its place is known.

use std::path::Path;

use crate::OsmError;

/// An unusable part of a file, without its place.
#[derive(Debug)]
pub(super) struct Fault(String);

impl Fault {
    /// Returns the error at a byte of a file.
    pub(super) fn at(self, path: &Path, byte: u64) -> OsmError {
        OsmError::Damaged { path: path.to_path_buf(), byte, reason: self.0 }
    }
}

impl<T: Into<String>> From<T> for Fault {
    fn from(reason: T) -> Self {
        Self(reason.into())
    }
}
