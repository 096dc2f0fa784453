//! GeoJSON that users bring, in WGS 84 as its standard (RFC 7946) has it.
//!
//! Portals offer several kinds of JSON under similar names, and the coordinates of some are
//! projected; each comes with the way out.

use std::path::{Path, PathBuf};

use geojson::{JsonObject, JsonValue, Position};
use serde::de::DeserializeOwned;
use serde_json::Error;

use super::error::{OsmError, brief, shortened};
use super::extract::Place;
use super::geometry::checked_place;
use super::table;

/// Names of reference systems whose coordinates are longitude and latitude in degrees. NAD 83 is
/// within 2 m of WGS 84, less than streets are wide.
const DEGREES: [&str; 4] = ["CRS84", "4326", "WGS84", "4269"];

/// Most characters of what the parser says.
const PARSER_CHARS: usize = 200;

/// Members that Esri's own JSON has and GeoJSON has not.
const ESRI: [&str; 3] = ["spatialReference", "geometryType", "displayFieldName"];

/// Reads GeoJSON of one type; `expected` is what messages call it.
///
/// # Errors
///
/// [`OsmError`] naming the file and, where known, line and column.
pub(super) fn read<T: DeserializeOwned>(
    bytes: &[u8],
    path: &Path,
    expected: &str,
) -> Result<T, OsmError> {
    let text = &*table::text(bytes, path)?;
    serde_json::from_str(text).map_err(|e| {
        if text.trim().is_empty() {
            return malformed(path, "line 1", format!("empty; {expected} is needed"));
        }
        let at = |e: &Error| format!("line {}, column {}", e.line().max(1), e.column());
        match serde_json::from_str::<JsonValue>(text) {
            Ok(JsonValue::Object(object)) => {
                malformed(path, at(&e), other_json(&object, &parser_message(&e), expected))
            }
            Ok(_) => malformed(path, "line 1", format!("no JSON object; {expected} is needed")),
            Err(e) => {
                let reason = format!("no JSON ({}); {expected} is needed", parser_message(&e));
                malformed(path, at(&e), reason)
            }
        }
    })
}

/// Checks that a `crs` member, which older GeoJSON has, does not name a projection.
///
/// # Errors
///
/// [`OsmError::Malformed`] with what it names.
pub(super) fn check_crs(members: Option<&JsonObject>, path: &Path) -> Result<(), OsmError> {
    let Some(crs) = members.and_then(|m| m.get("crs")).filter(|crs| !crs.is_null()) else {
        return Ok(());
    };
    let name = crs.pointer("/properties/name").and_then(JsonValue::as_str);
    let plain = name.map(|n| n.to_uppercase().replace(' ', ""));
    if plain.is_some_and(|n| DEGREES.iter().any(|d| n.ends_with(d))) {
        return Ok(());
    }
    let name = brief(&name.map_or_else(|| crs.to_string(), str::to_owned));
    Err(malformed(path, "crs", format!("coordinates are in {name}; export as WGS 84 (EPSG:4326)")))
}

/// Returns a position of a geometry as a place.
///
/// # Errors
///
/// What is wrong and the way out.
pub(super) fn place(position: &Position) -> Result<Place, String> {
    match position.as_slice() {
        [longitude, latitude, ..] => checked_place(*latitude, *longitude),
        _ => Err("a position needs longitude and latitude".to_owned()),
    }
}

/// Returns an error of a file at a place.
pub(super) fn malformed(
    path: &Path,
    place: impl Into<String>,
    reason: impl Into<String>,
) -> OsmError {
    OsmError::Malformed { path: PathBuf::from(path), place: place.into(), reason: reason.into() }
}

/// Returns what the parser says, without the place, which stands before it, and without names of
/// types of this program.
fn parser_message(error: &Error) -> String {
    let full = error.to_string();
    let message = full.split(" at line ").next().unwrap_or_default();
    let message = message.split(", expected struct ").next().unwrap_or_default();
    shortened(message, PARSER_CHARS)
}

