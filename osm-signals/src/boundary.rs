//! Boundaries: the part of an extract that a family is made of.
//!
//! Either a box of longitudes and latitudes or the polygons of a GeoJSON file, whose holes are
//! outside. A place on the boundary itself is outside. Across the 180th meridian longitudes may go on: 181 is -179.

use std::fmt;
use std::path::Path;

use geo::indexed::IntervalTreeMultiPolygon;
use geo::orient::Direction;
use geo::{BoundingRect, Contains, Coord, LineString, MultiPolygon, Orient, Polygon, Rect};
use geojson::{FeatureCollection, GeoJson, Geometry, GeometryValue, PolygonType};

use super::error::OsmError;
use super::error::malformed;
use super::extract::Place;
use super::features;
use super::file;
use super::geometry::{checked_place, continued};

/// How the numbers of a box are meant.
const ORDER: &str = "WEST,SOUTH,EAST,NORTH in degrees";

/// What a file has to hold.
const POLYGONS: &str = "GeoJSON with a Polygon or MultiPolygon";

/// Once around the world, degrees.
const TURN_DEG: f64 = 360.0;

/// Fewest positions of a ring; the last one repeats the first.
const RING: usize = 4;

/// A part of the world.
pub struct Boundary {
    /// `None` if it is the box of its bounds.
    polygons: Option<IntervalTreeMultiPolygon<f64>>,
    /// The smallest box around it: x is the longitude and y the latitude, degrees.
    pub bounds: Rect<f64>,
}

impl fmt::Debug for Boundary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Boundary")
            .field("polygons", &self.polygons.is_some())
            .field("bounds", &self.bounds)
            .finish()
    }
}

impl Boundary {
    /// Returns the boundary that an argument names: `WEST,SOUTH,EAST,NORTH` in degrees, or the
    /// path of a GeoJSON file with a Polygon or MultiPolygon.
    ///
    /// Fails on a box that is empty, outside the world or in another order, and on a file of anything but polygons in WGS 84.
    ///
    /// # Examples
    ///
    /// ```
    /// # use osm_signals::boundary::Boundary;
    /// # use osm_signals::extract::Place;
    /// let boundary = Boundary::parse("-112.1,40.69,-111.73,40.86")?;
    /// let temple_square = Place::from_degrees(40.7704, -111.8919).expect("on earth");
    /// assert!(boundary.contains(temple_square));
    /// # Ok::<(), osm_signals::OsmError>(())
    /// ```
    pub fn parse(argument: &str) -> Result<Self, OsmError> {
        let path = Path::new(argument);
        let numbers: Vec<_> = argument.split(',').map(|n| n.trim().parse::<f64>().ok()).collect();
        if numbers.len() > 1 && numbers.iter().any(Option::is_some) && !path.exists() {
            let in_box = |reason| malformed(path, format!("read as {ORDER}"), reason);
            return Self::from_numbers(&numbers).map_err(in_box);
        }
        Self::from_bytes(&file::bytes(path)?, path)
    }

    /// Reads a boundary from the bytes of a GeoJSON file; `path` is for messages only.
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self, OsmError> {
        let geometries: Vec<Geometry> = match features::read(bytes, path, POLYGONS)? {
            GeoJson::Geometry(geometry) => vec![geometry],
            GeoJson::Feature(feature) => feature.geometry.into_iter().collect(),
            GeoJson::FeatureCollection(FeatureCollection { features, .. }) => {
                features.into_iter().filter_map(|feature| feature.geometry).collect()
            }
        };
        let mut polygons = Vec::new();
        for (i, geometry) in geometries.iter().enumerate() {
            add(geometry, &format!("geometry {}", i + 1), path, &mut polygons)?;
        }
        // The index counts windings, so that a hole has to go round against its shell.
        let polygons = MultiPolygon(polygons).orient(Direction::Default);
        let bounds = polygons.bounding_rect().ok_or_else(|| OsmError::Nothing {
            path: path.to_path_buf(),
            reason: format!("no polygon; {POLYGONS} is needed"),
        })?;
        Ok(Self { polygons: Some(IntervalTreeMultiPolygon::new(&polygons)), bounds })
    }

    /// Returns whether a place is inside.
    pub fn contains(&self, place: Place) -> bool {
        [0.0, TURN_DEG, -TURN_DEG].into_iter().any(|turn| {
            let at = Coord { x: place.longitude() + turn, y: place.latitude() };
            self.bounds.contains(&at) && self.polygons.as_ref().is_none_or(|p| p.contains(&at))
        })
    }

    fn from_numbers(numbers: &[Option<f64>]) -> Result<Self, String> {
        let [Some(west), Some(south), Some(east), Some(north)] = *numbers else {
            return Err("four numbers are needed, such as -112.1,40.69,-111.73,40.86".to_owned());
        };
        for (latitude, longitude) in [(south, west), (north, east)] {
            checked_place(latitude, longitude)?;
        }
        if west >= east || south >= north {
            return Err("west has to be less than east (beyond the 180th meridian: 181), and south less than north".to_owned());
        }
        let bounds = Rect::new(Coord { x: west, y: south }, Coord { x: east, y: north });
        Ok(Self { polygons: None, bounds })
    }
}

