//! The family of a city: from approaches, or a table of point MDPs, to point MDPs.

pub mod approaches;
pub mod doubts;
pub mod features;
pub mod load;
pub mod points;
