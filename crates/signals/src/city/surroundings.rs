//! What a city's folder keeps for the maps and tables of reports: the streets, `streets.geojson`, thinned out so that a
//! page can draw them, and the names of the streets of every intersection, in `intersections.geojson`.

use std::collections::BTreeMap;
use std::path::Path;

use geo::{Coord, LineString, Simplify};
use geojson::{
    Feature, FeatureCollection, GeoJson, GeometryValue, JsonValue, LineStringType, Position,
};
use osm_signals::tags::Highway;
use osm_signals::{Extract, Place};
use serde_json::json;

use super::CityError;
use super::sites::City;
use basics::files::{self, FileError, limits, write_atomically};

/// Name of the file of streets.
const STREETS_FILE: &str = "streets.geojson";

/// Name of the file of intersections.
const INTERSECTIONS_FILE: &str = "intersections.geojson";

/// Files of a city's folder that a scenario made from it takes over.
pub(super) const SURROUNDINGS: [&str; 2] = [INTERSECTIONS_FILE, STREETS_FILE];

/// What stands between the streets of an intersection.
const BETWEEN: &str = " / ";

/// Names of the ranks, minor streets first.
const RANKS: [&str; 4] = ["minor", "tertiary", "secondary", "primary, trunk"];

/// Parts of a degree that coordinates of streets are rounded to: a metre.
const PER_DEGREE: f64 = 1e5;

/// Width of the surroundings that are drawn, as a share of the frame.
const MARGIN: f64 = 0.03;

/// Least height and width of the frame, degrees.
const LEAST_DEG: f64 = 0.005;

/// Finest detail that is kept, as a share of the frame's height: less than a pixel.
const DETAIL: f64 = 1.0 / 1500.0;

/// Most corners of streets that are drawn; beyond, minor streets are left out.
const MAX_CORNERS: usize = 60_000;

/// The lines of the streets of one rank: longitude and latitude, degrees.
pub type Lines = Vec<Vec<[f64; 2]>>;

/// The names of the streets of an intersection as it was found, and its latitude and longitude, degrees.
pub type Named = (Vec<String>, (f64, f64));

/// Returns the streets around the intersections of a city: how important each is, from 0 for minor ones to 3, and its corners,
/// latitude and longitude in degrees. Minor ones come first, and are left out where there are too many.
pub(super) fn around(extract: &Extract, city: &City) -> Vec<(usize, Vec<(f64, f64)>)> {
    let centres: Vec<Place> = city.sites().map(|site| site.found.centre).collect();
    let Some(frame) = frame(&centres) else { return Vec::new() };
    let mut streets = streets(extract, frame);
    if streets.iter().map(|(_, places)| places.len()).sum::<usize>() > MAX_CORNERS {
        streets.retain(|(highway, _)| *highway <= Highway::Tertiary);
    }
    streets.sort_by_key(|(highway, _)| std::cmp::Reverse(*highway));
    streets.into_iter().map(|(highway, places)| (rank(highway), places)).collect()
}

/// Writes streets, a feature per rank.
pub(super) fn write_streets(
    folder: &Path,
    streets: &[(usize, Vec<(f64, f64)>)],
) -> Result<(), FileError> {
    let rounded = |degrees: f64| (degrees * PER_DEGREE).round() / PER_DEGREE;
    let position = |p: &(f64, f64)| Position::from([rounded(p.1), rounded(p.0)]);
    let features = RANKS.iter().enumerate().filter_map(|(rank, name)| {
        let streets = streets.iter().filter(|(of, _)| *of == rank);
        let coordinates: Vec<LineStringType> =
            streets.map(|(_, places)| places.iter().map(position).collect()).collect();
        (!coordinates.is_empty()).then(|| {
            let geometry = GeometryValue::MultiLineString { coordinates };
            feature(geometry, json!({ "rank": rank, "streets": name }))
        })
    });
    write_features(&folder.join(STREETS_FILE), features.collect())
}

fn rank(highway: Highway) -> usize {
    match highway {
        Highway::Trunk | Highway::Primary => 3,
        Highway::Secondary => 2,
        Highway::Tertiary => 1,
        _ => 0,
    }
}

/// Returns the frame around some places: least and greatest latitude and longitude.
fn frame(places: &[Place]) -> Option<[f64; 4]> {
    let range = |of: fn(&Place) -> f64| {
        let values = places.iter().map(of);
        let (low, high) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| (a.min(v), b.max(v)));
        let more = ((high - low) * MARGIN).max((LEAST_DEG - (high - low)) / 2.0);
        (low - more, high + more)
    };
    let ((south, north), (west, east)) = (range(|p| p.latitude()), range(|p| p.longitude()));
    (!places.is_empty()).then_some([south, west, north, east])
}

fn within([south, west, north, east]: [f64; 4], place: Place) -> bool {
    (south..=north).contains(&place.latitude()) && (west..=east).contains(&place.longitude())
}

/// Returns the streets that touch a frame, with only as many corners as can be seen.
fn streets(extract: &Extract, frame: [f64; 4]) -> Vec<(Highway, Vec<(f64, f64)>)> {
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
        streets.push((way.street.highway, places));
    }
    streets
}

