//! GeoPackage: an SQLite database with a table of features.
//!
//! The file is opened as one that nobody changes, so that nothing is written beside it. Only plain
//! tables with plain columns are read: views and generated columns can compute without end.
//!
//! # References
//! OGC 12-128r19, GeoPackage Encoding Standard 1.4.

use std::io::Read;
use std::sync::Arc;

use rusqlite::limits::Limit;
use rusqlite::types::ValueRef;
use rusqlite::{Connection, OpenFlags, OptionalExtension, Row};

use super::feature::{Feature, FeatureSet, Property, crs_of, malformed};
use super::selection::{Selection, meets};
use super::wkb::areas_of;
use crate::error::{Cause, Error, ReadFault, Result, Wanted};
use crate::input::{Input, Reader, cannot_read};
use crate::raster::Crs;

/// Bytes of the header of an SQLite database.
const SQLITE_HEADER_BYTES: u64 = 100;

/// Reads the features of a table; of the only one if no `layer` is named.
pub(super) fn read(input: &Input, selection: Selection<'_>) -> Result<FeatureSet> {
    // SQLite reads files alone.
    let copy = if input.is_held() { Some(copied(input)?) } else { None };
    let on_disk = copy.as_ref().map_or_else(|| input.clone(), |copy| Input::path(copy.path()));
    let (file, length) = on_disk.open()?;
    refuse_open_changes(input)?;
    refuse_cut_off(input, file, length)?;
    let broken = |e: rusqlite::Error| malformed(input, &e.to_string(), "a GeoPackage");
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_URI | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let database = Connection::open_with_flags(uri(&on_disk), flags).map_err(broken)?;
    // A column must not compute a value larger than the file.
    let longest = i32::try_from(length.max(LEAST_VALUE)).unwrap_or(i32::MAX);
    database.set_limit(Limit::SQLITE_LIMIT_LENGTH, longest).map_err(broken)?;
    database.execute_batch("PRAGMA trusted_schema = OFF").map_err(broken)?;
    refuse_views(input, &database).map_err(broken)??;
    for table in DESCRIPTIONS {
        refuse_generated(input, &database, table).map_err(broken)??;
    }
    let layers = layers(&database).map_err(broken)?;
    let layer = chosen(input, selection.layer, &layers)?;
    refuse_generated(input, &database, layer).map_err(broken)??;
    let table = Table::of(&database, layer).map_err(broken)?;
    let Some(table) = table else {
        return Err(Error::read(input, ReadFault::NoTable(layer.to_string())));
    };
    let crs = crs(input, &database, table.srs);
    if let Some(bounds) = selection.bounds_in(crs.as_ref().ok().and_then(Option::as_ref))
        && envelope(&database, layer).is_some_and(|envelope| !meets(envelope, bounds))
    {
        return Ok(FeatureSet::outside(crs));
    }
    let features = table.features(input, &database, length)?;
    Ok(FeatureSet { crs, features, ..FeatureSet::default() })
}

/// Returns west, south, east, north of a table as the file tells them.
fn envelope(database: &Connection, layer: &str) -> Option<[f64; 4]> {
    let told = "SELECT min_x, min_y, max_x, max_y FROM gpkg_contents WHERE table_name = ?1";
    let row = |row: &Row<'_>| Ok([row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?]);
    let envelope: [f64; 4] = database.query_row(told, [layer], row).ok()?;
    (envelope[0] <= envelope[2] && envelope[1] <= envelope[3]).then_some(envelope)
}

/// Copies bytes that are no file into one, which is gone with what is returned.
fn copied(input: &Input) -> Result<tempfile::NamedTempFile> {
    let copy = || {
        let mut file = tempfile::NamedTempFile::with_suffix(".gpkg")?;
        let (mut bytes, _) = input.open().map_err(std::io::Error::other)?;
        std::io::copy(&mut bytes, &mut file)?;
        Ok(file)
    };
    copy().map_err(|e: std::io::Error| cannot_read(input, &e))
}

/// Least limit for the longest value of a file \[bytes\].
const LEAST_VALUE: u64 = 1 << 20;

/// Number of times that the bytes of a file may be read as values.
const READS_PER_BYTE: u64 = 2;

/// Tables that describe others.
const DESCRIPTIONS: [&str; 3] = ["gpkg_contents", "gpkg_geometry_columns", "gpkg_spatial_ref_sys"];

/// Refuses a generated column, which can compute without end.
fn refuse_generated(input: &Input, database: &Connection, table: &str) -> rusqlite::Result<Result<()>> {
    // 2 and 3 are columns generated when they are read and when they are written.
    let query = "SELECT name FROM pragma_table_xinfo(?1) WHERE hidden > 1 LIMIT 1";
    let found: Option<String> = database.query_row(query, [table], |row| row.get(0)).optional()?;
    Ok(found.map_or(Ok(()), |column| {
        let what = format!("the column `{column}` of `{table}` is generated, wanted one that is stored");
        Err(Error::unsupported(input, what).because(Cause::GeneratedColumn))
    }))
}

