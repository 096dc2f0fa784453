//! Traffic counts (AADT) and their join to streets.
//!
//! Counts come as GeoJSON, a line per counted stretch of road, or as CSV, a row per count
//! station. A count is the traffic of a road in both directions, of a one-way road in its one.
//!
//! The join looks along a street, from its junction outwards, for counted lines that run beside
//! it. Taking the nearest line instead gives a street the traffic of a freeway that crosses above
//! it (which happened in the embedded family: 200,403 vehicles per day on one lane) or of the
//! street that it meets; so a line has to have the street's direction, has to stay near it, and
//! its count has to be possible on the street's lanes.

mod csv;
mod field;
mod geojson;
mod index;
mod samples;

use std::path::{Path, PathBuf};

use geo::Rect;
use serde::{Deserialize, Serialize};

use self::index::Index;
use super::error::{OsmError, brief};
use super::extract::Place;
use super::oddities::Oddities;
use super::table;
use crate::family::check::within;

/// Ends of the names of files that hold GeoJSON, also if they are empty.
const JSON: [&str; 2] = ["json", "geojson"];

/// Which number is the count and when a count belongs to a street.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CountSettings {
    /// Property or column with the count, vehicles per day; by default the one named AADT, that
    /// of the latest year if there are several.
    pub field: Option<String>,
    /// Greatest distance of the street from the counted line or station, metres.
    pub match_m: f64,
    /// Greatest angle between the axes of the street and of the counted line, degrees.
    pub match_deg: f64,
    /// Greatest count per lane of the street, vehicles per day; above it a count is taken for
    /// another road, such as a freeway above or beside.
    pub max_veh_per_day_per_lane: f64,
}

impl Default for CountSettings {
    fn default() -> Self {
        Self {
            field: None,
            // Half the width of a divided road of eight lanes with its median. In Salt Lake City
            // three quarters of the matches are within 4 m; at 30 m 69% of the arms have one and
            // 1.4% of streets moved by 60 m, where none is; 50 m finds 2% more arms and nearly
            // triples the wrong ones (tests/osm_salt_lake_city.rs).
            match_m: 30.0,
            // A grid of streets has its next axis at 90 degrees, a fork at 45.
            match_deg: 30.0,
            // More than twice what a signal with half the green lets through: 1900 veh/h of
            // saturation flow in a peak hour of 9% of the day give 10,500 vehicles per day. In
            // Salt Lake City 6 of 763 joined arms are above it, all on freeways.
            max_veh_per_day_per_lane: 25_000.0,
        }
    }
}

impl CountSettings {
    /// Checks the numbers.
    ///
    /// # Errors
    ///
    /// The setting and what is wrong with it.
    pub fn check(&self) -> Result<(), (&'static str, String)> {
        for (name, value, low, high) in [
            ("match_m", self.match_m, 1.0, 1000.0),
            ("match_deg", self.match_deg, 1.0, 90.0),
            ("max_veh_per_day_per_lane", self.max_veh_per_day_per_lane, 1.0, 1e6),
        ] {
            within(value, low, high).map_err(|expected| (name, format!("{value}: {expected}")))?;
        }
        Ok(())
    }
}

/// A count that belongs to a street.
#[derive(Debug, Clone, PartialEq)]
pub struct CountMatch {
    /// The count: annual average daily traffic of the road, vehicles per day, of both directions
    /// unless the road is one-way.
    pub aadt_veh_per_day: f64,
    /// Mean distance of the street from the counted line, metres.
    pub distance_m: f64,
    /// Mean angle between their axes, degrees; 0 for a station without a bearing.
    pub angle_deg: f64,
    /// Id of the counted line or station, or else its number in the file, such as `feature 7`.
    pub id: String,
}

/// Where something was counted.
#[derive(Debug, Clone, PartialEq)]
enum Shape {
    /// Along lines.
    Lines(Vec<Vec<Place>>),
    /// At a station, with the axis of its road in degrees clockwise from north if it is known.
    Station(Place, Option<f64>),
}

/// A line or station with its count.
#[derive(Debug, Clone, PartialEq)]
struct Counted {
    id: String,
    aadt_veh_per_day: f64,
    shape: Shape,
}

