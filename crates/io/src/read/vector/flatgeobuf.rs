//! FlatGeobuf: a header, an optional index of bounding boxes, and features one after another.
//!
//! With bounds, only the features whose boxes meet them are read. The boxes are at the end of the
//! index, one per feature, with the feature's place in the file. They are read in order and the
//! levels above them skipped, so that no offset inside the index matters. Every table is verified
//! before it is used; lengths are compared with the file's before anything is reserved.
//!
//! # References
//! FlatGeobuf specification, version 3.

use std::io::{BufReader, Read, Seek, SeekFrom};
use std::sync::Arc;

use flatgeobuf::{
    Column, ColumnType, Feature as Table, Geometry, GeometryType, Header, size_prefixed_root_as_feature,
    size_prefixed_root_as_header,
};

use super::super::polygon::Polygon;
use super::super::solid::Face;
use super::feature::{Feature, FeatureSet, Property, crs_of, malformed};
use super::selection::Selection;
use super::surfaces::Areas;
use crate::error::{Cause, Error, Result};
use crate::input::{Input, Reader, cannot_read};
use crate::raster::Crs;

/// Bytes of a box in the index: four coordinates and an offset.
const BOX_BYTES: u64 = 40;

/// Bytes of a point: two coordinates.
const POINT_BYTES: usize = 16;

/// Least size of a part or ring \[bytes\]: the offset or the number that refers to it.
const PART_BYTES: usize = 4;

/// Deepest nesting of geometries.
const MOST_NESTED: usize = 16;

/// Reads the features of a file. With bounds and an index in the file, only features whose boxes
/// meet the bounds are read.
pub(super) fn read(input: &Input, selection: Selection<'_>) -> Result<FeatureSet> {
    let (file, length) = input.open()?;
    let mut source = Source { input, file: BufReader::new(file), at: 0, length };
    let magic = source.take(8)?;
    if &magic[..3] != b"fgb" || &magic[4..7] != b"fgb" || magic[3] > 3 {
        return Err(malformed(input, "a file that does not begin as FlatGeobuf does", "FlatGeobuf version 3"));
    }
    let head = source.prefixed()?;
    let header = size_prefixed_root_as_header(&head)
        .map_err(|e| malformed(input, &format!("a header that is none ({e})"), "FlatGeobuf"))?;
    let index = Index::of(&header, source.at, length).map_err(|found| malformed(input, &found, "FlatGeobuf"))?;
    let crs = crs(input, &header);
    let bounds = selection.bounds_in(crs.as_ref().ok().and_then(Option::as_ref));
    let wanted = match (bounds, index.n_boxes) {
        (Some(bounds), 1..) => Some(index.offsets(&mut source, bounds)?),
        _ => None,
    };
    let names = names_of(header.columns().into_iter().flatten(), head.len())
        .map_err(|found| malformed(input, &found, "FlatGeobuf"))?;
    let mut features = Vec::new();
    let mut n_bytes = 0;
    let mut add = |source: &mut Source<'_>, number: u64| {
        let bytes = source.prefixed()?;
        let wrong = |found: String| malformed(input, &format!("feature {number}: {found}"), "FlatGeobuf");
        // An index that names a feature many times would turn few bytes into much data.
        n_bytes += bytes.len() as u64;
        if n_bytes > length {
            return Err(wrong(format!("with it more than the {length} bytes of the file")));
        }
        let table = size_prefixed_root_as_feature(&bytes).map_err(|e| wrong(e.to_string()))?;
        features.push(feature_of(&header, &names, table, bytes.len()).map_err(wrong)?);
        Ok(())
    };
    match wanted {
        Some(offsets) => {
            source.check_end(index.end.saturating_add(offsets.last))?;
            for (number, offset) in offsets.wanted {
                source.go_to(index.end.saturating_add(offset))?;
                add(&mut source, number + 1)?;
            }
        }
        None => {
            source.go_to(index.end)?;
            let mut number = 0;
            while source.at < length {
                number += 1;
                add(&mut source, number)?;
            }
            let announced = header.features_count();
            if announced != 0 && announced != number {
                return Err(Error::truncated(input, format!("it ends after {number} of {announced} features")));
            }
        }
    }
    Ok(FeatureSet { crs, features, ..FeatureSet::default() })
}