fn feature(geometry: GeometryValue, properties: JsonValue) -> Feature {
    let properties = properties.as_object().cloned();
    Feature { geometry: Some(geometry.into()), properties, ..Feature::default() }
}

fn write_features(path: &Path, features: Vec<Feature>) -> Result<(), FileError> {
    let collection = FeatureCollection { bbox: None, features, foreign_members: None };
    let text = serde_json::to_vec(&collection).expect("features are plain data");
    write_atomically(path, &text)
}

/// Writes the intersections and the signals that are none: latitude, longitude and properties of each, in order.
pub(super) fn write_places(
    folder: &Path,
    places: impl Iterator<Item = (f64, f64, JsonValue)>,
) -> Result<(), FileError> {
    let features = places.map(|(latitude, longitude, properties)| {
        feature(GeometryValue::new_point([longitude, latitude]), properties)
    });
    write_features(&folder.join(INTERSECTIONS_FILE), features.collect())
}

/// Returns the lines of the streets of a city's folder with their rank, minor ones first; none when
/// the folder has no such file.
///
/// # Errors
///
/// [`CityError`] when the file cannot be read or is no GeoJSON.
pub fn read_streets(folder: &Path) -> Result<Vec<(usize, Lines)>, CityError> {
    let mut streets = Vec::new();
    for feature in features(&folder.join(STREETS_FILE))? {
        let rank = feature.property("rank").and_then(JsonValue::as_u64).unwrap_or(0);
        if let Some(GeometryValue::MultiLineString { coordinates }) =
            feature.geometry.map(|g| g.value)
        {
            let corner = |p: &Position| Some([*p.as_slice().first()?, *p.as_slice().get(1)?]);
            let line = |line: LineStringType| line.iter().filter_map(corner).collect();
            let lines: Lines = coordinates.into_iter().map(line).collect();
            streets.push(((rank as usize).min(RANKS.len() - 1), lines));
        }
    }
    streets.sort_by_key(|s| s.0);
    Ok(streets)
}

/// Returns the intersections of a city's folder by their ids; none when the folder has no such file.
///
/// # Errors
///
/// [`CityError`] when the file cannot be read or is no GeoJSON.
pub fn read_names(folder: &Path) -> Result<BTreeMap<String, Named>, CityError> {
    let mut names = BTreeMap::new();
    for feature in features(&folder.join(INTERSECTIONS_FILE))? {
        let text = |name: &str| Some(feature.property(name)?.as_str()?.to_owned());
        let (Some(id), Some(streets)) = (text("id"), text("streets")) else { continue };
        let Some(GeometryValue::Point { coordinates }) =
            feature.geometry.as_ref().map(|g| &g.value)
        else {
            continue;
        };
        let [longitude, latitude, ..] = coordinates.as_slice() else { continue };
        let streets = streets.split(BETWEEN).filter(|s| !s.is_empty()).map(str::to_owned);
        names.insert(id, (streets.collect(), (*latitude, *longitude)));
    }
    Ok(names)
}

fn features(path: &Path) -> Result<Vec<Feature>, CityError> {
    let text = files::if_present(files::read_text(path, limits::DOCUMENT))?;
    let Some(text) = text else { return Ok(Vec::new()) };
    let collection = text.parse::<GeoJson>().and_then(FeatureCollection::try_from);
    collection
        .map(|collection| collection.features)
        .map_err(|e| CityError::unfit(path, format!("{e}; build the city's networks again")))
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn streets_read_back_by_rank_minor_ones_first() {
        let street =
            |rank, south: f64| (rank, vec![(south, -111.0), (south + 0.123_456_789, -111.0)]);
        let streets = [street(3, 40.0), street(0, 41.0)];
        let dir = tempfile::tempdir().unwrap();
        assert_eq!(read_streets(dir.path()).unwrap(), []);
        write_streets(dir.path(), &streets).unwrap();
        let expected = [
            (0, vec![vec![[-111.0, 41.0], [-111.0, 41.12346]]]),
            (3, vec![vec![[-111.0, 40.0], [-111.0, 40.12346]]]),
        ];
        assert_eq!(read_streets(dir.path()).unwrap(), expected);
    }

    #[test]
    fn names_are_those_of_intersections_and_a_damaged_file_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let places = [("n1", Some("Main Street / 3rd Avenue")), ("n2", None)];
        let places = places.map(|(id, at)| (40.5, -111.0, json!({ "id": id, "streets": at })));
        write_places(dir.path(), places.into_iter()).unwrap();
        let names = read_names(dir.path()).unwrap();
        assert_eq!(names.len(), 1);
        assert_eq!(names["n1"].0, ["Main Street", "3rd Avenue"]);
        assert_eq!(names["n1"].1, (40.5, -111.0));
        fs::write(dir.path().join(INTERSECTIONS_FILE), "[]").unwrap();
        let e = read_names(dir.path()).unwrap_err().to_string();
        assert!(e.contains("intersections.geojson") && e.contains("build"), "{e}");
    }
}
