//! Which side of the street traffic keeps to, and the mirror between the two.
//!
//! Geometry is that of right-hand traffic: left-hand traffic is mirrored east to west where it comes in,
//! and back where it goes out.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::angle::mirrored_deg;
use super::extract::Extract;

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

    /// Returns the side of an extract: as somebody says, or that of its place; `None` where it may be either.
    pub fn of(extract: &Extract, said: Option<Self>) -> Option<Self> {
        let signal = extract.signals.first().map(|signal| signal.place);
        let node = || extract.nodes.places.iter().flatten().next().copied();
        let (y, x) = signal.or_else(node).map_or((0.0, 0.0), |p| (p.latitude(), p.longitude()));
        let lies_in = |boxes: &[[f64; 4]]| {
            let inside = |[south, west, north, east]: &[f64; 4]| {
                (south..=north).contains(&&y) && (west..=east).contains(&&x)
            };
            boxes.iter().any(inside)
        };
        said.or_else(|| match lies_in(&LEFT) {
            true => Some(Self::Left),
            false => (!lies_in(&EITHER)).then_some(Self::Right),
        })
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

/// Boxes (south, west, north, east, degrees) in which traffic keeps to the left.
///
/// Source: <https://en.wikipedia.org/wiki/Left-_and_right-hand_traffic>, as of 2024.
const LEFT: [[f64; 4]; 21] = [
    [49.88, -11.0, 61.0, 0.69],    // British Isles, to the west of France
    [50.89, 0.69, 61.0, 1.35],     // Dungeness to Dover
    [51.15, 1.35, 61.0, 1.8],      // Deal to Lowestoft
    [49.1, -2.8, 49.8, -2.0],      // Channel Islands
    [35.7, 14.1, 36.1, 14.6],      // Malta
    [34.5, 32.2, 35.8, 34.7],      // Cyprus
    [6.0, 68.0, 27.4, 92.0],       // India to Bangladesh, Sri Lanka
    [-50.0, 95.0, -0.5, 154.0],    // Indonesia, Papua New Guinea, Australia
    [-0.5, 95.0, 7.0, 118.0],      // Malaysia, Singapore
    [12.5, 99.7, 14.8, 101.9],     // Bangkok
    [-48.0, 166.0, -34.0, 179.0],  // New Zealand
    [30.0, 129.6, 37.2, 142.0],    // Japan to Tokyo
    [37.2, 136.5, 42.0, 146.0],    // Northern Honshu
    [42.0, 139.3, 43.6, 146.0],    // Southern Hokkaido
    [43.6, 139.3, 45.6, 145.35],   // Northern Hokkaido
    [22.15, 113.83, 22.44, 114.5], // Hong Kong
    [-11.7, 31.3, 3.0, 41.0],      // Uganda to Tanzania
    [-35.0, 16.0, -17.8, 36.0],    // Namibia to Mozambique, South Africa
    [17.6, -78.5, 18.6, -76.1],    // Jamaica
    [32.2, -65.0, 32.5, -64.6],    // Bermuda
    [-55.0, -61.6, -50.9, -57.6],  // Falkland Islands
];

/// Boxes outside of [`LEFT`] with countries of both sides.
const EITHER: [[f64; 4]; 9] = [
    [-1.0, 60.0, 37.1, 97.4],     // Pakistan to Myanmar
    [-56.0, 95.0, 22.6, 180.0],   // Macau to Fiji
    [24.0, 122.9, 33.4, 154.0],   // Southern islands of Japan
    [34.0, 129.1, 34.8, 129.6],   // Tsushima
    [-50.0, -180.0, 5.0, -124.0], // Samoa to Pitcairn
    [-36.0, -15.0, 5.1, 64.0],    // Saint Helena to Mauritius
    [10.0, -79.4, 27.4, -59.3],   // Bahamas to Trinidad
    [1.1, -61.5, 8.7, -53.9],     // Guyana, Suriname
    [17.6, -81.5, 19.8, -79.4],   // Cayman Islands
];

impl fmt::Display for DrivingSide {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::extract::{Place, SignalNode};
    use crate::tags::SignalTags;

    #[test]
    fn left_hand_traffic_is_right_hand_traffic_in_the_mirror() {
        assert_eq!(DrivingSide::Right.bearing_deg(90.0), 90.0);
        assert_eq!(DrivingSide::Left.swapped((1, 2)), (2, 1));
    }

    #[test]
    fn the_place_tells_the_side_unless_it_is_said_or_may_be_either() {
        let (left, right) = (Some(DrivingSide::Left), Some(DrivingSide::Right));
        for (city, latitude, longitude, side) in [
            ("Salt Lake City", 40.76, -111.89, right),
            ("Miami", 25.77, -80.19, right),
            ("Dieppe", 49.92, 1.08, right),
            ("Vladivostok", 43.12, 131.89, right),
            ("Seoul", 37.57, 126.98, right),
            ("London", 51.51, -0.13, left),
            ("Sydney", -33.87, 151.21, left),
            ("Auckland", -36.85, 174.76, left),
            ("Tokyo", 35.68, 139.76, left),
            ("Delhi", 28.61, 77.21, None),
            ("Bangkok", 13.76, 100.5, left),
            ("Nairobi", -1.29, 36.82, left),
            ("Cape Town", -33.92, 18.42, left),
            ("Manila", 14.6, 120.98, None),
            ("Lahore", 31.55, 74.34, None),
            ("Kigali", -1.94, 30.06, None),
            ("San Juan", 18.47, -66.1, None),
        ] {
            let place = Place::from_degrees(latitude, longitude).unwrap();
            let signals = vec![SignalNode { id: 1, place, tags: SignalTags::default() }];
            let extract = Extract { signals, ..Extract::default() };
            assert_eq!(DrivingSide::of(&extract, None), side, "{city}");
            assert_eq!(DrivingSide::of(&extract, left), left);
        }
    }
}
