//! The family of a city: from approaches, or a table of point MDPs, to point MDPs.

pub mod approaches;
pub mod describing;
pub mod doubts;
pub mod features;
mod inflow;
pub mod load;
pub mod points;
