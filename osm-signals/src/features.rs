//! GeoJSON that users bring, in WGS 84 as its standard (RFC 7946) has it.
//!
//! The coordinates of some are projected; that comes with the way out.

use std::path::Path;

use geojson::Position;
use serde::de::DeserializeOwned;

use super::error::{OsmError, malformed, shortened};
use super::extract::Place;
use super::geometry::checked_place;
use super::table;

/// Most characters of what the parser says.
const PARSER_CHARS: usize = 200;

/// Reads GeoJSON of one type; `expected` is what messages call it.
pub(super) fn read<T: DeserializeOwned>(
    bytes: &[u8],
    path: &Path,
    expected: &str,
) -> Result<T, OsmError> {
    let text = &*table::text(bytes, path)?;
    serde_json::from_str(text).map_err(|e| {
        let message = e.to_string();
        let message = message.split(" at line ").next().unwrap_or_default();
        let message = shortened(message, PARSER_CHARS);
        let at = format!("line {}, column {}", e.line().max(1), e.column());
        malformed(
            path,
            at,
            format!("{message}; {expected} is needed, as exports to GeoJSON have it"),
        )
    })
}

pub(super) fn place(position: &Position) -> Result<Place, String> {
    match position.as_slice() {
        [longitude, latitude, ..] => checked_place(*latitude, *longitude),
        _ => Err("a position needs longitude and latitude".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geojson::FeatureCollection;

    fn error(text: &str) -> String {
        let read = read::<FeatureCollection>(
            text.as_bytes(),
            Path::new("f.geojson"),
            "a FeatureCollection",
        );
        read.unwrap_err().to_string()
    }

    #[test]
    fn other_kinds_of_json_are_refused_with_what_is_needed() {
        for text in ["", "<html>", "[]", "{\"type\":", "{\"geometryType\":\"x\"}", "{\"error\":7}"]
        {
            assert!(error(text).contains("; a FeatureCollection is needed"), "{}", error(text));
        }
    }

    #[test]
    fn a_damaged_feature_is_named_by_line_and_column() {
        let text = "{\"type\":\"FeatureCollection\",\"features\":[\n{\"type\":\"Feature\",\
                    \"properties\":null,\"geometry\":{\"type\":\"LineString\",\
                    \"coordinates\":[[1,\"2\"]]}}]}";
        assert!(error(text).starts_with("f.geojson, line 2, column"), "{}", error(text));
    }
}
