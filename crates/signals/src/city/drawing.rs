//! The streets around the intersections of a city, thinned out so that a page can draw them.

use geo::{Coord, LineString, Simplify};
use osm_signals::tags::Highway;
use osm_signals::{Extract, Place};

use super::sites::City;

/// Width of the surroundings that are drawn, as a share of the frame.
const MARGIN: f64 = 0.03;

/// Least height and width of the frame, degrees.
const LEAST_DEG: f64 = 0.005;

/// Finest detail that is kept, as a share of the frame's height: less than a pixel.
const DETAIL: f64 = 1.0 / 1500.0;

/// Most corners of streets that are drawn; beyond, minor streets are left out.
const MAX_CORNERS: usize = 60_000;

/// A street to draw.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnStreet {
    /// Its class.
    pub highway: Highway,
    /// Latitude and longitude, degrees.
    pub places: Vec<(f64, f64)>,
}

/// What the map of a city shows beside its intersections.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Drawing {
    /// Streets, minor ones first.
    pub streets: Vec<DrawnStreet>,
    /// Signals that are no intersection: latitude, longitude and the reason.
    pub skipped: Vec<(f64, f64, &'static str)>,
    /// Least latitude, least longitude, greatest latitude, greatest longitude.
    pub frame: [f64; 4],
    /// Whether minor streets were left out.
    pub thinned: bool,
}

impl Drawing {
    /// Returns what to draw around the intersections of a city.
    pub fn new(extract: &Extract, city: &City) -> Self {
        let centres: Vec<Place> = city.sites().map(|site| site.found.centre).collect();
        let Some(frame) = frame(centres.iter().copied()) else { return Self::default() };
        let mut streets = streets(extract, frame);
        let corners = streets.iter().map(|s| s.places.len()).sum::<usize>();
        let thinned = corners > MAX_CORNERS;
        if thinned {
            streets.retain(|s| s.highway <= Highway::Tertiary);
        }
        streets.sort_by_key(|s| std::cmp::Reverse(s.highway));
        let inside = |p: Place| within(frame, p);
        let skipped = city.skipped().filter(|s| inside(s.place));
        let skipped = skipped.map(|s| (s.place.latitude(), s.place.longitude(), s.reason.words()));
        Self { streets, skipped: skipped.collect(), frame, thinned }
    }
}

/// Returns the frame around some places: least and greatest latitude and longitude.
fn frame(places: impl Iterator<Item = Place> + Clone) -> Option<[f64; 4]> {
    let range = |of: fn(Place) -> f64| {
        let values = places.clone().map(of);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)))
    };
    let ((south, north), (west, east)) = (range(Place::latitude), range(Place::longitude));
    if south > north {
        return None;
    }
    let margin = |low: f64, high: f64| {
        let more = ((high - low) * MARGIN).max((LEAST_DEG - (high - low)) / 2.0);
        (low - more, high + more)
    };
    let ((south, north), (west, east)) = (margin(south, north), margin(west, east));
    Some([south, west, north, east])
}

fn within([south, west, north, east]: [f64; 4], place: Place) -> bool {
    (south..=north).contains(&place.latitude()) && (west..=east).contains(&place.longitude())
}

/// Returns the streets that touch a frame, with only as many corners as can be seen.
fn streets(extract: &Extract, frame: [f64; 4]) -> Vec<DrawnStreet> {
    let detail = (frame[2] - frame[0]) * DETAIL;
    let mut streets = Vec::new();
    for way in &extract.ways {
        let nodes = extract.nodes_of(way).iter().filter_map(|id| extract.nodes.index(*id));
        let places: Vec<Place> = nodes.filter_map(|n| extract.nodes.places[n]).collect();
        if places.len() < 2 || !places.iter().any(|p| within(frame, *p)) {
            continue;
        }
        let line: LineString<f64> =
            places.iter().map(|p| Coord { x: p.longitude(), y: p.latitude() }).collect();
        let places = line.simplify(detail).into_iter().map(|c| (c.y, c.x)).collect();
        streets.push(DrawnStreet { highway: way.street.highway, places });
    }
    streets
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_single_place_gets_some_surroundings() {
        let place = Place::from_degrees(40.0, -75.0).unwrap();
        let [south, west, north, east] = frame(std::iter::once(place)).unwrap();
        assert!(north - south >= LEAST_DEG * 0.999 && east - west >= LEAST_DEG * 0.999);
        assert!(within([south, west, north, east], place));
    }
}
