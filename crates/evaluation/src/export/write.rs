//! Writes a table.

use std::path::Path;

use super::columns::{Cell, Columns, Line};
use super::parquet;
use crate::store::packed::pack;
use crate::store::results::Results;
use crate::store::{Layout, StoreError};
use basics::files::{FileError, lines, write_atomically};

/// What a table is written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// Apache Parquet, compressed, with the types of the columns
    Parquet,
    /// Comma-separated text
    Csv,
    /// The run itself, without episodes of training, as runs are published
    Packed,
}

impl Format {
    /// Returns what the names of such files end in.
    pub fn extension(self) -> &'static str {
        match self {
            Self::Parquet => "parquet",
            Self::Csv => "csv",
            Self::Packed => "jsonl.xz",
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

/// Why a table could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ExportError {
    /// The results directory cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The file cannot be written.
    #[error(transparent)]
    Io(#[from] FileError),
    /// The writer of Parquet files refused what it was given.
    #[error("cannot write {path}: {reason}")]
    Parquet {
        /// The file.
        path: String,
        /// Its reason.
        reason: String,
    },
}

/// Writes all records of a results directory to a file, which is either as before or complete.
///
/// # Errors
///
/// [`ExportError`] when a record is damaged or the file cannot be written.
pub fn export(layout: &Layout, to: &Path, format: Format) -> Result<Exported, ExportError> {
    let results = Results::load_all(layout)?;
    let tasks = (results.done().count(), results.plan().len());
    if matches!(format, Format::Packed) {
        return Ok(Exported { rows: pack(layout, &results, to)?, tasks });
    }
    let metrics = results.episode_metrics();
    // Of a sample that grows, only what the report is of has weights.
    let reported = results.clone().so_far();
    let columns =
        Columns::of(&results.manifest.identity, &reported.manifest.identity.sample, &metrics);
    let rows = results.done().flat_map(|(_, record)| {
        let alone = record.rows.is_empty().then_some(None);
        record.rows.iter().map(Some).chain(alone).map(move |row| (record, row))
    });
    let rows: Vec<Line<'_>> = rows.collect();
    let bytes = match format {
        Format::Csv => csv(&columns, &rows),
        _ => parquet::bytes(&columns, &rows).map_err(|e| ExportError::Parquet {
            path: to.display().to_string(),
            reason: e.to_string(),
        })?,
    };
    write_atomically(to, &bytes)?;
    Ok(Exported { rows: rows.len(), tasks })
}

/// Returns a table as comma-separated text; a number as the shortest text that reads back as the same.
fn csv(columns: &Columns<'_>, rows: &[Line<'_>]) -> Vec<u8> {
    let text = |cell: Cell<'_>| match cell {
        Cell::None => String::new(),
        Cell::Whole(value) => value.to_string(),
        Cell::Number(value) => value.to_string(),
        Cell::Text(value) => value.to_owned(),
    };
    let header: Vec<&str> = columns.all.iter().map(|c| c.name.as_str()).collect();
    let mut table = lines(&[header]);
    for row in rows {
        let cells = columns.all.iter().map(|column| text(columns.cell(*row, column)));
        table.extend(lines(&[cells.collect::<Vec<_>>()]));
    }
    table
}