/// File that is read from one place to the next.
struct Source<'a> {
    input: &'a Input,
    file: BufReader<Reader>,
    at: u64,
    length: u64,
}

impl Source<'_> {
    fn go_to(&mut self, at: u64) -> Result<()> {
        // PERF: of features near one another, what was read already is kept.
        let sought = match i64::try_from(i128::from(at) - i128::from(self.at)) {
            Ok(by) => self.file.seek_relative(by),
            Err(_) => self.file.seek(SeekFrom::Start(at)).map(|_| ()),
        };
        sought.map_err(|e| cannot_read(self.input, &e))?;
        self.at = at;
        Ok(())
    }

    /// Reads the next `n` bytes.
    fn take(&mut self, n: u64) -> Result<Vec<u8>> {
        self.check_left(n)?;
        let mut bytes = Vec::new();
        Read::by_ref(&mut self.file).take(n).read_to_end(&mut bytes).map_err(|e| cannot_read(self.input, &e))?;
        self.at += bytes.len() as u64;
        if bytes.len() as u64 == n { Ok(bytes) } else { Err(malformed(self.input, "an early end", "FlatGeobuf")) }
    }

    /// Refuses a file that ends before the end of its last feature, which begins at `start`.
    fn check_end(&mut self, start: u64) -> Result<()> {
        self.go_to(start)?;
        let bytes = self.take(4)?;
        let n = u64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]));
        self.check_left(n)
    }

    /// Refuses to read more than the file has left.
    fn check_left(&self, n: u64) -> Result<()> {
        let left = self.length.saturating_sub(self.at);
        if n > left {
            let what = format!("at byte {} it announces {n} bytes, but {left} are left", self.at);
            return Err(Error::truncated(self.input, what).because(Cause::CutShort));
        }
        Ok(())
    }

    /// Reads the next table with the length before it.
    fn prefixed(&mut self) -> Result<Vec<u8>> {
        let mut bytes = self.take(4)?;
        let n = u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        bytes.extend(self.take(u64::from(n))?);
        Ok(bytes)
    }
}

/// Offsets of features from the end of the index.
struct Offsets {
    /// Number and offset of each wanted feature.
    wanted: Vec<(u64, u64)>,
    /// Offset of the last feature of the file.
    last: u64,
}

/// Place of the boxes of the features, and of the first feature.
struct Index {
    /// Number of boxes; 0 without an index.
    n_boxes: u64,
    boxes: u64,
    end: u64,
}

impl Index {
    /// Computes the index from the numbers of features and of branches per node; the error names an
    /// impossible one.
    fn of(header: &Header<'_>, start: u64, length: u64) -> std::result::Result<Index, String> {
        let (n_features, n_branches) = (header.features_count(), u64::from(header.index_node_size()));
        if n_features == 0 || n_branches == 0 {
            return Ok(Index { n_boxes: 0, boxes: start, end: start });
        }
        if n_branches < 2 || n_features > length / BOX_BYTES {
            return Err(format!("an index of {n_features} boxes, {n_branches} to a node, in {length} bytes"));
        }
        let mut above = 0;
        let mut level = n_features;
        while level > 1 {
            level = level.div_ceil(n_branches);
            above += level;
        }
        // One feature has a box and a node above it.
        above = above.max(1);
        let boxes = start + above * BOX_BYTES;
        Ok(Index { n_boxes: n_features, boxes, end: boxes + n_features * BOX_BYTES })
    }

    /// Returns number and offset of each feature whose box meets `bounds`.
    fn offsets(&self, source: &mut Source<'_>, bounds: [f64; 4]) -> Result<Offsets> {
        source.go_to(self.boxes)?;
        let mut offsets = Offsets { wanted: Vec::new(), last: 0 };
        for number in 0..self.n_boxes {
            let bytes = source.take(BOX_BYTES)?;
            let word = |k: usize| bytes[8 * k..].first_chunk::<8>().copied().unwrap_or_default();
            let [west, south, east, north] = [0, 1, 2, 3].map(|k| f64::from_le_bytes(word(k)));
            let offset = u64::from_le_bytes(word(4));
            offsets.last = offsets.last.max(offset);
            if west <= bounds[2] && east >= bounds[0] && south <= bounds[3] && north >= bounds[1] {
                offsets.wanted.push((number, offset));
            }
        }
        Ok(offsets)
    }
}

