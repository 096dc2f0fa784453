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
use super::extract::Place;
use super::features::{self, check_crs, malformed};
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
    bounds: Rect<f64>,
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
    /// # Errors
    ///
    /// [`OsmError`] when the box is empty, outside the world or in another order, or when the file
    /// cannot be read or holds anything but polygons in WGS 84.
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
    ///
    /// # Errors
    ///
    /// [`OsmError`] when it holds anything but polygons in WGS 84.
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self, OsmError> {
        let mut polygons = Vec::new();
        match features::read::<GeoJson>(bytes, path, POLYGONS)? {
            GeoJson::Geometry(geometry) => add(&geometry, "geometry", path, &mut polygons)?,
            GeoJson::Feature(feature) => {
                check_crs(feature.foreign_members.as_ref(), path)?;
                if let Some(geometry) = feature.geometry {
                    add(&geometry, "geometry", path, &mut polygons)?;
                }
            }
            GeoJson::FeatureCollection(FeatureCollection { features, foreign_members, .. }) => {
                check_crs(foreign_members.as_ref(), path)?;
                for (i, feature) in features.into_iter().enumerate() {
                    if let Some(geometry) = feature.geometry {
                        add(&geometry, &format!("feature {}", i + 1), path, &mut polygons)?;
                    }
                }
            }
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

    /// Returns the smallest box around it: x is the longitude and y the latitude, degrees.
    pub fn bounds(&self) -> Rect<f64> {
        self.bounds
    }

    fn from_numbers(numbers: &[Option<f64>]) -> Result<Self, String> {
        let [Some(west), Some(south), Some(east), Some(north)] = *numbers else {
            return Err("four numbers are needed, such as -112.1,40.69,-111.73,40.86".to_owned());
        };
        for (latitude, longitude) in [(south, west), (north, east)] {
            checked_place(latitude, longitude).map_err(|reason| {
                if reason.contains("swap") {
                    format!("{reason}, as in {south},{west},{north},{east}")
                } else {
                    reason
                }
            })?;
        }
        if west >= east {
            return Err(format!(
                "west ({west}) is not less than east ({east}); a box across the 180th meridian is \
                 {west},{south},{},{north}",
                east + TURN_DEG
            ));
        }
        if south >= north {
            return Err(format!("south ({south}) is not less than north ({north})"));
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
    check_crs(geometry.foreign_members.as_ref(), path)?;
    match &geometry.value {
        GeometryValue::Polygon { coordinates } => one(coordinates),
        GeometryValue::MultiPolygon { coordinates } => coordinates.iter().try_for_each(one),
        other => {
            Err(malformed(path, place, format!("a {}; {POLYGONS} is needed", other.type_name())))
        }
    }
}

/// Returns a polygon; `None` if it has no ring.
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
    use proptest::prelude::*;

    use super::*;

    const SQUARE: &str = "[[0,0],[4,0],[4,4],[0,4],[0,0]]";
    const HOLE: &str = "[[1,1],[3,1],[3,3],[1,3],[1,1]]";

    fn at(latitude: f64, longitude: f64) -> Place {
        Place::from_degrees(latitude, longitude).unwrap()
    }

    fn read(text: &str) -> Result<Boundary, String> {
        Boundary::from_bytes(text.as_bytes(), Path::new("b.geojson")).map_err(|e| e.to_string())
    }

    fn error(argument: &str) -> String {
        Boundary::parse(argument).unwrap_err().to_string()
    }

    #[test]
    fn a_box_contains_what_is_within_it() {
        let boundary = Boundary::parse(" -112.0, 40.7,-111.8,40.8 ").unwrap();
        assert!(boundary.contains(at(40.75, -111.9)) && !boundary.contains(at(40.7, -112.0)));
        assert!(!boundary.contains(at(40.81, -111.9)) && !boundary.contains(at(40.75, -112.01)));
        assert_eq!(boundary.bounds().min(), Coord { x: -112.0, y: 40.7 });
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
        let e = error("179,-17,-179,-16");
        assert!(e.ends_with("a box across the 180th meridian is 179,-17,181,-16"), "{e}");
    }

    #[test]
    fn a_box_in_another_order_is_explained() {
        assert_eq!(
            error("40.7,-112.0,40.8,-111.8"),
            "40.7,-112.0,40.8,-111.8, read as WEST,SOUTH,EAST,NORTH in degrees: latitude -112, \
             longitude 40.7: outside the world, but not if swapped; swap latitude and longitude, \
             as in -112,40.7,-111.8,40.8"
        );
        assert!(error("-111.8,40.7,-112,40.8").contains("west (-111.8) is not less than east"));
        assert!(error("-112,40.8,-111.8,40.7").contains("south (40.8) is not less than north"));
        assert!(error("-112,40.8,-111.8").contains("four numbers are needed"));
        assert!(error("-112,40.8,-111.8,north").contains("four numbers are needed"));
        assert!(error("420000,4500000,430000,4510000").contains("looks projected"));
        assert!(error("nan,0,1,1").contains("not a number"));
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
                assert_eq!(boundary.bounds().max(), Coord { x: 4.0, y: 4.0 });
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
    fn what_is_no_polygon_is_refused_with_its_place() {
        let line = "{\"type\":\"LineString\",\"coordinates\":[[0,0],[1,1]]}";
        assert!(
            read(line).unwrap_err().contains("b.geojson, geometry: a LineString; GeoJSON with")
        );
        let none = "{\"type\":\"FeatureCollection\",\"features\":[]}";
        assert!(read(none).unwrap_err().contains("no polygon"));
        let short = "{\"type\":\"Polygon\",\"coordinates\":[[[0,0],[1,1],[0,0]]]}";
        assert!(read(short).unwrap_err().contains("a ring of 3 positions"));
        let swapped =
            "{\"type\":\"Polygon\",\"coordinates\":[[[40,-111],[40,-112],[41,-112],[40,-111]]]}";
        assert!(read(swapped).unwrap_err().contains("swap latitude and longitude"));
        assert!(error("missing.geojson").contains("cannot read missing.geojson"));
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            drop(Boundary::from_bytes(&bytes, Path::new("b.geojson")));
        }

        #[test]
        fn any_argument_is_read_or_refused(argument in "[0-9,.\\-aeinf ]{0,30}") {
            drop(Boundary::parse(&argument));
        }

        #[test]
        fn any_coordinates_are_read_or_refused(
            rings in prop::collection::vec(
                prop::collection::vec(prop::collection::vec(-200..200, 0..4), 0..6), 0..4,
            ),
        ) {
            let polygon = serde_json::json!({ "type": "Polygon", "coordinates": rings });
            drop(read(&polygon.to_string()));
        }

        #[test]
        fn any_ring_is_taken_without_panic(
            ring in prop::collection::vec((-2i32..3, -2i32..3), 3..8), place in (-2i32..3, -2i32..3),
        ) {
            let mut ring: Vec<_> = ring.into_iter().map(|(x, y)| [x, y]).collect();
            ring.push(ring[0]);
            let text = serde_json::json!({ "type": "Polygon", "coordinates": [ring] }).to_string();
            let boundary = read(&text).unwrap();
            let place = at(f64::from(place.1), f64::from(place.0));
            let bounds = boundary.bounds();
            let coord = Coord { x: place.longitude(), y: place.latitude() };
            prop_assert!(!boundary.contains(place) || bounds.contains(&coord));
        }
    }
}
