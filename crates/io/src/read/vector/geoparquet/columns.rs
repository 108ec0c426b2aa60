//! Columns of a group of rows, read side by side.

use std::sync::Arc;

use parquet::basic::{ConvertedType, LogicalType, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{ByteArray, ByteArrayType, DataType};
use parquet::errors::ParquetError;
use parquet::file::reader::RowGroupReader;
use parquet::schema::types::ColumnDescriptor;

use super::super::feature::{Feature, Property, bounds};
use super::super::selection::meets;
use super::super::wkb;
use super::Geometry;

/// Bytes that geometries and texts may still take: a dictionary turns few bytes into many.
pub(super) struct Budget(pub(super) usize);

impl Budget {
    fn spend(&mut self, n: usize) -> parquet::errors::Result<()> {
        let too_many = || ParquetError::General("more geometries and texts than a file of its length may hold".into());
        self.0 = self.0.checked_sub(n).ok_or_else(too_many)?;
        Ok(())
    }
}

/// Columns of a group of rows that are read.
pub(super) struct Columns {
    pub(super) shapes: Shapes,
    pub(super) properties: Vec<Column>,
    /// Place of the ids among the properties.
    pub(super) id: Option<usize>,
    /// Number of rows that were read or left out.
    pub(super) at: usize,
}

impl Columns {
    pub(super) fn of(group: &dyn RowGroupReader, geometry: &Geometry) -> parquet::errors::Result<Columns> {
        let ColumnReader::ByteArrayColumnReader(reader) = group.get_column_reader(geometry.column)? else {
            return Err(ParquetError::General("geometries that are no bytes".into()));
        };
        let max_level = group.metadata().column(geometry.column).column_descr().max_def_level();
        let shapes = Shapes { reader, max_level };
        let mut properties = Vec::new();
        for k in 0..group.metadata().num_columns() {
            if k != geometry.column && is_property(group.metadata().column(k).column_descr()) {
                properties.push(Column::of(group, k)?);
            }
        }
        let id = properties.iter().position(|column| *column.name == *"id");
        Ok(Columns { shapes, properties, id, at: 0 })
    }

    /// Leaves out the rows before one.
    pub(super) fn go_to(&mut self, row: usize) -> parquet::errors::Result<()> {
        let n = row - self.at;
        self.shapes.reader.skip_records(n)?;
        self.properties.iter_mut().try_for_each(|column| column.skip(n))?;
        self.at = row;
        Ok(())
    }

    /// Reads the next rows.
    ///
    /// # Errors
    /// An early end.
    pub(super) fn next(&mut self, n: usize, budget: &mut Budget) -> parquet::errors::Result<Batch<'_>> {
        let shapes = records(&mut self.shapes.reader, n, self.shapes.max_level)?;
        if shapes.len() < n {
            return Err(ParquetError::EOF(format!("its geometries end after {} rows", self.at + shapes.len())));
        }
        shapes.iter().flatten().try_for_each(|shape| budget.spend(shape.len()))?;
        let mut values = Vec::new();
        for column in &mut self.properties {
            values.push(column.next(n, budget)?.into_iter());
        }
        self.at += n;
        Ok(Batch { shapes, values, columns: self })
    }
}

/// Rows that were read.
pub(super) struct Batch<'a> {
    pub(super) shapes: Vec<Option<ByteArray>>,
    pub(super) values: Vec<std::vec::IntoIter<Property>>,
    pub(super) columns: &'a Columns,
}

impl Batch<'_> {
    /// Appends its rows as features, except those outside of a box. Fails with the place of a row and
    /// its fault.
    pub(super) fn add_to(
        mut self,
        features: &mut Vec<Feature>,
        within: Option<[f64; 4]>,
    ) -> std::result::Result<(), (usize, String)> {
        for (k, shape) in self.shapes.iter().enumerate() {
            let row: Vec<Property> = self.values.iter_mut().map(|v| v.next().unwrap_or(Property::Null)).collect();
            let feature = match shape {
                Some(shape) => wkb::areas_of(shape.data()).map_err(|fault| (k, fault))?.into_feature(),
                None => Feature::default(),
            };
            if within.is_some_and(|within| bounds(feature.polygons.iter()).is_some_and(|of| !meets(of, within))) {
                continue;
            }
            let id = self.columns.id.and_then(|k| row[k].text());
            let names = self.columns.properties.iter().map(|column| Arc::clone(&column.name));
            features.push(Feature { id, properties: names.zip(row).collect(), ..feature });
        }
        Ok(())
    }
}

