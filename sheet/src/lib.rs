//! Tables that users bring: CSV with a header, as spreadsheets and portals write it.
//!
//! One reader for all: point MDPs, approaches, signal lists, counts. What has one meaning only is
//! read: UTF-8, UTF-16 and Windows-1252, columns between commas, semicolons, tabs or bars, decimal commas. What has
//! two is refused. Lines that start with `#` are comments. Lines in messages are those of
//! the file, over comments, blank lines and line breaks within quotes.
//!
//! # Examples
//!
//! ```
//! use sheet::Sheet;
//!
//! # fn main() -> Result<(), sheet::Fault> {
//! let mut sheet = Sheet::open(b"id;speed_mph\nn1;27,5\n")?;
//! let row = sheet.next_row()?.expect("one row");
//! assert_eq!((row.line, row.text(0), row.number(1)), (2, "n1", Ok(Some(27.5))));
//! # Ok(())
//! # }
//! ```

mod encoding;
pub mod file;
mod numbers;
mod records;
pub mod uneven;

use std::sync::Arc;

use csv::StringRecord;

pub use encoding::decode;
use encoding::with_line_feeds;
use numbers::Numbers;
use records::{Record, SEPARATORS, records};

/// Rows that decide between two separators.
const ROWS_LOOKED_AT: usize = 50;

/// What is wrong at a line of a table.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// Line of the file, from 1.
    pub line: u64,
    /// What is wrong and the way out.
    pub message: String,
}

impl Fault {
    /// Returns a fault.
    pub fn new(line: u64, message: impl Into<String>) -> Self {
        Self { line, message: message.into() }
    }
}

/// Returns a name as people wrote it, with one blank between words; `None` for nothing but blanks, and
/// where control characters are left.
pub fn name(text: &str) -> Option<String> {
    let name = text.split_whitespace().collect::<Vec<_>>().join(" ");
    (!name.is_empty() && !name.chars().any(char::is_control)).then_some(name)
}

/// Returns a field without the apostrophe before what begins like a formula, with which tables are written so that no
/// spreadsheet computes it.
fn uncomputed(field: &str) -> &str {
    let text = field.strip_prefix('\'').filter(|text| text.starts_with(['=', '+', '-', '@']));
    text.unwrap_or(field)
}

fn filled(text: &str) -> Option<&str> {
    Some(text).filter(|text| !text.is_empty())
}

/// A row.
#[derive(Debug)]
pub struct Row {
    /// Line that it starts on.
    pub line: u64,
    fields: StringRecord,
    columns: Arc<[Numbers]>,
}

impl Row {
    /// Returns a field without the blanks around it, and without the apostrophe before what begins like a formula.
    pub fn text(&self, column: usize) -> &str {
        uncomputed(self.fields.get(column).unwrap_or_default())
    }

    /// Returns a field's number; `None` if the field is empty.
    ///
    /// # Errors
    ///
    /// The way out when it is no finite number.
    pub fn number(&self, column: usize) -> Result<Option<f64>, &'static str> {
        filled(self.text(column)).map(|text| self.columns[column].number(text)).transpose()
    }

    /// Returns a field's number of what is many, such as vehicles per day; `None` if the field is empty.
    /// `12.300` may be 12300 there, unless another number of the column has decimals.
    ///
    /// # Errors
    ///
    /// The way out when it is no finite number, and both numbers when it may be two.
    pub fn count(&self, column: usize) -> Result<Option<f64>, String> {
        let count = |text| self.columns[column].count(text, self.columns[column].have_decimals());
        filled(self.text(column)).map(count).transpose()
    }
}

/// Returns the number of what is many, such as vehicles per day, from a text that is in no table.
///
/// # Errors
///
/// The way out when it is no finite number, and both numbers when it may be two.
pub fn count(text: &str) -> Result<f64, String> {
    Numbers::default().count(text, false)
}