fn crs(input: &Input, header: &Header<'_>) -> Result<Option<Crs>> {
    let Some(crs) = header.crs() else { return Ok(None) };
    let code = (crs.code() > 0).then(|| format!("{}:{}", crs.org().unwrap_or("EPSG"), crs.code()));
    let is_known = |code: &String| ["EPSG:", "ESRI:"].iter().any(|known| code.to_uppercase().starts_with(known));
    match code.filter(is_known) {
        Some(code) => crs_of(input, &code),
        None => crs_of(input, crs.wkt().or(crs.code_string()).unwrap_or_default()),
    }
}

/// Returns the names of columns, which are stored in `n_bytes`. Longer names are the same bytes
/// referred to many times, and are refused.
fn names_of<'a>(
    columns: impl Iterator<Item = Column<'a>>,
    n_bytes: usize,
) -> std::result::Result<Vec<Arc<str>>, String> {
    let mut left = n_bytes;
    let name = |column: Column<'_>| {
        left = left
            .checked_sub(column.name().len())
            .ok_or_else(|| format!("columns with longer names than {n_bytes} bytes hold"))?;
        Ok(Arc::from(column.name()))
    };
    columns.map(name).collect()
}

/// Reads a feature that is stored in `n_bytes`, of columns with `names` unless it has its own.
fn feature_of(
    header: &Header<'_>,
    names: &[Arc<str>],
    table: Table<'_>,
    n_bytes: usize,
) -> std::result::Result<Feature, String> {
    let mut feature = Feature::default();
    let mut room = Room { n_bytes, points: n_bytes / POINT_BYTES, parts: n_bytes / PART_BYTES };
    if let Some(geometry) = table.geometry() {
        let kind = match header.geometry_type() {
            GeometryType::Unknown => geometry.type_(),
            kind => kind,
        };
        let mut areas = Areas::default();
        add_areas(&geometry, kind, (&mut areas, &mut room), 0)?;
        feature = areas.into_feature();
    }
    let columns = match (table.columns(), header.columns()) {
        (Some(columns), _) | (None, Some(columns)) => columns,
        (None, None) => return Ok(feature),
    };
    let own = table.columns().map(|columns| names_of(columns.iter(), n_bytes)).transpose()?;
    let names = own.as_deref().unwrap_or(names);
    let bytes = table.properties().map(|p| p.bytes()).unwrap_or_default();
    let mut rest = bytes;
    // One byte is no column number: some writers end with one, and GDAL ignores it.
    while rest.len() > 1 {
        let number = usize::from(u16::from_le_bytes(taken(&mut rest)?));
        if number >= columns.len() {
            return Err(format!("a value for column {} of {}", number + 1, columns.len()));
        }
        let column = columns.get(number);
        let value = value(column.type_(), &mut rest)?;
        feature.properties.push((names[number].clone(), value));
    }
    Ok(feature)
}

/// Room for points and parts in the bytes of a feature. Without this limit, bytes that are referred
/// to many times would turn into much data.
struct Room {
    n_bytes: usize,
    points: usize,
    parts: usize,
}

impl Room {
    fn take(left: &mut usize, n: usize, (what, n_bytes): (&str, usize)) -> std::result::Result<(), String> {
        *left = left.checked_sub(n).ok_or_else(|| format!("more {what} than {n_bytes} bytes hold"))?;
        Ok(())
    }
}

