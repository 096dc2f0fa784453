//! What a table is written to.

use super::columns::{Cells, Columns};
use super::error::ExportError;

/// What takes the rows of a table, some at a time.
pub(super) trait Sink {
    fn write(&mut self, columns: &Columns, cells: &[Cells]) -> Result<(), ExportError>;
    fn finish(self: Box<Self>) -> Result<(), ExportError>;
}
