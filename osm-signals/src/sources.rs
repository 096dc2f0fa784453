//! Lists in other shapes than CSV: workbooks and GeoJSON points. All of them become the text of a table, so that columns
//! and rows are read in one way.

use std::borrow::Cow;
use std::collections::BTreeSet;
use std::io::Cursor;
use std::path::Path;

use calamine::{Data, ExcelDateTime, ExcelDateTimeType, Range, Reader, Xlsx};
use geojson::{FeatureCollection, GeometryValue, JsonObject, JsonValue, Position};

use super::error::OsmError;
use super::error::malformed;
use super::features;
use super::table::PLACE;

/// First bytes of workbooks, which are archives.
const ARCHIVE: &[u8] = b"PK\x03\x04";

/// Days after 1899-12-30 from which on a cell with the form of a date is one of our time, and no other number.
const FIRST_DAY: f64 = 20_000.0;

const DAY_S: f64 = 86_400.0;

/// A list as the text of a table.
pub struct Source<'a> {
    /// The text; of CSV the bytes of the file.
    pub bytes: Cow<'a, [u8]>,
    /// What a row is called, and what its number in the file is more than its line in the text.
    pub rows: (&'static str, i64),
    /// Name of the sheet; empty for what is no workbook.
    pub sheet: String,
}

impl<'a> Source<'a> {
    /// Returns every sheet of a workbook that holds anything, or the one list of another file; at least one.
    pub fn sheets(bytes: &'a [u8], path: &Path) -> Result<Vec<Self>, OsmError> {
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        if bytes.starts_with(ARCHIVE) {
            return workbook(bytes, path);
        }
        if bytes.trim_ascii_start().starts_with(b"{") {
            return Ok(vec![points(bytes, path)?]);
        }
        if sheet::decode(bytes).is_err() {
            return Err(no_list(path));
        }
        Ok(vec![Self { bytes: Cow::Borrowed(bytes), rows: ("line", 0), sheet: String::new() }])
    }
}

fn no_list(path: &Path) -> OsmError {
    let reason =
        "neither CSV nor GeoJSON nor a workbook (.xlsx) with cells; save it as CSV or GeoJSON";
    OsmError::Nothing { path: path.to_path_buf(), reason: reason.to_owned() }
}

fn workbook(bytes: &[u8], path: &Path) -> Result<Vec<Source<'static>>, OsmError> {
    let mut workbook = Xlsx::new(Cursor::new(bytes)).map_err(|_| no_list(path))?;
    let mut sheets = Vec::new();
    for name in workbook.sheet_names() {
        let range = workbook.worksheet_range(&name).map_err(|_| no_list(path))?;
        let Some((first, _)) = range.start() else { continue };
        sheets.push(Source {
            bytes: Cow::Owned(csv(texts(&range)).into_bytes()),
            rows: ("row", i64::from(first)),
            sheet: name,
        });
    }
    if sheets.is_empty() { Err(no_list(path)) } else { Ok(sheets) }
}

/// Returns the texts of cells. Dates of a column in which one has a time have times too, also at midnight.
fn texts(range: &Range<Data>) -> Vec<Vec<String>> {
    let has_time = |data: &Data| matches!(data, Data::DateTime(at) if at.as_f64().fract() != 0.0);
    let has_times = |column: usize| range.rows().any(|row| has_time(&row[column]));
    let timed: Vec<bool> = (0..range.width()).map(has_times).collect();
    let cell = |(data, timed): (&Data, &bool)| match data {
        Data::Empty | Data::Error(_) => String::new(),
        Data::DateTime(at) => date_time(at, *timed),
        other => other.to_string(),
    };
    range.rows().map(|row| row.iter().zip(&timed).map(cell).collect()).collect()
}

/// Returns a date, a time of day or both; a number that is neither stays one.
fn date_time(at: &ExcelDateTime, timed: bool) -> String {
    let (year, month, day, hour, minute, second, _) = to_second(at).to_ymd_hms_milli();
    let date = format!("{year}-{month:02}-{day:02}");
    let time = format!("{hour:02}:{minute:02}:{second:02}");
    match at.as_f64() {
        days if days >= FIRST_DAY && timed => format!("{date} {time}"),
        days if days >= FIRST_DAY => date,
        days if (0.0..1.0).contains(&days) && timed => time,
        days => days.to_string(),
    }
}

/// Returns a time rounded to its second: days with few decimals, such as 46330.0208333, are a little before theirs.
fn to_second(at: &ExcelDateTime) -> ExcelDateTime {
    let of = |days: f64, is_1904| ExcelDateTime::new(days, ExcelDateTimeType::DateTime, is_1904);
    let days = at.as_f64();
    let is_1904 = of(days, true).to_ymd_hms_milli() == at.to_ymd_hms_milli();
    of((days * DAY_S).round() / DAY_S, is_1904)
}

fn points(bytes: &[u8], path: &Path) -> Result<Source<'static>, OsmError> {
    let collection: FeatureCollection =
        features::read(bytes, path, "a FeatureCollection of points")?;
    let none = JsonObject::new();
    let properties = collection.features.iter().map(|f| f.properties.as_ref().unwrap_or(&none));
    let columns: BTreeSet<&String> = properties.clone().flat_map(JsonObject::keys).collect();
    let columns: Vec<&String> = columns.into_iter().collect();
    let head = columns.iter().map(|column| (*column).clone()).chain(PLACE.map(str::to_owned));
    let mut rows = vec![head.collect::<Vec<_>>()];
    for ((i, feature), properties) in collection.features.iter().enumerate().zip(properties) {
        let place = match feature.geometry.as_ref().map(|g| &g.value) {
            None => Default::default(),
            Some(GeometryValue::Point { coordinates }) => written(coordinates),
            Some(GeometryValue::MultiPoint { coordinates }) if coordinates.len() == 1 => {
                written(&coordinates[0])
            }
            Some(other) => {
                let reason = format!("a {}; a Point is needed", other.type_name());
                return Err(malformed(path, format!("feature {}", i + 1), reason));
            }
        };
        let value = |column: &&String| match properties.get(*column) {
            None | Some(JsonValue::Null) => String::new(),
            Some(JsonValue::String(text)) => text.clone(),
            Some(other) => other.to_string(),
        };
        rows.push(columns.iter().map(value).chain(place).collect());
    }
    let bytes = Cow::Owned(csv(rows).into_bytes());
    Ok(Source { bytes, rows: ("feature", -1), sheet: String::new() })
}

fn written(position: &Position) -> [String; 2] {
    let at = |i: usize| position.as_slice().get(i).map_or_else(String::new, f64::to_string);
    [at(1), at(0)]
}

fn csv(rows: Vec<Vec<String>>) -> String {
    let field =
        |field: &String| format!("\"{}\"", field.replace(['\r', '\n'], " ").replace('"', "\"\""));
    let line = |row: &Vec<String>| row.iter().map(field).collect::<Vec<_>>().join(",") + "\n";
    rows.iter().map(line).collect()
}

#[cfg(test)]
mod tests;
