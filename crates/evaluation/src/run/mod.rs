//! From a problem to records: plan, executors, tasks with training, checkpoints and models.
//!
//! Nothing here knows what is evaluated; see [`domain`] for the seam.

pub mod audit;
pub mod batch;
pub mod checkpoint;
pub mod domain;
pub mod effort;
pub mod entry;
pub mod error;
pub mod executor;
pub mod fault;
pub mod method;
pub mod model;
pub mod plan;
pub mod progress;
pub mod search;
pub mod selection;
pub mod session;
pub mod stop;
#[cfg(test)]
pub(crate) mod testing;
pub mod together;
pub mod watchdog;
pub mod work;
pub mod worker;

pub use error::RunError;
pub use stop::STOPPED;
