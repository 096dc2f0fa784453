//! Files that hold more than one table: titles above the names of the columns, totals below the rows, several
//! tables one after the other. Every line is returned as it stands, with as many fields as it has.

use super::{
    Fault, Numbers, Record, SEPARATORS, decode, filled, records, uncomputed, with_line_feeds,
};

/// Lines of a file within which the first section of UTDF begins; titles may stand above it.
const SECTION_WITHIN: usize = 1000;

/// A line with its fields, without the blanks around them; at least one is not empty.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Line {
    /// Its number in the file, from 1.
    pub number: u64,
    record: Record,
    numbers: Numbers,
}

impl Line {
    /// Returns a field, without the apostrophe before what begins like a formula; empty beyond the last one.
    pub fn text(&self, column: usize) -> &str {
        uncomputed(self.record.fields.get(column).unwrap_or_default())
    }

    /// Returns all fields.
    pub fn fields(&self) -> impl Iterator<Item = &str> {
        self.record.fields.iter()
    }

    /// Returns a field's number; `None` if the field is empty.
    /// The error is the way out when it is no finite number, or may be two.
    pub fn optional(&self, column: usize) -> Result<Option<f64>, String> {
        let number = filled(self.text(column)).map(|text| self.numbers.number(text));
        number.transpose().map_err(str::to_owned)
    }

    /// Returns a field's number of what is many, such as vehicles; `None` if the field is empty.
    /// The error is the way out when it is no finite number, and both numbers when it may be two.
    pub fn count(&self, column: usize) -> Result<Option<f64>, String> {
        filled(self.text(column)).map(|text| self.numbers.count(text, false)).transpose()
    }
}

/// Returns the lines of a file that hold anything. The separator is the one that makes the most fields; where that is no
/// comma, numbers may have decimal commas.
/// Fails with [`Fault`] when it is no text, and where a quotation mark that is not closed makes one record of several lines.
pub fn lines(bytes: &[u8]) -> Result<Vec<Line>, Fault> {
    let text = decode(bytes)?;
    let text = with_line_feeds(&text);
    let mut found = SEPARATORS.map(|separator| (separator, records(&text, separator, false)));
    // Of several the first.
    found.sort_by_key(|(_, found)| {
        let fields = found.iter().flat_map(|(all, _)| all).map(|r| r.fields.len() - 1);
        std::cmp::Reverse(fields.sum::<usize>())
    });
    let [(separator, found), ..] = found;
    let numbers = Numbers { comma: separator != b',', ..Numbers::default() };
    let line = |record: Record| Line { number: record.line, record, numbers };
    Ok(found?.0.into_iter().map(line).collect())
}

/// Returns whether a file is UTDF by the names of its sections, in whatever encoding it is.
pub fn is_utdf(bytes: &[u8]) -> bool {
    let Ok(text) = decode(bytes) else { return false };
    text.split(['\n', '\r']).take(SECTION_WITHIN).any(|line| {
        let first = line.split([',', ';', '\t']).next().unwrap_or_default().trim().to_lowercase();
        ["[network]", "[nodes]", "[links]", "[lanes]", "[timeplans]", "[phases]"].contains(&&*first)
    })
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
    fn the_sections_of_utdf_show_what_a_file_is() {
        assert!(is_utdf(b"\xEF\xBB\xBF[Network],,\r\nNetwork Settings,,\r\n"));
        assert!(is_utdf(b"\xFF\xFE[\0L\0a\0n\0e\0s\0]\0,\0"));
        assert!(is_utdf(b"Caf\xe9\r[Network]\rNetwork Settings\r"));
        assert!(!is_utdf(b"[1, 2]") && !is_utdf(b"a,[Network]\n"));
    }

    #[test]
    fn semicolons_bring_decimal_commas_and_two_meanings_are_refused() {
        let lines = lines(b"a;b;c\n1,5;1.234;x\n").unwrap();
        assert_eq!(lines[1].optional(0), Ok(Some(1.5)));
        assert!(lines[1].optional(1).is_err() && lines[1].optional(2).is_err());
        let lines = super::lines(b"a,b\n1.234,\"2,500\"\n").unwrap();
        assert!(lines[1].count(0).is_err() && lines[1].count(1).is_err());
    }
}
