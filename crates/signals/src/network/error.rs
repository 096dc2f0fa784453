//! Why a network could not be built, checked or found.

use std::path::PathBuf;

use basics::files::FileError;

/// Why a network could not be built, checked or found.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// No netconvert to build with.
    #[error(
        "netconvert was not found ({tried}); install SUMO (Debian: `apt-get install sumo`; anywhere: \
         `pip install eclipse-sumo`) or set SUMO_HOME to the folder above its `bin`"
    )]
    NoNetconvert {
        /// Places looked at.
        tried: String,
    },
    /// netconvert rejected what it was given.
    #[error("{point}: netconvert failed: {message}")]
    Netconvert {
        /// The point MDP.
        point: String,
        /// The last lines of its standard error.
        message: String,
    },
    /// netconvert came to no end of its own.
    #[error("{point}: {reason}; this says nothing of the intersection, run the same command again")]
    Disturbed {
        /// The point MDP.
        point: String,
        /// What happened.
        reason: String,
    },
    /// An intersection that cannot exist.
    #[error("{point}: {reason}")]
    Intersection {
        /// The point MDP.
        point: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A built network that fails its checks.
    #[error("{point}: the network is unsound: {reason}")]
    Unsound {
        /// The point MDP.
        point: String,
        /// The failed check.
        reason: String,
    },
    /// A network file that is not as it was built.
    #[error(
        "{}: {what} since it was built; repeat the `build-networks` command with --force to build \
         it again",
        .path.display()
    )]
    Altered {
        /// The file.
        path: PathBuf,
        /// `was deleted` or `was altered`.
        what: &'static str,
    },
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] FileError),
}
