//! Tables that users bring: CSV with a header, as spreadsheets and portals write it.
//!
//! One reader for all: point MDPs, approaches, signal lists, counts. What has one meaning only is
//! read: UTF-8 and UTF-16, columns between commas, semicolons, tabs or bars, decimal commas. What has
//! two is refused with both. Lines that start with `#` are comments. Lines in messages are those of
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

mod dialect;
mod encoding;
mod fault;
pub mod file;
pub mod uneven;

use std::borrow::Cow;
use std::io::Cursor;
use std::sync::Arc;

use csv::StringRecord;

use dialect::Decimals;
pub use dialect::has_decimals;
pub use encoding::decode;
use encoding::lines;
pub use fault::Fault;

/// Returns a name as people wrote it, with one blank between words; `None` for nothing but blanks, and
/// where control characters are left.
pub fn name(text: &str) -> Option<String> {
    let name = text.split_whitespace().collect::<Vec<_>>().join(" ");
    (!name.is_empty() && !name.chars().any(char::is_control)).then_some(name)
}

/// A row.
#[derive(Debug)]
pub struct Row {
    /// Line that it starts on.
    pub line: u64,
    fields: StringRecord,
    decimals: Decimals,
    with_decimals: Arc<[bool]>,
}

impl Row {
    /// Returns a field without the blanks around it, and without the apostrophe before what begins like a formula.
    pub fn text(&self, column: usize) -> &str {
        dialect::uncomputed(self.fields.get(column).unwrap_or_default())
    }

    /// Returns a field's number; `None` if the field is empty.
    ///
    /// # Errors
    ///
    /// The way out when it is no finite number.
    pub fn number(&self, column: usize) -> Result<Option<f64>, &'static str> {
        match self.text(column) {
            "" => Ok(None),
            text => dialect::number(text, self.decimals).map(Some),
        }
    }

    /// Returns a field's number of what is many, such as vehicles per day; `None` if the field is empty.
    /// `12.300` may be 12300 there, unless another number of the column has decimals.
    ///
    /// # Errors
    ///
    /// The way out when it is no finite number, and both numbers when it may be two.
    pub fn count(&self, column: usize) -> Result<Option<f64>, String> {
        let have_decimals = self.with_decimals.get(column) == Some(&true);
        match self.text(column) {
            "" => Ok(None),
            text => dialect::count(text, self.decimals, have_decimals).map(Some),
        }
    }
}

/// Returns the number of what is many, such as vehicles per day, from a text beside others that are no
/// table, as [`Row::count`] returns that of a field.
///
/// # Arguments
///
/// * `have_decimals`: whether one of the others [`has_decimals`].
///
/// # Errors
///
/// The way out when it is no finite number, and both numbers when it may be two.
pub fn count(text: &str, have_decimals: bool) -> Result<f64, String> {
    dialect::count(text, Decimals::Point, have_decimals)
}

/// A table that is being read.
pub struct Sheet<'a> {
    headers: StringRecord,
    reader: csv::Reader<Cursor<Cow<'a, [u8]>>>,
    decimals: Decimals,
    /// Per column whether a number shows that it has decimals.
    with_decimals: Arc<[bool]>,
    separator: u8,
    /// Line of the names of the columns.
    header_line: u64,
    /// Where the last record ends, bytes of the text.
    end: u64,
    /// Bytes whose lines are counted, and how many line ends they have.
    counted: (usize, u64),
}

impl<'a> Sheet<'a> {
    /// Opens a table; without any text it has no columns.
    ///
    /// # Errors
    ///
    /// [`Fault`] when it is no table, or its columns may be separated in two ways.
    pub fn open(bytes: &'a [u8]) -> Result<Self, Fault> {
        Self::of(decode(bytes)?)
    }

