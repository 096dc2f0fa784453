//! Files that hold more than one table: titles above the names of the columns, totals below the rows, several
//! tables one after the other. Every line is returned as it stands, with as many fields as it has.

use std::io::Cursor;

use csv::{Position, ReaderBuilder, StringRecord, StringRecordsIntoIter, Trim};

use super::dialect::{self, Decimals};
use super::encoding::{self, decode, with_line_feeds};
use super::fault::Fault;

/// Separators of fields.
const SEPARATORS: [u8; 4] = [b',', b';', b'\t', b'|'];

/// Lines of a file within which the first section of UTDF begins; titles may stand above it.
const SECTION_WITHIN: usize = 1000;

/// A line with its fields, without the blanks around them; at least one is not empty.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Line {
    /// Its number in the file, from 1.
    pub number: u64,
    fields: StringRecord,
    comma: bool,
}

impl Line {
    /// Returns a field, without the apostrophe before what begins like a formula; empty beyond the last one.
    pub fn text(&self, column: usize) -> &str {
        dialect::uncomputed(self.fields.get(column).unwrap_or_default())
    }

    /// Returns all fields.
    pub fn fields(&self) -> impl Iterator<Item = &str> {
        self.fields.iter()
    }

    /// Returns how many fields it has.
    pub fn len(&self) -> usize {
        self.fields.len()
    }

    /// Returns whether it has no field.
    pub fn is_empty(&self) -> bool {
        self.fields.is_empty()
    }

    /// Returns a field's number; `None` if the field is empty.
    ///
    /// # Errors
    ///
    /// The way out when it is no finite number, or may be two.
    pub fn optional(&self, column: usize) -> Result<Option<f64>, String> {
        let decimals = if self.comma { Decimals::Comma } else { Decimals::Point };
        match self.text(column) {
            "" => Ok(None),
            text => dialect::number(text, decimals).map(Some).map_err(str::to_owned),
        }
    }

    /// Returns a field's number of what is many, such as vehicles; `None` if the field is empty.
    ///
    /// # Errors
    ///
    /// The way out when it is no finite number, and both numbers when it may be two.
    pub fn count(&self, column: usize) -> Result<Option<f64>, String> {
        let decimals = if self.comma { Decimals::Comma } else { Decimals::Point };
        match self.text(column) {
            "" => Ok(None),
            text => dialect::count(text, decimals, false).map(Some),
        }
    }
}

/// Returns the lines of a file that hold anything. The separator is the one that makes the most fields; where that is no
/// comma, numbers may have decimal commas.
///
/// # Errors
///
/// [`Fault`] when it is no text, and where a quotation mark that is not closed makes one record of several lines.
pub fn lines(bytes: &[u8]) -> Result<Vec<Line>, Fault> {
    let mut text = decode(bytes)?;
    if let Some(ended) = with_line_feeds(&text) {
        text = ended.into();
    }
    let fields = |separator: u8| -> usize {
        records(&text, separator)
            .map(|record| record.map_or(0, |r| r.len().saturating_sub(1)))
            .sum()
    };
    // Of several the first.
    let best =
        SEPARATORS.into_iter().map(|s| (fields(s), s)).rev().max_by_key(|(fields, _)| *fields);
    let separator = best.map_or(b',', |(_, separator)| separator);
    let mut lines = Vec::new();
    let (mut counted, mut number) = (0, 1);
    let mut records = records(&text, separator);
    let byte = |position: &Position| usize::try_from(position.byte()).unwrap_or(usize::MAX);
    while let Some(record) = records.next() {
        let fields = record.map_err(|e| Fault::new(number, e.to_string()))?;
        // The reader says that a record starts where the one before ends, so blank lines before it are passed over here.
        let begin = fields.position().map_or(0, byte).clamp(counted, text.len());
        let blank =
            text.as_bytes()[begin..].iter().take_while(|b| matches!(b, b'\r' | b'\n')).count();
        number += encoding::lines(&text.as_bytes()[counted..begin + blank]);
        counted = begin + blank;
        let end = byte(records.reader().position()).clamp(counted, text.len());
        if is_unclosed(&text.as_bytes()[counted..end]) {
            return Err(Fault::new(number, UNCLOSED));
        }
        if fields.iter().all(str::is_empty) {
            continue;
        }
        lines.push(Line { number, fields, comma: separator != b',' });
    }
    Ok(lines)
}

