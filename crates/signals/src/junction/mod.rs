//! What a junction is to whoever builds, simulates and times it: its movements, and which of these conflict.
//!
//! Right-hand traffic only, and neither files nor simulator. The generator makes conflicts from geometry and from netconvert's
//! right-of-way matrix; those of scenarios from elsewhere follow from what their programs show together.

pub mod conflicts;

use osm_signals::Turn;

pub use conflicts::{Conflicts, Set};

/// A way across a junction; arms are numbered clockwise from north.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Movement {
    /// Arm that it comes from.
    pub from: usize,
    /// Arm that it leads to.
    pub to: usize,
    /// Its category.
    pub turn: Turn,
}

impl Movement {
    /// Returns the id of the edge that it comes from.
    pub fn from_edge(&self) -> String {
        incoming_edge(self.from)
    }

    /// Returns the id of the edge that it leads to.
    pub fn to_edge(&self) -> String {
        outgoing_edge(self.to)
    }

    /// Returns whether two movements must not both be unconditionally green: on a circle around the junction they come from
    /// different arms, and end in the same arm or cross.
    pub fn conflicts_with(&self, other: &Self) -> bool {
        if self.from == other.from {
            return false;
        }
        // Clockwise, every arm has its entry before its exit, because traffic keeps to the right.
        let (entry, exit) = (2 * self.from, 2 * self.to + 1);
        let inside = |point: usize| entry.min(exit) < point && point < entry.max(exit);
        self.to == other.to || inside(2 * other.from) != inside(2 * other.to + 1)
    }
}

/// Returns the id of the edge that leads from an arm to the signal.
pub fn incoming_edge(arm: usize) -> String {
    format!("in{arm}")
}

/// Returns the id of the edge that leads from the signal to an arm.
pub fn outgoing_edge(arm: usize) -> String {
    format!("out{arm}")
}
