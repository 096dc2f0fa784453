//! OpenStreetMap to a family: from an extract to the approaches of its signalised intersections.
//!
//! Data flows one way: reading keeps the drivable ways, signals and turn restrictions of a file as
//! an [`extract::Extract`]; [`tags`] gives the values of tags their meaning. Nothing here knows of
//! simulation.

pub mod error;
pub mod extract;
pub mod oddities;
pub mod read;
pub mod tags;

pub use error::OsmError;
