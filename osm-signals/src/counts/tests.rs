//! Tests of reading counts.

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
    assert!(error(&utm).contains("feature 1: latitude 4507000, longitude 424000: looks projected"));
    let swapped = json!({ "type": "LineString", "coordinates": [[40.7, -111.9], [40.71, -111.9]] });
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
fn a_count_that_may_have_thousands_separators_is_refused_with_both_meanings() {
    let both = "12300 if the point separates thousands, 12.3 if it separates decimals; write 12300 or 12.3";
    assert_eq!(
        read("id,lat,lon,AADT\nN,40.703,-111.9,12.300\nE,40.7,-111.8,8150\n").unwrap_err(),
        format!("c, line 2: column AADT: \"12.300\" has two meanings: {both}")
    );
    let texts = |texts: [&str; 2]| {
        read(&collection(&texts.map(|n| feature(json!({ "AADT": n }), line()))).to_string())
    };
    assert_eq!(
        texts(["8150", "12.300"]).unwrap_err(),
        format!("c, feature 2: AADT = \"12.300\": {both}")
    );
    assert_eq!(
        texts(["12,300", "8,150"]).unwrap_err(),
        "c, feature 1: AADT = \"12,300\": write numbers with a point and without thousands separators"
    );
    // Unrounded counts show what their points are.
    let unrounded = "lat,lon,AADT\n40.703,-111.9,9312.457\n40.75,-111.9,312.457\n";
    assert_eq!(read(unrounded).unwrap().len(), 2);
    assert!(texts(["312.457", "1312.45"]).unwrap_err().contains("feature 1 (312.457)"));
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
fn of_different_counts_at_one_place_none_is_taken() {
    let text = "id,lat,lon,AADT,direction\nN1,40.703,-111.9,12300,NB\nN2,40.703,-111.9,11300,SB\n";
    assert_eq!(
        read(text).unwrap_err(),
        "c: no usable count in AADT; skipped: different counts at one place, all left out; give one per \
         place, of both directions together (2 times, first N1 (12300, NB) and N2 (11300, SB)); give lines or \
         stations with a number of vehicles per day"
    );
    let counts = read(&format!("{text}E,40.75,-111.9,500,EB\n")).unwrap();
    assert_eq!((counts.len(), counts.along(&street(), 2)), (1, None));
    let equal = "lat,lon,AADT,Direction\n40.703,-111.9,9000,EB\n40.703,-111.9,9000,WB\n";
    assert!(read(equal).unwrap_err().contains("line 2 (9000, EB) and line 3 (9000, WB)"));
    let ways = ["NB", "SB"].map(|way| feature(json!({ "AADT": 9000, "DIR": way }), line()));
    assert!(read(&collection(&ways).to_string()).unwrap_err().contains("feature 1 (9000, NB) and"));
    let years = [9000, 15000].map(|n| feature(json!({ "AADT": n }), line()));
    assert!(read(&collection(&years).to_string()).unwrap_err().contains("feature 1 (9000) and"));
    let same = [9000, 9000].map(|n| feature(json!({ "AADT": n }), line()));
    assert_eq!(read(&collection(&same).to_string()).unwrap().len(), 1);
}

#[test]
fn a_forecast_is_no_count() {
    let counts =
        read("lat,lon,AADT,Year\n40.703,-111.9,9000,2023\n40.703,-111.9,15000,2045\n").unwrap();
    assert_eq!(counts.along(&street(), 2).unwrap().aadt_veh_per_day, 9000.0);
    assert_eq!(counts.oddities().count("forecast of a year to come"), 1);
    let lines = [(9000, 2023), (15000, 2045)];
    let lines = lines.map(|(n, year)| feature(json!({ "AADT": n, "YEAR": year }), line()));
    let counts = read(&collection(&lines).to_string()).unwrap();
    assert_eq!(counts.along(&street(), 2).unwrap().aadt_veh_per_day, 9000.0);
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
