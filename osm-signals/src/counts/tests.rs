//! Tests of reading counts.

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
    assert_eq!((counts.count, &*counts.field), (1, "AADT2021"));
    assert_eq!(counts.along(&street(), 2).unwrap().id, "0015_301.7");
    let oddities: Vec<_> =
        counts.oddities.iter().map(|(r, o)| format!("{r}: {}", o.example)).collect();
    assert_eq!(
        oddities,
        [
            "geometry other than lines: feature 4",
            "missing count: feature 2",
            "negative count: feature 3, id 8"
        ]
    );
    assert_eq!(counts.bounds.max().y, 40.71);
}

#[test]
fn stations_are_read_from_a_table() {
    let counts = read("id,lat,lon,AADT,bearing_deg\nA,40.703,-111.9,8000,2\nB,40,-111,,\n");
    let counts = counts.unwrap();
    let found = counts.along(&street(), 2).unwrap();
    assert_eq!((found.aadt_veh_per_day, &*found.id), (8000.0, "A"));
    assert_eq!(counts.oddities.count("missing count"), 1);
    let without = read("lat,lon,AADT\n40.703,-111.9,8000\n").unwrap();
    assert_eq!(without.along(&street(), 2).unwrap().id, "line 2");
}

#[test]
fn an_unusable_file_is_refused() {
    let lines = |lines: Value| {
        let line = json!({ "type": "LineString", "coordinates": lines });
        collection(&[feature(json!({ "AADT": 5 }), line)]).to_string()
    };
    let of = |counts: [Value; 2]| {
        collection(&counts.map(|count| feature(json!({ "AADT": count }), line()))).to_string()
    };
    for text in [
        "",
        "lat,lon,aadt\n",
        "lat,lon,aadt\n40,-111,\"12,000\"\n",
        "lat,lon,aadt\n40,-111,12.300\n",
        // Two directions, or two years.
        "lat,lon,AADT,Direction\n40.703,-111.9,9000,EB\n40.703,-111.9,9000,WB\n",
        &of([json!(9000), json!(15000)]),
        &of([json!("8150"), json!("12.300")]),
        &of([json!("n/a"), json!(null)]),
        &collection(&[feature(json!({ "ROUTE": "0015" }), line())]).to_string(),
        &lines(json!([[424000, 4507000], [424000, 4508000]])),
        &lines(json!([[40.7, -111.9], [40.71, -111.9]])),
    ] {
        assert!(read(text).is_err(), "{text}");
    }
    for text in ["match_m = 0.0", "match_deg = 91.0", "max_veh_per_day_per_lane = nan"] {
        let settings: CountSettings = toml::from_str(text).unwrap();
        assert!(settings.check().is_err(), "{text}");
    }
}

#[test]
fn a_forecast_is_no_count() {
    let counts =
        read("lat,lon,AADT,Year\n40.703,-111.9,9000,2023\n40.703,-111.9,15000,2045\n").unwrap();
    assert_eq!(counts.along(&street(), 2).unwrap().aadt_veh_per_day, 9000.0);
    assert_eq!(counts.oddities.count("forecast of a year to come"), 1);
    let lines = [(9000, 2023), (15000, 2045)];
    let lines = lines.map(|(n, year)| feature(json!({ "AADT": n, "YEAR": year }), line()));
    let counts = read(&collection(&lines).to_string()).unwrap();
    assert_eq!(counts.along(&street(), 2).unwrap().aadt_veh_per_day, 9000.0);
}

fn chosen(names: &[&str]) -> Option<String> {
    choose(names, None).ok()
}

#[test]
fn the_only_name_or_else_the_latest_year_is_taken() {
    for (names, expected) in [
        (vec!["ROUTE", "AADT"], Some("AADT")),
        (vec!["aadt", "DOT_AADT"], Some("aadt")),
        (vec!["DOT_AADT", "DOT_AADTYR"], Some("DOT_AADT")),
        (vec!["AADT2019", "AADT2021", "AADT2018"], Some("AADT2021")),
        (vec!["AADT2023_Unrounded", "AADT2024_Unrounded"], Some("AADT2024_Unrounded")),
        (vec!["AADT2024_Unrounded", "AADT_2024"], Some("AADT_2024")),
        (vec!["aadt", "aadt_single_unit", "aadt_combination"], Some("aadt")),
        (vec!["AADT", "AADT2021"], Some("AADT2021")),
        // Trucks and forecasts are no counts of all vehicles.
        (vec!["AADT_TRUCK", "TOTAL_AADT"], Some("TOTAL_AADT")),
        (vec!["AADT_2023", "FUTURE_AADT_2045"], Some("AADT_2023")),
        (vec!["AADT2045", "DOT_AADT"], Some("DOT_AADT")),
        (vec!["AADT_SINGLE_UNIT", "AADT_COMBINATION"], None),
        (vec!["AHEAD_AADT", "BACK_AADT"], None),
        (vec!["AADT", "aadt"], None),
        (vec![], None),
    ] {
        assert_eq!(chosen(&names).as_deref(), expected, "{names:?}");
    }
    assert_eq!(choose(&["aadt", "AADT"], Some("AADT")).unwrap(), "AADT");
    assert_eq!(choose(&["Vol"], Some("vol")).unwrap(), "Vol");
    assert_eq!(
        choose(&["vol", "Vol"], Some("VOL")).unwrap_err(),
        "several names could be the count (VOL); the names are vol, Vol; give that of the counts as `field`"
    );
}

#[test]
fn what_counts_nothing_says_why() {
    assert_eq!(usable(Some(0.5), Some("2021")), Ok(0.5));
    for (number, year, reason) in [
        (None, None, "missing count"),
        (Some(f64::NAN), None, "count that is no number"),
        (Some(-1.0), None, "negative count"),
        (Some(0.0), None, "count of 0"),
        (Some(9.0), Some("2045"), "forecast of a year to come"),
    ] {
        assert_eq!(usable(number, year), Err(reason));
    }
}
