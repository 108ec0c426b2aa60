//! Shapefiles: `.shp` with its index `.shx` and its table `.dbf`; the CRS from `.prj`, the code
//! page from `.cpg`.
//!
//! # References
//! ESRI Shapefile Technical Description (1998).

use std::io::Cursor;

use shapefile::dbase::encoding::{DynEncoding, UnicodeLossy};
use shapefile::dbase::{FieldValue, ReaderBuilder, Record};
use shapefile::record::polygon::GenericPolygon;
use shapefile::record::traits::HasXY;
use shapefile::{PolygonRing, Shape, ShapeReader};

use super::super::polygon::Polygon;
use super::feature::{Feature, FeatureSet, Properties, Property, crs_of, malformed};
use super::patches::{areas_of_patches, surfaces_of};
use super::rings::assembled;
use super::selection::{Selection, meets};
use super::surfaces::Areas;
use crate::error::{Cause, Error, ReadFault, Result};
use crate::input::Input;

/// Largest number of characters of a column's name in a `.dbf`.
const NAME_LIMIT: usize = 10;

/// Bytes of a point: two coordinates.
const POINT_BYTES: usize = 16;

/// Bytes of the header of `.shp` and `.shx`.
const HEADER_BYTES: usize = 100;

/// Reads a shapefile with its sidecar files.
pub(super) fn read(input: &Input, selection: Selection<'_>) -> Result<FeatureSet> {
    let crs = match input.beside("prj") {
        Some(prj) => prj.read().and_then(|bytes| crs_of(input, &String::from_utf8_lossy(&bytes))),
        None => Ok(None),
    };
    if let Some(bounds) = selection.bounds_in(crs.as_ref().ok().and_then(Option::as_ref))
        && envelope(&input.head(HEADER_BYTES as u64)?).is_some_and(|envelope| !meets(envelope, bounds))
    {
        return Ok(FeatureSet::outside(crs));
    }
    let shp = input.read()?;
    let shx = input.beside("shx").ok_or_else(|| missing(input, "shx", "its index"))?;
    let dbf = input.beside("dbf").ok_or_else(|| missing(input, "dbf", "the table with its heights"))?;
    let shx = shx.read()?;
    check_index(input, &shx, shp.len())?;
    check_patches(input, &shp, &shx)?;
    let broken = |e: shapefile::Error| malformed(input, &e.to_string(), "a shapefile");
    let n_bytes = shp.len();
    let mut reader = ShapeReader::with_shx(Cursor::new(shp), Cursor::new(shx)).map_err(broken)?;
    let n_indexed = reader.shape_count().map_err(broken)?;
    let (mut shapes, mut n_points) = (Vec::new(), 0);
    for (number, shape) in reader.iter_shapes().enumerate() {
        let shape = shape.map_err(|e| malformed(input, &format!("feature {}: {e}", number + 1), "a shapefile"))?;
        // An index that names a shape many times would turn few bytes into much data.
        n_points += n_points_of(&shape);
        if n_points > n_bytes / POINT_BYTES {
            let found = format!("feature {}: with it more points than {n_bytes} bytes hold", number + 1);
            return Err(malformed(input, &found, "a shapefile"));
        }
        shapes.push(areas_of(shape));
    }
    let rows = table(input, &dbf)?;
    if shapes.len() != n_indexed || shapes.len() != rows.len() {
        let what = format!(
            "it holds {} shapes, its index {n_indexed} and its table {} rows, wanted as many of each",
            shapes.len(),
            rows.len()
        );
        return Err(Error::truncated(input, what).because(Cause::MixedFiles));
    }
    let features = shapes.into_iter().zip(rows);
    let features = features.map(|(areas, properties)| Feature { properties, ..areas.into_feature() });
    Ok(FeatureSet { crs, name_limit: Some(NAME_LIMIT), features: features.collect(), ..FeatureSet::default() })
}

/// Returns west, south, east, north that the header tells.
fn envelope(header: &[u8]) -> Option<[f64; 4]> {
    let at = |k: usize| Some(f64::from_le_bytes(header.get(36 + 8 * k..44 + 8 * k)?.try_into().ok()?));
    let envelope = [at(0)?, at(1)?, at(2)?, at(3)?];
    // Some writers leave zeros.
    (envelope[0] < envelope[2] && envelope[1] < envelope[3]).then_some(envelope)
}

fn missing(input: &Input, extension: &str, holds: &'static str) -> Error {
    let wanted = input.as_path().with_extension(extension);
    Error::read(input, ReadFault::NoSidecar(wanted.display().to_string(), holds))
}

/// Refuses an index whose records are larger than the file: it could have one shape read many
/// times.
fn check_index(input: &Input, shx: &[u8], shp_bytes: usize) -> Result<()> {
    let entries = shx.get(HEADER_BYTES..).unwrap_or_default().chunks_exact(8);
    let length = |entry: &[u8]| 2 * u64::from(u32::from_be_bytes([entry[4], entry[5], entry[6], entry[7]]));
    let indexed: u64 = entries.map(length).sum();
    if indexed > shp_bytes as u64 {
        let found = format!("its index names {indexed} bytes of shapes in a file of {shp_bytes}");
        return Err(malformed(input, &found, "an index of this file"));
    }
    Ok(())
}

