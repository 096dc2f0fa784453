//! Tables of plain text: for terminals, and for whoever writes them otherwise.

use comfy_table::{CellAlignment, LineStyle, Table, TableStyle};

/// A table before it is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Cells {
    /// Headings of the columns.
    pub(super) header: Vec<String>,
    /// Columns of numbers.
    pub(super) right: Vec<usize>,
    /// The rows.
    pub(super) rows: Vec<Vec<String>>,
}

impl Cells {
    /// Returns the table for terminals.
    pub(super) fn plain(self) -> String {
        let header: Vec<&str> = self.header.iter().map(String::as_str).collect();
        plain_table(&header, &self.right, self.rows)
    }
}

/// Returns a table with a rule below its heading; the columns of numbers are aligned to the right.
pub(super) fn plain_table(header: &[&str], right: &[usize], rows: Vec<Vec<String>>) -> String {
    let mut table = Table::new();
    let rule = LineStyle::none().fill('-').junction('-');
    table.load_style(TableStyle::new().header_separator(rule)).set_header(header);
    for i in right {
        if let Some(column) = table.column_mut(*i) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    for row in rows {
        table.add_row(row);
    }
    table.trim_fmt()
}