/// Returns whether a file is UTDF by the names of its sections, in whatever encoding it is.
pub fn is_utdf(bytes: &[u8]) -> bool {
    let text = decode(bytes).unwrap_or_else(|_| String::from_utf8_lossy(bytes));
    let lines = text.split(['\n', '\r']).map(|line| line.trim_start_matches('\u{feff}').trim());
    lines.take(SECTION_WITHIN).any(|line| {
        let first = line.split([',', ';', '\t']).next().unwrap_or_default().trim().to_lowercase();
        ["[network]", "[nodes]", "[links]", "[lanes]", "[timeplans]", "[phases]"].contains(&&*first)
    })
}

/// What is wrong with a record that [`is_unclosed`].
pub(super) const UNCLOSED: &str = "a quotation mark is not closed; close or remove it";

/// Whether a record goes on over several lines only because a quotation mark in it is not closed.
pub(super) fn is_unclosed(record: &[u8]) -> bool {
    let marks = record.iter().filter(|byte| **byte == b'"').count();
    marks % 2 == 1 && record.trim_ascii_end().contains(&b'\n')
}

fn records(text: &str, separator: u8) -> StringRecordsIntoIter<Cursor<&[u8]>> {
    let mut builder = ReaderBuilder::new();
    builder.trim(Trim::All).flexible(true).has_headers(false).delimiter(separator);
    builder.from_reader(Cursor::new(text.as_bytes())).into_records()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn titles_blank_lines_and_totals_are_lines_of_their_own() {
        let text =
            "Counts of Main St\r\n\r\n\"Date\",INTID, NBL ,\r\n11/5/2026,7,12,\r\nTotal,,12\r\n";
        let lines = lines(text.as_bytes()).unwrap();
        let numbers: Vec<u64> = lines.iter().map(|l| l.number).collect();
        assert_eq!(numbers, [1, 3, 4, 5]);
        assert_eq!(lines[1].fields().collect::<Vec<_>>(), ["Date", "INTID", "NBL", ""]);
        assert_eq!(
            (lines[2].count(2), lines[2].count(3), lines[2].count(9)),
            (Ok(Some(12.0)), Ok(None), Ok(None))
        );
    }

    #[test]
    fn a_quotation_mark_that_is_not_closed_is_refused_at_its_line() {
        let error = |text: &str| {
            let fault = lines(text.as_bytes()).unwrap_err();
            format!("{}: {}", fault.line, fault.message)
        };
        let unclosed = "a quotation mark is not closed; close or remove it";
        let rest = "a,b\n\n1,\"crash\n2,x\n3,y\n";
        assert_eq!(error(rest), format!("3: {unclosed}"));
        assert_eq!(error("a,b\r1,\"crash\r2,x\r"), format!("2: {unclosed}"));
        // The next quotation mark closes it, and the lines between are gone.
        let part = "a,b\n1,\"crash\n2,x\n3,\"y\"\n4,z\n";
        assert_eq!(error(part), format!("2: {unclosed}"));
    }

    #[test]
    fn quotation_marks_around_several_lines_and_for_inches_are_read() {
        let lines = lines(b"a,b\n1,\"two\nlines\"\n2,12\" pipe\n3,\"last\n").unwrap();
        let second: Vec<(u64, &str)> = lines.iter().map(|l| (l.number, l.text(1))).collect();
        assert_eq!(second, [(1, "b"), (2, "two\nlines"), (4, "12\" pipe"), (5, "last")]);
    }

    #[test]
    fn the_sections_of_utdf_show_what_a_file_is() {
        assert!(is_utdf(b"\xEF\xBB\xBF[Network],,\r\nNetwork Settings,,\r\n"));
        let utf16 =
            |text: &str| text.encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>();
        assert!(
            is_utdf(&utf16("\u{feff}[Network],,\r\n")) && is_utdf(&utf16("Title\r\n[Lanes],\r\n"))
        );
        assert!(is_utdf(b"Caf\xe9\r[Network]\rNetwork Settings\r"));
        assert!(
            is_utdf(b"\n[lanes]\nLane Group Data\n")
                && !is_utdf(b"[1, 2]")
                && !is_utdf(b"a,[Network]\n")
        );
    }

    #[test]
    fn semicolons_bring_decimal_commas_and_two_meanings_are_refused() {
        let lines = lines(b"a;b;c\n1,5;1.234;x\n").unwrap();
        assert_eq!(lines[1].optional(0), Ok(Some(1.5)));
        assert!(lines[1].optional(2).unwrap_err().contains("write a number"));
        let lines = super::lines(b"a,b\n1.234,\"2,500\"\n").unwrap();
        assert!(lines[1].count(0).unwrap_err().contains("1234 if the point separates thousands"));
        assert!(lines[1].count(1).is_err());
    }
}
