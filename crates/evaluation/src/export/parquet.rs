//! A table as a Parquet file.

use std::ptr;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{ColumnPath, Type};

use super::columns::{Cell, Column, Columns, Kind, Line};

/// Rows that a group has at least.
const GROUP: usize = 1 << 16;

/// Returns a table as a Parquet file.
///
/// # Errors
///
/// What the writer of Parquet files refuses.
pub(super) fn bytes(columns: &Columns<'_>, rows: &[Line<'_>]) -> Result<Vec<u8>, ParquetError> {
    let mut properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by(format!("tsc-family {}", env!("CARGO_PKG_VERSION")));
    // Hardly any value of a metric comes again.
    for column in columns.all.iter().filter(|column| column.is_metric()) {
        let column = ColumnPath::from(column.name.clone());
        properties = properties.set_column_dictionary_enabled(column, false);
    }
    let properties = Arc::new(properties.build());
    let mut writer = SerializedFileWriter::new(Vec::new(), schema(columns)?, properties)?;
    let mut rest = rows;
    while !rest.is_empty() {
        let least = GROUP.min(rest.len());
        // A group ends where a record does.
        let last = rest[least - 1].0;
        let more = rest[least..].iter().take_while(|(record, _)| ptr::eq(*record, last));
        let (rows, later) = rest.split_at(least + more.count());
        let mut group = writer.next_row_group()?;
        for column in &columns.all {
            let writer = group.next_column()?;
            let mut writer = writer.expect("there is one for every column of the schema");
            let cells: Vec<Cell<'_>> = rows.iter().map(|row| columns.cell(*row, column)).collect();
            write_column(&mut writer, column.kind, &cells)?;
            writer.close()?;
        }
        group.close()?;
        rest = later;
    }
    writer.into_inner()
}

fn schema(columns: &Columns<'_>) -> Result<Arc<Type>, ParquetError> {
    let field = |column: &Column<'_>| {
        let (physical, logical) = match column.kind {
            Kind::Whole => (Physical::INT64, Some(LogicalType::integer(64, false))),
            Kind::Number => (Physical::DOUBLE, None),
            Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let field = Type::primitive_type_builder(&column.name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical)
            .build();
        field.map(Arc::new)
    };
    let fields = columns.all.iter().map(field).collect::<Result<_, _>>()?;
    Type::group_type_builder("episodes").with_fields(fields).build().map(Arc::new)
}

fn write_column(
    writer: &mut SerializedColumnWriter<'_>,
    kind: Kind,
    cells: &[Cell<'_>],
) -> Result<(), ParquetError> {
    let levels: Vec<i16> = cells.iter().map(|cell| i16::from(*cell != Cell::None)).collect();
    let levels = Some(levels.as_slice());
    match kind {
        Kind::Whole => {
            // Unsigned numbers stand in the same bits.
            let values = cells.iter().filter_map(|cell| match cell {
                Cell::Whole(value) => Some(value.cast_signed()),
                _ => None,
            });
            let values: Vec<i64> = values.collect();
            writer.typed::<Int64Type>().write_batch(&values, levels, None)?;
        }
        Kind::Number => {
            let values = cells.iter().filter_map(|cell| match cell {
                Cell::Number(value) => Some(*value),
                _ => None,
            });
            let values: Vec<f64> = values.collect();
            writer.typed::<DoubleType>().write_batch(&values, levels, None)?;
        }
        Kind::Text => {
            let values = cells.iter().filter_map(|cell| match cell {
                Cell::Text(value) => Some(ByteArray::from(*value)),
                _ => None,
            });
            let values: Vec<ByteArray> = values.collect();
            writer.typed::<ByteArrayType>().write_batch(&values, levels, None)?;
        }
    }
    Ok(())
}
