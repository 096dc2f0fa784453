//! From text to records with their lines.

use csv::{ReaderBuilder, StringRecord, Trim};

use super::Fault;

/// Separators of columns.
pub(super) const SEPARATORS: [u8; 4] = [b',', b';', b'\t', b'|'];

/// A record, and the line on which it begins.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Record {
    pub(super) line: u64,
    pub(super) fields: StringRecord,
}

/// Comments, with their lines.
pub(super) type Comments<'a> = Vec<(u64, &'a str)>;

/// Returns the records of a text whose lines end with `\n`, and the lines of its comments. Lines are those of the file,
/// over blank lines, comments and breaks within quotes.
///
/// # Errors
///
/// [`Fault`] where a quotation mark that is not closed makes one record of several lines.
pub(super) fn records(
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
