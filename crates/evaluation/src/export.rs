//! All records of a run in one table, a row per episode, as a Parquet file for pandas, polars or DuckDB.
//!
//! Rows are in the order of the plan, so that the same records give the same bytes. A task that failed has one row,
//! without an episode and with its reason.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::path::Path;
use std::ptr;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{ColumnPath, Type};

use crate::store::manifest::{Identity, PointRow};
use crate::store::packed::pack;
use crate::store::record::{Outcome, Record, Row};
use crate::store::results::Results;
use crate::store::{Layout, StoreError};
use basics::files::{FileError, write_atomically};

/// Rows that a group has at least.
const GROUP: usize = 1 << 16;

/// What records are written as.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Format {
    /// Apache Parquet, compressed, with the types of the columns
    Parquet,
    /// The run itself, without episodes of training, as runs are published
    Packed,
}

/// A row of the table: an episode of a record, or a record that has none.
#[derive(Clone, Copy)]
struct Line<'a> {
    record: &'a Record,
    row: Option<&'a Row>,
    point: &'a PointRow,
    /// Of the point MDP in the sample, if it is in it.
    weight: Option<f64>,
}

type Of<'a, T> = Box<dyn Fn(&Line<'a>) -> Option<T> + 'a>;

/// What stands in the cells of a column.
enum Cells<'a> {
    Whole(Of<'a, u64>),
    Number(Of<'a, f64>),
    Text(Of<'a, &'a str>),
}

/// Writes all records of a results directory to a file, which is either as before or complete; returns the rows of the table,
/// the tasks that have a record, and all tasks.
pub fn export(
    layout: &Layout,
    to: &Path,
    format: Format,
) -> Result<(usize, usize, usize), StoreError> {
    let results = Results::load_all(layout)?;
    let (done, tasks) = (results.done().count(), results.plan().len());
    if format == Format::Packed {
        return Ok((
            pack(layout, &results.manifest, results.done().map(|row| row.1), to)?,
            done,
            tasks,
        ));
    }
    // Of a sample that grows, only what the report is of has weights.
    let reported = results.clone().so_far();
    let draws = reported.manifest.identity.sample.draws.iter();
    let weights: HashMap<&str, f64> = draws.map(|d| (d.point.as_str(), d.weight)).collect();
    let points = results.manifest.identity.points.iter();
    let points: HashMap<&str, &PointRow> = points.map(|p| (p.point.as_str(), p)).collect();
    let rows = results.done().flat_map(|(task, record)| {
        let (point, weight) = (points[&*task.point], weights.get(&*task.point).copied());
        let alone = record.rows.is_empty().then_some(None);
        let rows = record.rows.iter().map(Some).chain(alone);
        rows.map(move |row| Line { record, row, point, weight })
    });
    let rows: Vec<Line<'_>> = rows.collect();
    let columns = columns(&results.manifest.identity, &results.episode_metrics());
    let bytes = bytes(&columns, &rows);
    let bytes = bytes.map_err(|e| FileError::at("write", to)(std::io::Error::other(e)))?;
    write_atomically(to, &bytes)?;
    Ok((rows.len(), done, tasks))
}

/// Returns the columns by name, each with whether it is a metric; a feature or metric that is called as something before it
/// has `feature_` or `metric_` before that.
fn columns<'a>(
    identity: &'a Identity,
    metrics: &BTreeSet<&'a String>,
) -> Vec<(String, Cells<'a>, bool)> {
    fn whole<'a>(of: fn(&Line<'a>) -> Option<u64>) -> Cells<'a> {
        Cells::Whole(Box::new(of))
    }
    fn text<'a>(of: fn(&Line<'a>) -> Option<&'a str>) -> Cells<'a> {
        Cells::Text(Box::new(of))
    }
    let of_task = [
        ("task", whole(|l| Some(l.record.summary.task as u64))),
        ("method", text(|l| Some(&l.record.summary.method))),
        ("point", text(|l| Some(&l.record.summary.point))),
        ("title", text(|l| Some(l.point.name()))),
        ("replicate", whole(|l| Some(l.record.summary.replicate.into()))),
        ("kind", text(|l| Some(l.row?.kind.name()))),
        ("episode", whole(|l| Some(l.row?.episode.into()))),
        ("seed", whole(|l| Some(l.row?.seed))),
        (
            "outcome",
            text(|l| match l.record.summary.outcome {
                Outcome::Ok => Some("ok"),
                Outcome::Failed => Some("failed"),
            }),
        ),
        ("reason", text(|l| l.record.summary.reason.as_deref())),
        ("importance", Cells::Number(Box::new(|l| Some(l.point.importance)))),
        ("weight", Cells::Number(Box::new(|l| l.weight))),
        ("instances", whole(|l| Some(l.point.instances.into()))),
    ];
    let mut all: Vec<(String, Cells<'_>, bool)> =
        of_task.into_iter().map(|(name, cells)| (name.to_owned(), cells, false)).collect();
    let mut taken: HashSet<String> = all.iter().map(|(name, ..)| name.clone()).collect();
    let mut add = |prefix: &str, name: &str, cells: Cells<'a>, is_metric: bool| {
        let mut name = name.to_owned();
        while !taken.insert(name.clone()) {
            name = format!("{prefix}_{name}");
        }
        all.push((name, cells, is_metric));
    };
    for (i, feature) in identity.features.iter().enumerate() {
        let of = move |l: &Line<'_>| l.point.features.get(i).copied();
        add("feature", &feature.name, Cells::Number(Box::new(of)), false);
    }
    for name in metrics.iter().copied() {
        let of = move |l: &Line<'_>| l.row?.metrics.get(name).copied();
        add("metric", name, Cells::Number(Box::new(of)), true);
    }
    all
}