fn add(
    geometry: &Geometry,
    place: &str,
    path: &Path,
    polygons: &mut Vec<Polygon<f64>>,
) -> Result<(), OsmError> {
    let mut one = |rings: &PolygonType| {
        polygons.extend(polygon(rings).map_err(|reason| malformed(path, place, reason))?);
        Ok(())
    };
    match &geometry.value {
        GeometryValue::Polygon { coordinates } => one(coordinates),
        GeometryValue::MultiPolygon { coordinates } => coordinates.iter().try_for_each(one),
        other => {
            Err(malformed(path, place, format!("a {}; {POLYGONS} is needed", other.type_name())))
        }
    }
}

fn polygon(rings: &PolygonType) -> Result<Option<Polygon<f64>>, String> {
    let ring = |ring: &Vec<geojson::Position>| {
        if ring.len() < RING {
            return Err(format!("a ring of {} positions; it needs at least {RING}", ring.len()));
        }
        // A ring that goes on beyond 180 degrees has to stay one piece.
        let coord = |position: &geojson::Position| -> Result<Coord<f64>, String> {
            let place = features::place(position)?;
            Ok(Coord {
                x: continued(position.as_slice()[0], place.longitude()),
                y: place.latitude(),
            })
        };
        Ok(LineString(ring.iter().map(coord).collect::<Result<_, String>>()?))
    };
    let mut rings = rings.iter().map(ring).collect::<Result<Vec<_>, _>>()?.into_iter();
    Ok(rings.next().map(|shell| Polygon::new(shell, rings.collect())))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str = "[[0,0],[4,0],[4,4],[0,4],[0,0]]";
    const HOLE: &str = "[[1,1],[3,1],[3,3],[1,3],[1,1]]";

    fn at(latitude: f64, longitude: f64) -> Place {
        Place::from_degrees(latitude, longitude).unwrap()
    }

    fn read(text: &str) -> Result<Boundary, String> {
        Boundary::from_bytes(text.as_bytes(), Path::new("b.geojson")).map_err(|e| e.to_string())
    }

    #[test]
    fn a_box_contains_what_is_within_it() {
        let boundary = Boundary::parse(" -112.0, 40.7,-111.8,40.8 ").unwrap();
        assert!(boundary.contains(at(40.75, -111.9)) && !boundary.contains(at(40.7, -112.0)));
        assert!(!boundary.contains(at(40.81, -111.9)) && !boundary.contains(at(40.75, -112.01)));
        assert_eq!(boundary.bounds.min(), Coord { x: -112.0, y: 40.7 });
    }

    #[test]
    fn a_boundary_across_the_180th_meridian_is_one_piece() {
        let ring = "[[179,-17],[181,-17],[181,-16],[179,-16],[179,-17]]";
        let polygon = read(&format!("{{\"type\":\"Polygon\",\"coordinates\":[{ring}]}}")).unwrap();
        for boundary in [polygon, Boundary::parse("179,-17,181,-16").unwrap()] {
            for (longitude, is_inside) in
                [(179.5, true), (-179.5, true), (0.0, false), (-178.5, false)]
            {
                assert_eq!(boundary.contains(at(-16.5, longitude)), is_inside, "{longitude}");
            }
        }
    }

    #[test]
    fn a_hole_is_outside_whichever_way_its_ring_goes() {
        let reversed = "[[1,1],[1,3],[3,3],[3,1],[1,1]]";
        for hole in [HOLE, reversed] {
            let polygon = format!("{{\"type\":\"Polygon\",\"coordinates\":[{SQUARE},{hole}]}}");
            let feature =
                format!("{{\"type\":\"Feature\",\"properties\":null,\"geometry\":{polygon}}}");
            let all = format!("{{\"type\":\"FeatureCollection\",\"features\":[{feature}]}}");
            for text in [&polygon, &feature, &all] {
                let boundary = read(text).unwrap();
                assert!(boundary.contains(at(0.5, 0.5)) && !boundary.contains(at(0.0, 2.0)));
                assert!(!boundary.contains(at(2.0, 2.0)) && !boundary.contains(at(5.0, 2.0)));
                assert_eq!(boundary.bounds.max(), Coord { x: 4.0, y: 4.0 });
            }
        }
    }

    #[test]
    fn an_island_within_a_hole_is_inside() {
        let text = format!(
            "{{\"type\":\"MultiPolygon\",\"coordinates\":[[{SQUARE},{HOLE}],\
             [[[1.5,1.5],[2.5,1.5],[2.5,2.5],[1.5,2.5],[1.5,1.5]]]]}}"
        );
        let boundary = read(&text).unwrap();
        assert!(boundary.contains(at(2.0, 2.0)) && !boundary.contains(at(1.2, 1.2)));
    }

    #[test]
    fn what_is_no_box_or_polygon_is_refused() {
        for argument in [
            "40.7,-112.0,40.8,-111.8",
            "-111.8,40.7,-112,40.8",
            "-112,40.8,-111.8,40.7",
            "179,-17,-179,-16",
            "-112,40.8,-111.8",
            "-112,40.8,-111.8,north",
            "420000,4500000,430000,4510000",
            "nan,0,1,1",
            "missing.geojson",
        ] {
            assert!(Boundary::parse(argument).is_err(), "{argument}");
        }
        for text in [
            "{\"type\":\"LineString\",\"coordinates\":[[0,0],[1,1]]}",
            "{\"type\":\"FeatureCollection\",\"features\":[]}",
            "{\"type\":\"Polygon\",\"coordinates\":[[[0,0],[1,1],[0,0]]]}",
            "{\"type\":\"Polygon\",\"coordinates\":[[[40,-111],[40,-112],[41,-112],[40,-111]]]}",
        ] {
            assert!(read(text).is_err(), "{text}");
        }
    }
}
