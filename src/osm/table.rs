//! Tables that users bring: CSV with a header, whose columns are found by their usual names.
//!
//! Every error names the line, says what was found and gives the way out, because such tables
//! come out of spreadsheets and portals in many shapes.

use std::fs::{self, Metadata};
use std::io::{Error, ErrorKind};
use std::path::{Path, PathBuf};

use csv::{ReaderBuilder, StringRecord, Trim};

use super::error::{OsmError, brief};
use super::extract::Place;
use super::geometry::checked_place;
use crate::files::FileError;

/// Most columns that a message names.
const QUOTED_COLUMNS: usize = 20;

/// Mark that some programs put before UTF-8 text.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// How packed files start, which portals offer beside plain ones.
const PACKED: [(&[u8], &str); 2] = [(b"PK\x03\x04", "a ZIP archive"), (b"\x1f\x8b", "gzip data")];

/// Usual names of the column with the latitude.
const LATITUDE: [&str; 3] = ["latitude", "lat", "y"];

/// Usual names of the column with the longitude.
const LONGITUDE: [&str; 5] = ["longitude", "lon", "lng", "long", "x"];

/// A column to look for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Column<'a> {
    /// What it holds; also the setting that gives its name.
    pub(super) what: &'static str,
    /// Its name, if the user gives it.
    pub(super) given: Option<&'a str>,
    /// Its usual names, the best one first.
    pub(super) usual: &'a [&'a str],
}

impl<'a> Column<'a> {
    /// Returns the column with the latitude, degrees.
    pub(super) fn latitude(given: Option<&'a str>) -> Self {
        Self { what: "latitude", given, usual: &LATITUDE }
    }

    /// Returns the column with the longitude, degrees.
    pub(super) fn longitude(given: Option<&'a str>) -> Self {
        Self { what: "longitude", given, usual: &LONGITUDE }
    }
}

/// A row.
#[derive(Debug)]
pub(super) struct Row {
    /// Line that it starts on.
    pub(super) line: u64,
    fields: StringRecord,
}

impl Row {
    /// Returns a field without the blanks around it.
    pub(super) fn text(&self, column: usize) -> &str {
        self.fields.get(column).unwrap_or_default()
    }
}

/// A table that is being read.
pub(super) struct Table<'a> {
    path: &'a Path,
    text: &'a [u8],
    headers: StringRecord,
    reader: csv::Reader<&'a [u8]>,
    /// Bytes whose lines are counted, and how many line ends they have.
    counted: (usize, u64),
}

impl<'a> Table<'a> {
    /// Opens a table; `path` is for messages only.
    ///
    /// # Errors
    ///
    /// [`OsmError`] when it is no UTF-8 text, empty, or not separated by commas.
    pub(super) fn open(bytes: &'a [u8], path: &'a Path) -> Result<Self, OsmError> {
        let text = utf8(bytes, path)?;
        if text.trim_start().starts_with(['{', '[', '<']) {
            let reason = "holds JSON or XML, not a table; give a CSV file".to_owned();
            return Err(malformed(path, 1, reason));
        }
        let text = text.as_bytes();
        let mut reader = ReaderBuilder::new().trim(Trim::All).flexible(true).from_reader(text);
        let headers = reader.headers().map_err(|e| malformed(path, 1, e.to_string()))?.clone();
        let table = Self { path, text, headers, reader, counted: (0, 0) };
        if table.headers.iter().all(str::is_empty) {
            return Err(table.nothing("empty; the first line has to name the columns"));
        }
        let header = table.headers.iter().collect::<Vec<_>>().join(",");
        for (separator, name) in [(';', "semicolons"), ('\t', "tabs"), ('|', "bars")] {
            if header.matches(separator).count() > table.headers.len() - 1 {
                let reason = format!(
                    "the columns are separated by {name}; save the table with commas between \
                     columns and points in numbers"
                );
                return Err(table.error(1, reason));
            }
        }
        Ok(table)
    }

    /// Returns the names of the columns.
    pub(super) fn headers(&self) -> impl Iterator<Item = &str> {
        self.headers.iter()
    }

