//! A table as a Parquet file.

use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedColumnWriter, SerializedFileWriter};
use parquet::schema::types::{ColumnPath, Type};

use super::columns::{Cell, Cells, Column, Columns, Kind};
use super::error::ExportError;
use super::sink::Sink;
use basics::files::Streamed;

/// A table that is written.
pub(super) struct Table {
    writer: SerializedFileWriter<Streamed>,
    path: String,
}

impl Table {
    /// Begins a table.
    pub(super) fn new(file: Streamed, path: &Path, columns: &Columns) -> Result<Self, ExportError> {
        let path = path.display().to_string();
        let failed = failed(&path);
        let schema = schema(columns).map_err(&failed)?;
        let mut properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(format!("tsc-family {}", env!("CARGO_PKG_VERSION")));
        // Hardly any value of a metric comes again.
        for column in columns.all.iter().filter(|column| column.is_metric()) {
            let column = ColumnPath::from(column.name.clone());
            properties = properties.set_column_dictionary_enabled(column, false);
        }
        let properties = Arc::new(properties.build());
        let writer = SerializedFileWriter::new(file, schema, properties).map_err(&failed)?;
        Ok(Self { writer, path })
    }
}

fn failed(path: &str) -> impl Fn(ParquetError) -> ExportError + use<> {
    let path = path.to_owned();
    move |e| ExportError::Parquet { path: path.clone(), reason: e.to_string() }
}

fn schema(columns: &Columns) -> Result<Arc<Type>, ParquetError> {
    let field = |column: &Column| {
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

impl Sink for Table {
    fn write(&mut self, columns: &Columns, cells: &[Cells]) -> Result<(), ExportError> {
        let failed = failed(&self.path);
        let mut group = self.writer.next_row_group().map_err(&failed)?;
        for column in &columns.all {
            let writer = group.next_column().map_err(&failed)?;
            let mut writer = writer.expect("there is one for every column of the schema");
            write_column(&mut writer, column, cells).map_err(&failed)?;
            writer.close().map_err(&failed)?;
        }
        group.close().map(drop).map_err(failed)
    }

    fn finish(self: Box<Self>) -> Result<(), ExportError> {
        let failed = failed(&self.path);
        Ok(self.writer.into_inner().map_err(failed)?.finish()?)
    }
}

fn write_column(
    writer: &mut SerializedColumnWriter<'_>,
    column: &Column,
    cells: &[Cells],
) -> Result<(), ParquetError> {
    let all = || cells.iter().map(|row| row.cell(column));
    let levels: Vec<i16> = all().map(|cell| i16::from(cell != Cell::None)).collect();
    let levels = Some(levels.as_slice());
    match column.kind {
        Kind::Whole => {
            // Unsigned numbers stand in the same bits.
            let values = all().filter_map(|cell| match cell {
                Cell::Whole(value) => Some(value.cast_signed()),
                _ => None,
            });
            let values: Vec<i64> = values.collect();
            writer.typed::<Int64Type>().write_batch(&values, levels, None)?;
        }
        Kind::Number => {
            let values = all().filter_map(|cell| match cell {
                Cell::Number(value) => Some(value),
                _ => None,
            });
            let values: Vec<f64> = values.collect();
            writer.typed::<DoubleType>().write_batch(&values, levels, None)?;
        }
        Kind::Text => {
            let values = all().filter_map(|cell| match cell {
                Cell::Text(value) => Some(ByteArray::from(value)),
                _ => None,
            });
            let values: Vec<ByteArray> = values.collect();
            writer.typed::<ByteArrayType>().write_batch(&values, levels, None)?;
        }
    }
    Ok(())
}
