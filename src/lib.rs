//! Evaluates traffic signal controllers over the whole family of a city's intersections.

pub mod cli;
pub mod control;
pub mod env;
pub mod error;
pub mod eval;
pub mod exit;
pub mod family;
pub mod files;
pub mod hash;
pub mod network;
pub mod nn;
pub mod osm;
pub mod report;
pub mod rl;
pub mod sample;
pub mod seed;
pub mod sheet;
pub mod side;
pub mod sim;
pub mod stats;
pub mod store;
pub mod suggest;
pub mod timing;
pub mod units;