    /// Returns where a column is; `None` if the table has none with a usual name.
    ///
    /// # Errors
    ///
    /// [`OsmError`] when there is none of the name that the user gives, or several of one name.
    pub(super) fn find(&self, column: &Column<'_>) -> Result<Option<usize>, OsmError> {
        let given = column.given.as_ref().map(std::slice::from_ref);
        for name in given.unwrap_or(column.usual) {
            let is = |header: &str| plain(header) == plain(name);
            let mut found = (0..self.headers.len()).filter(|i| is(&self.headers[*i]));
            match (found.next(), found.next()) {
                (Some(first), None) => return Ok(Some(first)),
                (Some(first), Some(second)) => {
                    let reason = format!(
                        "columns {} and {} are both named {:?}; rename one of them",
                        first + 1,
                        second + 1,
                        brief(name)
                    );
                    return Err(self.error(1, reason));
                }
                _ => {}
            }
        }
        match column.given {
            Some(name) => Err(self.error(
                1,
                format!(
                    "no column {:?} (given as {}); {}",
                    brief(name),
                    column.what,
                    self.columns()
                ),
            )),
            None => Ok(None),
        }
    }

    /// Returns where a column is that has to be there.
    ///
    /// # Errors
    ///
    /// [`OsmError`] when there is none or several of one name.
    pub(super) fn need(&self, column: &Column<'_>) -> Result<usize, OsmError> {
        if let Some(index) = self.find(column)? {
            return Ok(index);
        }
        let names = column.usual.join(", ");
        let way_out = if self.headers.iter().any(|h| h.parse::<f64>().is_ok()) {
            "the first line seems to hold values; put a line with the names of the columns before it"
        } else {
            "rename one of them, or give its name in the settings"
        };
        let reason =
            format!("no column with the {} ({names}); {}; {way_out}", column.what, self.columns());
        Err(self.error(1, reason))
    }

    /// Returns the next row that is not blank; `None` at the end.
    ///
    /// # Errors
    ///
    /// [`OsmError`] when it has more or less fields than there are columns.
    pub(super) fn next_row(&mut self) -> Result<Option<Row>, OsmError> {
        loop {
            let mut fields = StringRecord::new();
            let more = self.reader.read_record(&mut fields);
            if !more.map_err(|e| self.error(1, e.to_string()))? {
                return Ok(None);
            }
            if fields.iter().all(str::is_empty) {
                continue;
            }
            let start = fields.position().map_or(0, csv::Position::byte);
            let line = self.line_at(usize::try_from(start).unwrap_or(usize::MAX));
            let (found, expected) = (fields.len(), self.headers.len());
            if found != expected {
                let way_out = if found > expected {
                    "write numbers with a point (40.78, not 40,78) and put texts with commas in \
                     quotes"
                } else {
                    "complete or remove it"
                };
                let reason =
                    format!("{found} fields, but {expected} columns in the first line; {way_out}");
                return Err(self.error(line, reason));
            }
            return Ok(Some(Row { line, fields }));
        }
    }

