//! Signalised intersections in SUMO: everything that knows of traffic.

pub mod content;
pub mod contest;
pub mod control;
pub mod controllers;
pub mod domain;
pub mod effort;
pub mod env;
pub mod environment;
pub mod error;
pub mod family;
pub mod model;
pub mod network;
pub mod places;
pub mod problem;
pub mod program;
pub mod report;
pub mod settings;
pub mod side;
pub mod sim;
pub mod simulator;
pub mod timing;
pub mod trial;
