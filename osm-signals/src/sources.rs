//! Lists in other shapes than CSV: workbooks, GeoJSON points, Esri shapefiles, and archives that hold one of
//! these. All of them become the text of a table, so that columns and rows are read in one way.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use std::path::Path;

use calamine::{Data, ExcelDateTime, ExcelDateTimeType, Ods, Range, Reader, Xls, Xlsb, Xlsx};
use geojson::{FeatureCollection, GeometryValue, JsonObject, JsonValue, Position};
use shapefile::{Shape, ShapeReader, dbase};
use zip::ZipArchive;

use super::error::{OsmError, brief};
use super::features::{self, check_crs, malformed};
use super::file;
use super::table::PLACE;

/// First bytes of archives, of old workbooks, and of shapefiles.
const ARCHIVE: &[u8] = b"PK\x03\x04";
const OLD_WORKBOOK: &[u8] = &[0xD0, 0xCF, 0x11, 0xE0];
const SHAPES: &[u8] = &[0, 0, 0x27, 0x0A];

/// Parts of archives that are workbooks: of Excel, of Excel in binary, of OpenDocument.
const WORKBOOKS: [&str; 3] = ["xl/workbook.xml", "xl/workbook.bin", "mimetype"];

/// Ends of names of files that hold a list, and of those beside shapes.
const LISTS: [&str; 9] = ["csv", "tsv", "txt", "geojson", "json", "xlsx", "xls", "ods", "shp"];

/// Days after 1899-12-30 from which on a cell with the form of a date is one of our time, and no other number.
const FIRST_DAY: f64 = 20_000.0;

/// Seconds of a day.
const DAY_S: f64 = 86_400.0;

/// What a list has to be.
const EXPECTED: &str =
    "a CSV, a workbook, GeoJSON points, a shapefile of points, or a zipped one of these";

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
    /// Returns the list in the bytes of a file; of a workbook the first sheet that holds anything.
    ///
    /// # Errors
    ///
    /// [`OsmError`] naming the file: it is damaged, projected, has no points, or holds no list or several.
    pub fn of(bytes: &'a [u8], path: &Path) -> Result<Self, OsmError> {
        Ok(Self::sheets(bytes, path)?.swap_remove(0))
    }

    /// Returns every sheet of a workbook that holds anything, or the one list of another file; at least one.
    ///
    /// # Errors
    ///
    /// As [`Source::of`].
    pub fn sheets(bytes: &'a [u8], path: &Path) -> Result<Vec<Self>, OsmError> {
        if bytes.starts_with(ARCHIVE) {
            return archive(bytes, path);
        }
        if bytes.starts_with(OLD_WORKBOOK) {
            return workbook(Xls::new(Cursor::new(bytes)), path);
        }
        if bytes.starts_with(SHAPES) {
            let beside = |end: &str| {
                let other = path.with_extension(end);
                other.is_file().then(|| file::bytes(&other)).transpose()
            };
            let (records, projection) = (beside("dbf")?, beside("prj")?);
            return Ok(vec![shapes(bytes, records.as_deref(), projection.as_deref(), path)?]);
        }
        let is_json = bytes.iter().find(|b| !b.is_ascii_whitespace()) == Some(&b'{');
        if is_json || bytes.starts_with(b"\xEF\xBB\xBF{") {
            return Ok(vec![points(bytes, path)?]);
        }
        Ok(vec![Self { bytes: Cow::Borrowed(bytes), rows: ("line", 0), sheet: String::new() }])
    }

    fn owned(self) -> Source<'static> {
        Source { bytes: Cow::Owned(self.bytes.into_owned()), rows: self.rows, sheet: self.sheet }
    }
}

fn nothing(path: &Path, reason: impl Into<String>) -> OsmError {
    OsmError::Nothing { path: path.to_path_buf(), reason: reason.into() }
}

