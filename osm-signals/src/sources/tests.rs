//! Tests of lists in other shapes than CSV.

use serde_json::json;

use super::*;
use crate::signals::{SignalColumns, SignalList};

fn read(bytes: &[u8], name: &str) -> Result<Vec<(String, f64, f64, u64)>, String> {
    let list = SignalList::from_bytes(bytes, Path::new(name), &SignalColumns::default());
    let list = list.map_err(|e| e.to_string())?;
    let of = |s: &crate::signals::ListedSignal| {
        (s.id.clone(), s.place.latitude(), s.place.longitude(), s.line)
    };
    Ok(list.signals.iter().map(of).collect())
}

fn geojson(second: &serde_json::Value) -> String {
    let feature = |id: &str, geometry: serde_json::Value| json!({"type": "Feature", "properties": {"SIGNAL ID": id, "lat": 1}, "geometry": geometry});
    let first = feature("a", json!({"type": "Point", "coordinates": [-111.9, 40.7]}));
    json!({"type": "FeatureCollection", "features": [first, feature("b", second.clone())]})
        .to_string()
}

fn two(lines: [u64; 2]) -> Vec<(String, f64, f64, u64)> {
    vec![("a".to_owned(), 40.7, -111.9, lines[0]), ("b".to_owned(), 40.8, -111.8, lines[1])]
}

#[test]
fn geojson_points_are_a_list() {
    let second = json!({"type": "Point", "coordinates": [-111.8, 40.8]});
    assert_eq!(read(geojson(&second).as_bytes(), "s.geojson").unwrap(), two([1, 2]));
    let line = json!({"type": "LineString", "coordinates": [[0, 1], [1, 1]]});
    let reason = read(geojson(&line).as_bytes(), "s.geojson").unwrap_err();
    assert_eq!(reason, "s.geojson, feature 2: a LineString; a Point is needed");
    let outside = json!({"type": "Point", "coordinates": [40.8, -111.8]});
    let reason = read(geojson(&outside).as_bytes(), "s.geojson").unwrap_err();
    assert!(reason.starts_with("s.geojson, feature 2: ") && reason.contains("swap"), "{reason}");
}

#[test]
fn what_is_no_list_is_refused() {
    for bytes in [&b"PK\x03\x04nonsense"[..], b"\0\0\x27\x0a\0", b"\xd0\xcf\x11\xe0\0"] {
        let reason = read(bytes, "s.zip").unwrap_err();
        assert!(reason.contains("save it as CSV or GeoJSON"), "{reason}");
    }
}

#[test]
fn midnight_has_its_time_in_a_column_of_times() {
    let excel = |days, is_1904| {
        Data::DateTime(ExcelDateTime::new(days, calamine::ExcelDateTimeType::DateTime, is_1904))
    };
    let column = |cells: [Data; 2]| {
        let mut range = Range::new((0, 0), (1, 0));
        for (row, data) in (0..).zip(cells) {
            range.set_value((row, 0), data);
        }
        texts(&range).concat()
    };
    let both = ["2026-11-05 00:00:00", "2026-11-05 07:15:00"];
    assert_eq!(column([excel(46_331.0, false), excel(46_331.302_083_333_3, false)]), both);
    assert_eq!(column([excel(44_869.0, true), excel(44_869.302_083_333_3, true)]), both);
    assert_eq!(column([excel(0.0, false), excel(0.25, false)]), ["00:00:00", "06:00:00"]);
    // Days with few decimals are before their second.
    let both = ["2026-11-05 00:30:00", "2026-11-06 00:00:00"];
    assert_eq!(column([excel(46_331.020_833_3, false), excel(46_331.999_999_9, false)]), both);
    assert_eq!(column([excel(44_869.020_833_3, true), excel(44_869.999_999_9, true)]), both);
    assert_eq!(column([excel(0.020_833, false), excel(0.25, false)]), ["00:30:00", "06:00:00"]);
    // A column of dates, and of numbers with the form of a date.
    assert_eq!(
        column([excel(46_331.0, false), excel(46_332.0, false)]),
        ["2026-11-05", "2026-11-06"]
    );
    assert_eq!(column([excel(0.0, false), excel(45.0, false)]), ["0", "45"]);
}
