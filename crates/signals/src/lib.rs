//! Signalised intersections in SUMO: everything that knows of traffic.
//!
//! All geometry knows right-hand traffic only. What is left-hand is mirrored east to west where it comes in
//! (extracts in [`osm_signals::mirror`], intersections to build in [`network::intersection`], SUMO's scenes in
//! [`env::side`]) and back where it goes out.

pub mod city;
pub mod control;
pub mod controllers;
pub mod domain;
pub mod env;
pub mod environment;
pub mod error;
pub mod existing;
pub mod family;
pub mod junction;
pub mod model;
pub mod movement_results;
pub mod needs;
pub mod network;
pub mod network_files;
pub mod own;
pub mod placed;
pub mod places;
pub mod problem;
pub mod program;
pub mod replay;
pub mod settings;
pub mod sim;
pub mod simulator;
pub mod street_results;
pub mod timing;
pub mod trial;
pub mod turning;
pub mod utdf;
pub mod vocabulary;
