//! What a report says of traffic signals beside what it says of any task.

pub mod level_of_service;
mod measures;
mod overloaded;

pub use measures::TrafficMeasures;
pub(crate) use measures::{GRIDLOCK_EXCESS, GRIDLOCK_SHARE, UNFINISHED};
pub use overloaded::Overloaded;
pub(crate) use overloaded::overloaded;