/// What a reader finds in a file.
struct Found {
    counted: Vec<Counted>,
    field: String,
    oddities: Oddities,
}

/// The counts of a file, to be joined to streets; at least one.
#[derive(Debug)]
pub struct Counts {
    index: Index,
    settings: CountSettings,
    field: String,
    oddities: Oddities,
}

impl Counts {
    /// Reads counts: GeoJSON with LineString and MultiLineString features in WGS 84, or CSV with
    /// latitude, longitude, aadt and, where they are known, bearing_deg (the axis of the street)
    /// and id. Which of the two a file is shows in its content.
    ///
    /// # Errors
    ///
    /// [`OsmError`] naming the file and the place: neither of the two, no property or column with
    /// counts, coordinates outside the world, no usable count at all, an unusable setting.
    pub fn read(path: &Path, settings: &CountSettings) -> Result<Self, OsmError> {
        Self::from_bytes(&table::bytes(path)?, path, settings)
    }

    /// Reads counts from the bytes of a file; `path` is for messages only.
    ///
    /// # Errors
    ///
    /// As [`Counts::read`].
    pub fn from_bytes(
        bytes: &[u8],
        path: &Path,
        settings: &CountSettings,
    ) -> Result<Self, OsmError> {
        settings.check().map_err(|(place, reason)| OsmError::Malformed {
            path: PathBuf::from(path),
            place: place.to_owned(),
            reason,
        })?;
        let text = table::utf8(bytes, path)?.trim_start();
        let ending =
            path.extension().is_some_and(|e| JSON.iter().any(|j| e.eq_ignore_ascii_case(j)));
        let json = text.starts_with(['{', '[', '<']) || (text.is_empty() && ending);
        let field = settings.field.as_deref();
        let Found { counted, field, oddities } =
            if json { geojson::read(bytes, path, field)? } else { csv::read(bytes, path, field)? };
        let nothing = || {
            let skipped: Vec<_> = oddities
                .iter()
                .map(|(reason, o)| format!("{} ({} times, first {})", reason, o.count, o.example))
                .collect();
            let skipped = if skipped.is_empty() { "none".to_owned() } else { skipped.join(", ") };
            let reason = format!(
                "no usable count in {}; skipped: {skipped}; give lines or stations with a \
                 number of vehicles per day",
                brief(&field)
            );
            OsmError::Nothing { path: PathBuf::from(path), reason }
        };
        let index = Index::new(counted).ok_or_else(nothing)?;
        Ok(Self { index, settings: settings.clone(), field, oddities })
    }

    /// Returns the count of a street, if one belongs to it.
    ///
    /// # Arguments
    ///
    /// * `street`: its places from the junction outwards, at least two.
    /// * `lanes_both_directions`: its lanes; tells which counts are possible.
    ///
    /// Of the street's first 150 m a place every 10 m is compared with the counted lines; a line
    /// has to be near at least half of them and to run in the same axis there. Of several lines
    /// the one wins that is near most of them, each weighted with how near it is.
    /// A station has to be beside the street and not where it meets others; the nearest one wins.
    pub fn along(&self, street: &[Place], lanes_both_directions: u32) -> Option<CountMatch> {
        self.index.along(street, lanes_both_directions, &self.settings)
    }

    /// Returns how many counts lay along a street that was asked for but are above what its lanes
    /// can carry ([`CountSettings::max_veh_per_day_per_lane`]), each once. If they are many, the
    /// setting is too small or the field is no daily traffic.
    pub fn over_cap(&self) -> usize {
        self.index.over_cap()
    }

    /// Returns how many lines or stations have a count.
    pub fn len(&self) -> usize {
        self.index.len()
    }

    /// Returns `false`: a file without any count is an error.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the property or column that was read.
    pub fn field(&self) -> &str {
        &self.field
    }

    /// Returns what was skipped and why.
    pub fn oddities(&self) -> &Oddities {
        &self.oddities
    }

