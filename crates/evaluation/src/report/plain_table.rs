//! Tables for terminals.

use comfy_table::{CellAlignment, LineStyle, Table, TableStyle};

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
