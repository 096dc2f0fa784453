//! Tables of places: the columns of a [`Sheet`], found by their usual names.
//!
//! Every error names the line, says what was found and gives the way out, because such tables
//! come out of spreadsheets and portals in many shapes.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use sheet::{Fault, Row, Sheet};

use super::error::{OsmError, brief};
use super::extract::Place;
use super::geometry::checked_place;

/// Most columns that a message names.
const QUOTED_COLUMNS: usize = 20;

/// Names of the columns with the places of features.
pub(super) const PLACE: [&str; 2] = ["feature_latitude", "feature_longitude"];

/// Most usual names that a message names.
const QUOTED_NAMES: usize = 5;

/// Usual names of the column with the latitude.
const LATITUDE: [&str; 13] = [
    PLACE[0], "latitude", "lat", "y", "latitude_wgs84", "lat_wgs84", "lat_dd", "gps_lat",
    "point_y", "y_coord", "shape_lat", "latitude_dd", "lat_deg",
];

/// Usual names of the column with the longitude.
const LONGITUDE: [&str; 18] = [
    PLACE[1], "longitude", "lon", "lng", "long", "x", "longitude_wgs84", "lon_wgs84", "lon_dd",
    "gps_lon", "point_x", "x_coord", "shape_lng", "shape_lon", "gps_lng", "lng_wgs84",
    "longitude_dd", "lon_deg",
];

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

/// A table that is being read.
pub(super) struct Table<'a> {
    path: &'a Path,
    sheet: Sheet<'a>,
    /// What a row is called, and what its number in the file is more than its line in the text.
    rows: (&'static str, i64),
}

impl<'a> Table<'a> {
    /// Opens a table; `path` is for messages only.
    ///
    /// # Errors
    ///
    /// [`OsmError`] when it is no text, empty, or no table.
    pub(super) fn open(bytes: &'a [u8], path: &'a Path) -> Result<Self, OsmError> {
        Self::with_rows(bytes, path, ("line", 0))
    }

    /// Opens a table whose rows have other names or numbers in the file.
    ///
    /// # Errors
    ///
    /// As [`Table::open`].
    pub(super) fn with_rows(
        bytes: &'a [u8],
        path: &'a Path,
        rows: (&'static str, i64),
    ) -> Result<Self, OsmError> {
        let sheet = Sheet::open(bytes).map_err(|fault| malformed(path, fault))?;
        let table = Self { path, sheet, rows };
        if table.sheet.headers().iter().all(str::is_empty) {
            return Err(table.nothing("empty; the first line has to name the columns"));
        }
        Ok(table)
    }

    /// Returns the names of the columns.
    pub(super) fn headers(&self) -> impl Iterator<Item = &str> {
        self.sheet.headers().iter()
    }

    /// Returns the name of a column.
    pub(super) fn name(&self, column: usize) -> &str {
        self.sheet.headers().get(column).unwrap_or_default()
    }

    /// Returns the line with the names of the columns.
    pub(super) fn header_line(&self) -> u64 {
        self.sheet.header_line()
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
            let headers = self.sheet.headers();
            let mut found = (0..headers.len()).filter(|i| is(&headers[*i]));
            match (found.next(), found.next()) {
                (Some(first), None) => return Ok(Some(first)),
                (Some(first), Some(second)) => {
                    let reason = format!(
                        "columns {} and {} are both named {:?}; rename one of them",
                        first + 1,
                        second + 1,
                        brief(name)
                    );
                    return Err(self.error(self.header_line(), reason));
                }
                _ => {}
            }
        }
        match column.given {
            Some(name) => Err(self.error(
                self.header_line(),
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
        let usual = column.usual.iter().filter(|name| !PLACE.contains(name));
        let names = usual.copied().take(QUOTED_NAMES).collect::<Vec<_>>().join(", ");
        let way_out = if self.headers().any(|h| h.parse::<f64>().is_ok()) {
            "the first line seems to hold values; put a line with the names of the columns before it"
        } else {
            "rename one of them, or give its name in the settings"
        };
        let reason =
            format!("no column with the {} ({names}); {}; {way_out}", column.what, self.columns());
        Err(self.error(self.header_line(), reason))
    }

    /// Returns the next row that is not blank; `None` at the end.
    ///
    /// # Errors
    ///
    /// [`OsmError`] when it has more or less fields than there are columns.
    pub(super) fn next_row(&mut self) -> Result<Option<Row>, OsmError> {
        self.sheet.next_row().map_err(|fault| self.error(fault.line, fault.message))
    }

    /// Returns the number that a line of the text has in the file.
    pub(super) fn number_of(&self, line: u64) -> u64 {
        line.saturating_add_signed(self.rows.1).max(1)
    }

    /// Returns a field's number; `None` if the field is empty.
    ///
    /// # Errors
    ///
    /// [`OsmError`] when it is no finite number.
    pub(super) fn optional_number(&self, row: &Row, at: usize) -> Result<Option<f64>, OsmError> {
        row.number(at).map_err(|way_out| {
            let reason = format!(
                "column {}: {:?} is no number; {way_out}",
                brief(&self.sheet.headers()[at]),
                brief(row.text(at))
            );
            self.error(row.line, reason)
        })
    }

    /// Returns a field's number of what is many, such as vehicles per day.
    ///
    /// # Errors
    ///
    /// [`OsmError`] when the field is empty, no finite number, or may be two.
    pub(super) fn count(&self, row: &Row, at: usize) -> Result<f64, OsmError> {
        // What is no number or empty is told as of any other column.
        let number = self.number(row, at)?;
        row.count(at).map(|count| count.unwrap_or(number)).map_err(|both| {
            let reason = format!(
                "column {}: {:?} has two meanings: {both}",
                brief(&self.sheet.headers()[at]),
                brief(row.text(at))
            );
            self.error(row.line, reason)
        })
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
                brief(&self.sheet.headers()[at])
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
        let place = match self.rows.0 {
            "feature" if line <= self.header_line() => "columns".to_owned(),
            what => format!("{what} {}", self.number_of(line)),
        };
        OsmError::Malformed { path: PathBuf::from(self.path), place, reason }
    }

    /// Returns an error for a table in which something is missing altogether.
    pub(super) fn nothing(&self, reason: &str) -> OsmError {
        OsmError::Nothing { path: PathBuf::from(self.path), reason: reason.to_owned() }
    }

    pub(super) fn columns(&self) -> String {
        let names: Vec<String> = self.headers().take(QUOTED_COLUMNS).map(brief).collect();
        let more = if self.sheet.headers().len() > QUOTED_COLUMNS { ", ..." } else { "" };
        format!("the columns are {}{more}", names.join(", "))
    }
}

/// Returns the text of a file, without the mark before it.
///
/// # Errors
///
/// [`OsmError`] naming the line that is none.
pub(super) fn text<'a>(bytes: &'a [u8], path: &Path) -> Result<Cow<'a, str>, OsmError> {
    sheet::decode(bytes).map_err(|fault| malformed(path, fault))
}

fn malformed(path: &Path, fault: Fault) -> OsmError {
    let Fault { line, message } = fault;
    let place = format!("line {line}");
    OsmError::Malformed { path: PathBuf::from(path), place, reason: message }
}

/// Returns a column's name as it is compared: `Signal ID` is `signal_id`.
fn plain(name: &str) -> String {
    name.trim().to_lowercase().replace([' ', '-'], "_")
}

#[cfg(test)]
mod tests;