/// A table that is being read.
pub struct Sheet {
    headers: StringRecord,
    header_line: u64,
    columns: Arc<[Numbers]>,
    rows: std::vec::IntoIter<Record>,
}

impl Sheet {
    /// Opens a table; without any text it has no columns.
    ///
    /// # Errors
    ///
    /// [`Fault`] when it is no table, or its columns may be separated in two ways.
    pub fn open(bytes: &[u8]) -> Result<Self, Fault> {
        Self::of(&decode(bytes)?)
    }

    /// Opens a table from its text.
    ///
    /// # Errors
    ///
    /// As [`Sheet::open`].
    pub fn of(text: &str) -> Result<Self, Fault> {
        if text.trim_start().starts_with(['{', '[', '<']) {
            return Err(Fault::new(1, "JSON, XML or UTDF, not a table; give a CSV file"));
        }
        let text = with_line_feeds(text);
        // Excel may write the separator into a line of its own.
        let first = text.lines().next().unwrap_or_default();
        let says = |by: &u8| first.trim_matches('"') == format!("sep={}", char::from(*by));
        let said = SEPARATORS.into_iter().find(says);
        let rest = &text[if said.is_some() { first.len() } else { 0 }..];
        let separator = said.map_or_else(|| separator(rest), Ok)?;
        let (mut all, comments) = records(rest, separator, true)?;
        all.extend(all.is_empty().then(|| Record { line: 1, fields: StringRecord::new() }));
        let first = all.remove(0);
        let columns = Numbers::columns(all.iter().map(|row| &row.fields), separator).into();
        for (line, comment) in comments {
            let fields = comment.split(char::from(separator)).count();
            if fields > 1 && fields == first.fields.len() {
                let message = "starts with # as a comment does, but has as many fields as there are columns; remove it, \
                               or put the # in quotes";
                return Err(Fault::new(line, message));
            }
        }
        Ok(Self { headers: first.fields, header_line: first.line, columns, rows: all.into_iter() })
    }

    /// Returns the names of the columns.
    pub fn headers(&self) -> &StringRecord {
        &self.headers
    }

    /// Returns the line of the names of the columns.
    pub fn header_line(&self) -> u64 {
        self.header_line
    }

    /// Returns the next row that is not blank; `None` at the end.
    ///
    /// # Errors
    ///
    /// [`Fault`] when it has more or less fields than there are columns.
    pub fn next_row(&mut self) -> Result<Option<Row>, Fault> {
        let Some(Record { line, fields }) = self.rows.next() else { return Ok(None) };
        let (found, expected) = (fields.len(), self.headers.len());
        if found != expected {
            let message = format!(
                "{found} fields, but {expected} columns; write numbers with a point and put texts with separators in quotes"
            );
            return Err(Fault { line, message });
        }
        Ok(Some(Row { line, fields, columns: Arc::clone(&self.columns) }))
    }
}

/// Returns what separates the columns: the separator with which all rows have as many fields as there are names, else
/// the one with the most columns.
///
/// # Errors
///
/// [`Fault`] when two would do.
fn separator(text: &str) -> Result<u8, Fault> {
    let mut candidates = Vec::new();
    for separator in SEPARATORS {
        let Ok((records, _)) = records(text, separator, true) else { continue };
        let columns = records.first().map_or(0, |record| record.fields.len());
        let fits = records.iter().take(ROWS_LOOKED_AT).all(|row| row.fields.len() == columns);
        if columns > 1 {
            candidates.push((fits, columns, separator));
        }
    }
    candidates.sort_by_key(|(fits, columns, _)| (!fits, usize::MAX - columns));
    match candidates[..] {
        [(true, one, _), (true, other, _), ..] if one == other => Err(Fault::new(
            1,
            "two separators of columns would do; put texts with one of them in quotes",
        )),
        [(.., separator), ..] => Ok(separator),
        [] => Ok(b','),
    }
}

#[cfg(test)]
mod tests;
