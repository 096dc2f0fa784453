//! A table as comma-separated text.

use super::columns::{Cell, Cells, Columns};
use super::error::ExportError;
use super::sink::Sink;
use basics::files::{Streamed, lines};

/// Rows that are text at once.
const AT_ONCE: usize = 1024;

/// A table that is written.
pub(super) struct Table {
    file: Streamed,
}

impl Table {
    /// Begins a table with its header.
    pub(super) fn new(mut file: Streamed, columns: &Columns) -> Result<Self, ExportError> {
        let header: Vec<&str> = columns.all.iter().map(|c| c.name.as_str()).collect();
        file.write(&lines(&[header]))?;
        Ok(Self { file })
    }
}

impl Sink for Table {
    fn write(&mut self, columns: &Columns, cells: &[Cells]) -> Result<(), ExportError> {
        let row = |row: &Cells| -> Vec<String> {
            columns.all.iter().map(|column| text(row.cell(column))).collect()
        };
        // Text takes far more memory than numbers.
        for part in cells.chunks(AT_ONCE) {
            self.file.write(&lines(&part.iter().map(row).collect::<Vec<_>>()))?;
        }
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<(), ExportError> {
        Ok(self.file.finish()?)
    }
}

/// Returns a cell as text, a number as the shortest text that reads back as the same.
fn text(cell: Cell<'_>) -> String {
    match cell {
        Cell::None => String::new(),
        Cell::Whole(value) => value.to_string(),
        Cell::Number(value) => value.to_string(),
        Cell::Text(value) => value.to_owned(),
    }
}
