//! Why input of `build-networks --osm` cannot be used.

use std::path::PathBuf;

use crate::family::error::FamilyError;
use crate::files::FileError;

/// Why an extract, a signal list, counts or a boundary cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OsmError {
    /// A file whose content is not what its name says.
    #[error("{}: holds {found}, but its name promises {expected}; {way_out}", .path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What it holds.
        found: &'static str,
        /// What its name promises.
        expected: &'static str,
        /// What to do.
        way_out: String,
    },
    /// A file that is damaged.
    #[error("{}, byte {byte}: {reason}; fetch the file again", .path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Where reading failed, in bytes of the file as it is stored.
        byte: u64,
        /// What is wrong.
        reason: String,
    },
    /// A table, GeoJSON or setting with something unusable at a place.
    #[error("{}, {place}: {reason}", .path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// Line, feature or field.
        place: String,
        /// What is wrong and the way out.
        reason: String,
    },
    /// A file that can be read but holds nothing to work with.
    #[error("{}: {reason}", .path.display())]
    Nothing {
        /// The file.
        path: PathBuf,
        /// What is missing and the way out.
        reason: String,
    },
    /// The family that was derived is unusable.
    #[error(transparent)]
    Family(#[from] FamilyError),
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] FileError),
}

/// Most characters of a value that a message quotes.
const QUOTED: usize = 60;

/// Returns a value from a file for a message: the start of it, if it is long.
pub(super) fn brief(text: &str) -> String {
    shortened(text, QUOTED)
}

/// Returns a text, or the start of it with so many characters, if it is longer.
pub(super) fn shortened(text: &str, chars: usize) -> String {
    match text.char_indices().nth(chars) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}
