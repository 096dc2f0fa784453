//! Evaluates traffic signal controllers over the whole family of a city's intersections.

pub mod error;
pub mod family;
pub mod network;
pub mod sample;
pub mod seed;
pub mod store;
pub mod units;
