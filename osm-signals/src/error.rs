//! Why what is read cannot be used.

use std::io;
use std::path::{Path, PathBuf};

/// Why an extract, a signal list, counts or a boundary cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OsmError {
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
    /// A file that cannot be read.
    #[error("cannot read {}: {reason}", .path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The operating system's reason; part of the message, so it is no source of its own.
        reason: io::Error,
    },
}

impl OsmError {
    pub(crate) fn unreadable(path: &Path) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_path_buf();
        move |reason| Self::Unreadable { path, reason }
    }
}

/// Checks that a setting lies within limits, both included; NaN does not. The error names it, its value and the limits.
pub(crate) fn check_range(
    setting: &str,
    value: f64,
    (low, high): (f64, f64),
) -> Result<(), String> {
    let wrong = || format!("{setting}: {value}: expected a number from {low} to {high}");
    (low..=high).contains(&value).then_some(()).ok_or_else(wrong)
}

/// Most characters of a value that a message quotes.
const QUOTED: usize = 60;

pub(crate) fn brief(text: &str) -> String {
    shortened(text, QUOTED)
}

/// Returns a text, or the start of it with so many characters, if it is longer.
pub fn shortened(text: &str, chars: usize) -> String {
    match text.char_indices().nth(chars) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}

pub(super) fn malformed(
    path: &Path,
    place: impl Into<String>,
    reason: impl Into<String>,
) -> OsmError {
    OsmError::Malformed { path: PathBuf::from(path), place: place.into(), reason: reason.into() }
}
