//! From a scenario to records: plan, worker processes, tasks.

pub mod checkpoint;
pub mod error;
pub mod lab;
pub mod method;
pub mod model;
pub mod plan;
pub mod pool;
pub mod task;
#[cfg(test)]
mod testing;

pub use error::EvalError;