/// Reads what an archive holds.
fn archive(bytes: &[u8], path: &Path) -> Result<Vec<Source<'static>>, OsmError> {
    let damaged = |e: &dyn std::fmt::Display| {
        nothing(path, format!("a damaged archive ({e}); fetch it again"))
    };
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|e| damaged(&e))?;
    let names = archive.file_names().map(|name| name.map(Cow::into_owned));
    let names: Vec<String> = names.collect::<Result<_, _>>().map_err(|e| damaged(&e))?;
    match WORKBOOKS.iter().position(|part| names.iter().any(|name| name == part)) {
        Some(0) => return workbook(Xlsx::new(Cursor::new(bytes)), path),
        Some(1) => return workbook(Xlsb::new(Cursor::new(bytes)), path),
        Some(_) => return workbook(Ods::new(Cursor::new(bytes)), path),
        None => {}
    }
    let end =
        |name: &str| name.rsplit_once('.').map(|(_, end)| end.to_lowercase()).unwrap_or_default();
    let hidden = |name: &str| name.split('/').any(|part| part.starts_with(['.', '_']));
    let mut lists: Vec<&String> =
        names.iter().filter(|n| !hidden(n) && LISTS.contains(&&*end(n))).collect();
    lists.sort();
    let [list] = lists[..] else {
        let found: Vec<String> = lists.iter().map(|name| brief(name)).collect();
        let found = if found.is_empty() { "none".to_owned() } else { found.join(", ") };
        return Err(nothing(
            path,
            format!(
                "an archive that has to hold one list and holds {found}; {EXPECTED} is \
                                          needed"
            ),
        ));
    };
    let mut part = |name: &str| -> Result<Vec<u8>, OsmError> {
        let entry = archive.by_name(name).map_err(|e| damaged(&e))?;
        let mut inflated = Vec::new();
        let most = sheet::file::TABLE_BYTES;
        entry.take(most + 1).read_to_end(&mut inflated).map_err(|e| damaged(&e))?;
        if inflated.len() as u64 > most {
            return Err(nothing(path, format!("{} is larger than {most} bytes", brief(name))));
        }
        Ok(inflated)
    };
    let inner = part(list)?;
    if end(list) != "shp" {
        let sheets = Source::sheets(&inner, &path.join(list))?;
        return Ok(sheets.into_iter().map(Source::owned).collect());
    }
    let stem = &list[..list.len() - "shp".len()];
    let mut beside = |end: &str| {
        let name = names.iter().find(|n| n.eq_ignore_ascii_case(&format!("{stem}{end}")));
        name.map(|name| part(name)).transpose()
    };
    let (records, projection) = (beside("dbf")?, beside("prj")?);
    Ok(vec![shapes(&inner, records.as_deref(), projection.as_deref(), path)?])
}

/// Reads the sheets of a workbook that hold anything.
fn workbook<'b, R>(
    workbook: Result<R, R::Error>,
    path: &Path,
) -> Result<Vec<Source<'static>>, OsmError>
where
    R: Reader<Cursor<&'b [u8]>>,
    R::Error: std::fmt::Display,
{
    let damaged = |e: R::Error| nothing(path, format!("a workbook that cannot be read ({e})"));
    let mut workbook = workbook.map_err(damaged)?;
    let mut sheets = Vec::new();
    for name in workbook.sheet_names() {
        let range = workbook.worksheet_range(&name).map_err(damaged)?;
        let Some((first, _)) = range.start() else { continue };
        sheets.push(Source {
            bytes: Cow::Owned(csv(texts(&range).into_iter()).into_bytes()),
            rows: ("row", i64::from(first)),
            sheet: name,
        });
    }
    if sheets.is_empty() {
        return Err(nothing(path, "a workbook without any cell"));
    }
    Ok(sheets)
}

/// Returns the texts of cells. Dates of a column in which one has a time have times too, also at midnight.
fn texts(range: &Range<Data>) -> Vec<Vec<String>> {
    let has_times = |column: usize| range.rows().any(|row| has_time(&row[column]));
    let timed: Vec<bool> = (0..range.width()).map(has_times).collect();
    let text = |row: &[Data]| {
        let cells = row.iter().zip(&timed).map(|(data, timed)| cell(data, *timed));
        cells.collect::<Vec<String>>()
    };
    range.rows().map(text).collect()
}

/// Returns whether a cell has a time of day that its number or text shows.
fn has_time(data: &Data) -> bool {
    match data {
        Data::DateTime(at) => at.as_f64().fract() != 0.0,
        Data::DateTimeIso(text) => text.contains('T'),
        _ => false,
    }
}

/// Returns the text of a cell.
///
/// # Arguments
///
/// * `timed`: whether its column has times of day.
fn cell(data: &Data, timed: bool) -> String {
    match data {
        Data::Empty | Data::Error(_) => String::new(),
        Data::DurationIso(duration) => clock_time(duration).unwrap_or_else(|| duration.clone()),
        Data::DateTime(at) => date_time(at, timed),
        Data::DateTimeIso(day) if timed && !has_time(data) => format!("{day}T00:00:00"),
        other => other.to_string(),
    }
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

/// Returns a time of day as `07:15:00`, which OpenDocument has as the duration `PT07H15M00S` since midnight.
fn clock_time(duration: &str) -> Option<String> {
    let (hours, rest) = duration.strip_prefix("PT")?.split_once('H')?;
    let (minutes, rest) = rest.split_once('M')?;
    let seconds = rest.strip_suffix('S')?.split('.').next()?;
    let numbers: Option<Vec<u32>> =
        [hours, minutes, seconds].iter().map(|number| number.parse().ok()).collect();
    let [hours, minutes, seconds] = numbers?[..] else { return None };
    Some(format!("{hours:02}:{minutes:02}:{seconds:02}"))
}

/// Reads GeoJSON points.
fn points(bytes: &[u8], path: &Path) -> Result<Source<'static>, OsmError> {
    let collection: FeatureCollection =
        features::read(bytes, path, "a FeatureCollection of points")?;
    check_crs(collection.foreign_members.as_ref(), path)?;
    let mut columns: Vec<String> = Vec::new();
    let mut known: BTreeMap<String, usize> = BTreeMap::new();
    let none = JsonObject::new();
    for feature in &collection.features {
        for key in feature.properties.as_ref().unwrap_or(&none).keys() {
            if !known.contains_key(key) {
                known.insert(key.clone(), columns.len());
                columns.push(key.clone());
            }
        }
    }
    let mut rows = vec![with_place(columns.clone(), PLACE.map(str::to_owned))];
    for (i, feature) in collection.features.iter().enumerate() {
        let at = format!("feature {}", i + 1);
        let place = match feature.geometry.as_ref().map(|g| &g.value) {
            None => [String::new(), String::new()],
            Some(GeometryValue::Point { coordinates }) => written(coordinates),
            Some(GeometryValue::MultiPoint { coordinates }) if coordinates.len() == 1 => {
                written(&coordinates[0])
            }
            Some(other) => {
                let reason = format!("a {}; a Point is needed", other.type_name());
                return Err(malformed(path, at, reason));
            }
        };
        let properties = feature.properties.as_ref().unwrap_or(&none);
        let fields = columns.iter().map(|c| properties.get(c).map_or_else(String::new, value));
        rows.push(with_place(fields.collect(), place));
    }
    Ok(of_features(rows))
}

