//! Points as texts: `POINT (longitude latitude)`, as databases and portals write them.

use super::error::brief;

/// Returns latitude and longitude, degrees, of a text such as `POINT (-111.9 40.7)`, `SRID=4326;POINT Z(-111.9 40.7 3)`,
/// `(40.7, -111.9)`, which portals of Socrata write, or `{"type": "Point", "coordinates": [-111.9, 40.7]}`.
///
/// # Errors
///
/// What is expected instead.
pub(super) fn point(text: &str) -> Result<(f64, f64), String> {
    let found = || {
        let (kind, rest) = text.split_once(['(', '['])?;
        let (inner, _) = rest.rsplit_once([')', ']'])?;
        let numbers = inner.split([' ', ',', '(', ')', '[', ']']).filter(|n| !n.is_empty());
        let numbers: Vec<f64> = numbers.map(|n| n.parse().ok()).collect::<Option<_>>()?;
        match (kind.trim(), &numbers[..]) {
            ("", [latitude, longitude]) => Some((*latitude, *longitude)),
            ("", _) => None,
            (_, [longitude, latitude] | [longitude, latitude, _]) => {
                text.to_uppercase().contains("POINT").then_some((*latitude, *longitude))
            }
            _ => None,
        }
    };
    found().ok_or_else(|| {
        let text = brief(text);
        format!("{text:?}: expected POINT (longitude latitude), such as POINT (-111.89 40.76)")
    })
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
