//! From an intersection to a SUMO network with demand.
//!
//! [`intersection`] holds arms and lanes as the data has them; [`movements`], [`lanes`] and
//! [`phases`] decide what may go where and when; [`plain`] and [`netconvert`] make the network,
//! [`validate`] checks it, [`demand`] fills it, [`build`] does all of that for a family and
//! notices when a file is altered.

pub mod bays;
pub mod build;
pub mod default_program;
pub mod demand;
pub mod error;
pub mod intersection;
pub mod lanes;
pub mod left_turns;
pub mod movements;
pub mod netconvert;
pub mod phases;
pub mod plain;
mod tool;
pub mod validate;
