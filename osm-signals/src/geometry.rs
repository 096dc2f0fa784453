//! Distances, bearings and positions on the ground.
//!
//! As in OSMnx, the earth is a sphere of radius 6,371,009 m and a bearing is the initial one, degrees clockwise from north.
//! Where thousands of short distances are compared, a `Plane` takes the surroundings of a place as flat instead: within 1
//! km the error is below 0.1% up to 80 degrees north and south.

use geo::{Bearing, Coord, Destination, Distance, HaversineMeasure, InterpolatePoint, Point};

use super::extract::Place;

/// Radius of the earth, metres (OSMnx's).
pub const EARTH_RADIUS_M: f64 = 6_371_009.0;

/// Larger than any degree: coordinates beyond it are metres or feet of a projection.
const NO_DEGREES: f64 = 360.0;

/// Half of the way around the earth, degrees.
const HALF_CIRCLE_DEG: f64 = 180.0;

/// Distances and bearings on the sphere.
const SPHERE: HaversineMeasure = HaversineMeasure::new(EARTH_RADIUS_M);

/// The surroundings of a place, taken as flat: x is metres east and y metres north of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    /// Latitude and longitude, degrees.
    origin: (f64, f64),
    pub(crate) east_m_per_deg: f64,
    pub(crate) north_m_per_deg: f64,
}

impl Plane {
    pub(crate) fn around(place: Place) -> Self {
        let north_m_per_deg = EARTH_RADIUS_M.to_radians();
        let east_m_per_deg = north_m_per_deg * place.latitude().to_radians().cos();
        Self { origin: (place.latitude(), place.longitude()), east_m_per_deg, north_m_per_deg }
    }

    /// Returns where a longitude (x) and latitude (y), degrees, lie.
    pub(crate) fn flat(&self, degrees: Coord<f64>) -> Coord<f64> {
        let (latitude, longitude) = self.origin;
        let east_deg = continued(longitude, degrees.x) - longitude;
        Coord {
            x: east_deg * self.east_m_per_deg,
            y: (degrees.y - latitude) * self.north_m_per_deg,
        }
    }
}

/// Returns a longitude as it continues from another one by the shorter way, which may pass 180 degrees.
pub(crate) fn continued(from_deg: f64, to_deg: f64) -> f64 {
    match to_deg - from_deg {
        east if east > HALF_CIRCLE_DEG => to_deg - 2.0 * HALF_CIRCLE_DEG,
        east if east < -HALF_CIRCLE_DEG => to_deg + 2.0 * HALF_CIRCLE_DEG,
        _ => to_deg,
    }
}

/// Returns the middle of places near each other, also on both sides of the 180th meridian; `None` of no place.
pub(crate) fn middle(places: impl Iterator<Item = Place> + Clone) -> Option<Place> {
    let first_deg = places.clone().next()?.longitude();
    let count = places.clone().count() as f64;
    let mean = |of: &dyn Fn(Place) -> f64| places.clone().map(of).sum::<f64>() / count;
    let longitude = mean(&|place| continued(first_deg, place.longitude()));
    Place::from_degrees(mean(&Place::latitude), continued(0.0, longitude))
}

/// Returns the place that somebody gives, degrees. A longitude may go on beyond 180 degrees, as in some programs: 181 is
/// -179, and 248 is -112. The error says what is wrong and the way out: projected, swapped or no number.
pub fn checked_place(latitude: f64, longitude: f64) -> Result<Place, String> {
    if longitude.abs() <= NO_DEGREES
        && let Some(place) = Place::from_degrees(latitude, continued(0.0, longitude))
    {
        return Ok(place);
    }
    let why = match latitude.abs().max(longitude.abs()) {
        _ if Place::from_degrees(longitude, latitude).is_some() => "swap latitude and longitude",
        most if most > NO_DEGREES => "looks projected; export as WGS 84 (EPSG:4326)",
        _ => "outside the world; give degrees such as 40.76 and -111.89",
    };
    Err(format!("latitude {latitude}, longitude {longitude}: {why}"))
}

/// Returns the great-circle distance between two places, metres.
pub fn distance_m(a: Place, b: Place) -> f64 {
    SPHERE.distance(point(a), point(b))
}

/// Returns the initial bearing from `a` to `b`, degrees clockwise from north, in [0, 360); 0 if they are one place.
pub fn bearing_deg(a: Place, b: Place) -> f64 {
    if a == b { 0.0 } else { SPHERE.bearing(point(a), point(b)) }
}

/// Returns the place some metres from another in a direction, degrees clockwise from north.
pub fn beyond(from: Place, bearing_deg: f64, metres: f64) -> Place {
    let at = SPHERE.destination(point(from), bearing_deg, metres);
    Place::from_degrees(at.y(), at.x()).unwrap_or(from)
}

/// Returns where a place is on the sphere, metres from the centre of the earth.
pub(crate) fn chord(place: Place) -> [f64; 3] {
    let (latitude, longitude) = (place.latitude().to_radians(), place.longitude().to_radians());
    let east = [latitude.cos() * longitude.cos(), latitude.cos() * longitude.sin()];
    [east[0], east[1], latitude.sin()].map(|c| c * EARTH_RADIUS_M)
}

