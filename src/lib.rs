//! Evaluates traffic signal controllers over the whole family of a city's intersections.

pub mod analysis;
pub mod cartpole;
pub mod cli;
pub mod domains;
pub mod family;
pub mod files;
pub mod hash;
pub mod nn;
pub mod osm;
pub mod report;
pub mod rl;
pub mod run;
pub mod sample;
pub mod seed;
pub mod settings;
pub mod sheet;
pub mod stats;
pub mod store;
pub mod suggest;
pub mod traffic;
pub mod units;
