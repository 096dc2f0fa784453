//! From a city's map to its family: approaches, scenario, networks and what to think of them.
//!
//! [`derive`](derive::derive) does all of it. What is on the ground comes from the crate [`osm_signals`];
//! [`sites`] leaves out the intersections that no network can be built for, `write` has what a family is loaded from,
//! [`quality`] and [`surroundings`] what the page on quality shows.

pub mod config;
pub mod counted;
pub mod derive;
pub mod error;
pub mod folder;
pub mod quality;
pub mod sites;
pub mod surroundings;
mod write;