fn bytes<'a>(
    columns: &[(String, Cells<'a>, bool)],
    rows: &[Line<'a>],
) -> Result<Vec<u8>, ParquetError> {
    let mut properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(format!("tsc-family {}", env!("CARGO_PKG_VERSION")));
    // Hardly any value of a metric comes again.
    for (name, ..) in columns.iter().filter(|(.., is_metric)| *is_metric) {
        let column = ColumnPath::from(name.clone());
        properties = properties.set_column_dictionary_enabled(column, false);
    }
    let field = |(name, cells, _): &(String, Cells<'_>, bool)| {
        let (physical, logical) = match cells {
            Cells::Whole(_) => (Physical::INT64, Some(LogicalType::integer(64, false))),
            Cells::Number(_) => (Physical::DOUBLE, None),
            Cells::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let field = Type::primitive_type_builder(name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical)
            .build();
        field.map(Arc::new)
    };
    let fields = columns.iter().map(field).collect::<Result<_, _>>()?;
    let schema = Type::group_type_builder("episodes").with_fields(fields).build().map(Arc::new)?;
    let properties = Arc::new(properties.build());
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, properties)?;
    let mut rest = rows;
    while !rest.is_empty() {
        let least = GROUP.min(rest.len());
        // A group ends where a record does.
        let last = rest[least - 1].record;
        let more = rest[least..].iter().take_while(|line| ptr::eq(line.record, last));
        let (rows, later) = rest.split_at(least + more.count());
        let mut group = writer.next_row_group()?;
        for (_, cells, _) in columns {
            let writer = group.next_column()?;
            let mut writer = writer.expect("there is one for every column of the schema");
            write_column(&mut writer, cells, rows)?;
            writer.close()?;
        }
        group.close()?;
        rest = later;
    }
    writer.into_inner()
}

fn write_column<'a>(
    writer: &mut SerializedColumnWriter<'_>,
    cells: &Cells<'a>,
    rows: &[Line<'a>],
) -> Result<(), ParquetError> {
    fn split<T, V>(
        cells: impl Iterator<Item = Option<T>>,
        value: fn(T) -> V,
    ) -> (Vec<V>, Vec<i16>) {
        let (mut values, mut levels) = (Vec::new(), Vec::new());
        for cell in cells {
            levels.push(i16::from(cell.is_some()));
            values.extend(cell.map(value));
        }
        (values, levels)
    }
    match cells {
        Cells::Whole(of) => {
            // Unsigned numbers stand in the same bits.
            let (values, levels) = split(rows.iter().map(of), u64::cast_signed);
            writer.typed::<Int64Type>().write_batch(&values, Some(&levels), None)?;
        }
        Cells::Number(of) => {
            let known = |line| of(line).filter(|value| !value.is_nan());
            let (values, levels) = split(rows.iter().map(known), |value| value);
            writer.typed::<DoubleType>().write_batch(&values, Some(&levels), None)?;
        }
        Cells::Text(of) => {
            let (values, levels) = split(rows.iter().map(of), ByteArray::from);
            writer.typed::<ByteArrayType>().write_batch(&values, Some(&levels), None)?;
        }
    }
    Ok(())
}
