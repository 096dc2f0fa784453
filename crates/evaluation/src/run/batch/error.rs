//! Why a batch system did not do what was asked.

use std::io;
use std::path::PathBuf;

use basics::files::FileError;

/// Why a batch system did not do what was asked.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BatchError {
    /// A command that is not here.
    #[error(
        "cannot start {command}: {reason}; this has to run where the batch system takes jobs, such as a login node"
    )]
    Missing {
        /// The command.
        command: &'static str,
        /// Why not.
        reason: io::Error,
    },
    /// A command that says no.
    #[error("{command} failed: {said}")]
    Refused {
        /// The command.
        command: &'static str,
        /// Its words.
        said: String,
    },
    /// A line of the user's that cannot be taken.
    #[error("{}: line {line}: {reason}", .path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong and the way out.
        reason: String,
    },
    /// The way to the results directory or the program, which a batch system could not pass on.
    #[error("{} has {what} in its name, which batch systems do not pass on; choose another name", .path.display())]
    Name {
        /// The file.
        path: PathBuf,
        /// What it has.
        what: &'static str,
    },
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] FileError),
}
