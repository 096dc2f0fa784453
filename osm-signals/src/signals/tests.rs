//! Tests of reading lists.

use super::*;

fn read(text: &str) -> Result<Vec<ListedSignal>, String> {
    SignalList::from_bytes(text.as_bytes(), Path::new("s.csv"), &SignalColumns::default())
        .map(|list| list.signals)
        .map_err(|e| e.to_string())
}

#[test]
fn a_list_keeps_ids_places_and_lines() {
    let signals = read("SIGNAL,TYPE,LAT,LNG\n1001,Signal,40.78,-111.92\n").unwrap();
    let place = Place::from_degrees(40.78, -111.92).unwrap();
    assert_eq!(signals, [ListedSignal { id: "1001".into(), place, line: 2, controller: None }]);
}

fn list(text: &str, columns: &str) -> Result<SignalList, String> {
    let columns: SignalColumns = toml::from_str(columns).unwrap();
    SignalList::from_bytes(text.as_bytes(), Path::new("s.csv"), &columns).map_err(|e| e.to_string())
}

const MIXED: &str = "ID,Type,the_geom\n1,SIGNAL,POINT (-111 40)\n2,Beacon,POINT (-111.1 40)\n\
                     3,PENDING SIGNAL,\"SRID=4326;POINT Z(-111.2 40 7)\"\n4,Signal,\n";

#[test]
fn a_place_may_be_a_text() {
    let signals = read(MIXED).unwrap();
    let at = |lat, lon| Place::from_degrees(lat, lon).unwrap();
    let places = [at(40.0, -111.0), at(40.0, -111.1), at(40.0, -111.2), at(0.0, 0.0)];
    assert_eq!(signals.iter().map(|s| s.place).collect::<Vec<_>>(), places);
    let named = list("n,Where\n1,POINT(-111 40)\n", "point = \"where\"").unwrap();
    assert_eq!(named.signals[0].place, places[0]);
    let reason = read("id,shape\n1,LINESTRING (1 2)\n").unwrap_err();
    assert!(reason.starts_with("s.csv, line 2: ") && reason.contains("POINT"), "{reason}");
    let swapped = read("id,shape\n1,POINT (40 -111)\n").unwrap_err();
    assert!(swapped.contains("swap latitude and longitude"), "{swapped}");
}

#[test]
fn rows_are_chosen_by_their_columns() {
    let ids = |keep: &str| {
        let list = list(MIXED, &format!("where = {keep}"))?;
        let ids = list.signals.iter().map(|s| s.id.as_str()).collect::<Vec<_>>().join(" ");
        Ok::<_, String>((ids, list.left_out, list.doubts.len()))
    };
    assert_eq!(ids("[\"type=signal\"]"), Ok(("1 4".to_owned(), 2, 0)));
    assert_eq!(ids("[\"Type=Signal\", \"Type=beacon\"]"), Ok(("1 2 4".to_owned(), 1, 0)));
    assert_eq!(ids("[\"Type!=Beacon\", \"ID!=4\"]"), Ok(("1 3".to_owned(), 2, 0)));
    assert_eq!(
        ids("[\"type=sgnal\"]").unwrap_err(),
        "s.csv: no row is as asked for; column Type has Beacon (1), PENDING SIGNAL (1), SIGNAL (1), Signal (1)"
    );
    assert!(ids("[\"kind=x\"]").unwrap_err().contains("no column \"kind\""));
    assert!(ids("[\"x\"]").unwrap_err().contains("expected COLUMN=VALUE"));
}

#[test]
fn rows_without_a_place_are_kept_to_be_named() {
    let signals = read("id,lat,lon\n1,40,-111\n2,,\n").unwrap();
    assert_eq!((signals[1].place.latitude_e7, signals[1].place.longitude_e7), (0, 0));
    assert!(read("id,lat,lon\n1,40,\n").is_err());
}

#[test]
fn the_number_of_a_signal_goes_before_the_id_of_its_row() {
    for (columns, row, id, doubts) in [
        ("ID,Signal ID", "1,1001", "1001", 0),
        ("OBJECTID,SIGNAL_NUM", "1,107", "107", 0),
        ("OBJECTID,Signal No.", "1,107", "107", 0),
        ("node,objectid", "7,8", "7", 0),
        ("name,id", "7,8", "8", 0),
        ("OBJECTID,x1", "7,8", "1", 1),
        ("a,b", "7,8", "1", 1),
    ] {
        let one = list(&format!("{columns},lat,lon\n{row},40,-111\n"), "").unwrap();
        assert_eq!((&*one.signals[0].id, one.doubts.len()), (id, doubts), "{columns}");
    }
    let given = list("id,signal_id,lat,lon\n1,1001,40,-111\n", "id = \"id\"").unwrap();
    assert_eq!(given.signals[0].id, "1");
}

#[test]
fn a_list_without_an_id_or_a_place_or_with_two_of_one_id_is_refused() {
    for text in [
        "id,y,x\n7,40,-111\n8,41,-111\n7,40,-111\n",
        "id,y,x\n,40,-111\n",
        "id,y,x\n",
        "id,lat,lon\n7,,\n",
    ] {
        assert!(read(text).is_err(), "{text}");
    }
}

#[test]
fn what_may_be_no_signal_is_told() {
    let kinds =
        ["Full Signal", "Half Signal", "PHB", "HAWK", "Mid-block", "Fire Station", "Beacon"];
    let row = |(i, kind): (usize, &&str)| format!("{i},{kind},40,-111.{i}\n");
    let rows: String = kinds.iter().enumerate().map(row).collect();
    let doubts = list(&format!("id,TYPE,latitude,longitude\n{rows}"), "").unwrap().doubts;
    assert_eq!(
        doubts,
        [
            "6 rows may be no signals: column TYPE has Beacon (1), Fire Station (1), HAWK (1), Half Signal (1), \
             Mid-block (1), PHB (1); leave them out with --signals-where, such as 'TYPE!=Beacon'"
        ]
    );
}

#[test]
fn signals_far_from_the_first_of_their_controller_stay_intersections_of_their_own() {
    // 0.001 degrees of latitude are 111 m.
    let text = "id,lat,lon,controller_id\n1,40.000,-111,A\n2,40.002,-111,A\n3,40.010,-111,A\n4,40.020,-111,B\n";
    let list = list(text, "").unwrap();
    let controllers: Vec<_> = list.signals.iter().map(|s| s.controller.as_deref()).collect();
    assert_eq!(controllers, [Some("A"), Some("A"), None, Some("B")]);
    assert_eq!(list.doubts.len(), 1);
}

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
