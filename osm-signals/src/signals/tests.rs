//! Tests of reading lists.

use proptest::prelude::*;

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

#[test]
fn rows_without_an_id_column_are_numbered() {
    let list = list("y,x\n40,-111\n41,-111\n", "").unwrap();
    assert_eq!(list.signals.iter().map(|s| &*s.id).collect::<Vec<_>>(), ["1", "2"]);
    assert!(list.doubts[0].starts_with("no column has an id"), "{:?}", list.doubts);
}

#[test]
fn an_id_that_may_change_with_each_export_is_said() {
    for name in ["OBJECTID", "object_id"] {
        let one = list(&format!("{name},lat,lon\n7,40,-111\n"), "").unwrap();
        let doubt =
            format!("the id is {name}, which numbers the rows of a database and may change");
        assert!(one.doubts[0].starts_with(&doubt), "{:?}", one.doubts);
    }
    let given = list("OBJECTID,lat,lon\n7,40,-111\n", "id = \"objectid\"").unwrap();
    assert_eq!((&*given.signals[0].id, given.doubts.len()), ("7", 0));
}

#[test]
fn the_number_of_a_signal_goes_before_the_id_of_its_row_and_the_choice_is_said() {
    let both = list("ID,Signal ID,lat,lon\n1,1001,40,-111\n", "").unwrap();
    assert_eq!(both.signals[0].id, "1001");
    assert_eq!(
        both.doubts,
        [
            "several columns could be the id (Signal ID, ID), and Signal ID is used; name another one as `id` in \
             [signals] of the settings"
        ]
    );
    let given = list("id,signal_id,lat,lon\n1,1001,40,-111\n", "id = \"id\"").unwrap();
    assert_eq!((&*given.signals[0].id, given.doubts.len()), ("1", 0));
    for (columns, id) in [("node,objectid", "7"), ("int,name", "7"), ("name,id", "8")] {
        let one = list(&format!("{columns},lat,lon\n7,8,40,-111\n"), "").unwrap();
        assert_eq!((&*one.signals[0].id, one.doubts.len()), (id, 0), "{columns}");
    }
}

#[test]
fn the_number_of_a_signal_is_known_however_it_is_shortened() {
    for name in ["SIGNAL_NUM", "SignalNo", "Signal No.", "Signal #", "SIGNALNUMBER", "Sig-Num"] {
        let text = format!("OBJECTID,{name},lat,lon\n1,107,40,-111\n");
        assert_eq!(list(&text, "").unwrap().signals[0].id, "107", "{name}");
    }
}

#[test]
fn an_id_that_comes_twice_names_both_lines() {
    let reason = read("id,y,x\n7,40,-111\n8,41,-111\n7,40,-111\n").unwrap_err();
    assert_eq!(
        reason,
        "s.csv, line 4: signal 7 is on line 2 already; if these are two signals, name a column that \
         tells them apart (`id` in [signals] of the settings), else remove one of them"
    );
    let long = "7".repeat(100_000);
    let reason = read(&format!("id,y,x\n{long},40,-111\n{long},40,-111\n")).unwrap_err();
    assert!(reason.len() < 300, "{reason}");
}

#[test]
fn bounds_are_those_of_all_signals() {
    let text = "y,x\n40,-111\n41.5,-112\n40.5,-110\n";
    let list = SignalList::from_bytes(text.as_bytes(), Path::new("s"), &SignalColumns::default());
    let bounds = list.unwrap().bounds();
    assert_eq!(bounds.min(), Coord { x: -112.0, y: 40.0 });
    assert_eq!(bounds.max(), Coord { x: -110.0, y: 41.5 });
}

#[test]
fn a_missing_id_and_a_list_without_rows_are_refused() {
    assert!(read("id,y,x\n,40,-111\n").unwrap_err().contains("line 2: no id"));
    assert!(read("id,y,x\n").unwrap_err().contains("no signal below the first line"));
}

