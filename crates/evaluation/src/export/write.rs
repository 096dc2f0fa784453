//! Writes a table, some rows at a time.

use std::collections::BTreeSet;
use std::path::Path;

use super::columns::Columns;
use super::error::ExportError;
use super::sink::Sink;
use super::{csv, parquet};
use crate::store::Layout;
use crate::store::kept::{Keep, Rows};
use crate::store::record::Record;
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
    let results = Results::load_all(layout, |_| Keep::nothing())?;
    let columns = Columns::of(&results.manifest.identity, &metrics(&results));
    let has_record: Vec<bool> = results.rows().map(|(_, kept)| kept.is_some()).collect();
    let (origin, tasks) = (results.origin.clone(), has_record.len());
    let done = has_record.iter().filter(|has| **has).count();
    drop(results);
    let file = Streamed::new(to)?;
    let mut sink: Box<dyn Sink> = match format {
        Format::Csv => Box::new(csv::Table::new(file, &columns)?),
        Format::Parquet => Box::new(parquet::Table::new(file, to, &columns)?),
    };
    let (mut rows, mut cells) = (0, Vec::new());
    let of = |_: usize, record: Record| columns.cells(&record);
    origin.each(
        |position| has_record[position],
        of,
        |new| {
            cells.extend(new);
            if cells.len() >= AT_ONCE {
                rows += cells.len();
                sink.write(&columns, &cells)?;
                cells.clear();
            }
            Ok::<_, ExportError>(())
        },
    )?;
    if !cells.is_empty() {
        rows += cells.len();
        sink.write(&columns, &cells)?;
    }
    sink.finish()?;
    Ok(Exported { rows, tasks: (done, tasks) })
}

/// Returns the names of all metrics that some episode has.
fn metrics(results: &Results) -> BTreeSet<String> {
    let rows = results.done().flat_map(|(_, kept)| [Some(&kept.evaluations), kept.training()]);
    let mut last: &[String] = &[];
    let mut all = BTreeSet::new();
    for names in rows.flatten().map(Rows::all_names) {
        // Most have the names of those before them.
        if names != last {
            all.extend(names.iter().cloned());
        }
        last = names;
    }
    all
}