    /// Returns a field's number; `None` if the field is empty.
    ///
    /// # Errors
    ///
    /// [`OsmError`] when it is no finite number.
    pub(super) fn optional_number(&self, row: &Row, at: usize) -> Result<Option<f64>, OsmError> {
        let text = row.text(at);
        if text.is_empty() {
            return Ok(None);
        }
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(Some(number)),
            _ => {
                let way_out = if text.contains(',') {
                    "write numbers with a point and without thousands separators"
                } else {
                    "write a number such as 40.78"
                };
                let reason = format!(
                    "column {}: {:?} is no number; {way_out}",
                    brief(&self.headers[at]),
                    brief(text)
                );
                Err(self.error(row.line, reason))
            }
        }
    }

    /// Returns a field's number.
    ///
    /// # Errors
    ///
    /// [`OsmError`] when the field is empty or no finite number.
    pub(super) fn number(&self, row: &Row, at: usize) -> Result<f64, OsmError> {
        self.optional_number(row, at)?.ok_or_else(|| {
            let reason = format!(
                "column {} is empty; fill it in or remove the row",
                brief(&self.headers[at])
            );
            self.error(row.line, reason)
        })
    }

    /// Returns the place of a row, from its columns of latitude and longitude.
    ///
    /// # Errors
    ///
    /// [`OsmError`] when it is outside the world.
    pub(super) fn place(&self, row: &Row, at: (usize, usize)) -> Result<Place, OsmError> {
        let (latitude, longitude) = (self.number(row, at.0)?, self.number(row, at.1)?);
        checked_place(latitude, longitude).map_err(|reason| self.error(row.line, reason))
    }

    /// Returns an error at a line.
    pub(super) fn error(&self, line: u64, reason: String) -> OsmError {
        malformed(self.path, line, reason)
    }

    /// Returns an error for a table in which something is missing altogether.
    pub(super) fn nothing(&self, reason: &str) -> OsmError {
        OsmError::Nothing { path: PathBuf::from(self.path), reason: reason.to_owned() }
    }

    fn columns(&self) -> String {
        let names: Vec<String> = self.headers.iter().take(QUOTED_COLUMNS).map(brief).collect();
        let more = if self.headers.len() > QUOTED_COLUMNS { ", ..." } else { "" };
        format!("the columns are {}{more}", names.join(", "))
    }

    /// Returns the line of a record, which the reader says to start before the blank lines above.
    fn line_at(&mut self, start: usize) -> u64 {
        let blank = self.text.iter().skip(start).take_while(|b| matches!(b, b'\r' | b'\n')).count();
        let (before, lines) = self.counted;
        let start = (start + blank).clamp(before, self.text.len());
        let ends = self.text[before..start].iter().filter(|b| **b == b'\n').count() as u64;
        self.counted = (start, lines + ends);
        1 + self.counted.1
    }
}

/// Returns the text of a file that has to be UTF-8, without the mark before it.
///
/// # Errors
///
/// [`OsmError`] naming the line that is not.
pub(super) fn utf8<'a>(bytes: &'a [u8], path: &Path) -> Result<&'a str, OsmError> {
    for (start, name) in PACKED {
        if bytes.starts_with(start) {
            return Err(malformed(path, 1, format!("{name}; unpack it first")));
        }
    }
    let bytes = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
    std::str::from_utf8(bytes).map_err(|e| {
        let line = 1 + bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count() as u64;
        malformed(path, line, "not UTF-8 text; save the file as UTF-8".to_owned())
    })
}

/// Returns the bytes of a regular file.
///
/// # Errors
///
/// [`OsmError::Io`] with its name.
pub(super) fn bytes(path: &Path) -> Result<Vec<u8>, OsmError> {
    regular(path)?;
    Ok(fs::read(path).map_err(FileError::at("read", path))?)
}

/// Returns what is known of a regular file. Others are refused before they are opened: a pipe
/// without a writer would block, and what a pipe holds can be read only once.
///
/// # Errors
///
/// [`FileError`] with its name and the way out.
pub(super) fn regular(path: &Path) -> Result<Metadata, FileError> {
    let about = fs::metadata(path).map_err(FileError::at("read", path))?;
    let refused = |kind, reason| Err(FileError::at("read", path)(Error::new(kind, reason)));
    if about.is_dir() {
        return refused(ErrorKind::IsADirectory, "it is a folder; give a regular file");
    }
    if !about.is_file() {
        return refused(ErrorKind::InvalidInput, "it is a pipe or device; give a regular file");
    }
    Ok(about)
}

fn malformed(path: &Path, line: u64, reason: String) -> OsmError {
    OsmError::Malformed { path: PathBuf::from(path), place: format!("line {line}"), reason }
}

/// Returns a column's name as it is compared: `Signal ID` is `signal_id`.
fn plain(name: &str) -> String {
    name.trim().to_lowercase().replace([' ', '-'], "_")
}

#[cfg(test)]
mod tests;
