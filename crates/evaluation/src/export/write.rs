//! Writes a table, some rows at a time.

use std::path::Path;

use super::columns::Columns;
use super::error::ExportError;
use super::sink::Sink;
use super::{csv, parquet};
use crate::store::Layout;
use crate::store::results::Results;
use basics::files::Streamed;

/// Rows that are in memory at once, and that a group of a Parquet file has at least.
const AT_ONCE: usize = 1 << 16;

/// What a table is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// Apache Parquet, compressed, with the types of the columns
    Parquet,
    /// Comma-separated text
    Csv,
}

impl Format {
    /// Returns what the names of such files end in.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Parquet => "parquet",
            Self::Csv => "csv",
        }
    }
}

/// What was written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Exported {
    /// Rows of the table.
    pub rows: usize,
    /// Tasks that have a record, and all.
    pub tasks: (usize, usize),
}

/// Writes all records of a results directory to a file, which is either as before or complete.
///
/// # Errors
///
/// [`ExportError`] when a record is damaged or the file cannot be written.
pub fn export(layout: &Layout, to: &Path, format: Format) -> Result<Exported, ExportError> {
    let results = Results::load_all(layout)?;
    let columns = Columns::of(&results.manifest.identity, &results.episode_metrics());
    let file = Streamed::new(to)?;
    let mut sink: Box<dyn Sink> = match format {
        Format::Csv => Box::new(csv::Table::new(file, &columns)?),
        Format::Parquet => Box::new(parquet::Table::new(file, to, &columns)?),
    };
    let (mut rows, mut cells) = (0, Vec::new());
    for (_, record) in results.done() {
        cells.extend(columns.cells(record));
        if cells.len() >= AT_ONCE {
            rows += cells.len();
            sink.write(&columns, &cells)?;
            cells.clear();
        }
    }
    if !cells.is_empty() {
        rows += cells.len();
        sink.write(&columns, &cells)?;
    }
    sink.finish()?;
    Ok(Exported { rows, tasks: (results.done().count(), results.plan().len()) })
}
