//! A table as comma-separated text.

use super::columns::{Cell, Cells, Columns};
use super::error::ExportError;
use super::sink::Sink;
use crate::files::Streamed;

/// A table that is written.
pub(super) struct Table {
    file: Streamed,
}

impl Table {
    /// Begins a table with its header.
    pub(super) fn new(mut file: Streamed, columns: &Columns) -> Result<Self, ExportError> {
        file.write(&lines(std::iter::once(columns.all.iter().map(|c| c.name.clone()).collect())))?;
        Ok(Self { file })
    }
}

impl Sink for Table {
    fn write(&mut self, columns: &Columns, cells: &[Cells]) -> Result<(), ExportError> {
        let row = |row: &Cells| columns.all.iter().map(|column| text(row.cell(column))).collect();
        Ok(self.file.write(&lines(cells.iter().map(row)))?)
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

fn lines(rows: impl Iterator<Item = Vec<String>>) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let in_memory = "writing rows of equal length to memory cannot fail";
    rows.for_each(|row| writer.write_record(row).expect(in_memory));
    writer.into_inner().expect(in_memory)
}
