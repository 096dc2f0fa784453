//! What the program does as its users start it.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../common/mod.rs"]
mod common;
#[cfg(feature = "libsumo")]
#[path = "../libsumo/fixture.rs"]
mod fixture;
#[cfg(feature = "libsumo")]
#[path = "../common/nightly.rs"]
mod nightly;

mod adding;
#[cfg(feature = "libsumo")]
mod batch;
#[cfg(feature = "libsumo")]
mod check;
mod cli_evaluate;
mod cli_help;
#[cfg(feature = "libsumo")]
mod cli_learn;
mod cli_list;
mod cli_osm;
#[cfg(feature = "libsumo")]
mod cli_routes;
#[cfg(feature = "libsumo")]
mod cli_run;
#[cfg(feature = "libsumo")]
mod cli_signals;
mod cli_turning_counts;
mod completions;
mod control_tasks_run;
#[cfg(feature = "libsumo")]
mod faults;
mod folder;
mod growth;
#[cfg(feature = "libsumo")]
mod imported;
#[cfg(feature = "libsumo")]
mod imported_networks;
#[cfg(feature = "libsumo")]
mod osm_simulate;
mod outcomes;
#[cfg(feature = "libsumo")]
mod own_controllers;
#[cfg(feature = "libsumo")]
mod plans_sumo;
#[cfg(feature = "libsumo")]
mod refusals;
mod report_links;
#[cfg(feature = "libsumo")]
mod several_signals;
mod wrong_inputs;
