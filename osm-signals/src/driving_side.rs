//! Which side of the street traffic keeps to, and the mirror between the two.
//!
//! Geometry is that of right-hand traffic: left-hand traffic is mirrored east to west where it comes in,
//! and back where it goes out.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::angle::mirrored_deg;

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn left_hand_traffic_is_right_hand_traffic_in_the_mirror() {
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