/// Refuses views in place of the tables that describe others: a view can compute without end.
fn refuse_views(input: &Input, database: &Connection) -> rusqlite::Result<Result<()>> {
    let query = "SELECT name FROM sqlite_master WHERE rootpage = 0 AND lower(name) IN (?1, ?2, ?3)";
    let found: Option<String> = database.query_row(query, DESCRIPTIONS, |row| row.get(0)).optional()?;
    Ok(match found {
        Some(name) => Err(malformed(input, &format!("`{name}`, which is no plain table"), "a GeoPackage")),
        None => Ok(()),
    })
}

/// Refuses a database whose last changes are in a file beside it, since another program holds it
/// open.
fn refuse_open_changes(input: &Input) -> Result<()> {
    if let Some(beside) = input.with_suffix("-wal").filter(|changes| changes.len() > 0) {
        let what = format!("{beside} holds changes that are not in it yet");
        return Err(Error::unsupported(input, what).because(Cause::OpenDatabase));
    }
    Ok(())
}

/// Refuses a file with fewer pages than its header declares: SQLite would read it as far as it can.
fn refuse_cut_off(input: &Input, file: Reader, length: u64) -> Result<()> {
    let mut header = Vec::new();
    file.take(SQLITE_HEADER_BYTES).read_to_end(&mut header).map_err(|e| cannot_read(input, &e))?;
    let word = |at: usize| header.get(at..).and_then(<[u8]>::first_chunk::<4>).map(|w| u32::from_be_bytes(*w));
    // The number of pages counts only if it was written by the version that wrote the file last.
    let (Some(n_pages), true) = (word(28), word(24) == word(92)) else { return Ok(()) };
    // The page size is the upper half of the word at byte 16; 1 means 65 536.
    let page = match word(16).map_or(0, |w| w >> 16) {
        1 => 65_536,
        bytes => u64::from(bytes),
    };
    if u64::from(n_pages) * page > length {
        let what = format!("it ends after {length} bytes of {n_pages} pages of {page}");
        return Err(Error::truncated(input, what).because(Cause::CutShort));
    }
    Ok(())
}

/// Returns a path as SQLite takes it, with the promise that the file does not change.
fn uri(input: &Input) -> String {
    // Byte by byte, since a path need not be Unicode.
    let bytes = input.as_path().as_os_str().as_encoded_bytes().iter();
    let escaped: String = bytes
        .map(|byte| match byte {
            b'\\' if cfg!(windows) => "/".to_string(),
            b'%' | b'?' | b'#' | 0x80.. => format!("%{byte:02x}"),
            plain => char::from(*plain).to_string(),
        })
        .collect();
    // Two slashes at the beginning would name a host.
    let root = if escaped.starts_with('/') { "//" } else { "" };
    format!("file:{root}{escaped}?immutable=1")
}

/// Returns the tables of features, in the order of the file.
fn layers(database: &Connection) -> rusqlite::Result<Vec<String>> {
    let mut query = database.prepare("SELECT table_name FROM gpkg_contents WHERE data_type = 'features' LIMIT 1000")?;
    query.query_map([], |row| row.get(0))?.collect()
}

fn chosen<'a>(input: &Input, asked: Option<&'a str>, layers: &'a [String]) -> Result<&'a str> {
    let fault = match (asked, layers) {
        (Some(asked), layers) if layers.iter().any(|l| l == asked) => return Ok(asked),
        (None, [only]) => return Ok(only),
        (_, []) => ReadFault::Nothing(Wanted::Layers),
        (Some(asked), _) => ReadFault::NoLayer(asked.to_string(), layers.to_vec()),
        (None, _) => ReadFault::Layers(layers.to_vec()),
    };
    Err(Error::read(input, fault))
}

/// A table of features.
struct Table<'a> {
    name: &'a str,
    geometry: String,
    key: Option<String>,
    srs: i64,
}

