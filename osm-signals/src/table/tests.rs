//! Tables as spreadsheets and portals write them.

use super::*;

fn places(text: &[u8]) -> Result<Vec<(u64, Place)>, String> {
    let read = || {
        let mut table = Table::open(text, Path::new("t.csv"), ("line", 0))?;
        let [latitude, longitude] = Column::place([None; 2]);
        let at = [table.need(&latitude)?, table.need(&longitude)?];
        let mut places = Vec::new();
        while let Some(row) = table.next_row()? {
            places.push((row.line, table.place(&row, at)?));
        }
        Ok(places)
    };
    read().map_err(|e: OsmError| e.to_string())
}

#[test]
fn columns_are_found_by_their_usual_names_in_any_order_and_case() {
    let expected = vec![(2, Place::from_degrees(40.78, -111.9).unwrap())];
    for text in [
        "LNG,LAT\n-111.9,40.78\n",
        "\u{feff}X, a ,Y\n-111.9,,40.78",
        "Lat;lon\r\n40,78;-111,9",
        "Latitude (WGS84),shape_lat,GPS-Lon\n,40.78,-111.9\n",
    ] {
        assert_eq!(places(text.as_bytes()).as_ref(), Ok(&expected), "{text}");
    }
}

#[test]
fn what_cannot_be_a_place_is_refused_at_its_line() {
    for (text, at) in [
        ("lat,street\n", "line 1"),
        ("40.7,-111.9\n", "line 1"),
        ("lat,Lat,lon\n1,2,3\n", "line 1"),
        ("lat;lon\n40,781;-111,901\n", "line 2"),
        ("lat,lon\n40,78,-111,9\n", "line 2"),
        ("lat,lon\n1,2\nmany,2\n", "line 3"),
        ("lat,lon\n1,inf\n", "line 2"),
        ("lat,lon\n1,\n", "line 2"),
        ("lat,lon\n-111.9,40.78\n", "line 2"),
        ("y,x\n4515000,421000\n", "line 2"),
        ("", ""),
    ] {
        let error = places(text.as_bytes()).unwrap_err();
        assert!(error.starts_with(&format!("t.csv, {at}: ")) || at.is_empty(), "{error}");
    }
}

#[test]
fn a_name_that_is_given_has_to_be_there_once() {
    let table = Table::open(b"a,b,B\n", Path::new("t.csv"), ("line", 0)).unwrap();
    let find = |name| table.find(&Column::place([Some(name), None])[0]).ok();
    assert_eq!([find("A"), find("lat"), find("b")], [Some(Some(0)), None, None]);
}
