//! Tables in columns, for data frames: Apache Parquet.

use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;

use super::columns::Column;
use crate::error::{Error, Result};

fn field(column: &Column, name: &str) -> std::result::Result<Type, ParquetError> {
    let (physical, logical) = match column {
        Column::Text(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        Column::Whole(_) => (Physical::INT64, None),
        Column::Number(_) => (Physical::DOUBLE, None),
    };
    Type::primitive_type_builder(name, physical)
        .with_repetition(Repetition::OPTIONAL)
        .with_logical_type(logical)
        .build()
}

/// Returns the values of all cells that have one, and for each cell 1 if it has one, else 0.
fn present<T: Clone>(cells: &[Option<T>]) -> (Vec<T>, Vec<i16>) {
    (cells.iter().flatten().cloned().collect(), cells.iter().map(|cell| i16::from(cell.is_some())).collect())
}

/// Encodes a table of named columns of one length as Parquet, with its provenance under the key
/// `skyshed`.
///
/// # Errors
/// E402 if the columns are not equally long.
pub fn encode_parquet(columns: &[(String, Column)], provenance: &str) -> Result<Vec<u8>> {
    encoded(columns, provenance).map_err(|e| Error::encode("a table in columns", e.to_string()))
}

fn encoded(columns: &[(String, Column)], provenance: &str) -> std::result::Result<Vec<u8>, ParquetError> {
    let fields = columns.iter().map(|(name, column)| Ok(Arc::new(field(column, name)?)));
    let fields = fields.collect::<std::result::Result<Vec<_>, ParquetError>>()?;
    let schema = Arc::new(Type::group_type_builder("skyshed").with_fields(fields).build()?);
    let origin = KeyValue::new("skyshed".to_string(), provenance.to_string());
    let properties = WriterProperties::builder()
        .set_compression(Compression::SNAPPY)
        .set_created_by("skyshed".to_string())
        .set_key_value_metadata(Some(vec![origin]))
        .build();
    let mut writer = SerializedFileWriter::new(Vec::new(), schema, Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for (_, column) in columns {
        let Some(mut out) = group.next_column()? else { break };
        match column {
            Column::Text(cells) => {
                let (values, are) = present(cells);
                let values: Vec<ByteArray> = values.iter().map(|text| text.as_str().into()).collect();
                out.typed::<ByteArrayType>().write_batch(&values, Some(&are), None)?;
            }
            Column::Whole(cells) => {
                let (values, are) = present(cells);
                out.typed::<Int64Type>().write_batch(&values, Some(&are), None)?;
            }
            Column::Number(cells) => {
                let (values, are) = present(cells);
                out.typed::<DoubleType>().write_batch(&values, Some(&are), None)?;
            }
        }
        out.close()?;
    }
    group.close()?;
    writer.into_inner()
}
