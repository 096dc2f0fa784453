//! All records of a run in one table, a row per episode, for whoever goes on with pandas, polars, DuckDB or a
//! spreadsheet: as a Parquet file or as CSV.
//!
//! Rows are in the order of the plan, so that the same records give the same bytes, and are written group by group, so
//! that memory does not grow with them. A task that failed has one row, without an episode and with its reason.

mod columns;
mod csv;
mod error;
mod parquet;
mod sink;
mod write;

pub use columns::{Cell, Cells, Column, Columns, Kind};
pub use error::ExportError;
pub use write::{Exported, Format, export};
