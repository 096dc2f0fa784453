//! From a city's map to its family: approaches, scenario, networks and what to think of them.
//!
//! [`derive`](derive::derive) does all of it. What is on the ground comes from the crate [`osm_signals`];
//! [`sites`] leaves out the intersections that no network can be built for, [`table`] and `scenario` are what a
//! family is loaded from, [`quality`] and [`drawing`] what the page on quality shows.

pub mod config;
pub mod counted;
pub mod derive;
pub mod drawing;
pub mod error;
mod facts;
pub mod flag;
pub mod folder;
pub mod input;
mod one_green;
pub mod quality;
pub mod reason;
mod scenario;
pub mod sites;
pub mod spots;
pub mod surroundings;
pub mod table;
mod write;