    /// Opens a table from its text.
    ///
    /// # Errors
    ///
    /// As [`Sheet::open`].
    pub fn of(text: impl Into<Cow<'a, str>>) -> Result<Self, Fault> {
        let mut text: Cow<'a, str> = text.into();
        if text.trim_start().starts_with('[') && uneven::is_utdf(text.as_bytes()) {
            let message = "a network in UTDF, not a table; give it with `build-networks --utdf`";
            return Err(Fault::new(1, message));
        }
        if text.trim_start().starts_with(['{', '[', '<']) {
            return Err(Fault::new(1, "holds JSON or XML, not a table; give a CSV file"));
        }
        if let Some(ended) = encoding::with_line_feeds(&text) {
            text = Cow::Owned(ended);
        }
        let said = dialect::said(&text);
        if let Some((_, bytes)) = said {
            // The line stays, as an empty one, so that lines are those of the file.
            text = Cow::Owned(text[bytes..].to_owned());
        }
        let separator = match said {
            Some((separator, _)) => separator,
            None => dialect::separator(&text)?,
        };
        let decimals = dialect::decimals(&text, separator);
        let with_decimals = dialect::with_decimals(&text, separator).into();
        let bytes = match text {
            Cow::Borrowed(text) => Cow::Borrowed(text.as_bytes()),
            Cow::Owned(text) => Cow::Owned(text.into_bytes()),
        };
        let mut reader = dialect::reader(separator, Cursor::new(bytes));
        let headers = reader.headers().map_err(|e| Fault::new(1, e.to_string()))?.clone();
        let mut sheet = Self {
            headers,
            reader,
            decimals,
            with_decimals,
            separator,
            header_line: 1,
            end: 0,
            counted: (0, 0),
        };
        sheet.header_line = sheet.next_line()?;
        Ok(sheet)
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
        loop {
            let mut fields = StringRecord::new();
            let more = self.reader.read_record(&mut fields);
            let more = more.map_err(|e| Fault::new(self.header_line, e.to_string()))?;
            // Comments at the end are looked at as well.
            let line = self.next_line()?;
            if !more {
                return Ok(None);
            }
            let text: &[u8] = self.reader.get_ref().get_ref();
            let end = usize::try_from(self.end).unwrap_or(usize::MAX).min(text.len());
            if uneven::is_unclosed(&text[self.counted.0.min(end)..end]) {
                return Err(Fault::new(line, uneven::UNCLOSED));
            }
            if fields.iter().all(str::is_empty) {
                continue;
            }
            let (found, expected) = (fields.len(), self.headers.len());
            if found != expected {
                let way_out = match (found > expected, self.separator) {
                    (true, b',') => {
                        "write numbers with a point (40.78, not 40,78) and put texts with commas in \
                         quotes"
                    }
                    (true, _) => "put texts with such separators in quotes",
                    (false, _) => "complete or remove it",
                };
                let message = format!("{found} fields, but {expected} columns; {way_out}");
                return Err(Fault { line, message });
            }
            let with_decimals = Arc::clone(&self.with_decimals);
            return Ok(Some(Row { line, fields, decimals: self.decimals, with_decimals }));
        }
    }

    /// Returns the line of the record that has just been read. The reader says that it starts where
    /// the one before ends, so blank lines and comments between them are passed over here.
    fn next_line(&mut self) -> Result<u64, Fault> {
        let text: &[u8] = self.reader.get_ref().get_ref();
        let (before, ends) = self.counted;
        let mut at = usize::try_from(self.end).unwrap_or(usize::MAX).clamp(before, text.len());
        loop {
            at += text[at..].iter().take_while(|b| matches!(b, b'\r' | b'\n')).count();
            if text.get(at) != Some(&b'#') {
                break;
            }
            let comment = text[at..].iter().take_while(|b| !matches!(b, b'\r' | b'\n')).count();
            self.check_comment(&text[at..at + comment], || ends + 1 + lines(&text[before..at]))?;
            at += comment;
        }
        let ends = ends + lines(&text[before..at]);
        self.counted = (at, ends);
        self.end = self.reader.position().byte();
        Ok(1 + ends)
    }

    /// Refuses a comment that may be a row, or the names of the columns.
    fn check_comment(&self, text: &[u8], line: impl Fn() -> u64) -> Result<(), Fault> {
        let fields =
            dialect::reader(self.separator, &text[1..]).headers().map_or(0, StringRecord::len);
        if fields < 2 || fields != self.headers.len() {
            return Ok(());
        }
        let message = "starts with # as a comment does, but has as many fields as there are \
                       columns; remove it if it is one, remove the # before names of columns, put \
                       the first field in quotes if it is a row";
        Err(Fault::new(line(), message))
    }
}

#[cfg(test)]
mod tests;