#[test]
fn columns_with_other_names_can_be_given() {
    let columns: SignalColumns =
        toml::from_str("latitude = \"Breite\"\nlongitude = \"Länge\"").unwrap();
    let text = "Breite,LÄNGE\n40,-111\n";
    let list = SignalList::from_bytes(text.as_bytes(), Path::new("s.csv"), &columns).unwrap();
    assert_eq!(list.signals.len(), 1);
    assert!(toml::from_str::<SignalColumns>("lat = \"y\"").is_err());
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
fn what_may_be_no_signal_is_told() {
    assert_eq!(
        list(MIXED, "").unwrap().doubts,
        [
            "2 rows may be no signals: column Type has Beacon (1), PENDING SIGNAL (1); leave them out with \
          --signals-where, such as 'Type!=Beacon'"
        ]
    );
}

#[test]
fn half_signals_and_those_for_pedestrians_or_fire_engines_are_told() {
    let kinds = ["Full Signal", "Half Signal", "Pedestrian Signal", "Mid-block", "Fire Station"];
    let row = |(i, kind): (usize, &&str)| format!("{i},{kind},40,-111.{i}\n");
    let rows: String = kinds.iter().enumerate().map(row).collect();
    let doubts = list(&format!("id,TYPE,latitude,longitude\n{rows}"), "").unwrap().doubts;
    assert!(doubts[0].starts_with("4 rows may be no signals: column TYPE has Fire"), "{doubts:?}");
    assert!(!doubts[0].contains("Full"), "{doubts:?}");
}

#[test]
fn rows_without_a_place_are_kept_to_be_named() {
    let signals = read("id,lat,lon\n1,40,-111\n2,,\n").unwrap();
    assert_eq!((signals[1].place.latitude_e7, signals[1].place.longitude_e7), (0, 0));
    assert!(read("id,lat,lon\n1,40,\n").unwrap_err().contains("column lon is empty"));
}

#[test]
fn a_list_whose_columns_of_places_are_empty_names_them() {
    assert_eq!(
        read("id,lat,lon,latitude,longitude\n7,40,-75,,\n").unwrap_err(),
        "s.csv: no row has a place in the columns latitude and longitude; fill them in, or name other columns \
         (`latitude` and `longitude` in [signals] of the settings)"
    );
    assert!(
        read("id,the_geom\n7,\n")
            .unwrap_err()
            .contains("no row has a place in the column the_geom")
    );
}

proptest! {
    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let columns = SignalColumns::default();
        drop(SignalList::from_bytes(&bytes, Path::new("s.csv"), &columns));
    }

    #[test]
    fn any_rows_are_read_or_refused(rows in "[0-9;,.\"\\-\r\n a]{0,80}") {
        drop(read(&format!("id,lat,lon\n{rows}")));
    }
}

#[test]
fn signals_of_one_controller_that_are_far_apart_stay_intersections_of_their_own() {
    // 0.001 degrees of latitude are 111 m.
    let text = "id,lat,lon,controller_id\n1,40.000,-111,A\n2,40.002,-111,A\n3,40.004,-111,A\n4,40.010,-111,A\n\
                5,40.020,-111,B\n6,40.021,-111,B\n7,40.5,-111,\n";
    let list = list(text, "").unwrap();
    let of = |row: usize| list.signals[row].controller.as_deref();
    assert_eq!(of(6), None);
    assert!(of(4) == Some("B") && of(5) == of(4));
    assert!(
        of(0).is_some() && of(0) == of(1) && of(1) == of(2) && of(2) != of(3),
        "{:?}",
        list.signals
    );
    assert_eq!(
        list.doubts,
        [
            "1 controllers have signals more than 250 m from their others, which stay intersections of their own: A has 2 places"
        ]
    );
}

#[test]
fn what_cities_call_their_columns_and_kinds_is_known() {
    let seattle = list("SIGNAL_ID,SHAPE_LAT,SHAPE_LNG\n1,40,-111\n", "").unwrap();
    assert_eq!(seattle.signals[0].place, Place::from_degrees(40.0, -111.0).unwrap());
    let toronto = "id,geometry\n1,\"{\"\"coordinates\"\": [[-111, 40]], \"\"type\"\": \"\"MultiPoint\"\"}\"\n";
    assert_eq!(list(toronto, "").unwrap().signals[0].place, seattle.signals[0].place);
    let kinds = "id,lat,lon,kind\n1,40,-111,Traffic signal\n2,40.1,-111,HAWK\n3,40.2,-111,Pelican crossing\n";
    assert!(list(kinds, "").unwrap().doubts[0].starts_with("2 rows may be no signals"), "kinds");
}
