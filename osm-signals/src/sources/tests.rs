//! Tests of lists in other shapes than CSV.

use std::io::Write;

use serde_json::json;
use zip::write::{SimpleFileOptions, ZipWriter};

use super::*;
use crate::signals::{SignalColumns, SignalList};

/// The ids, latitudes and longitudes of a list, and their numbers in the file.
fn read(bytes: &[u8], name: &str) -> Result<Vec<(String, f64, f64, u64)>, String> {
    let list = SignalList::from_bytes(bytes, Path::new(name), &SignalColumns::default());
    let list = list.map_err(|e| e.to_string())?;
    let of = |s: &crate::signals::ListedSignal| {
        (s.id.clone(), s.place.latitude(), s.place.longitude(), s.line)
    };
    Ok(list.signals.iter().map(of).collect())
}

fn zipped(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        writer.start_file(*name, SimpleFileOptions::default()).unwrap();
        writer.write_all(bytes).unwrap();
    }
    writer.finish().unwrap().into_inner()
}

const CSV: &[u8] = b"id,lat,lon\na,40.7,-111.9\nb,40.8,-111.8\n";

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

/// A shapefile of the two points: its parts .shp and .dbf.
fn shapefile() -> (Vec<u8>, Vec<u8>) {
    use dbase::{FieldName, Record, TableWriterBuilder};
    let (mut shp, mut shx, mut dbf) =
        (Cursor::new(Vec::new()), Cursor::new(Vec::new()), Cursor::new(Vec::new()));
    {
        let shapes = shapefile::ShapeWriter::with_shx(&mut shp, &mut shx);
        let table = TableWriterBuilder::new()
            .add_character_field(FieldName::try_from("SIGNALID").unwrap(), 10)
            .build_with_dest(&mut dbf);
        let mut writer = shapefile::Writer::new(shapes, table);
        for (id, x, y) in [("a", -111.9, 40.7), ("b", -111.8, 40.8)] {
            let mut record = Record::default();
            record.insert("SIGNALID".into(), dbase::FieldValue::Character(Some(id.into())));
            writer.write_shape_and_record(&shapefile::Point::new(x, y), &record).unwrap();
        }
    }
    (shp.into_inner(), dbf.into_inner())
}

#[test]
fn a_shapefile_is_a_list_beside_its_records_and_in_an_archive() {
    let (shp, dbf) = shapefile();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("signals.shp");
    std::fs::write(&path, &shp).unwrap();
    let alone = SignalList::read(&path, &SignalColumns::default()).unwrap_err().to_string();
    assert!(alone.contains("without its .dbf"), "{alone}");
    std::fs::write(path.with_extension("dbf"), &dbf).unwrap();
    let list = SignalList::read(&path, &SignalColumns::default()).unwrap();
    assert_eq!(list.signals.len(), 2);
    let files: [(&str, &[u8]); 2] = [("x/signals.shp", &shp), ("x/signals.dbf", &dbf)];
    assert_eq!(read(&zipped(&files), "s.zip").unwrap(), two([1, 2]));
    let utm: &[u8] = b"PROJCS[\"NAD_1983_UTM_Zone_12N\",GEOGCS[]]";
    let projected = [&files[..], &[("x/signals.prj", utm)]].concat();
    let reason = read(&zipped(&projected), "s.zip").unwrap_err();
    assert!(
        reason.contains("coordinates are in NAD_1983_UTM_Zone_12N; export as WGS 84"),
        "{reason}"
    );
}

#[test]
fn an_archive_holds_one_list() {
    assert_eq!(
        read(&zipped(&[("a/list.csv", CSV), ("__MACOSX/._list.csv", b"x")]), "s.zip").unwrap(),
        two([2, 3])
    );
    let reason = read(&zipped(&[("a.csv", CSV), ("b.csv", CSV)]), "s.zip").unwrap_err();
    assert!(reason.contains("has to hold one list and holds a.csv, b.csv"), "{reason}");
    assert!(read(&zipped(&[("a.pdf", b"x")]), "s.zip").unwrap_err().contains("holds none"));
    assert!(read(b"PK\x03\x04nonsense", "s.zip").unwrap_err().contains("damaged archive"));
}

