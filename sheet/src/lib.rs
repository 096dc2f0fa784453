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

pub mod file;
pub mod uneven;

use std::borrow::Cow;
use std::sync::Arc;

use csv::{ReaderBuilder, StringRecord, Trim};
use encoding_rs::{Encoding, UTF_8, WINDOWS_1252};

/// Digits of a group of thousands.
const GROUP: usize = 3;

const SEPARATORS: [u8; 4] = [b',', b';', b'\t', b'|'];

type Comments<'a> = Vec<(u64, &'a str)>;

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
    /// The error is the way out when it is no finite number.
    pub fn number(&self, column: usize) -> Result<Option<f64>, &'static str> {
        filled(self.text(column)).map(|text| self.columns[column].number(text)).transpose()
    }

    /// Returns a field's number of what is many, such as vehicles per day; `None` if the field is empty.
    /// `12.300` may be 12300 there, unless another number of the column has decimals.
    /// The error is the way out when it is no finite number, and both numbers when it may be two.
    pub fn count(&self, column: usize) -> Result<Option<f64>, String> {
        let count = |text| self.columns[column].count(text, self.columns[column].have_decimals());
        filled(self.text(column)).map(count).transpose()
    }
}

/// Returns the number of what is many, such as vehicles per day, from a text that is in no table.
/// The error is the way out when it is no finite number, and both numbers when it may be two.
pub fn count(text: &str) -> Result<f64, String> {
    Numbers::default().count(text, false)
}

/// A table that is being read.
pub struct Sheet {
    /// The names of the columns.
    pub headers: StringRecord,
    /// The line of the names of the columns.
    pub header_line: u64,
    columns: Arc<[Numbers]>,
    rows: std::vec::IntoIter<Record>,
}

impl Sheet {
    /// Opens a table; without any text it has no columns.
    /// Fails with [`Fault`] when it is no table, or its columns may be separated in two ways.
    pub fn open(bytes: &[u8]) -> Result<Self, Fault> {
        Self::of(&decode(bytes)?)
    }

    /// Opens a table from its text.
    /// Fails as [`Sheet::open`].
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

    /// Returns the next row that is not blank; `None` at the end.
    /// Fails with [`Fault`] when it has more or less fields than there are columns.
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

/// Returns the text of a file without the mark before it: UTF-8, UTF-16 with a mark, else Windows-1252, as Excel writes
/// it.
/// Fails with [`Fault`] for what is no text, such as a workbook.
pub fn decode(bytes: &[u8]) -> Result<Cow<'_, str>, Fault> {
    let (encoding, mark) = Encoding::for_bom(bytes).unwrap_or((UTF_8, 0));
    let text = &bytes[mark..];
    let decode = |encoding: &'static Encoding| {
        encoding.decode_without_bom_handling_and_without_replacement(text)
    };
    let decoded = decode(encoding).or_else(|| (mark == 0).then(|| decode(WINDOWS_1252)).flatten());
    decoded
        .filter(|text| !text.contains('\0'))
        .ok_or_else(|| Fault::new(1, "not text; save it as CSV in UTF-8"))
}