impl<'a> Table<'a> {
    /// Reads the description of a table; `None` where it is a view or has no geometry.
    fn of(database: &Connection, name: &'a str) -> rusqlite::Result<Option<Table<'a>>> {
        let is_plain = "SELECT 1 FROM sqlite_master WHERE name = ?1 AND type = 'table' AND rootpage > 0";
        if !database.prepare(is_plain)?.exists([name])? {
            return Ok(None);
        }
        let geometry = "SELECT column_name, srs_id FROM gpkg_geometry_columns WHERE table_name = ?1";
        let found = database.query_row(geometry, [name], |row| Ok((row.get(0)?, row.get(1)?))).optional()?;
        let key = "SELECT name FROM pragma_table_info(?1) WHERE pk = 1";
        let key = database.query_row(key, [name], |row| row.get(0)).optional()?;
        Ok(found.map(|(geometry, srs)| Table { name, geometry, key, srs }))
    }

    fn features(&self, input: &Input, database: &Connection, file_bytes: u64) -> Result<Vec<Feature>> {
        let broken = |e: rusqlite::Error| malformed(input, &e.to_string(), "a GeoPackage");
        let quoted = self.name.replace('"', "\"\"");
        let mut query = database.prepare(&format!("SELECT * FROM \"{quoted}\"")).map_err(broken)?;
        let columns = self.columns(database).map_err(broken)?;
        if columns.len() != query.column_count() {
            return Err(malformed(input, "a table whose columns are not those that it names", "a GeoPackage"));
        }
        let mut rows = query.query([]).map_err(broken)?;
        let mut features = Vec::new();
        let mut n_bytes = 0;
        while let Some(row) = rows.next().map_err(broken)? {
            let number = features.len() + 1;
            let wrong = |found: String| malformed(input, &format!("feature {number}: {found}"), "a GeoPackage");
            // Damaged pages may lead in circles, and columns may have long values that are in no
            // row.
            n_bytes += 1 + bytes_of(row, columns.len());
            if n_bytes > READS_PER_BYTE * file_bytes {
                return Err(wrong(format!("with it more than the {file_bytes} bytes of the file")));
            }
            features.push(self.feature(row, &columns).map_err(wrong)?);
        }
        Ok(features)
    }

    /// Returns the names of the columns. Statements have them too, but panic where a damaged name
    /// is no UTF-8.
    fn columns(&self, database: &Connection) -> rusqlite::Result<Vec<Arc<str>>> {
        let mut query = database.prepare("SELECT name FROM pragma_table_info(?1)")?;
        let name = |row: &Row<'_>| Ok(String::from_utf8_lossy(row.get_ref(0)?.as_bytes().unwrap_or_default()).into());
        query.query_map([self.name], name)?.collect()
    }

    fn is_geometry(&self, column: &str) -> bool {
        column.eq_ignore_ascii_case(&self.geometry)
    }

    fn feature(&self, row: &Row<'_>, columns: &[Arc<str>]) -> std::result::Result<Feature, String> {
        let mut feature = Feature::default();
        for (k, name) in columns.iter().enumerate() {
            let value = row.get_ref(k).map_err(|e| e.to_string())?;
            if self.is_geometry(name) {
                if let ValueRef::Blob(blob) = value {
                    let properties = std::mem::take(&mut feature.properties);
                    feature = Feature { properties, ..areas_of(geometry(blob)?)?.into_feature() };
                }
                continue;
            }
            // A row need not hold columns without a value.
            if value != ValueRef::Null {
                feature.properties.push((name.clone(), property(value)));
            }
        }
        if feature.property("id", None).is_none() {
            let key = self.key.as_ref().and_then(|key| feature.property(key, None));
            feature.id = key.and_then(Property::text);
        }
        Ok(feature)
    }
}

/// Returns the least number of bytes that the values of a row take.
fn bytes_of(row: &Row<'_>, n_columns: usize) -> u64 {
    let of_value = |k| match row.get_ref(k) {
        Ok(ValueRef::Null) | Err(_) => 0,
        Ok(ValueRef::Blob(bytes) | ValueRef::Text(bytes)) => 1 + bytes.len() as u64,
        Ok(_) => 1,
    };
    (0..n_columns).map(of_value).sum()
}

/// Returns the well-known binary inside a geometry of a GeoPackage.
fn geometry(blob: &[u8]) -> std::result::Result<&[u8], String> {
    let [b'G', b'P', _, flags, ..] = blob else { return Err("a geometry that does not begin with `GP`".into()) };
    if flags & 0x20 != 0 {
        return Err("a geometry of an extended type".into());
    }
    let envelope = match (flags >> 1) & 7 {
        0 => 0,
        1 => 32,
        2 | 3 => 48,
        4 => 64,
        other => return Err(format!("a geometry with the unknown envelope {other}")),
    };
    blob.get(8 + envelope..).ok_or_else(|| "a geometry that ends too early".to_string())
}

fn property(value: ValueRef<'_>) -> Property {
    match value {
        #[expect(clippy::cast_precision_loss, reason = "identifiers are told as numbers, heights are far below 2^53")]
        ValueRef::Integer(n) => Property::Number(n as f64),
        ValueRef::Real(v) => Property::Number(v),
        ValueRef::Text(text) => Property::Text(String::from_utf8_lossy(text).into_owned()),
        ValueRef::Null | ValueRef::Blob(_) => Property::Null,
    }
}

fn crs(input: &Input, database: &Connection, srs: i64) -> Result<Option<Crs>> {
    let broken = |e: rusqlite::Error| malformed(input, &e.to_string(), "a GeoPackage");
    let query = "SELECT organization, organization_coordsys_id, definition FROM gpkg_spatial_ref_sys WHERE srs_id = ?1";
    let columns = |row: &Row<'_>| Ok((row.get::<_, String>(0)?, row.get::<_, i64>(1)?, row.get::<_, String>(2)?));
    let found = database.query_row(query, [srs], columns).optional().map_err(broken)?;
    match found {
        Some((organization, code, _)) if organization.eq_ignore_ascii_case("EPSG") => {
            crs_of(input, &format!("EPSG:{code}"))
        }
        Some((_, _, definition)) if definition != "undefined" => crs_of(input, &definition),
        _ => Ok(None),
    }
}
