//! Why a results directory cannot be used.

use std::path::PathBuf;

use crate::files::FileError;

/// Why a results directory cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StoreError {
    /// No manifest.
    #[error(
        "{} is not a results directory (it has no manifest.json); give the folder that \
         `tsc-family run --out` wrote",
        .0.display()
    )]
    NotResults(PathBuf),
    /// Written by a version with other files.
    #[error(
        "{}: schema version {found}, but this tsc-family reads {expected}; use the version that \
         wrote it or give another --out",
        .path.display()
    )]
    Version {
        /// The manifest.
        path: PathBuf,
        /// Version found.
        found: String,
        /// Version understood.
        expected: u32,
    },
    /// A file that does not parse.
    #[error("{}: {reason}", .path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The parser's message.
        reason: String,
    },
    /// A record whose content does not match its own checksum or task.
    #[error(
        "{}: {reason}; delete the file and run again, only this task is repeated",
        .path.display()
    )]
    Record {
        /// The record.
        path: PathBuf,
        /// What does not match.
        reason: String,
    },
    /// The directory belongs to another run.
    #[error(
        "{} holds another run: {difference}; give another --out, or repeat the first command ({command}) \
         to continue it",
        .path.display()
    )]
    Mismatch {
        /// The directory.
        path: PathBuf,
        /// What differs, with both values.
        difference: String,
        /// The command that began the run.
        command: String,
    },
    /// Another process works on the directory.
    #[error(
        "{} is in use by another run ({holder}); wait for it, stop it, or give another --out",
        .path.display()
    )]
    Locked {
        /// The directory.
        path: PathBuf,
        /// What the lock file says.
        holder: String,
    },
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] FileError),
}
