//! OpenStreetMap to a family: from an extract to the approaches of its signalised intersections.
//!
//! Data flows one way: reading keeps the drivable ways, signals and turn restrictions of a file as
//! an [`extract::Extract`]; [`tags`] gives the values of tags their meaning. Nothing here knows of
//! simulation.

pub mod arms;
pub mod config;
pub mod error;
pub mod extract;
pub mod geometry;
pub mod graph;
pub mod intersections;
pub mod legs;
pub mod oddities;
pub mod read;
pub mod sites;
pub mod streets;
pub mod tags;
pub mod turns;

pub use error::OsmError;