/// Refuses multipatches with more parts or points than their records hold, since the crate reserves
/// memory for as many.
fn check_patches(input: &Input, shp: &[u8], shx: &[u8]) -> Result<()> {
    const MULTIPATCH: u32 = 31;
    /// Bytes of a record before its parts: the type, the box, and the two counts.
    const COUNTS_END: u64 = 44;
    let entries = shx.get(HEADER_BYTES..).unwrap_or_default().chunks_exact(8);
    for (number, entry) in entries.enumerate() {
        let word = u64::from(u32::from_be_bytes([entry[0], entry[1], entry[2], entry[3]]));
        // The record begins with its number and its length.
        let Some(record) = usize::try_from(2 * word).ok().and_then(|at| shp.get(at..)) else { continue };
        let four = |at: usize| record.get(at..).and_then(<[u8]>::first_chunk::<4>).copied();
        let Some([MULTIPATCH, n_parts, n_points]) =
            four(8).zip(four(44)).zip(four(48)).map(|((a, b), c)| [a, b, c].map(u32::from_le_bytes))
        else {
            continue;
        };
        let length = 2 * u64::from(four(4).map_or(0, u32::from_be_bytes));
        let least = COUNTS_END + 8 * u64::from(n_parts) + 24 * u64::from(n_points);
        if least > length {
            let found =
                format!("feature {}: {n_parts} parts and {n_points} points in a record of {length} bytes", number + 1);
            return Err(malformed(input, &found, "a shapefile"));
        }
    }
    Ok(())
}

/// Returns the number of points of the areas of a shape.
fn n_points_of(shape: &Shape) -> usize {
    match shape {
        Shape::Polygon(polygon) => polygon.total_point_count(),
        Shape::PolygonM(polygon) => polygon.total_point_count(),
        Shape::PolygonZ(polygon) => polygon.total_point_count(),
        Shape::Multipatch(patches) => patches.total_point_count(),
        _ => 0,
    }
}

/// Returns the areas of a shape; points, lines and empty shapes have none.
fn areas_of(shape: Shape) -> Areas {
    match shape {
        Shape::Polygon(polygon) => Areas::of_surfaces(rings_of(&polygon), Vec::new()),
        Shape::PolygonM(polygon) => Areas::of_surfaces(rings_of(&polygon), Vec::new()),
        Shape::PolygonZ(polygon) => Areas::of_surfaces(rings_of(&polygon), surfaces_of(&polygon)),
        Shape::Multipatch(patches) => areas_of_patches(patches),
        _ => Areas::default(),
    }
}

fn rings_of<P: HasXY>(polygon: &GenericPolygon<P>) -> Vec<Polygon> {
    let (mut shells, mut holes) = (Vec::new(), Vec::new());
    for ring in polygon.rings() {
        let (points, kind) = match ring {
            PolygonRing::Outer(points) => (points, &mut shells),
            PolygonRing::Inner(points) => (points, &mut holes),
        };
        kind.push(points.iter().map(|p| [p.x(), p.y()]).collect());
    }
    assembled(shells, holes)
}

/// Reads the rows of the table, each by column name.
fn table(input: &Input, table: &Input) -> Result<Vec<Properties>> {
    let dbf = table.read()?;
    let code_page = match input.beside("cpg") {
        Some(cpg) => Some(String::from_utf8_lossy(&cpg.read()?).trim().to_string()),
        None => None,
    };
    let encoding = code_page.and_then(|name| DynEncoding::from_name(&name));
    let broken = |e: shapefile::dbase::Error| malformed(table, &e.to_string(), "a dBase table");
    let built = match encoding {
        Some(encoding) => ReaderBuilder::new().with_encoding(encoding).build(Cursor::new(dbf)),
        // A table without a code page, or with an unknown one, still has its numbers.
        None => match ReaderBuilder::new().build(Cursor::new(&dbf)) {
            Ok(_) => ReaderBuilder::new().build(Cursor::new(dbf)),
            Err(_) => ReaderBuilder::new().with_encoding(UnicodeLossy).build(Cursor::new(dbf)),
        },
    };
    let mut reader = built.map_err(broken)?;
    let rows = reader.iter_records();
    rows.map(|row| row.map(properties).map_err(broken)).collect()
}

/// Returns the values of a row, sorted by name: the crate keeps them in no order.
fn properties(row: Record) -> Properties {
    let mut properties: Properties = row.into_iter().map(|(name, value)| (name.into(), property(value))).collect();
    properties.sort_by(|a, b| a.0.cmp(&b.0));
    properties
}

fn property(value: FieldValue) -> Property {
    match value {
        FieldValue::Numeric(Some(v)) | FieldValue::Currency(v) | FieldValue::Double(v) => Property::Number(v),
        FieldValue::Float(Some(v)) => Property::Number(f64::from(v)),
        FieldValue::Integer(v) => Property::Number(f64::from(v)),
        FieldValue::Character(Some(text)) | FieldValue::Memo(text) => Property::Text(text),
        FieldValue::Logical(Some(true)) => Property::Text("yes".into()),
        FieldValue::Logical(Some(false)) => Property::Text("no".into()),
        _ => Property::Null,
    }
}
