//! From maps and lists to the networks of point MDPs.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../common/nightly.rs"]
mod nightly;
mod xml;

mod network_build;
mod osm_city;
mod osm_mirrored;
mod per_approach_sample;