    /// Returns the smallest box around all counts: x is the longitude and y the latitude, degrees.
    pub fn bounds(&self) -> Rect<f64> {
        self.index.bounds()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use serde_json::{Value, json};

    use super::*;

    fn read(text: &str) -> Result<Counts, String> {
        Counts::from_bytes(text.as_bytes(), Path::new("c"), &CountSettings::default())
            .map_err(|e| e.to_string())
    }

    fn feature(properties: Value, geometry: Value) -> Value {
        json!({ "type": "Feature", "properties": properties, "geometry": geometry })
    }

    fn line() -> Value {
        json!({ "type": "LineString", "coordinates": [[-111.9, 40.7, 1300], [-111.9, 40.71]] })
    }

    fn collection(features: &[Value]) -> Value {
        json!({ "type": "FeatureCollection", "features": features })
    }

    fn street() -> [Place; 2] {
        [40.701, 40.705].map(|latitude| Place::from_degrees(latitude, -111.9001).unwrap())
    }

    #[test]
    fn lines_are_read_with_ids_and_what_is_skipped_is_counted() {
        let many = json!({ "type": "MultiLineString", "coordinates": [line()["coordinates"]] });
        let point = json!({ "type": "Point", "coordinates": [0, 0] });
        let counts = read(
            &collection(&[
                feature(json!({ "SEGID": "0015_301.7", "AADT2021": "9000" }), many),
                feature(json!({ "AADT2021": null, "AADT2019": 5 }), line()),
                feature(json!({ "AADT2021": -1, "OBJECTID": 8 }), line()),
                feature(json!({ "AADT2021": 5 }), point),
            ])
            .to_string(),
        )
        .unwrap();
        assert_eq!((counts.len(), counts.field()), (1, "AADT2021"));
        assert_eq!(counts.along(&street(), 2).unwrap().id, "0015_301.7");
        let oddities: Vec<_> =
            counts.oddities().iter().map(|(r, o)| format!("{r}: {}", o.example)).collect();
        assert_eq!(
            oddities,
            [
                "geometry other than lines: feature 4",
                "missing count: feature 2",
                "negative count: feature 3, id 8"
            ]
        );
        assert_eq!(counts.bounds().max().y, 40.71);
    }

    #[test]
    fn stations_are_read_from_a_table() {
        let counts = read("id,lat,lon,AADT,bearing_deg\nA,40.703,-111.9,8000,2\nB,40,-111,,\n");
        let counts = counts.unwrap();
        let found = counts.along(&street(), 2).unwrap();
        assert_eq!((found.aadt_veh_per_day, &*found.id), (8000.0, "A"));
        assert_eq!(counts.oddities().count("missing count"), 1);
        let without = read("lat,lon,AADT\n40.703,-111.9,8000\n").unwrap();
        assert_eq!(without.along(&street(), 2).unwrap().id, "line 2");
    }

    #[test]
    fn an_unusable_file_is_refused_with_the_way_out() {
        let error = |text: &str| read(text).unwrap_err();
        let without = collection(&[feature(json!({ "ROUTE": "0015" }), line())]).to_string();
        assert!(error(&without).contains("no name has AADT in it; the names are ROUTE"));
        let utm =
            json!({ "type": "LineString", "coordinates": [[424000, 4507000], [424000, 4508000]] });
        let utm = collection(&[feature(json!({ "AADT": 5 }), utm)]).to_string();
        assert!(
            error(&utm).contains("feature 1: latitude 4507000, longitude 424000: looks projected")
        );
        let swapped =
            json!({ "type": "LineString", "coordinates": [[40.7, -111.9], [40.71, -111.9]] });
        let swapped = collection(&[feature(json!({ "AADT": 5 }), swapped)]).to_string();
        assert!(error(&swapped).contains("swap latitude and longitude"));
        let point = json!({ "type": "Point", "coordinates": [0, 0] });
        let points = collection(&[feature(json!({ "AADT": 5 }), point)]).to_string();
        assert_eq!(
            error(&points),
            "c: no usable count in AADT; skipped: geometry other than lines (1 times, first \
             feature 1); give lines or stations with a number of vehicles per day"
        );
        assert!(error("lat,lon,aadt\n").contains("no usable count in aadt; skipped: none"));
        assert!(error("lat,lon,aadt\n40,-111,\"12,000\"\n").contains("thousands separators"));
        assert!(error("lat,lon,aadt,bearing\n40,-111,9,400\n").contains("a bearing of 400"));
    }

    #[test]
    fn a_property_without_any_usable_value_is_named_with_an_example() {
        for value in [json!(null), json!(-1), json!("n/a")] {
            let features = [feature(json!({ "ROUTE": "x", "AADT": value }), line())];
            let error = read(&collection(&features).to_string()).unwrap_err();
            let expected = format!(
                "c, properties: AADT has no usable value (such as {value}); the names \
                 are AADT, ROUTE; give that of the counts as `field`"
            );
            assert_eq!(error, expected);
        }
    }

    #[test]
    fn an_empty_file_is_told_what_its_name_promises() {
        let error = |name: &str| {
            let counts = Counts::from_bytes(b" \n", Path::new(name), &CountSettings::default());
            counts.unwrap_err().to_string()
        };
        assert!(error("c.GeoJSON").contains("line 1: empty; GeoJSON with"), "{}", error("c.json"));
        assert!(error("c.csv").contains("empty; the first line has to name the columns"));
    }

    #[test]
    fn counts_above_what_lanes_carry_are_known_each_once() {
        let text = "id,lat,lon,AADT\nA,40.703,-111.9,90000\nB,40.704,-111.9,60000\n\
                    far,41,-111.9,90000\n";
        let counts = read(text).unwrap();
        assert_eq!(counts.over_cap(), 0);
        assert_eq!((counts.along(&street(), 2), counts.over_cap()), (None, 2));
        assert_eq!((counts.along(&street(), 1), counts.over_cap()), (None, 2));
        assert!(counts.along(&street(), 4).is_some());
    }

    #[test]
    fn a_page_of_several_is_noticed() {
        let mut page = collection(&[feature(json!({ "AADT": 5 }), line())]);
        page["properties"] = json!({ "exceededTransferLimit": true });
        let counts = read(&page.to_string()).unwrap();
        assert_eq!(counts.oddities().count("file that is one page of several"), 1);
    }

    #[test]
    fn settings_out_of_range_are_refused() {
        for text in ["match_m = 0.0", "match_deg = 91.0", "max_veh_per_day_per_lane = nan"] {
            let settings: CountSettings = toml::from_str(text).unwrap();
            let error = Counts::from_bytes(b"", Path::new("c"), &settings).unwrap_err().to_string();
            assert!(error.contains("expected a number from 1 to"), "{error}");
        }
        assert!(toml::from_str::<CountSettings>("factor = 2").is_err());
    }

    /// JSON like that of counts, with anything in it.
    fn any_json() -> impl Strategy<Value = Value> {
        let leaf = prop_oneof![
            Just(json!(null)),
            (-1e7..1e7).prop_map(|n: f64| json!(n)),
            Just(json!([[-111.9, 40.7], [-111.9, 40.71]])),
            "(LineString|Polygon|GeometryCollection|Feature|EPSG:3857|9000)".prop_map(Value::from),
        ];
        let key = "(type|coordinates|geometry|geometries|properties|features|AADT|id|crs|bbox)";
        leaf.prop_recursive(4, 24, 4, move |inner| {
            prop_oneof![
                prop::collection::vec(inner.clone(), 0..4).prop_map(Value::from),
                prop::collection::hash_map(key, inner, 0..5)
                    .prop_map(|m| Value::Object(m.into_iter().collect())),
            ]
        })
    }

    proptest! {
        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            drop(Counts::from_bytes(&bytes, Path::new("c"), &CountSettings::default()));
        }

        #[test]
        fn any_rows_are_read_or_refused(rows in "[0-9;,.\"\\-\r\n a]{0,80}") {
            drop(read(&format!("lat,lon,aadt,bearing\n{rows}")));
        }

        #[test]
        fn any_features_are_read_or_refused(
            features in prop::collection::vec((any_json(), any_json(), any_json()), 0..4),
        ) {
            let features: Vec<_> = features
                .into_iter()
                .map(|(properties, geometry, coordinates)| match geometry {
                    Value::Object(_) => feature(properties, geometry),
                    _ => feature(
                        json!({ "AADT": properties }),
                        json!({ "type": "LineString", "coordinates": coordinates }),
                    ),
                })
                .collect();
            drop(read(&collection(&features).to_string()));
        }
    }
}
