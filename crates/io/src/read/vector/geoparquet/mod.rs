//! GeoParquet: columns of properties beside one of well-known binary, in groups of rows.
//!
//! With bounds, groups are left out whose statistics of bounding boxes do not meet them, and then
//! rows whose areas do not. The columns are read side by side, some thousand rows at a time. Lists
//! and records, such as names in all languages, are no properties.
//!
//! # References
//! GeoParquet 1.1; Apache Parquet format 2.12, type `GEOMETRY`.

mod chunks;
mod columns;
mod footer;

use std::ops::Range;

use parquet::basic::{LogicalType, Type as Physical};
use parquet::errors::ParquetError;
use parquet::file::metadata::{ParquetMetaData, RowGroupMetaData};
use parquet::file::reader::{FileReader, RowGroupReader, SerializedFileReader};
use parquet::file::statistics::Statistics;
use serde_json::Value;

use super::feature::{FeatureSet, Property, crs_of, malformed};
use super::selection::{Selection, meets};
use crate::crs;
use crate::error::{Cause, Error, Place, Result};
use crate::guard::guarded;
use crate::input::Input;
use crate::raster::Crs;
use chunks::Chunks;
use columns::{Budget, Column, Columns};

/// Rows that are read at once.
const BATCH: usize = 4096;
/// Names of a column of geometries in a file without metadata.
const GEOMETRY_NAMES: [&str; 4] = ["geometry", "geom", "wkb_geometry", "wkb"];

/// Reads the features of a file. With bounds, only those that meet them are kept.
///
/// # Errors
/// E302 for a damaged file; E303 for geometries that are no well-known binary.
pub(super) fn read(input: &Input, selection: Selection<'_>) -> Result<FeatureSet> {
    // The library gives up on some bytes.
    guarded(|| read_columns(input, selection))
        .unwrap_or_else(|| Err(malformed(input, "a description or pages that are none", "a GeoParquet file")))
}

fn read_columns(input: &Input, selection: Selection<'_>) -> Result<FeatureSet> {
    let wrong = |e: ParquetError| match e.to_string() {
        what if what.contains("Disabled feature") => {
            Error::unsupported(input, "it is compressed in a way that this build does not read")
                .because(Cause::NotBuilt)
        }
        what => malformed(input, &what, "a GeoParquet file"),
    };
    let chunks = Chunks::of(input)?;
    chunks.check_footer().map_err(wrong)?;
    let (length, mut budget) = (chunks.length, Budget(chunks.most_bytes()));
    let file = SerializedFileReader::new(chunks).map_err(wrong)?;
    // Each row takes a byte at least, of its geometry.
    let announced = file.metadata().file_metadata().num_rows();
    let all = file.metadata().row_groups().iter().map(|group| i128::from(group.num_rows())).sum::<i128>();
    if all > i128::from(length) || i128::from(announced) != all {
        let found = format!("it announces {announced} rows, and {all} in its groups, in {length} bytes");
        return Err(malformed(input, &found, "a GeoParquet file"));
    }
    let geometry = Geometry::of(input, file.metadata())?;
    let within = selection.bounds_in(geometry.crs.as_ref().ok().and_then(Option::as_ref));
    let (mut features, mut n_before) = (Vec::new(), 0);
    for k in 0..file.num_row_groups() {
        let group = file.get_row_group(k).map_err(wrong)?;
        let n_rows = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        let rows = match within {
            Some(within) if geometry.is_outside(group.metadata(), within) => Vec::new(),
            Some(within) => geometry.rows_within(&*group, n_rows, within).map_err(wrong)?,
            None => std::iter::once(0..n_rows).collect(),
        };
        if !rows.is_empty() {
            let mut columns = Columns::of(&*group, &geometry).map_err(wrong)?;
            for rows in rows {
                columns.go_to(rows.start).map_err(wrong)?;
                while columns.at < rows.end {
                    let number = n_before + columns.at + 1;
                    let batch = columns.next(BATCH.min(rows.end - columns.at), &mut budget).map_err(wrong)?;
                    batch
                        .add_to(&mut features, within)
                        .map_err(|(k, fault)| Error::malformed(input, fault).at(Place::Feature((number + k) as u64)))?;
                }
            }
        }
        n_before += n_rows;
    }
    Ok(FeatureSet { crs: geometry.crs, features, ..FeatureSet::default() })
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

    /// Returns the rows of a group whose boxes meet another one; all where there are no boxes.
    fn rows_within(
        &self,
        group: &dyn RowGroupReader,
        n_rows: usize,
        within: [f64; 4],
    ) -> parquet::errors::Result<Vec<Range<usize>>> {
        let Some(columns) = self.boxes else { return Ok(std::iter::once(0..n_rows).collect()) };
        // Numbers alone are read here.
        let (mut sides, mut none) = (Vec::new(), Budget(0));
        for column in columns {
            sides.push(Column::of(group, column)?);
        }
        let mut rows: Vec<Range<usize>> = Vec::new();
        let mut at = 0;
        while at < n_rows {
            let n = BATCH.min(n_rows - at);
            let values =
                sides.iter_mut().map(|side| side.next(n, &mut none)).collect::<parquet::errors::Result<Vec<_>>>()?;
            for k in 0..n {
                let side = |k_side: usize| match values[k_side].get(k) {
                    Some(Property::Number(v)) => Some(*v),
                    _ => None,
                };
                let of_row = || Some([side(0)?, side(1)?, side(2)?, side(3)?]);
                if of_row().is_some_and(|of_row| !meets(of_row, within)) {
                    continue;
                }
                match rows.last_mut().filter(|last| last.end == at + k) {
                    Some(last) => last.end += 1,
                    None => rows.push(at + k..at + k + 1),
                }
            }
            at += n;
        }
        Ok(rows)
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
