//! The files of a city beside its networks.

use std::collections::BTreeMap;
use std::path::Path;

use geojson::{Feature, FeatureCollection, GeometryValue, JsonObject, JsonValue};
use osm_signals::traffic::InflowSource;

use super::folder::{FAMILY_FILE, MATCHES_FILE};
use super::quality::{ListedRow, Quality};
use super::sites::City;
use super::spots::Spot;
use super::surroundings::INTERSECTIONS_FILE;
use crate::family::load::LoadedScenario;
use basics::files::{FileError, lines, write_atomically};
use evaluation::family::MdpFamily;

/// Digits after the point of a share.
const SHARE_DIGITS: i32 = 4;

/// Writes the point MDPs as a table: id, importance, intersections and features.
///
/// # Errors
///
/// [`FileError`].
pub(super) fn write_family(folder: &Path, family: &MdpFamily) -> Result<(), FileError> {
    let names = family.features.iter().map(|f| f.name.clone());
    let head = ["point", "importance", "intersections"].map(str::to_owned);
    let mut rows: Vec<Vec<String>> = vec![head.into_iter().chain(names).collect()];
    rows.extend(family.points.iter().map(|p| {
        let fixed = [p.id.clone(), p.importance.to_string(), p.instances.to_string()];
        fixed.into_iter().chain(p.features.iter().map(f64::to_string)).collect::<Vec<String>>()
    }));
    write_atomically(&folder.join(FAMILY_FILE), &lines(&rows))
}

/// Writes what became of every row of the signal list: its intersection, the distance, the reason.
///
/// # Errors
///
/// [`FileError`].
pub(super) fn write_matches(folder: &Path, listed: &[ListedRow]) -> Result<(), FileError> {
    write_atomically(&folder.join(MATCHES_FILE), &matches(listed))
}

/// Returns the table of [`write_matches`].
fn matches(listed: &[ListedRow]) -> Vec<u8> {
    let head = [
        "id", "row", "latitude", "longitude", "intersection", "distance_m", "signal_on_map",
        "duplicate_of_row", "reason",
    ];
    let mut rows = vec![head.map(str::to_owned)];
    rows.extend(listed.iter().map(|m| {
        let metres = m.distance_m.map(|metres| format!("{metres:.1}"));
        [
            m.id.clone(),
            m.line.to_string(),
            m.latitude.to_string(),
            m.longitude.to_string(),
            m.intersection.clone().unwrap_or_default(),
            metres.unwrap_or_default(),
            m.on_map.to_string(),
            m.duplicate_of.map(|line| line.to_string()).unwrap_or_default(),
            m.why().unwrap_or_default(),
        ]
    }));
    lines(&rows)
}

/// Writes `intersections.geojson`: intersections with their point MDP, its importance and features,
/// and how well they are known; and the signals that are none, with the reason.
///
/// # Errors
///
/// [`FileError`].
pub(super) fn write_geojson(
    folder: &Path,
    city: &City,
    quality: &Quality,
    loaded: &LoadedScenario,
) -> Result<(), FileError> {
    let mut point_of: BTreeMap<&str, usize> = BTreeMap::new();
    for (point, members) in loaded.members.iter().enumerate() {
        for i in members {
            // Of several periods the first.
            point_of.entry(loaded.intersections[*i].id.as_str()).or_insert(point);
        }
    }
    let rows = quality.spots.iter().enumerate().map(|(index, spot)| {
        let point = point_of.get(spot.id.as_str()).map(|p| &loaded.family.points[*p]);
        let mut properties = spot_properties(spot);
        properties.insert("point".to_owned(), point.map(|p| p.id.clone()).into());
        properties.insert("importance".to_owned(), point.map(|p| p.importance).into());
        for d in &quality.features {
            properties.insert(d.name.clone(), number(d.values[index], 2));
        }
        feature(spot.latitude, spot.longitude, properties)
    });
    let skipped = city.skipped().map(|s| {
        let mut properties = JsonObject::new();
        properties.insert("status".to_owned(), "skipped".into());
        properties.insert("reason".to_owned(), s.reason.words().into());
        let id = s.signals.first().map(|id| format!("n{id}"));
        properties.insert("id".to_owned(), id.into());
        feature(s.place.latitude(), s.place.longitude(), properties)
    });
    let features = rows.chain(skipped).collect();
    let collection = FeatureCollection { bbox: None, features, foreign_members: None };
    let text = serde_json::to_vec(&collection).expect("features are plain data");
    write_atomically(&folder.join(INTERSECTIONS_FILE), &text)
}

fn spot_properties(spot: &Spot) -> JsonObject {
    let known = number(spot.known, SHARE_DIGITS);
    let metres = |value: Option<f64>| value.map_or(JsonValue::Null, |v| number(v, 1));
    let pairs = [
        ("status", "intersection".into()),
        ("id", spot.id.clone().into()),
        ("streets", spot.streets.join(" / ").into()),
        ("arms", spot.arms.into()),
        ("signal_nodes", spot.signals.into()),
        ("known_share", known),
        ("inflow_sources", inflow_sources(spot).into()),
        ("flags", spot.flags.iter().map(|f| f.words()).collect::<Vec<_>>().join("; ").into()),
        ("list_distance_m", metres(spot.list_distance_m)),
        ("count_distance_m", metres(spot.count_distance_m)),
    ];
    pairs.into_iter().map(|(key, value)| (key.to_owned(), value)).collect()
}

/// Returns what the inflows of an intersection rest on, in the order of its approaches.
fn inflow_sources(spot: &Spot) -> String {
    let word = |source: &InflowSource| match source {
        InflowSource::Counted => "counted",
        InflowSource::Spread => "spread",
        InflowSource::Imputed => "imputed",
        InflowSource::Default => "default",
    };
    spot.inflow_sources.iter().map(word).collect::<Vec<_>>().join(", ")
}

fn feature(latitude: f64, longitude: f64, properties: JsonObject) -> Feature {
    Feature {
        geometry: Some(GeometryValue::new_point([longitude, latitude]).into()),
        properties: Some(properties),
        ..Feature::default()
    }
}

/// Returns a number with so many digits after the point.
fn number(value: f64, digits: i32) -> JsonValue {
    let scale = 10f64.powi(digits);
    ((value * scale).round() / scale).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_id_of_a_signal_list_is_no_formula() {
        let row = ListedRow {
            id: "=HYPERLINK(1)".to_owned(),
            line: 2,
            latitude: 40.5,
            longitude: -111.25,
            intersection: None,
            distance_m: None,
            on_map: false,
            reason: Some("too far"),
            duplicate_of: None,
        };
        let text = String::from_utf8(matches(&[row])).unwrap();
        assert_eq!(text.lines().nth(1), Some("'=HYPERLINK(1),2,40.5,-111.25,,,false,,too far"));
    }
}
