//! Points as texts: `POINT (longitude latitude)`, as databases and portals write them.

use serde::Deserialize;

use super::error::brief;

/// A point as GeoJSON, which portals of CKAN write into cells.
#[derive(Deserialize)]
#[serde(tag = "type", content = "coordinates")]
enum GeoJson {
    Point(Vec<f64>),
    MultiPoint([Vec<f64>; 1]),
}

/// Returns latitude and longitude, degrees, of a text such as `POINT (-111.9 40.7)`, `SRID=4326;POINT Z(-111.9 40.7 3)`,
/// `(40.7, -111.9)`, which portals of Socrata write, or `{"type": "Point", "coordinates": [-111.9, 40.7]}`.
///
/// # Errors
///
/// What is expected instead.
pub(super) fn point(text: &str) -> Result<(f64, f64), String> {
    let wrong = || {
        format!(
            "{:?}: expected POINT (longitude latitude), such as POINT (-111.89 40.76)",
            brief(text)
        )
    };
    if text.trim_start().starts_with('{') {
        let (GeoJson::Point(at) | GeoJson::MultiPoint([at])) =
            serde_json::from_str(text).map_err(|_| wrong())?;
        return match at[..] {
            [longitude, latitude] | [longitude, latitude, _] => Ok((latitude, longitude)),
            _ => Err(wrong()),
        };
    }
    let plain = text.trim().to_uppercase();
    let plain = plain.split_once(';').map_or(plain.as_str(), |(_, rest)| rest).trim();
    let kind = plain.split('(').next().unwrap_or_default().trim();
    let inner = plain
        .split_once('(')
        .and_then(|(_, rest)| rest.trim().strip_suffix(')'))
        .ok_or_else(wrong)?;
    // MULTIPOINT ((x y)) has two pairs of parentheses.
    let inner = inner.trim().trim_start_matches('(').trim_end_matches(')');
    let numbers: Option<Vec<f64>> =
        inner.split([' ', ',']).filter(|n| !n.is_empty()).map(|n| n.parse().ok()).collect();
    let numbers = numbers.ok_or_else(wrong)?;
    let words: Vec<&str> = kind.split_whitespace().collect();
    match (&words[..], &numbers[..]) {
        ([], [latitude, longitude]) => Ok((*latitude, *longitude)),
        (["POINT" | "MULTIPOINT"], [longitude, latitude])
        | (["POINT" | "POINTZ" | "POINTM", ..], [longitude, latitude, _])
        | (["POINT" | "POINTZM", ..], [longitude, latitude, _, _]) => Ok((*latitude, *longitude)),
        _ => Err(wrong()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_read_as_they_are_published() {
        for text in [
            "POINT (-111.9 40.7)",
            "point(-111.9 40.7)",
            "POINT Z (-111.9 40.7 1200)",
            "SRID=4326;POINT(-111.9 40.7)",
            "MULTIPOINT ((-111.9 40.7))",
            "(40.7, -111.9)",
            r#"{"type": "Point", "coordinates": [-111.9, 40.7]}"#,
            r#"{"coordinates": [[-111.9, 40.7, 3.0]], "type": "MultiPoint"}"#,
        ] {
            assert_eq!(point(text), Ok((40.7, -111.9)), "{text}");
        }
        for text in [
            "",
            "POINT",
            "POINT ()",
            "POINT (1)",
            "LINESTRING (1 2)",
            "MULTIPOINT (1 2, 3 4)",
            "1 2",
            r#"{"type": "Point", "coordinates": [1]}"#,
            r#"{"type": "MultiPoint", "coordinates": [[1, 2], [3, 4]]}"#,
            r#"{"type": "LineString", "coordinates": [[1, 2]]}"#,
        ] {
            assert!(point(text).is_err(), "{text}");
        }
    }
}
