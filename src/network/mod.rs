//! From an intersection to a SUMO network with demand.

pub mod intersection;
