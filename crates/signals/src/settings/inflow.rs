//! What the inflows of a table of approaches rest on, and the defaults of the directional split; what is
//! made of them is in [`crate::family`].

use serde::{Deserialize, Serialize};

use super::is_zero;

/// Share of each direction of a street whose directions are equal.
pub const EVEN_SPLIT: f64 = 0.5;

/// Heading around which the peak direction of streets lies, degrees clockwise from north.
pub const NORTH_EAST_DEG: f64 = 45.0;

/// What the inflows of a table of approaches rest on: shares of the approaches, which sum to 1. Pages
/// of results say it; it decides nothing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InflowSources {
    /// A traffic count on the approach.
    pub counted: f64,
    /// A traffic count elsewhere on the same street.
    pub spread: f64,
    /// The mean of counted streets of its class.
    pub imputed: f64,
    /// A default by class of street.
    pub default: f64,
    /// Vehicles by turn in the simulated hour; among `counted`. The table of approaches says it.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub by_turn: f64,
}

impl InflowSources {
    /// Returns the shares in the order of their worth.
    pub fn to_array(self) -> [f64; 4] {
        [self.counted, self.spread, self.imputed, self.default]
    }
}

/// Returns whether a share is that of equal directions.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
pub(super) fn is_even(share: &f64) -> bool {
    *share == EVEN_SPLIT
}

/// Returns whether a heading is the default.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde passes a reference")]
pub(super) fn is_north_east(heading_deg: &f64) -> bool {
    *heading_deg == NORTH_EAST_DEG
}