fn add_areas(
    geometry: &Geometry<'_>,
    kind: GeometryType,
    (areas, room): (&mut Areas, &mut Room),
    depth: usize,
) -> std::result::Result<(), String> {
    Room::take(&mut room.parts, 1, ("parts", room.n_bytes))?;
    if depth > MOST_NESTED {
        return Err(format!("its geometry nests more than {MOST_NESTED} collections"));
    }
    match kind {
        GeometryType::Polygon | GeometryType::Triangle => {
            let n_points = geometry.xy().map_or(0, |xy| xy.len() / 2);
            Room::take(&mut room.points, n_points, ("points", room.n_bytes))?;
            let n_rings = geometry.ends().map_or(0, |ends| ends.len());
            Room::take(&mut room.parts, n_rings, ("rings", room.n_bytes))?;
            let numbers: Vec<f64> = geometry.xy().map(|xy| xy.iter().collect()).unwrap_or_default();
            let points: Vec<[f64; 2]> = numbers.chunks_exact(2).map(|p| [p[0], p[1]]).collect();
            let heights: Vec<f64> = geometry.z().filter(|z| z.len() == points.len()).into_iter().flatten().collect();
            let ends: Vec<usize> = geometry.ends().map(|e| e.iter().map(|n| n as usize).collect()).unwrap_or_default();
            let ends = if ends.is_empty() { vec![points.len()] } else { ends };
            let mut from = 0;
            let (mut rings, mut face): (Polygon, Face) = (Vec::new(), Vec::new());
            for to in ends {
                let ring = points
                    .get(from..to)
                    .ok_or_else(|| format!("a ring from point {from} to {to} of {}", points.len()))?;
                if let Some(heights) = heights.get(from..to) {
                    face.push(ring.iter().zip(heights).map(|([x, y], z)| [*x, *y, *z]).collect());
                } else {
                    rings.push(ring.to_vec());
                }
                from = to;
            }
            if face.is_empty() {
                areas.push(rings)
            } else {
                areas.push_face(face)
            }
            Ok(())
        }
        GeometryType::MultiPolygon
        | GeometryType::GeometryCollection
        | GeometryType::PolyhedralSurface
        | GeometryType::TIN => {
            let parts = geometry.parts().map(|parts| parts.iter().collect::<Vec<_>>()).unwrap_or_default();
            parts.iter().try_for_each(|part| {
                let kind = match (kind, part.type_()) {
                    (GeometryType::GeometryCollection, kind) => kind,
                    (_, GeometryType::Triangle) => GeometryType::Triangle,
                    _ => GeometryType::Polygon,
                };
                add_areas(part, kind, (&mut *areas, &mut *room), depth + 1)
            })
        }
        GeometryType::Curve | GeometryType::CurvePolygon | GeometryType::MultiSurface | GeometryType::Surface => {
            Err("it is a curve; straighten it first: `ogr2ogr -nlt CONVERT_TO_LINEAR`".into())
        }
        _ => {
            areas.has_other_parts = true;
            Ok(())
        }
    }
}

/// Reads the value of a column, of the type in the header.
fn value(kind: ColumnType, rest: &mut &[u8]) -> std::result::Result<Property, String> {
    #[expect(clippy::cast_precision_loss, reason = "identifiers are told as numbers, heights are far below 2^53")]
    let number = match kind {
        ColumnType::Byte => f64::from(i8::from_le_bytes(taken(rest)?)),
        ColumnType::UByte => f64::from(u8::from_le_bytes(taken(rest)?)),
        ColumnType::Short => f64::from(i16::from_le_bytes(taken(rest)?)),
        ColumnType::UShort => f64::from(u16::from_le_bytes(taken(rest)?)),
        ColumnType::Int => f64::from(i32::from_le_bytes(taken(rest)?)),
        ColumnType::UInt => f64::from(u32::from_le_bytes(taken(rest)?)),
        ColumnType::Long => i64::from_le_bytes(taken(rest)?) as f64,
        ColumnType::ULong => u64::from_le_bytes(taken(rest)?) as f64,
        ColumnType::Float => f64::from(f32::from_le_bytes(taken(rest)?)),
        ColumnType::Double => f64::from_le_bytes(taken(rest)?),
        ColumnType::Bool => {
            return Ok(Property::Text(if taken::<1>(rest)? == [0] { "no" } else { "yes" }.into()));
        }
        ColumnType::String | ColumnType::Json | ColumnType::DateTime | ColumnType::Binary => {
            let n = u32::from_le_bytes(taken(rest)?) as usize;
            let (text, after) = rest.split_at_checked(n).ok_or_else(|| format!("a text of {n} bytes"))?;
            *rest = after;
            if kind == ColumnType::Binary {
                return Ok(Property::Null);
            }
            return Ok(Property::Text(String::from_utf8_lossy(text).into_owned()));
        }
        other => return Err(format!("a column of the unknown type {}", other.0)),
    };
    Ok(Property::Number(number))
}

fn taken<const N: usize>(rest: &mut &[u8]) -> std::result::Result<[u8; N], String> {
    let (head, after) = rest.split_first_chunk::<N>().ok_or("its properties end too early")?;
    *rest = after;
    Ok(*head)
}
