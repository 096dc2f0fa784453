//! OpenStreetMap to a family: from an extract to the approaches of its signalised intersections.
//!
//! Data flows one way: [`read`] keeps the drivable ways, signals and turn restrictions of a file as
//! an [`extract::Extract`]; [`tags`] gives the values of tags their meaning. Nothing here knows of
//! simulation.

pub mod arms;
pub mod boundary;
pub mod city;
pub mod config;
pub mod counts;
mod crossings;
pub mod drawing;
pub mod error;
pub mod extract;
mod features;
pub mod flags;
pub mod geometry;
pub mod graph;
pub mod intersections;
pub mod legs;
pub mod listing;
pub mod mirror;
mod near;
pub mod oddities;
pub mod quality;
pub mod read;
pub mod side;
pub mod signals;
pub mod sites;
pub mod sketch;
pub mod spots;
pub mod spread;
pub mod streets;
pub mod surroundings;
mod table;
pub mod tags;
pub mod traffic;
pub mod turns;
pub mod write;

pub use error::OsmError;