/// Returns the angle between two axes, degrees, in [0, 90]: directions that differ by 180 degrees are one axis.
pub fn axis_difference_deg(a_deg: f64, b_deg: f64) -> f64 {
    let difference = (a_deg - b_deg).rem_euclid(180.0);
    difference.min(180.0 - difference)
}

/// Returns the length of a polyline, metres; 0 for less than two places.
pub fn length_m(polyline: &[Place]) -> f64 {
    polyline.windows(2).map(|pair| distance_m(pair[0], pair[1])).sum()
}

/// Returns `(latitude, longitude)`, degrees, of the point some metres from the start along a
/// polyline; `None` before its start, beyond its end or if it has no place.
pub fn along(polyline: &[Place], metres: f64) -> Option<(f64, f64)> {
    if metres < 0.0 {
        return None;
    }
    if metres == 0.0 {
        return polyline.first().map(|p| (p.latitude(), p.longitude()));
    }
    // The sum is taken as in `length_m`, so that the length itself is not beyond the end.
    let mut before = 0.0;
    for pair in polyline.windows(2) {
        let after = before + distance_m(pair[0], pair[1]);
        if metres <= after {
            let (start, end) = (point(pair[0]), point(pair[1]));
            let found = SPHERE.point_at_distance_between(start, end, metres - before);
            return Some((found.y(), found.x()));
        }
        before = after;
    }
    None
}

fn point(place: Place) -> Point<f64> {
    Point::new(place.longitude(), place.latitude())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(latitude: f64, longitude: f64) -> Place {
        Place::from_degrees(latitude, longitude).unwrap()
    }

    #[test]
    fn a_degree_of_latitude_is_as_long_as_on_the_sphere() {
        // One degree of a circle with that radius.
        let degree = distance_m(at(40.0, -111.0), at(41.0, -111.0));
        assert!((degree - 111_195.083).abs() < 0.001, "{degree}");
    }

    #[test]
    fn bearings_go_clockwise_from_north() {
        let centre = at(40.0, -111.0);
        for (latitude, longitude, expected) in
            [(40.01, -111.0, 0.0), (40.0, -110.99, 90.0), (39.99, -111.0, 180.0)]
        {
            let bearing = bearing_deg(centre, at(latitude, longitude));
            assert!((bearing - expected).abs() < 0.01, "{bearing} for {expected}");
        }
        assert_eq!(bearing_deg(centre, centre), 0.0);
    }

    #[test]
    fn opposite_directions_are_one_axis() {
        assert_eq!(axis_difference_deg(10.0, 190.0), 0.0);
        assert_eq!(axis_difference_deg(350.0, 10.0), 20.0);
        assert_eq!(axis_difference_deg(0.0, 270.0), 90.0);
    }

    #[test]
    fn a_point_along_a_polyline_is_none_outside_it() {
        let line = [at(40.0, -111.0), at(40.0, -111.0), at(40.001, -111.0), at(40.001, -110.99)];
        let length = length_m(&line);
        assert_eq!(along(&line, 0.0), Some((40.0, -111.0)));
        let (latitude, longitude) = along(&line, length).unwrap();
        assert!((latitude - 40.001).abs() < 1e-9 && (longitude + 110.99).abs() < 1e-9);
        let (latitude, longitude) = along(&line, 55.6).unwrap();
        assert!((latitude - 40.0005).abs() < 1e-6 && (longitude + 111.0).abs() < 1e-9);
        assert_eq!(along(&line, length + 0.01), None);
        assert_eq!(along(&line, -0.01), None);
        assert_eq!(along(&line, f64::NAN), None);
        assert_eq!(along(&[], 0.0), None);
    }

    #[test]
    fn the_plane_agrees_with_the_sphere() {
        for latitude in [0.0, 40.76, -80.0] {
            let (a, b) = (at(latitude, 10.0), at(latitude + 0.004, 10.004));
            let b_at = Plane::around(a).flat(Coord { x: b.longitude(), y: b.latitude() });
            let exact = distance_m(a, b);
            assert!((b_at.x.hypot(b_at.y) / exact - 1.0).abs() < 1e-3, "at {latitude}");
        }
    }

    #[test]
    fn places_on_both_sides_of_the_180th_meridian_are_near_each_other() {
        for (west, east, expected) in
            [(179.999, -179.998, -179.9995), (-179.999, 179.998, 179.9995), (10.0, 12.0, 11.0)]
        {
            let middle = middle([at(-17.0, west), at(-17.002, east)].into_iter()).unwrap();
            assert_eq!(middle, at(-17.001, expected));
        }
        let Coord { x, .. } =
            Plane::around(at(-17.0, 179.999)).flat(Coord { x: -179.999, y: -17.0 });
        assert!((x - distance_m(at(-17.0, 179.999), at(-17.0, -179.999))).abs() < 0.1, "{x}");
        assert_eq!(super::middle(std::iter::empty()), None);
    }

    #[test]
    fn a_place_outside_the_world_is_refused_and_one_beyond_180_degrees_is_not() {
        assert_eq!(checked_place(-16.8, 181.0), Ok(at(-16.8, -179.0)));
        assert_eq!(checked_place(40.76, 248.5), Ok(at(40.76, -111.5)));
        for (latitude, longitude) in
            [(-111.83, 40.76), (4_510_000.0, 425_000.0), (95.0, 95.0), (f64::NAN, 1.0)]
        {
            assert!(checked_place(latitude, longitude).is_err(), "{latitude}");
        }
    }
}
