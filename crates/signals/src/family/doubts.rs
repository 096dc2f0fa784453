//! What is doubtful in a table, and what of it is not simulated as it stands there: nothing of it stops a
//! run, and nothing of it is believed without a word.
//!
//! - **Changed:** an inflow that is cut or raised, a count that is missing, a turn lane that needs another lane.
//! - **Implausible for its column:** a speed, length or count that few streets have, with the unit it may be in.
//! - **Implausible beside the rest of the table:** a length beyond the next intersection, a bearing that
//!   contradicts the neighbour, a place far from the others or in no country.
//!
//! Source: thresholds are this project's; each is beside its reason.

mod changes;
mod doubt;
mod places;
mod points;
mod values;

use super::approaches::Intersection;
use crate::settings::{Detail, FamilySettings};
pub use doubt::Doubt;
use evaluation::family::MdpFamily;

/// Returns what is doubtful in a table of approaches, and what of it is changed.
pub fn of_approaches(intersections: &[Intersection], settings: &FamilySettings) -> Vec<Doubt> {
    let per_approach = settings.detail == Detail::PerApproach;
    let mut doubts = changes::changes(intersections, settings, per_approach);
    doubts.extend(values::values(intersections));
    doubts.extend(places::places(intersections, settings.length_scale));
    doubts
}

/// Returns what is doubtful in a table of point MDPs, and what of it is changed.
pub fn of_points(family: &MdpFamily) -> Vec<Doubt> {
    points::points(family)
}

#[cfg(test)]
mod tests;
