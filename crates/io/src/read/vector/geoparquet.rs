//! GeoParquet: columns of properties beside one of well-known binary, in groups of rows.
//!
//! With bounds, groups are left out whose statistics of bounding boxes do not meet them, and then
//! rows whose areas do not. The columns are read side by side, some thousand rows at a time. Lists
//! and records, such as names in all languages, are no properties.
//!
//! # References
//! GeoParquet 1.1; Apache Parquet format 2.12, type `GEOMETRY`.

use std::io::{BufReader, Read, Seek, SeekFrom};
use std::sync::Arc;

use bytes::Bytes;
use parquet::basic::{ConvertedType, LogicalType, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{ByteArray, DataType};
use parquet::errors::ParquetError;
use parquet::file::metadata::{ParquetMetaData, RowGroupMetaData};
use parquet::file::reader::{ChunkReader, FileReader, Length, RowGroupReader, SerializedFileReader};
use parquet::file::statistics::Statistics;
use parquet::schema::types::ColumnDescriptor;
use serde_json::Value;

use super::feature::{Feature, FeatureSet, Property, bounds, crs_of, malformed};
use super::wkb;
use crate::crs;
use crate::error::{Error, Place, Result};
use crate::input::{Input, Reader};
use crate::raster::Crs;

/// Rows that are read at once.
const BATCH: usize = 4096;
/// Names of a column of geometries in a file without metadata.
const GEOMETRY_NAMES: [&str; 4] = ["geometry", "geom", "wkb_geometry", "wkb"];

/// Reads the features of a file. With `bounds`, only those that meet them are kept.
///
/// # Errors
/// E302 for a damaged file; E303 for geometries that are no well-known binary.
pub(super) fn read(input: &Input, within: Option<[f64; 4]>) -> Result<FeatureSet> {
    let (_, length) = input.open()?;
    let wrong = |e: ParquetError| malformed(input, &e.to_string(), "a GeoParquet file");
    let file = SerializedFileReader::new(Chunks { input: input.clone(), length }).map_err(wrong)?;
    let geometry = Geometry::of(input, file.metadata())?;
    let (mut features, mut number) = (Vec::new(), 0);
    for k in 0..file.num_row_groups() {
        let group = file.get_row_group(k).map_err(wrong)?;
        let n_rows = u64::try_from(group.metadata().num_rows()).unwrap_or(0);
        if within.is_some_and(|within| geometry.is_outside(group.metadata(), within)) {
            number += n_rows;
            continue;
        }
        let mut columns = Columns::of(&*group, &geometry).map_err(wrong)?;
        loop {
            let shapes = columns.shapes.next().map_err(wrong)?;
            let n = shapes.len();
            if n == 0 {
                break;
            }
            let values =
                columns.properties.iter_mut().map(|column| column.next(n)).collect::<parquet::errors::Result<Vec<_>>>();
            let mut values: Vec<_> = values.map_err(wrong)?.into_iter().map(Vec::into_iter).collect();
            for shape in shapes {
                number += 1;
                let row: Vec<Property> =
                    values.iter_mut().map(|column| column.next().unwrap_or(Property::Null)).collect();
                let (mut polygons, mut has_other_parts) = (Vec::new(), false);
                if let Some(shape) = &shape {
                    has_other_parts = wkb::polygons_of(shape.data(), &mut polygons)
                        .map_err(|fault| Error::malformed(input, fault).at(Place::Feature(number)))?;
                }
                if within.is_some_and(|within| bounds(polygons.iter()).is_some_and(|of| !meets(of, within))) {
                    continue;
                }
                let id = columns.id.and_then(|k| row[k].text());
                let properties = columns.properties.iter().map(|column| Arc::clone(&column.name)).zip(row).collect();
                features.push(Feature { id, properties, polygons, has_other_parts, ..Feature::default() });
            }
        }
    }
    Ok(FeatureSet { crs: geometry.crs, features, ..FeatureSet::default() })
}

/// Returns `true` when two boxes west, south, east, north meet.
fn meets(a: [f64; 4], b: [f64; 4]) -> bool {
    a[0] <= b[2] && b[0] <= a[2] && a[1] <= b[3] && b[1] <= a[3]
}

/// File that is read by parts.
struct Chunks {
    input: Input,
    length: u64,
}

impl Chunks {
    fn at(&self, start: u64) -> parquet::errors::Result<BufReader<Reader>> {
        let (mut file, _) = self.input.open().map_err(|e| ParquetError::External(Box::new(e)))?;
        file.seek(SeekFrom::Start(start))?;
        Ok(BufReader::new(file))
    }
}

impl Length for Chunks {
    fn len(&self) -> u64 {
        self.length
    }
}

impl ChunkReader for Chunks {
    type T = BufReader<Reader>;

    fn get_read(&self, start: u64) -> parquet::errors::Result<Self::T> {
        self.at(start)
    }

    fn get_bytes(&self, start: u64, length: usize) -> parquet::errors::Result<Bytes> {
        // Lengths in a file are compared with it before anything is reserved.
        if start.saturating_add(length as u64) > self.length {
            return Err(ParquetError::EOF(format!("it announces {length} bytes at byte {start} of {}", self.length)));
        }
        let mut bytes = Vec::with_capacity(length);
        self.at(start)?.take(length as u64).read_to_end(&mut bytes)?;
        if bytes.len() < length {
            return Err(ParquetError::EOF(format!("it ends {} bytes early", length - bytes.len())));
        }
        Ok(bytes.into())
    }
}

/// Column of geometries, and the columns of their boxes.
struct Geometry {
    column: usize,
    crs: Result<Option<Crs>>,
    /// Columns of west, south, east and north.
    boxes: Option<[usize; 4]>,
}

impl Geometry {
    /// Finds the column of geometries by the metadata of GeoParquet, by the type of the column, or
    /// by its name.
    fn of(input: &Input, metadata: &ParquetMetaData) -> Result<Geometry> {
        let schema = metadata.file_metadata().schema_descr();
        let of_path = |path: &[&str]| (0..schema.num_columns()).find(|k| schema.column(*k).path().parts() == path);
        let pairs = metadata.file_metadata().key_value_metadata();
        let geo = pairs.into_iter().flatten().find(|pair| pair.key == "geo").and_then(|pair| pair.value.as_deref());
        let geo: Option<Value> = geo.and_then(|text| serde_json::from_str(text).ok());
        let named = geo.as_ref().and_then(|geo| geo.get("primary_column")).and_then(Value::as_str);
        let is_geometry = |k: &usize| matches!(schema.column(*k).logical_type_ref(), Some(LogicalType::Geometry(_)));
        let by_type = || (0..schema.num_columns()).find(is_geometry);
        let by_name = || GEOMETRY_NAMES.iter().find_map(|name| of_path(&[name]));
        let column = match named {
            Some(name) => of_path(&[name]),
            None => by_type().or_else(by_name),
        };
        let is_binary = |k: &usize| schema.column(*k).physical_type() == Physical::BYTE_ARRAY;
        let Some(column) = column.filter(is_binary) else {
            let wanted = "a column of geometries in well-known binary";
            let names: Vec<&str> =
                schema.columns().iter().filter_map(|c| c.path().parts().first()).map(String::as_str).collect();
            let found = format!("found columns {}", names.iter().take(12).copied().collect::<Vec<_>>().join(", "));
            return Err(Error::unsupported(input, format!("{found}, wanted {wanted}")));
        };
        let facts = geo.as_ref().zip(named).and_then(|(geo, name)| geo.get("columns")?.get(name));
        let crs = match (facts.and_then(|facts| facts.get("crs")), schema.column(column).logical_type_ref()) {
            (Some(Value::Null), _) => Ok(None),
            (Some(Value::String(text)), _) => crs_of(input, text),
            (Some(system), _) => crs_of(input, &system.to_string()),
            (None, Some(LogicalType::Geometry(of))) if of.crs.is_some() => {
                crs_of(input, of.crs.as_deref().unwrap_or_default())
            }
            (None, _) => crs::from_epsg(4326).map(Some),
        };
        let covering = |side: &str| -> Option<usize> {
            let path = facts?.get("covering")?.get("bbox")?.get(side)?.as_array()?;
            of_path(&path.iter().filter_map(Value::as_str).collect::<Vec<_>>())
        };
        let plain = |side: &str| of_path(&["bbox", side]);
        let find = |of: &dyn Fn(&str) -> Option<usize>| Some([of("xmin")?, of("ymin")?, of("xmax")?, of("ymax")?]);
        Ok(Geometry { column, crs, boxes: find(&covering).or_else(|| find(&plain)) })
    }

    /// Returns `true` when statistics say that no row of a group meets a box.
    fn is_outside(&self, group: &RowGroupMetaData, within: [f64; 4]) -> bool {
        let Some([west, south, east, north]) = self.boxes else { return false };
        let of = |column: usize, is_min: bool| extreme(group.column(column).statistics()?, is_min);
        let least = |column| of(column, true);
        let most = |column| of(column, false);
        let all = || Some([least(west)?, least(south)?, most(east)?, most(north)?]);
        all().is_some_and(|of_group| !meets(of_group, within))
    }
}

/// Returns the least or the greatest number of a column.
fn extreme(statistics: &Statistics, is_min: bool) -> Option<f64> {
    match statistics {
        Statistics::Float(of) => if is_min { of.min_opt() } else { of.max_opt() }.map(|v| f64::from(*v)),
        Statistics::Double(of) => if is_min { of.min_opt() } else { of.max_opt() }.copied(),
        _ => None,
    }
}

/// Columns of a group of rows that are read.
struct Columns {
    shapes: Shapes,
    properties: Vec<Column>,
    /// Place of the ids among the properties.
    id: Option<usize>,
}

impl Columns {
    fn of(group: &dyn RowGroupReader, geometry: &Geometry) -> parquet::errors::Result<Columns> {
        let ColumnReader::ByteArrayColumnReader(reader) = group.get_column_reader(geometry.column)? else {
            return Err(ParquetError::General("geometries that are no bytes".into()));
        };
        let of_shapes = group.metadata().column(geometry.column).column_descr();
        let shapes = Shapes { reader, is_optional: of_shapes.max_def_level() > 0 };
        let mut properties = Vec::new();
        for k in 0..group.metadata().num_columns() {
            let description = group.metadata().column(k).column_descr();
            if k != geometry.column && is_property(description) {
                properties.push(Column {
                    name: description.name().into(),
                    reader: group.get_column_reader(k)?,
                    is_optional: description.max_def_level() > 0,
                });
            }
        }
        let id = properties.iter().position(|column| *column.name == *"id");
        Ok(Columns { shapes, properties, id })
    }
}

/// Returns `true` for columns of numbers, texts and truths that are part of nothing.
fn is_property(of: &ColumnDescriptor) -> bool {
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
struct Shapes {
    reader: ColumnReaderImpl<parquet::data_type::ByteArrayType>,
    is_optional: bool,
}

impl Shapes {
    /// Returns the next geometries, none at the end.
    fn next(&mut self) -> parquet::errors::Result<Vec<Option<ByteArray>>> {
        records(&mut self.reader, BATCH, self.is_optional)
    }
}

/// Column of a property.
struct Column {
    name: Arc<str>,
    reader: ColumnReader,
    is_optional: bool,
}

impl Column {
    /// Returns the next `n` values.
    fn next(&mut self, n: usize) -> parquet::errors::Result<Vec<Property>> {
        let is_optional = self.is_optional;
        #[expect(clippy::cast_precision_loss, reason = "heights and storeys are small")]
        let whole = |v: i64| Property::Number(v as f64);
        Ok(match &mut self.reader {
            ColumnReader::BoolColumnReader(of) => {
                properties(records(of, n, is_optional)?, |v| Property::Text(if v { "yes" } else { "no" }.into()))
            }
            ColumnReader::Int32ColumnReader(of) => properties(records(of, n, is_optional)?, |v| whole(v.into())),
            ColumnReader::Int64ColumnReader(of) => properties(records(of, n, is_optional)?, whole),
            ColumnReader::FloatColumnReader(of) => properties(records(of, n, is_optional)?, |v| number(v.into())),
            ColumnReader::DoubleColumnReader(of) => properties(records(of, n, is_optional)?, number),
            ColumnReader::ByteArrayColumnReader(of) => properties(records(of, n, is_optional)?, |v| {
                v.as_utf8().map_or(Property::Null, |text| Property::Text(text.to_string()))
            }),
            _ => Vec::new(),
        })
    }
}

fn number(v: f64) -> Property {
    if v.is_finite() { Property::Number(v) } else { Property::Null }
}

fn properties<T>(values: Vec<Option<T>>, property: impl Fn(T) -> Property) -> Vec<Property> {
    values.into_iter().map(|value| value.map_or(Property::Null, &property)).collect()
}

/// Returns the next `n` values of a column, fewer at its end.
fn records<T: DataType>(
    reader: &mut ColumnReaderImpl<T>,
    n: usize,
    is_optional: bool,
) -> parquet::errors::Result<Vec<Option<T::T>>> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    let mut n_read = 0;
    while n_read < n {
        let (n_more, ..) = reader.read_records(n - n_read, is_optional.then_some(&mut levels), None, &mut values)?;
        if n_more == 0 {
            break;
        }
        n_read += n_more;
    }
    if !is_optional {
        return Ok(values.into_iter().map(Some).collect());
    }
    let mut values = values.into_iter();
    Ok(levels.into_iter().map(|level| if level > 0 { values.next() } else { None }).collect())
}
