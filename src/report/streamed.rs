//! Tables that may have millions of rows: made in several threads, written in order, never in memory as a whole.

use rayon::prelude::*;

use super::error::ReportError;
use crate::files::Streamed;

/// Rows that are in memory at once, and those that a thread makes at a time.
const AT_ONCE: usize = 8192;
const PART: usize = 256;

/// Writes a table; every row has as many cells as the header.
///
/// # Errors
///
/// [`ReportError::Io`] when the disk is full.
pub(crate) fn write_rows<T: Sync>(
    mut file: Streamed,
    header: &[String],
    rows: &[T],
    of: impl Fn(&T) -> Vec<String> + Sync,
) -> Result<(), ReportError> {
    file.write(&lines(&[header]))?;
    let text = |part: &[T]| lines(&part.iter().map(&of).collect::<Vec<_>>());
    for rows in rows.chunks(AT_ONCE) {
        for text in rows.par_chunks(PART).map(text).collect::<Vec<_>>() {
            file.write(&text)?;
        }
    }
    Ok(file.finish()?)
}

/// Returns rows as they stand in a table.
pub(crate) fn lines<R: AsRef<[C]>, C: AsRef<str>>(rows: &[R]) -> Vec<u8> {
    let mut writer = csv::WriterBuilder::new().flexible(true).from_writer(Vec::new());
    let in_memory = "writing rows to memory cannot fail";
    for row in rows {
        let cells = row.as_ref().iter().map(|cell| cell.as_ref().as_bytes());
        writer.write_record(cells).expect(in_memory);
    }
    writer.into_inner().expect(in_memory)
}
