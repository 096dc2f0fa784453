//! Places along a street that are compared with counted lines, in metres on a flat frame.

use geo::line_measures::InterpolateLine;
use geo::{Coord, Euclidean, Length, LineString, Point};

use crate::extract::Place;
use crate::geometry::LocalMetric;

/// Distance of the first place from the junction, metres; before it the streets overlap.
pub(super) const FIRST_M: f64 = 5.0;

/// Distance between places, metres.
const STEP_M: f64 = 10.0;

/// Length of the street that is compared, metres: about a block. A longer street may bend away,
/// and its counted line may end at a junction that the street goes through.
const COMPARED_M: f64 = 150.0;

/// Half the length of the chord whose direction is that of the street, metres; single pieces of
/// a street can be short and point anywhere.
const HALF_CHORD_M: f64 = 10.0;

/// The surroundings of a street as a plane: x is metres east and y metres north of its start.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plane {
    origin: (f64, f64),
    /// Metres per degree.
    pub(super) metric: LocalMetric,
}

impl Plane {
    /// Returns the plane around a place.
    pub(super) fn around(place: Place) -> Self {
        let origin = (place.latitude(), place.longitude());
        Self { origin, metric: LocalMetric::at(origin.0) }
    }

    /// Returns where a longitude (x) and latitude (y) lie on the plane.
    pub(super) fn flat(&self, degrees: Coord<f64>) -> Coord<f64> {
        let (x, y) = self.metric.offset_m(self.origin, (degrees.y, degrees.x));
        Coord { x, y }
    }

    /// Returns a street on the plane; `None` if it has no length.
    pub(super) fn street(&self, places: &[Place]) -> Option<Street> {
        let degrees = places.iter().map(|p| Coord { x: p.longitude(), y: p.latitude() });
        let mut coords: Vec<_> = degrees.map(|c| self.flat(c)).collect();
        coords.dedup();
        let line = LineString(coords);
        let length_m = Euclidean.length(&line);
        (length_m > 0.0).then_some(Street { line, length_m })
    }
}

/// A street on the plane.
#[derive(Debug, Clone)]
pub(super) struct Street {
    /// Its line, metres.
    pub(super) line: LineString<f64>,
    /// Its length, metres.
    pub(super) length_m: f64,
}

/// A place along a street.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Sample {
    /// Where it is, metres.
    pub(super) at: Point<f64>,
    /// The street's direction there, degrees clockwise from north.
    pub(super) axis_deg: f64,
}

impl Street {
    /// Returns the places to compare: every 10 m from 5 m on, or the middle of a shorter street.
    pub(super) fn samples(&self) -> Vec<Sample> {
        let end = self.length_m.min(COMPARED_M);
        let first = FIRST_M.min(self.length_m / 2.0);
        let places = (0_u32..).map(|i| first + STEP_M * f64::from(i)).take_while(|m| *m <= end);
        places.filter_map(|metres| self.sample(metres)).collect()
    }

    /// Returns the place some metres from the start; `None` if the street turns back there.
    pub(super) fn sample(&self, metres: f64) -> Option<Sample> {
        let point = |m: f64| Euclidean.point_at_distance_from_start(&self.line, m);
        let (from, to) = (point(metres - HALF_CHORD_M)?, point(metres + HALF_CHORD_M)?);
        let chord = to - from;
        (chord != Point::new(0.0, 0.0))
            .then_some(Sample { at: point(metres)?, axis_deg: axis_deg(chord.into()) })
    }
}

/// Returns the direction of a step on the plane, degrees clockwise from north.
pub(super) fn axis_deg(step: Coord<f64>) -> f64 {
    step.x.atan2(step.y).to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn street(places: &[(f64, f64)]) -> Option<Street> {
        let places: Vec<_> =
            places.iter().map(|(y, x)| Place::from_degrees(*y, *x).unwrap()).collect();
        Plane::around(places[0]).street(&places)
    }

    #[test]
    fn a_long_street_is_compared_along_its_first_block() {
        let samples = street(&[(40.0, -111.0), (40.01, -111.0)]).unwrap().samples();
        assert_eq!(samples.len(), 15);
        assert!((samples[0].at.y() - 5.0).abs() < 1e-6 && samples[0].axis_deg.abs() < 1e-6);
        assert!((samples[14].at.y() - 145.0).abs() < 1e-6);
    }

    #[test]
    fn a_short_street_is_compared_in_its_middle() {
        let samples = street(&[(40.0, -111.0), (40.00004, -111.0)]).unwrap().samples();
        assert_eq!(samples.len(), 1);
        assert!((samples[0].at.y() - 2.224).abs() < 0.001, "{samples:?}");
    }

    #[test]
    fn a_street_without_length_has_no_place() {
        assert!(street(&[(40.0, -111.0), (40.0, -111.0)]).is_none());
        assert!(street(&[(40.0, -111.0)]).is_none());
    }

    #[test]
    fn the_direction_is_that_of_a_chord_not_of_a_crooked_piece() {
        let crooked =
            [(40.0, -111.0), (40.00045, -111.0), (40.00045, -110.99999), (40.001, -111.0)];
        let samples = street(&crooked).unwrap().samples();
        assert!(samples.iter().all(|s| s.axis_deg.abs() < 8.0), "{samples:?}");
    }
}