fn written(position: &Position) -> [String; 2] {
    let at = |i: usize| position.as_slice().get(i).map_or_else(String::new, f64::to_string);
    [at(1), at(0)]
}

fn value(value: &JsonValue) -> String {
    match value {
        JsonValue::Null => String::new(),
        JsonValue::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// Reads a shapefile of points.
fn shapes(
    shapes: &[u8],
    records: Option<&[u8]>,
    projection: Option<&[u8]>,
    path: &Path,
) -> Result<Source<'static>, OsmError> {
    let damaged =
        |e: &dyn std::fmt::Display| nothing(path, format!("a shapefile that cannot be read ({e})"));
    if let Some(text) = projection.map(String::from_utf8_lossy)
        && let Some(rest) = text.trim_start().strip_prefix("PROJCS")
    {
        let name = rest.split('"').nth(1).unwrap_or("a projection");
        let reason = format!("coordinates are in {}; export as WGS 84 (EPSG:4326)", brief(name));
        return Err(malformed(path, "prj", reason));
    }
    let Some(records) = records else {
        return Err(nothing(
            path,
            "a shapefile without its .dbf beside it; keep the files of a shapefile together",
        ));
    };
    let shapes = ShapeReader::new(Cursor::new(shapes)).map_err(|e| damaged(&e))?;
    let records = dbase::Reader::new(Cursor::new(records)).map_err(|e| damaged(&e))?;
    let columns: Vec<String> = records.fields().iter().map(|f| f.name().to_owned()).collect();
    let mut rows = vec![with_place(columns.clone(), PLACE.map(str::to_owned))];
    let mut both = shapefile::Reader::new(shapes, records);
    for (i, pair) in both.iter_shapes_and_records().enumerate() {
        let (shape, record) = pair.map_err(|e| damaged(&e))?;
        let place = match shape {
            Shape::Point(p) => Some((p.y, p.x)),
            Shape::PointM(p) => Some((p.y, p.x)),
            Shape::PointZ(p) => Some((p.y, p.x)),
            Shape::NullShape => None,
            other => {
                let reason = format!("a {}; a Point is needed", other.shapetype());
                return Err(malformed(path, format!("feature {}", i + 1), reason));
            }
        };
        let place = place.map_or_else(Default::default, |(y, x)| [y.to_string(), x.to_string()]);
        let fields = columns.iter().map(|c| record.get(c).map_or_else(String::new, field));
        rows.push(with_place(fields.collect(), place));
    }
    Ok(of_features(rows))
}

fn field(value: &dbase::FieldValue) -> String {
    use dbase::FieldValue::{
        Character, Currency, Date, Double, Float, Integer, Logical, Memo, Numeric,
    };
    match value {
        Character(text) => text.clone().unwrap_or_default(),
        Numeric(number) => number.map(|n| n.to_string()).unwrap_or_default(),
        Float(number) => number.map(|n| n.to_string()).unwrap_or_default(),
        Logical(truth) => truth.map(|t| t.to_string()).unwrap_or_default(),
        Date(date) => date.map(|d| d.to_string()).unwrap_or_default(),
        Integer(number) => number.to_string(),
        Currency(number) | Double(number) => number.to_string(),
        Memo(text) => text.clone(),
        _ => String::new(),
    }
}

fn with_place(mut fields: Vec<String>, place: [String; 2]) -> Vec<String> {
    fields.extend(place);
    fields
}

/// Returns the list of features from the names of its columns and their rows.
fn of_features(rows: Vec<Vec<String>>) -> Source<'static> {
    let bytes = Cow::Owned(csv(rows.into_iter()).into_bytes());
    Source { bytes, rows: ("feature", -1), sheet: String::new() }
}

/// Returns rows as the text of a table, one line each.
fn csv(rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut text = String::new();
    for row in rows {
        let fields = row.iter().map(|field| {
            let one_line = field.split(['\r', '\n']).collect::<Vec<_>>().join(" ");
            format!("\"{}\"", one_line.replace('"', "\"\""))
        });
        text += &fields.collect::<Vec<_>>().join(",");
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests;
