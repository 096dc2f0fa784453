//! Evaluates traffic signal controllers over the whole family of a city's intersections.

pub mod control;
pub mod env;
pub mod error;
pub mod family;
pub mod network;
pub mod sample;
pub mod seed;
pub mod sim;
pub mod store;
pub mod units;
