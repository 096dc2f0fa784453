//! Signalised intersections in SUMO: everything that knows of traffic.

pub mod content;
pub mod contest;
pub mod control;
pub mod controllers;
pub mod env;
pub mod environment;
pub mod family;
pub mod network;
pub mod program;
pub mod settings;
pub mod side;
pub mod sim;
pub mod timing;