/// Returns `true` for columns of numbers, texts and truths that are part of nothing.
pub(super) fn is_property(of: &ColumnDescriptor) -> bool {
    let is_text = || {
        matches!(of.converted_type(), ConvertedType::UTF8 | ConvertedType::ENUM)
            || matches!(of.logical_type_ref(), Some(LogicalType::String | LogicalType::Enum))
    };
    let is_known = match of.physical_type() {
        Physical::BOOLEAN | Physical::FLOAT | Physical::DOUBLE => true,
        Physical::INT32 | Physical::INT64 => of.converted_type() != ConvertedType::DECIMAL,
        Physical::BYTE_ARRAY => is_text(),
        _ => false,
    };
    is_known && of.path().parts().len() == 1 && of.max_rep_level() == 0 && of.max_def_level() <= 1
}

/// Column of geometries.
pub(super) struct Shapes {
    pub(super) reader: ColumnReaderImpl<ByteArrayType>,
    pub(super) max_level: i16,
}

/// Column of a property.
pub(super) struct Column {
    pub(super) name: Arc<str>,
    pub(super) reader: ColumnReader,
    /// Level of a value that is there.
    pub(super) max_level: i16,
}

impl Column {
    pub(super) fn of(group: &dyn RowGroupReader, k: usize) -> parquet::errors::Result<Column> {
        let description = group.metadata().column(k).column_descr();
        let (name, max_level) = (description.name().into(), description.max_def_level());
        Ok(Column { name, reader: group.get_column_reader(k)?, max_level })
    }

    /// Leaves out the next `n` values.
    pub(super) fn skip(&mut self, n: usize) -> parquet::errors::Result<()> {
        match &mut self.reader {
            ColumnReader::BoolColumnReader(of) => of.skip_records(n),
            ColumnReader::Int32ColumnReader(of) => of.skip_records(n),
            ColumnReader::Int64ColumnReader(of) => of.skip_records(n),
            ColumnReader::FloatColumnReader(of) => of.skip_records(n),
            ColumnReader::DoubleColumnReader(of) => of.skip_records(n),
            ColumnReader::ByteArrayColumnReader(of) => of.skip_records(n),
            _ => Ok(0),
        }
        .map(|_| ())
    }

    /// Returns the next `n` values.
    pub(super) fn next(&mut self, n: usize, budget: &mut Budget) -> parquet::errors::Result<Vec<Property>> {
        let max = self.max_level;
        #[expect(clippy::cast_precision_loss, reason = "heights and storeys are small")]
        let whole = |v: i64| Property::Number(v as f64);
        Ok(match &mut self.reader {
            ColumnReader::BoolColumnReader(of) => {
                properties(records(of, n, max)?, |v| Property::Text(if v { "yes" } else { "no" }.into()))
            }
            ColumnReader::Int32ColumnReader(of) => properties(records(of, n, max)?, |v| whole(v.into())),
            ColumnReader::Int64ColumnReader(of) => properties(records(of, n, max)?, whole),
            ColumnReader::FloatColumnReader(of) => properties(records(of, n, max)?, |v| number(v.into())),
            ColumnReader::DoubleColumnReader(of) => properties(records(of, n, max)?, number),
            ColumnReader::ByteArrayColumnReader(of) => {
                let texts = records(of, n, max)?;
                texts.iter().flatten().try_for_each(|text| budget.spend(text.len()))?;
                properties(texts, |v| v.as_utf8().map_or(Property::Null, |text| Property::Text(text.to_string())))
            }
            _ => Vec::new(),
        })
    }
}

pub(super) fn number(v: f64) -> Property {
    if v.is_finite() { Property::Number(v) } else { Property::Null }
}

pub(super) fn properties<T>(values: Vec<Option<T>>, property: impl Fn(T) -> Property) -> Vec<Property> {
    values.into_iter().map(|value| value.map_or(Property::Null, &property)).collect()
}

/// Returns the next `n` values of a column, fewer at its end.
pub(super) fn records<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    n: usize,
    max_level: i16,
) -> parquet::errors::Result<Vec<Option<T::T>>> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    let mut n_read = 0;
    while n_read < n {
        let (n_more, ..) =
            reader.read_records(n - n_read, (max_level > 0).then_some(&mut levels), None, &mut values)?;
        if n_more == 0 {
            break;
        }
        n_read += n_more;
    }
    if max_level == 0 {
        return Ok(values.into_iter().map(Some).collect());
    }
    let mut values = values.into_iter();
    Ok(levels.into_iter().map(|level| if level == max_level { values.next() } else { None }).collect())
}
