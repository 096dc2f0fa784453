//! From a scenario to records: plan, worker processes, tasks.

pub mod plan;
pub mod pool;
pub mod task;

pub use crate::error::EvalError;
