//! What the program does as its users start it.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../common/mod.rs"]
mod common;
#[path = "../libsumo/fixture.rs"]
mod fixture;
#[path = "../common/nightly.rs"]
mod nightly;

mod adding;
mod batch;
mod check;
mod cli_help;
mod cli_learn;
mod cli_list;
mod cli_osm;
mod cli_routes;
mod cli_run;
mod cli_signals;
mod cli_turning_counts;
mod completions;
mod control_tasks_run;
mod faults;
mod folder;
mod growth;
mod imported;
mod imported_networks;
mod osm_simulate;
mod outcomes;
mod own_controllers;
mod plans_sumo;
mod refusals;
mod report_links;
mod saved_model;
mod several_signals;
mod wrong_inputs;
