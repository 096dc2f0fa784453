//! What a city's folder keeps for the maps and tables of reports: the streets, `streets.geojson`, and
//! the names of the streets of every intersection, in `intersections.geojson`.

use std::collections::BTreeMap;
use std::path::Path;

use geojson::{
    Feature, FeatureCollection, GeoJson, GeometryValue, JsonObject, LineStringType, Position,
};
use osm_signals::tags::Highway;

use super::drawing::Drawing;
use super::error::CityError;
use basics::files::{self, limits, write_atomically};

/// Name of the file of streets.
pub const STREETS_FILE: &str = "streets.geojson";

/// Name of the file of intersections.
pub const INTERSECTIONS_FILE: &str = "intersections.geojson";

/// What stands between the streets of an intersection.
const BETWEEN: &str = " / ";

/// Names of the ranks, minor streets first.
const RANKS: [&str; 4] = ["minor", "tertiary", "secondary", "primary, trunk"];

/// Parts of a degree that coordinates of streets are rounded to: a metre.
const PER_DEGREE: f64 = 1e5;

/// The lines of the streets of one rank: longitude and latitude, degrees.
pub type Lines = Vec<Vec<[f64; 2]>>;

/// An intersection as it was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Named {
    /// Names of its streets.
    pub streets: Vec<String>,
    /// Latitude and longitude, degrees.
    pub at: (f64, f64),
}

/// Returns how important a street is when it is drawn: 0 for minor ones to 3.
pub fn rank(highway: Highway) -> usize {
    match highway {
        Highway::Trunk | Highway::Primary => 3,
        Highway::Secondary => 2,
        Highway::Tertiary => 1,
        _ => 0,
    }
}

/// Writes the streets around the intersections of a city, a feature per rank.
///
/// # Errors
///
/// [`CityError::Io`].
pub fn write_streets(folder: &Path, drawing: &Drawing) -> Result<(), CityError> {
    let rounded = |degrees: f64| (degrees * PER_DEGREE).round() / PER_DEGREE;
    let position = |p: &(f64, f64)| Position::from([rounded(p.1), rounded(p.0)]);
    let features = RANKS.iter().enumerate().filter_map(|(rank, name)| {
        let streets = drawing.streets.iter().filter(|s| self::rank(s.highway) == rank);
        let lines: Vec<LineStringType> =
            streets.map(|s| s.places.iter().map(position).collect()).collect();
        let mut properties = JsonObject::new();
        properties.insert("rank".to_owned(), rank.into());
        properties.insert("streets".to_owned(), (*name).into());
        (!lines.is_empty()).then(|| Feature {
            geometry: Some(GeometryValue::MultiLineString { coordinates: lines }.into()),
            properties: Some(properties),
            ..Feature::default()
        })
    });
    let features = features.collect();
    let collection = FeatureCollection { bbox: None, features, foreign_members: None };
    let text = serde_json::to_vec(&collection).expect("features are plain data");
    Ok(write_atomically(&folder.join(STREETS_FILE), &text)?)
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
        let rank = feature.property("rank").and_then(geojson::JsonValue::as_u64).unwrap_or(0);
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
        names.insert(id, Named { streets: streets.collect(), at: (*latitude, *longitude) });
    }
    Ok(names)
}

fn features(path: &Path) -> Result<Vec<Feature>, CityError> {
    let text = files::if_present(files::read_text(path, limits::DOCUMENT))?;
    let Some(text) = text else { return Ok(Vec::new()) };
    let collection = text.parse::<GeoJson>().and_then(FeatureCollection::try_from);
    match collection {
        Ok(collection) => Ok(collection.features),
        Err(reason) => Err(CityError::Folder { path: path.to_path_buf(), reason }),
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::super::drawing::DrawnStreet;
    use super::*;

    #[test]
    fn streets_read_back_by_rank_minor_ones_first() {
        let street = |highway, south: f64| DrawnStreet {
            highway,
            places: vec![(south, -111.0), (south + 0.123_456_789, -111.0)],
        };
        let streets = vec![street(Highway::Primary, 40.0), street(Highway::Residential, 41.0)];
        let drawing = Drawing { streets, ..Drawing::default() };
        let dir = tempfile::tempdir().unwrap();
        assert_eq!(read_streets(dir.path()).unwrap(), []);
        write_streets(dir.path(), &drawing).unwrap();
        let expected = [
            (0, vec![vec![[-111.0, 41.0], [-111.0, 41.12346]]]),
            (3, vec![vec![[-111.0, 40.0], [-111.0, 40.12346]]]),
        ];
        assert_eq!(read_streets(dir.path()).unwrap(), expected);
    }

    #[test]
    fn names_are_those_of_intersections_and_a_damaged_file_is_refused() {
        let dir = tempfile::tempdir().unwrap();
        let feature = |id: &str, streets: &str| {
            format!(
                r#"{{"type":"Feature","geometry":{{"type":"Point","coordinates":[-111,40.5]}},
                "properties":{{"id":"{id}"{streets}}}}}"#
            )
        };
        let (named, skipped) =
            (feature("n1", r#","streets":"Main Street / 3rd Avenue""#), feature("n2", ""));
        let text = format!(r#"{{"type":"FeatureCollection","features":[{named},{skipped}]}}"#);
        fs::write(dir.path().join(INTERSECTIONS_FILE), text).unwrap();
        let names = read_names(dir.path()).unwrap();
        assert_eq!(names.len(), 1);
        assert_eq!(names["n1"].streets, ["Main Street", "3rd Avenue"]);
        assert_eq!(names["n1"].at, (40.5, -111.0));
        fs::write(dir.path().join(INTERSECTIONS_FILE), "[]").unwrap();
        let e = read_names(dir.path()).unwrap_err().to_string();
        assert!(e.contains("intersections.geojson") && e.contains("build"), "{e}");
    }
}
