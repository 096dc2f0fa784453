//! What is computed from records: statistics, reports, estimates, sensitivity.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

#[path = "../common/mod.rs"]
mod common;
mod families;
mod made_up;
#[path = "../common/nightly.rs"]
mod nightly;

mod across;
mod compare;
mod damaged;
mod decided;
mod dropped;
mod estimate;
mod pages;
mod palette;
mod published;
mod published_figures;
mod quality_snapshot;
mod replicates;
mod rliable;
mod samples;
mod sensitivity;
mod summaries;
