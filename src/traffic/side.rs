//! Which side of the street traffic keeps to, and the mirror between the two.
//!
//! All geometry of this project knows right-hand traffic only. What is left-hand is mirrored east to
//! west where it comes in (extracts in [`osm::mirror`](crate::osm::mirror), intersections to build in
//! [`network::intersection`](crate::traffic::network::intersection), SUMO's scenes in
//! [`env::side`](crate::traffic::env::side)) and back where it goes out.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::units::normalise_degrees;

/// The side of the street that traffic keeps to.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[serde(rename_all = "kebab-case")]
pub enum DrivingSide {
    /// Right-hand traffic: turns to the left cross opposing traffic.
    #[default]
    Right,
    /// Left-hand traffic: turns to the right cross opposing traffic.
    Left,
}

impl DrivingSide {
    /// Returns whether traffic keeps to the right.
    pub fn is_right(&self) -> bool {
        *self == Self::Right
    }

    /// Returns the other side.
    #[must_use]
    pub fn other(self) -> Self {
        match self {
            Self::Right => Self::Left,
            Self::Left => Self::Right,
        }
    }

    /// Returns the word that settings use: `right` or `left`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Right => "right",
            Self::Left => "left",
        }
    }

    /// Returns what lies `(left, right)` on the ground as right-hand traffic would have it, or the
    /// other way round: for left-hand traffic the two change places.
    pub fn swapped<T>(self, (left, right): (T, T)) -> (T, T) {
        match self {
            Self::Right => (left, right),
            Self::Left => (right, left),
        }
    }

    /// Returns a bearing on the ground, degrees clockwise from north, as right-hand traffic would have
    /// it, or the other way round: for left-hand traffic mirrored.
    pub fn bearing_deg(self, bearing_deg: f64) -> f64 {
        match self {
            Self::Right => bearing_deg,
            Self::Left => mirrored_deg(bearing_deg),
        }
    }
}

impl fmt::Display for DrivingSide {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Returns a bearing with east and west exchanged, degrees in `[0, 360)`.
pub fn mirrored_deg(bearing_deg: f64) -> f64 {
    normalise_degrees(360.0 - bearing_deg)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mirror_exchanges_east_and_west_and_leaves_north_and_south() {
        assert_eq!([0.0, 90.0, 180.0, 300.0].map(mirrored_deg), [0.0, 270.0, 180.0, 60.0]);
        assert_eq!(DrivingSide::Right.bearing_deg(90.0), 90.0);
        assert_eq!(DrivingSide::Left.swapped((1, 2)), (2, 1));
        assert_eq!(DrivingSide::Left.other(), DrivingSide::Right);
    }

    #[test]
    fn right_hand_traffic_is_what_settings_leave_out() {
        assert!(DrivingSide::default().is_right());
        assert_eq!(serde_json::to_string(&DrivingSide::Left).unwrap(), "\"left\"");
        assert_eq!(DrivingSide::Left.to_string(), "left");
    }
}
