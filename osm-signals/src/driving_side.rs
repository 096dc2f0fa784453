//! Which side of the street traffic keeps to, and the mirror between the two.
//!
//! Geometry is that of right-hand traffic: left-hand traffic is mirrored east to west where it comes in,
//! and back where it goes out.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::angle::mirrored_deg;
use super::extract::{Extract, Place};

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

    /// Returns the side of an extract: as somebody says, else right; `None` where it may as well be left.
    pub fn of(extract: &Extract, said: Option<Self>) -> Option<Self> {
        let signal = extract.signals.first().map(|signal| signal.place);
        let place =
            signal.or_else(|| (0..extract.nodes.len()).find_map(|n| extract.nodes.place(n)));
        let inside = |[south, west, north, east]: &[f64; 4], place: Place| {
            (*south..=*north).contains(&place.latitude())
                && (*west..=*east).contains(&place.longitude())
        };
        let may_be_left = place.is_some_and(|place| WITH_LEFT.iter().any(|b| inside(b, place)));
        said.or_else(|| (!may_be_left).then_some(Self::Right))
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

/// Boxes (south, west, north, east, degrees) outside of which traffic keeps to the right everywhere. Within them it keeps
/// to the left, or there are countries of both.
///
/// Source: <https://en.wikipedia.org/wiki/Left-_and_right-hand_traffic>, as of 2024.
const WITH_LEFT: [[f64; 4]; 21] = [
    [49.8, -11.0, 61.0, 1.8],       // British Isles
    [49.1, -2.8, 49.8, -1.9],       // Channel Islands
    [35.7, 14.1, 36.1, 14.6],       // Malta
    [34.5, 32.2, 35.8, 34.7],       // Cyprus
    [-1.0, 60.0, 37.1, 97.4],       // Pakistan to Bhutan, Maldives
    [5.5, 97.3, 20.5, 105.7],       // Thailand
    [22.1, 113.4, 22.6, 114.5],     // Hong Kong, Macau
    [-56.0, 95.0, 7.5, 180.0],      // Malaysia to New Zealand
    [-50.0, -180.0, 5.0, -150.0],   // Samoa to the Cook Islands
    [-26.0, -131.0, -23.0, -124.0], // Pitcairn
    [24.0, 122.9, 46.0, 154.0],     // Japan
    [-36.0, 11.7, 5.1, 42.0],       // Kenya to South Africa
    [-20.6, 45.9, -3.0, 64.0],      // Seychelles, Mauritius
    [-41.0, -15.0, -7.0, -5.0],     // Saint Helena
    [20.8, -80.5, 27.4, -71.0],     // Bahamas, Turks and Caicos Islands
    [17.6, -81.5, 19.8, -76.1],     // Jamaica, Cayman Islands
    [10.0, -65.2, 18.8, -59.3],     // Virgin Islands to Trinidad
    [1.1, -61.5, 8.7, -53.9],       // Guyana, Suriname
    [32.2, -65.0, 32.5, -64.6],     // Bermuda
    [-53.0, -61.6, -50.9, -57.6],   // Falkland Islands
    [-55.0, -38.5, -53.9, -35.5],   // South Georgia
];

impl fmt::Display for DrivingSide {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::extract::SignalNode;
    use crate::tags::SignalTags;

    #[test]
    fn left_hand_traffic_is_right_hand_traffic_in_the_mirror() {
        assert_eq!(DrivingSide::Right.bearing_deg(90.0), 90.0);
        assert_eq!(DrivingSide::Left.swapped((1, 2)), (2, 1));
        assert_eq!(DrivingSide::Left.other(), DrivingSide::Right);
    }

    #[test]
    fn where_traffic_may_keep_to_the_left_the_side_has_to_be_said() {
        for (latitude, longitude, side) in [
            (40.76, -111.89, Some(DrivingSide::Right)),
            (50.95, 1.86, Some(DrivingSide::Right)),
            (51.51, -0.13, None),
            (-33.87, 151.21, None),
            (35.68, 139.76, None),
            (28.61, 77.21, None),
            (-1.29, 36.82, None),
        ] {
            let place = Place::from_degrees(latitude, longitude).unwrap();
            let signals = vec![SignalNode { id: 1, place, tags: SignalTags::default() }];
            let extract = Extract { signals, ..Extract::default() };
            assert_eq!(DrivingSide::of(&extract, None), side, "{latitude}");
            let left = Some(DrivingSide::Left);
            assert_eq!(DrivingSide::of(&extract, left), left);
        }
    }

    #[test]
    fn right_hand_traffic_is_what_settings_leave_out() {
        assert!(DrivingSide::default().is_right());
        assert_eq!(serde_json::to_string(&DrivingSide::Left).unwrap(), "\"left\"");
        assert_eq!(DrivingSide::Left.to_string(), "left");
    }
}