fn with_line_feeds(text: &str) -> Cow<'_, str> {
    match text.contains('\r') {
        true => text.replace("\r\n", "\n").replace('\r', "\n").into(),
        false => text.into(),
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Record {
    line: u64,
    fields: StringRecord,
}

/// Returns the records of a text whose lines end with `\n`, and the lines of its comments. Lines are those of the file,
/// over blank lines, comments and breaks within quotes.
fn records(
    text: &str,
    separator: u8,
    with_comments: bool,
) -> Result<(Vec<Record>, Comments<'_>), Fault> {
    let mut builder = ReaderBuilder::new();
    builder.trim(Trim::All).flexible(true).has_headers(false).delimiter(separator);
    builder.comment(with_comments.then_some(b'#'));
    let mut reader = builder.from_reader(text.as_bytes());
    let (mut records, mut comments) = (Vec::new(), Vec::new());
    let (mut at, mut line) = (0, 1);
    loop {
        let mut fields = StringRecord::new();
        let more = reader.read_record(&mut fields).map_err(|e| Fault::new(line, e.to_string()))?;
        // The reader passes over what lies before a record.
        loop {
            let blank = text[at..].len() - text[at..].trim_start_matches('\n').len();
            (at, line) = (at + blank, line + blank as u64);
            if !with_comments || !text[at..].starts_with('#') {
                break;
            }
            let comment = text[at..].lines().next().unwrap_or_default();
            comments.push((line, &comment[1..]));
            at += comment.len();
        }
        if !more {
            return Ok((records, comments));
        }
        let end = usize::try_from(reader.position().byte()).unwrap_or(usize::MAX);
        let stored = &text[at..end.clamp(at, text.len())];
        if stored.matches('"').count() % 2 == 1 && stored.trim_end().contains('\n') {
            return Err(Fault::new(line, "a quotation mark is not closed; close or remove it"));
        }
        if !fields.iter().all(str::is_empty) {
            records.push(Record { line, fields });
        }
        (at, line) = (at + stored.len(), line + stored.matches('\n').count() as u64);
    }
}

/// What the numbers of a column have between digits.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct Numbers {
    /// Something is no number.
    text: bool,
    /// One has a point, or a comma, that can only stand before decimals.
    point: bool,
    comma: bool,
    /// One may have a point between thousands.
    grouped: bool,
    /// A point may separate thousands, as other columns have decimal commas.
    doubtful: bool,
}

impl Numbers {
    fn columns<'a>(rows: impl Iterator<Item = &'a StringRecord>, separator: u8) -> Vec<Self> {
        let mut columns: Vec<Self> = Vec::new();
        for row in rows {
            columns.resize(columns.len().max(row.len()), Self::default());
            for (column, field) in columns.iter_mut().zip(row).filter(|(_, f)| !f.is_empty()) {
                match kind(field) {
                    Kind::Text => column.text = true,
                    Kind::Point => column.point = true,
                    Kind::Comma => column.comma = true,
                    Kind::Grouped => column.grouped |= field.contains('.'),
                    Kind::Whole => {}
                }
            }
        }
        // Between commas, "10,7" may be a list; elsewhere it shows decimal commas.
        let commas = separator != b',' && columns.iter().any(|c| c.comma && !c.text && !c.point);
        for column in &mut columns {
            column.doubtful = commas && column.grouped && !column.point;
        }
        columns
    }

    fn number(self, text: &str) -> Result<f64, &'static str> {
        let plain = match (text.contains(','), text.contains('.')) {
            (false, true) if !self.doubtful && (self.point || !self.comma) => text.to_owned(),
            (true, false) if self.comma && !self.point && text.matches(',').count() == 1 => {
                text.replace(',', ".")
            }
            (false, false) => text.to_owned(),
            _ => return Err("write numbers with a point and without thousands separators"),
        };
        let number = plain.parse().ok().filter(|number: &f64| number.is_finite());
        number.ok_or("write a number such as 40.78")
    }

    fn have_decimals(self) -> bool {
        self.point || self.comma
    }

    /// Returns the number of what is many, such as vehicles: a separator before three digits may be one of thousands
    /// there, unless others `have_decimals`.
    fn count(self, text: &str, have_decimals: bool) -> Result<f64, String> {
        let number = self.number(text)?;
        if have_decimals || !matches!(kind(text), Kind::Grouped) {
            return Ok(number);
        }
        let whole = text.replace([',', '.'], "");
        Err(format!(
            "{whole} if the separator is one of thousands, {number} if decimals follow; write {whole} or {number:.4}"
        ))
    }
}

enum Kind {
    Text,
    Whole,
    /// With a point or comma that may separate thousands as well.
    Grouped,
    Point,
    Comma,
}

fn kind(field: &str) -> Kind {
    let digits = field.strip_prefix(['+', '-']).unwrap_or(field);
    let number = |c: char| c.is_ascii_digit() || ".,".contains(c);
    if !digits.chars().all(number) || !digits.contains(|c: char| c.is_ascii_digit()) {
        return Kind::Text;
    }
    let Some((before, after)) = digits.split_once([',', '.']) else { return Kind::Whole };
    let thousands =
        after.len() == GROUP && (1..=GROUP).contains(&before.len()) && !before.starts_with('0');
    match digits.contains(',') {
        _ if thousands || after.contains([',', '.']) => Kind::Grouped,
        true => Kind::Comma,
        false => Kind::Point,
    }
}

#[cfg(test)]
mod tests;
