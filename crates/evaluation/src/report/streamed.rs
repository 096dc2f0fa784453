//! Tables that may have millions of rows: made in several threads, written in order, never in memory as a whole.

use rayon::prelude::*;

use super::error::ReportError;
use basics::files::{Lines, Streamed, lines};

/// Rows that are in memory at once, and those that a thread makes at a time.
const AT_ONCE: usize = 8192;
const PART: usize = 256;

/// Writes a table; `of` adds the cells of a row, as many as the header has, and ends it.
///
/// # Errors
///
/// [`ReportError::Io`] when the disk is full.
pub fn write_rows<T: Sync>(
    mut file: Streamed,
    header: &[String],
    rows: &[T],
    of: impl Fn(&T, &mut Lines) + Sync,
) -> Result<(), ReportError> {
    file.write(&lines(&[header]))?;
    let text = |part: &[T]| {
        let mut lines = Lines::default();
        part.iter().for_each(|row| of(row, &mut lines));
        lines.into_bytes()
    };
    for rows in rows.chunks(AT_ONCE) {
        for text in rows.par_chunks(PART).map(text).collect::<Vec<_>>() {
            file.write(&text)?;
        }
    }
    Ok(file.finish()?)
}
