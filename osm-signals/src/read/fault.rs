//! Why a part of a file cannot be used, before its place is known.

use std::path::Path;

use crate::OsmError;
use crate::extract::Extract;

/// An unusable part of a file, without its place.
#[derive(Debug)]
pub(super) enum Fault {
    /// It is damaged.
    Damaged(String),
    /// It is something that this reader does not have; the text says what to do.
    Unsupported(String),
}

impl Fault {
    /// Returns the error at a byte of a file.
    pub(super) fn at(self, path: &Path, byte: u64) -> OsmError {
        let path = path.to_path_buf();
        match self {
            Self::Damaged(reason) => OsmError::Damaged { path, byte, reason },
            Self::Unsupported(reason) => {
                OsmError::Malformed { path, place: format!("byte {byte}"), reason }
            }
        }
    }
}

impl From<&str> for Fault {
    fn from(reason: &str) -> Self {
        Self::Damaged(reason.to_owned())
    }
}

impl From<protobuf::Error> for Fault {
    fn from(error: protobuf::Error) -> Self {
        Self::Damaged(format!("the data is garbled ({error})"))
    }
}

/// Returns the error for an extract without streets.
pub(super) fn no_streets(path: &Path) -> OsmError {
    let reason = "no drivable street in it; take an extract with the ways tagged `highway` and \
                  their nodes"
        .to_owned();
    OsmError::Nothing { path: path.to_path_buf(), reason }
}

/// Returns an extract if some node of its streets has a place.
pub(super) fn placed(path: &Path, extract: Extract) -> Result<Extract, OsmError> {
    if extract.nodes.have_places() {
        return Ok(extract);
    }
    let reason = "holds streets and no node of them, so that nothing has a place, as Overpass writes with `out geom` or \
                  without `>`; end the query with `(._; >;); out body;`";
    Err(OsmError::Nothing { path: path.to_path_buf(), reason: reason.to_owned() })
}
