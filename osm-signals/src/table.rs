//! Tables of places: the columns of a [`Sheet`], found by their usual names.

use std::borrow::Cow;
use std::path::Path;

use sheet::{Fault, Row, Sheet};

use super::error::{OsmError, brief, malformed};
use super::extract::Place;
use super::geometry::checked_place;

/// Most columns, and most usual names, that a message names.
const QUOTED_COLUMNS: usize = 20;
const QUOTED_NAMES: usize = 4;

/// Names of the columns with the places of features.
pub(super) const PLACE: [&str; 2] = ["feature_latitude", "feature_longitude"];

/// Usual names of the columns with latitude and longitude.
const LATITUDE: &[&str] =
    &[PLACE[0], "latitude", "lat", "y", "gps_lat", "point_y", "y_coord", "shape_lat", "lat_wgs84"];
const LONGITUDE: &[&str] = &[
    PLACE[1], "longitude", "lon", "lng", "long", "x", "gps_lon", "gps_lng", "point_x", "x_coord",
    "shape_lng", "shape_lon", "lon_wgs84",
];

#[derive(Debug, Clone, Copy)]
pub(super) struct Column<'a> {
    /// What it holds; also the setting that gives its name.
    pub(super) what: &'static str,
    pub(super) given: Option<&'a str>,
    pub(super) usual: &'a [&'a str],
}

impl<'a> Column<'a> {
    pub(super) fn place(given: [Option<&'a str>; 2]) -> [Self; 2] {
        [
            Self { what: "latitude", given: given[0], usual: LATITUDE },
            Self { what: "longitude", given: given[1], usual: LONGITUDE },
        ]
    }
}

pub(super) struct Table<'a> {
    path: &'a Path,
    sheet: Sheet,
    /// What a row is called, and what its number in the file is more than its line in the text.
    rows: (&'static str, i64),
}

impl<'a> Table<'a> {
    pub(super) fn open(
        bytes: &[u8],
        path: &'a Path,
        rows: (&'static str, i64),
    ) -> Result<Self, OsmError> {
        let sheet = Sheet::open(bytes).map_err(|fault| at_line(path, fault))?;
        let table = Self { path, sheet, rows };
        if table.sheet.headers.iter().all(str::is_empty) {
            return Err(table.nothing("empty; the first line has to name the columns"));
        }
        Ok(table)
    }

    pub(super) fn headers(&self) -> impl Iterator<Item = &str> {
        self.sheet.headers.iter()
    }

    pub(super) fn name(&self, column: usize) -> String {
        brief(self.sheet.headers.get(column).unwrap_or_default())
    }

    pub(super) fn find(&self, column: &Column<'_>) -> Result<Option<usize>, OsmError> {
        let given = column.given.as_ref().map(std::slice::from_ref);
        for name in given.unwrap_or(column.usual) {
            let mut found = self.headers().enumerate().filter(|(_, h)| plain(h) == plain(name));
            match (found.next(), found.next()) {
                (Some((first, _)), None) => return Ok(Some(first)),
                (Some(_), Some(_)) => {
                    let reason = format!("two columns {:?}; rename one of them", brief(name));
                    return Err(self.error(self.header_line(), reason));
                }
                _ => {}
            }
        }
        column.given.map_or(Ok(None), |name| {
            let (name, what) = (brief(name), column.what);
            Err(self.no_column(&format!("no column {name:?} (given as {what})")))
        })
    }

    pub(super) fn need(&self, column: &Column<'_>) -> Result<usize, OsmError> {
        self.find(column)?.ok_or_else(|| {
            let usual = column.usual.iter().filter(|name| !PLACE.contains(name));
            let names: Vec<&str> = usual.copied().take(QUOTED_NAMES).collect();
            self.no_column(&format!("no column with the {} ({})", column.what, names.join(", ")))
        })
    }

    fn no_column(&self, what: &str) -> OsmError {
        let names: Vec<String> = self.headers().take(QUOTED_COLUMNS).map(brief).collect();
        let names = names.join(", ");
        let reason = format!(
            "{what}; the columns are {names}; rename one, or give its name in the settings"
        );
        self.error(self.header_line(), reason)
    }

    pub(super) fn next_row(&mut self) -> Result<Option<Row>, OsmError> {
        self.sheet.next_row().map_err(|fault| self.error(fault.line, fault.message))
    }

    pub(super) fn header_line(&self) -> u64 {
        self.sheet.header_line
    }

    /// Returns the number that a line of the text has in the file.
    pub(super) fn number_of(&self, line: u64) -> u64 {
        line.saturating_add_signed(self.rows.1).max(1)
    }

    pub(super) fn optional_number(&self, row: &Row, at: usize) -> Result<Option<f64>, OsmError> {
        row.number(at).map_err(|way_out| self.no_number(row, at, way_out))
    }

    pub(super) fn count(&self, row: &Row, at: usize) -> Result<f64, OsmError> {
        let count = row.count(at).map_err(|way_out| self.no_number(row, at, &way_out))?;
        count.ok_or_else(|| self.no_number(row, at, "fill it in or remove the row"))
    }

    pub(super) fn place(&self, row: &Row, at: [usize; 2]) -> Result<Place, OsmError> {
        let number = |at| {
            let number = self.optional_number(row, at)?;
            number.ok_or_else(|| self.no_number(row, at, "fill it in or remove the row"))
        };
        let (latitude, longitude) = (number(at[0])?, number(at[1])?);
        checked_place(latitude, longitude).map_err(|reason| self.error(row.line, reason))
    }

    fn no_number(&self, row: &Row, at: usize, way_out: &str) -> OsmError {
        let (name, text) = (self.name(at), brief(row.text(at)));
        self.error(row.line, format!("column {name}: {text:?} is no number; {way_out}"))
    }

    pub(super) fn error(&self, line: u64, reason: String) -> OsmError {
        malformed(self.path, format!("{} {}", self.rows.0, self.number_of(line)), reason)
    }

    pub(super) fn nothing(&self, reason: &str) -> OsmError {
        OsmError::Nothing { path: self.path.to_path_buf(), reason: reason.to_owned() }
    }
}

/// Returns the text of a file, without the mark before it.
pub(super) fn text<'a>(bytes: &'a [u8], path: &Path) -> Result<Cow<'a, str>, OsmError> {
    sheet::decode(bytes).map_err(|fault| at_line(path, fault))
}

fn at_line(path: &Path, Fault { line, message }: Fault) -> OsmError {
    malformed(path, format!("line {line}"), message)
}

/// Returns a column's name as it is compared: `Signal ID`, `signal_id` and `SignalID` are one.
fn plain(name: &str) -> String {
    name.to_lowercase().chars().filter(|c| c.is_alphanumeric()).collect()
}

#[cfg(test)]
mod tests;
