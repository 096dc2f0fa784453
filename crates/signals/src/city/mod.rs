//! From a city's map to its family: approaches, scenario, networks and what to think of them.
//!
//! [`derive`](derive::derive) does all of it. What is on the ground comes from the crate [`osm_signals`];
//! [`sites`] leaves out the intersections that no network can be built for,
//! [`quality`] and [`surroundings`] what the page on quality shows.

pub mod config;
pub mod counted;
pub mod derive;
pub mod folder;
pub mod quality;
pub mod sites;
pub mod surroundings;

use std::path::{Path, PathBuf};

use osm_signals::OsmError;

use crate::network::error::NetworkError;
use basics::files::FileError;
use evaluation::family::error::FamilyError;

/// Why no city can be derived from what was given.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum CityError {
    /// The extract, or a file that says more of its city, cannot be used.
    #[error(transparent)]
    Input(#[from] OsmError),
    /// A file does not fit: settings, a place elsewhere, a table that was edited.
    #[error("{}: {reason}", .path.display())]
    Unfit {
        /// The file.
        path: PathBuf,
        /// What is wrong with it, and the way out.
        reason: String,
    },
    /// The family that was derived is unusable.
    #[error(transparent)]
    Family(#[from] FamilyError),
    /// A network cannot be built.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// A file could not be read or written.
    #[error(transparent)]
    Io(#[from] FileError),
}

impl CityError {
    fn unfit(path: &Path, reason: impl Into<String>) -> Self {
        Self::Unfit { path: path.to_path_buf(), reason: reason.into() }
    }
}