/// A workbook with the text of its only sheet.
fn workbook(sheet: &str) -> Vec<u8> {
    let types = b"<?xml version=\"1.0\"?><Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">\
        <Default Extension=\"rels\" ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>\
        <Override PartName=\"/xl/workbook.xml\" ContentType=\"application/vnd.openxmlformats-officedocument.spreadsheetml.sheet.main+xml\"/>\
        <Override PartName=\"/xl/worksheets/sheet1.xml\" ContentType=\"application/vnd.openxmlformats-officedocument.spreadsheetml.worksheet+xml\"/></Types>";
    let book = b"<?xml version=\"1.0\"?><workbook xmlns=\"http://schemas.openxmlformats.org/spreadsheetml/2006/main\" \
        xmlns:r=\"http://schemas.openxmlformats.org/officeDocument/2006/relationships\"><sheets>\
        <sheet name=\"Signals\" sheetId=\"1\" r:id=\"rId1\"/></sheets></workbook>";
    let relations = b"<?xml version=\"1.0\"?><Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">\
        <Relationship Id=\"rId1\" Type=\"http://schemas.openxmlformats.org/officeDocument/2006/relationships/worksheet\" \
        Target=\"worksheets/sheet1.xml\"/></Relationships>";
    let sheet = format!(
        "<?xml version=\"1.0\"?><worksheet xmlns=\"http://schemas.openxmlformats.org/spreadsheetml/2006/main\">\
         <sheetData>{sheet}</sheetData></worksheet>"
    );
    let root = b"<?xml version=\"1.0\"?><Relationships xmlns=\"http://schemas.openxmlformats.org/package/2006/relationships\">\
        <Relationship Id=\"rId1\" Type=\"http://schemas.openxmlformats.org/officeDocument/2006/relationships/officeDocument\" \
        Target=\"xl/workbook.xml\"/></Relationships>";
    zipped(&[
        ("[Content_Types].xml", types),
        ("_rels/.rels", root),
        ("xl/workbook.xml", book),
        ("xl/_rels/workbook.xml.rels", relations),
        ("xl/worksheets/sheet1.xml", sheet.as_bytes()),
    ])
}

#[test]
fn a_workbook_is_a_list() {
    let row = |n: u32, cells: &[&str]| {
        let cell = |(text, column): (&&str, char)| match text.parse::<f64>() {
            Ok(_) => format!("<c r=\"{column}{n}\"><v>{text}</v></c>"),
            Err(_) => format!("<c r=\"{column}{n}\" t=\"inlineStr\"><is><t>{text}</t></is></c>"),
        };
        let cells: String = cells.iter().zip('A'..).map(cell).collect();
        format!("<row r=\"{n}\">{cells}</row>")
    };
    let sheet = [
        row(3, &["Signal ID", "Latitude", "Longitude"]),
        row(4, &["a", "40.7", "-111.9"]),
        row(5, &["b", "40.8", "-111.8"]),
    ];
    assert_eq!(read(&workbook(&sheet.concat()), "s.xlsx").unwrap(), two([4, 5]));
    let outside = row(4, &["a", "400.7", "-111.9"]);
    let reason = read(&workbook(&[&*sheet[0], &outside].concat()), "s.xlsx").unwrap_err();
    assert!(reason.starts_with("s.xlsx, row 4: "), "{reason}");
    assert!(read(&workbook(""), "s.xlsx").unwrap_err().contains("without any cell"));
}

#[test]
fn times_of_opendocument_are_read_as_clock_times() {
    let text = |duration: &str| cell(&Data::DurationIso(duration.to_owned()), false);
    assert_eq!(text("PT07H15M00S"), "07:15:00");
    assert_eq!(text("PT7H5M0.000S"), "07:05:00");
    assert_eq!(text("P1D"), "P1D");
}

#[test]
fn midnight_has_its_time_in_a_column_of_times() {
    let excel = |days, is_1904| {
        Data::DateTime(ExcelDateTime::new(days, calamine::ExcelDateTimeType::DateTime, is_1904))
    };
    let iso = |text: &str| Data::DateTimeIso(text.to_owned());
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
    assert_eq!(
        column([iso("2026-11-05"), iso("2026-11-05T07:15:00")]),
        ["2026-11-05T00:00:00", "2026-11-05T07:15:00"]
    );
    // A column of dates, and of numbers with the form of a date.
    assert_eq!(
        column([excel(46_331.0, false), excel(46_332.0, false)]),
        ["2026-11-05", "2026-11-06"]
    );
    assert_eq!(column([excel(0.0, false), excel(45.0, false)]), ["0", "45"]);
}
