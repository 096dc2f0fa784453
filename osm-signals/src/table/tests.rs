//! Tables as spreadsheets and portals write them.

use super::*;

fn places(text: &[u8]) -> Result<Vec<(u64, Place)>, String> {
    let read = || {
        let mut table = Table::open(text, Path::new("t.csv"))?;
        let latitude = table.need(&Column::latitude(None))?;
        let longitude = table.need(&Column::longitude(None))?;
        let mut places = Vec::new();
        while let Some(row) = table.next_row()? {
            places.push((row.line, table.place(&row, (latitude, longitude))?));
        }
        Ok(places)
    };
    read().map_err(|e: OsmError| e.to_string())
}

fn error(text: &str) -> String {
    places(text.as_bytes()).unwrap_err()
}

#[test]
fn columns_are_found_by_their_usual_names_in_any_order_and_case() {
    let expected = vec![(2, Place::from_degrees(40.78, -111.9).unwrap())];
    for text in
        ["LNG,LAT\n-111.9,40.78\n", "\u{feff}X, a ,Y\n-111.9,,40.78", "Lat,lon\r\n40.78,-111.9"]
    {
        assert_eq!(places(text.as_bytes()).as_ref(), Ok(&expected), "{text}");
    }
}

#[test]
fn lines_are_counted_over_blank_ones_and_breaks_within_quotes() {
    let text = "lat,lon,note\n\n40,1,\"a\nb\"\n , ,\r\n\r\n41,1,\n";
    let lines: Vec<_> = places(text.as_bytes()).unwrap().iter().map(|p| p.0).collect();
    assert_eq!(lines, [3, 7]);
}

#[test]
fn a_missing_column_names_those_that_are_there() {
    assert_eq!(
        error("lat,street\n"),
        "t.csv, line 1: no column with the longitude (longitude, lon, lng, long, x); the \
         columns are lat, street; rename one of them, or give its name in the settings"
    );
    assert!(error("40.7,-111.9\n").contains("put a line with the names"));
}

#[test]
fn a_name_that_is_given_has_to_be_there_once() {
    let table = Table::open(b"a,b,B\n", Path::new("t.csv")).unwrap();
    let find = |name| table.find(&Column::latitude(Some(name))).map_err(|e| e.to_string());
    assert_eq!(find("A"), Ok(Some(0)));
    assert!(find("lat").unwrap_err().contains("no column \"lat\" (given as latitude)"));
    assert!(find("b").unwrap_err().contains("columns 2 and 3 are both named \"b\""));
}

#[test]
fn other_separators_and_decimal_commas_are_read_or_explained() {
    let expected = vec![(2, Place::from_degrees(40.78, -111.9).unwrap())];
    for text in ["lat;lon\n40,78;-111,9\n", "lat\tlon\n40.78\t-111.9\n"] {
        assert_eq!(places(text.as_bytes()).as_ref(), Ok(&expected), "{text}");
    }
    assert_eq!(
        error("lat;lon\n40,781;-111,901\n"),
        "t.csv, line 2: column lat: \"40,781\" is no number; write numbers with a point and \
         without thousands separators"
    );
    assert!(error("lat,lon\n40,78,-111,9\n").contains("line 2: 4 fields, but 2 columns"));
}

#[test]
fn what_is_no_number_is_refused_with_its_line() {
    assert!(error("lat,lon\n1,2\nmany,2\n").starts_with("t.csv, line 3: column lat: \"many\""));
    assert!(error("lat,lon\nNaN,2\n").contains("\"NaN\" is no number"));
    assert!(error("lat,lon\n1,inf\n").contains("\"inf\" is no number"));
    assert!(error("lat,lon\n1,\n").contains("column lon is empty"));
}

#[test]
fn swapped_and_projected_coordinates_are_recognised() {
    assert!(error("lat,lon\n-111.9,40.78\n").contains("swap latitude and longitude"));
    assert!(error("y,x\n4515000,421000\n").contains("looks projected"));
}

#[test]
fn an_empty_table_and_other_encodings_are_refused() {
    assert!(error("").contains("empty; the first line has to name the columns"));
    assert!(error("\n\n").contains("empty"));
    assert!(places(b"lat,lon,n\n1,2,caf\xe9\n").unwrap_err().contains("line 2: not UTF-8 text"));
    assert!(places(b"PK\x03\x04\x14").unwrap_err().contains("a ZIP archive or a workbook"));
}