/// Says what JSON is that is not as expected.
fn other_json(object: &JsonObject, error: &str, expected: &str) -> String {
    if let Some(message) = object.get("error") {
        let message = brief(&message.to_string());
        return format!("the answer of a server that failed ({message}); fetch the file again");
    }
    if ESRI.iter().any(|member| object.contains_key(*member)) {
        return "Esri's JSON, not GeoJSON; export as GeoJSON (of a feature service: f=geojson)"
            .to_owned();
    }
    match object.get("type").and_then(JsonValue::as_str) {
        Some("Topology") => "TopoJSON, not GeoJSON; export as GeoJSON".to_owned(),
        Some(kind) => {
            format!("a {} that cannot be used ({error}); {expected} is needed", brief(kind))
        }
        None => format!("no GeoJSON ({error}); {expected} is needed"),
    }
}

#[cfg(test)]
mod tests {
    use geojson::FeatureCollection;
    use serde_json::json;

    use super::*;

    fn error(text: &str) -> String {
        let read = read::<FeatureCollection>(
            text.as_bytes(),
            Path::new("f.geojson"),
            "a FeatureCollection",
        );
        read.unwrap_err().to_string()
    }

    #[test]
    fn other_kinds_of_json_are_recognised() {
        assert!(error("").contains("empty; a FeatureCollection is needed"));
        assert!(error("<html>").contains("line 1, column 1: no JSON (expected value)"));
        for text in ["[]", "[{\"type\":\"Feature\"}]", "3"] {
            assert_eq!(
                error(text),
                "f.geojson, line 1: no JSON object; a FeatureCollection is needed"
            );
        }
        assert_eq!(
            error("{\"type\":\"FeatureCollection\",\"features\":[7]}"),
            "f.geojson, line 1, column 41: a FeatureCollection that cannot be used (invalid type: \
             integer `7`); a FeatureCollection is needed"
        );
        assert!(error("{\"type\":").contains("EOF"));
        assert!(error("{\"geometryType\":\"esriGeometryPolyline\"}").contains("f=geojson"));
        assert!(error("{\"type\":\"Topology\",\"arcs\":[]}").contains("TopoJSON"));
        assert!(error("{\"error\":{\"code\":400}}").contains("a server that failed"));
        assert!(error("{\"type\":\"Point\",\"coordinates\":[1,2]}").contains("a Point that"));
    }

    #[test]
    fn a_damaged_feature_is_named_by_line_and_column() {
        let text = "{\"type\":\"FeatureCollection\",\"features\":[\n{\"type\":\"Feature\",\
                    \"properties\":null,\"geometry\":{\"type\":\"LineString\",\
                    \"coordinates\":[[1,\"2\"]]}}]}";
        assert!(error(text).starts_with("f.geojson, line 2, column"), "{}", error(text));
    }

    #[test]
    fn only_reference_systems_in_degrees_are_taken() {
        let check = |crs: JsonValue| {
            let members = json!({ "crs": crs });
            check_crs(members.as_object(), Path::new("f")).map_err(|e| e.to_string())
        };
        let named = |name: &str| json!({ "type": "name", "properties": { "name": name } });
        assert_eq!(check(JsonValue::Null), Ok(()));
        assert_eq!(check(named("urn:ogc:def:crs:OGC:1.3:CRS84")), Ok(()));
        assert_eq!(check(named("EPSG:4326")), Ok(()));
        assert_eq!(
            check(named("urn:ogc:def:crs:EPSG::26912")).unwrap_err(),
            "f, crs: coordinates are in urn:ogc:def:crs:EPSG::26912; export as WGS 84 (EPSG:4326)"
        );
        assert!(check(json!({ "type": "link" })).unwrap_err().contains("{\"type\":\"link\"}"));
    }
}
