//! All records of a run in one table, a row per episode, for whoever goes on with pandas, polars, DuckDB or a
//! spreadsheet: as a Parquet file or as CSV.
//!
//! Rows are in the order of the plan, so that the same records give the same bytes. A task that failed has one row,
//! without an episode and with its reason.

mod columns;
mod parquet;
mod write;

pub use write::{ExportError, Exported, Format, export};
