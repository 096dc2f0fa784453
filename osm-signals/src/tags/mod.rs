//! What the tags of ways and nodes mean: which ways are drivable, which way traffic goes, what a
//! signal node controls.
//!
//! Drivable is what OSMnx's filter `drive` keeps.
//!
//! Deviation: the paper removes motorways and their links. They are streets here unless
//! `streets.motorways` and `streets.motorway_links` say otherwise: an off-ramp that ends at a signal is an
//! approach of it, and so is a motorway that does.
//!
//! Deviation: streets that are private to motor vehicles by another tag than `access`
//! (`motor_vehicle=private`, `motorcar=private`, `vehicle=no` or `private`) are not drivable either.
//! OSMnx keeps them, but private drives would end the approaches of public streets.

mod access;
mod bus_lanes;
mod closed;
mod direction;
mod drivable;
mod highway;
pub mod lanes;
mod signal;
pub mod speed;
mod street;
mod value;

pub use direction::Direction;
pub use drivable::drivable;
pub use highway::Highway;
pub use signal::{SignalTags, Special, is_crossing_signal};
pub use street::Street;
pub use value::{Tags, tag};
