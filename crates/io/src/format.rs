//! Formats of files, by their first bytes. Where these do not tell, the extension of the name does.

use std::path::Path;

use crate::error::{Cause, Error, Result};
use crate::input::Input;
use crate::packed::Archive;

/// Bytes of a file that are looked at.
const HEAD_BYTES: u64 = 4096;

/// Format of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileFormat {
    /// GeoTIFF.
    GeoTiff,
    /// Esri ASCII grid.
    AsciiGrid,
    /// Lines of x, y and z on a regular grid.
    Xyz,
    /// Virtual raster of GDAL.
    VirtualRaster,
    /// Folder of rasters.
    RasterFolder,
    /// GeoJSON, as one document or as one object in each line.
    GeoJson,
    /// CityJSON, as one document or as one object in each line.
    CityJson,
    /// CityGML, or buildings of INSPIRE.
    CityGml,
    /// OpenStreetMap data as XML, PBF, or an answer of the Overpass API.
    Osm,
    /// Shapefile.
    Shapefile,
    /// FlatGeobuf.
    FlatGeobuf,
    /// GeoPackage.
    GeoPackage,
    /// GeoParquet.
    GeoParquet,
    /// Wavefront OBJ.
    Obj,
    /// Polygon file format (Stanford).
    Ply,
    /// LAS, LAZ or COPC.
    PointCloud,
    /// A format that is known by name and not read.
    Foreign(ForeignFormat),
}

/// Kind of what a format holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FileKind {
    /// Heights by cell.
    Raster,
    /// Features with areas.
    Vector,
    /// Triangles.
    Mesh,
    /// Points with classes.
    PointCloud,
}

/// Format that is not read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ForeignFormat {
    /// Name with its article, such as `a ZIP archive`.
    pub name: &'static str,
    /// Way to a format that is read.
    pub conversion: Conversion,
}

/// Way from a format that is not read to one that is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Conversion {
    /// None is known.
    None,
    /// `gdal_translate`, of heights by cell.
    GdalTranslate,
    /// `ogr2ogr`, of features with areas.
    Ogr2Ogr,
    /// `gunzip`, `bunzip2`, `unzip`, `7z x`, `tar xf` and the like; the command without the file.
    Unpack(&'static str),
    /// `fcb deser`.
    Fcb,
    /// Export as a mesh in `.obj` or `.ply` from the program that made it.
    Mesh,
    /// The file of that extension beside it.
    Sibling(&'static str),
    /// The download again: it is a message of the server.
    Download,
}

impl FileFormat {
    /// Returns the format of a file or a folder.
    ///
    /// # Errors
    /// E301 if it cannot be read.
    pub fn of(input: &Input) -> Result<FileFormat> {
        if input.is_folder() {
            return Ok(of_folder(input.as_path()));
        }
        let head = input.head(HEAD_BYTES)?;
        let extension = input.extension();
        Ok(FileFormat::of_head(&head)
            .or_else(|| FileFormat::of_extension(&extension))
            .unwrap_or(FileFormat::Foreign(unknown(&head))))
    }

    /// Returns the format of an extension (lower case, without the point) that is read.
    pub fn of_extension(extension: &str) -> Option<FileFormat> {
        Some(match extension {
            "geojson" | "json" | "geojsonl" | "geojsons" | "geojsonseq" | "ndjson" | "jsonl" => FileFormat::GeoJson,
            "gml" | "citygml" => FileFormat::CityGml,
            "osm" | "pbf" => FileFormat::Osm,
            "shp" => FileFormat::Shapefile,
            "fgb" => FileFormat::FlatGeobuf,
            "gpkg" => FileFormat::GeoPackage,
            "parquet" | "geoparquet" => FileFormat::GeoParquet,
            "obj" => FileFormat::Obj,
            "ply" => FileFormat::Ply,
            "las" | "laz" => FileFormat::PointCloud,
            "tif" | "tiff" => FileFormat::GeoTiff,
            "asc" => FileFormat::AsciiGrid,
            "xyz" => FileFormat::Xyz,
            "vrt" => FileFormat::VirtualRaster,
            _ => return None,
        })
    }

    /// Returns the format of the extension of a path, if it is one that is read.
    pub fn of_name(path: &Path) -> Option<FileFormat> {
        FileFormat::of_extension(&path.extension()?.to_string_lossy().to_lowercase())
    }

    /// Returns the format that the first bytes of a file tell.
    fn of_head(head: &[u8]) -> Option<FileFormat> {
        if is_tiff(head) {
            return Some(FileFormat::GeoTiff);
        }
        // Versions 1.0 and 1.1 have names of their own, and later ones another.
        if head.starts_with(b"SQLite format 3\0") && head.get(68..70).is_some_and(|id| id == b"GP") {
            return Some(FileFormat::GeoPackage);
        }
        match head {
            [b'f', b'g', b'b', ..] => return Some(FileFormat::FlatGeobuf),
            [b'L', b'A', b'S', b'F', ..] => return Some(FileFormat::PointCloud),
            [b'P', b'A', b'R', b'1', ..] => return Some(FileFormat::GeoParquet),
            [0, 0, 0x27, 0x0a, ..] => return Some(FileFormat::Shapefile),
            [b'p', b'l', b'y', b'\r' | b'\n', ..] => return Some(FileFormat::Ply),
            _ => {}
        }
        // The size of the first block's header, and the name of that block in it.
        if head.starts_with(&[0, 0]) && head.get(4..32).is_some_and(|of| of.windows(9).any(|name| name == b"OSMHeader"))
        {
            return Some(FileFormat::Osm);
        }
        if let Some(foreign) = of_binary(head) {
            return Some(FileFormat::Foreign(foreign));
        }
        of_text(leading_text(head)?)
    }

    /// Returns its name with an article.
    pub fn name(self) -> &'static str {
        match self {
            FileFormat::GeoTiff => "a GeoTIFF",
            FileFormat::AsciiGrid => "an Esri ASCII grid",
            FileFormat::Xyz => "an XYZ grid",
            FileFormat::VirtualRaster => "a virtual raster",
            FileFormat::RasterFolder => "a folder of rasters",
            FileFormat::GeoJson => "GeoJSON",
            FileFormat::CityJson => "CityJSON",
            FileFormat::CityGml => "CityGML",
            FileFormat::Osm => "OpenStreetMap data",
            FileFormat::Shapefile => "a Shapefile",
            FileFormat::FlatGeobuf => "FlatGeobuf",
            FileFormat::GeoPackage => "a GeoPackage",
            FileFormat::GeoParquet => "GeoParquet",
            FileFormat::Obj => "a mesh in OBJ",
            FileFormat::Ply => "a mesh in PLY",
            FileFormat::PointCloud => "a LAS point cloud",
            FileFormat::Foreign(format) => format.name,
        }
    }

    /// Returns its name without an article.
    pub fn noun(self) -> &'static str {
        let name = self.name();
        name.strip_prefix("a ").or_else(|| name.strip_prefix("an ")).unwrap_or(name)
    }

    /// Returns the error for a file of this format where one of a kind is wanted.
    pub(crate) fn unwanted(self, input: &Input, kind: FileKind) -> Error {
        // What is converted to vectors or a mesh was no raster, whatever was wanted.
        let kind = match self {
            FileFormat::Foreign(ForeignFormat { conversion: Conversion::Ogr2Ogr | Conversion::Fcb, .. }) => {
                FileKind::Vector
            }
            FileFormat::Foreign(ForeignFormat { conversion: Conversion::Mesh, .. }) => FileKind::Mesh,
            _ => kind,
        };
        let wanted = match kind {
            FileKind::Raster => "a GeoTIFF, an Esri ASCII grid, an XYZ grid or a GDAL virtual raster",
            FileKind::Vector => {
                "GeoJSON, CityJSON, CityGML, OpenStreetMap data, FlatGeobuf, GeoParquet, a GeoPackage or a Shapefile"
            }
            FileKind::Mesh => "a mesh in OBJ or PLY",
            FileKind::PointCloud => "a point cloud in LAS or LAZ",
        };
        let what = format!("it is {} ({} bytes), wanted {wanted}", self.name(), input.len());
        let error = Error::malformed(input, what);
        match self {
            FileFormat::Foreign(format) => error.because(Cause::Foreign(format.conversion)),
            _ => error,
        }
    }

    /// Returns the kind of an archive that is opened as what is inside.
    pub(crate) fn archive(self) -> Option<Archive> {
        match self {
            FileFormat::Foreign(GZIP) => Some(Archive::Gzip),
            FileFormat::Foreign(ZIP) => Some(Archive::Zip),
            _ => None,
        }
    }

    /// Returns the kind of what it holds; `None` for a format that is not read.
    pub fn kind(self) -> Option<FileKind> {
        Some(match self {
            FileFormat::GeoTiff
            | FileFormat::AsciiGrid
            | FileFormat::Xyz
            | FileFormat::VirtualRaster
            | FileFormat::RasterFolder => FileKind::Raster,
            FileFormat::GeoJson
            | FileFormat::CityJson
            | FileFormat::CityGml
            | FileFormat::Osm
            | FileFormat::Shapefile
            | FileFormat::FlatGeobuf
            | FileFormat::GeoPackage
            | FileFormat::GeoParquet => FileKind::Vector,
            FileFormat::Obj | FileFormat::Ply => FileKind::Mesh,
            FileFormat::PointCloud => FileKind::PointCloud,
            FileFormat::Foreign(_) => return None,
        })
    }
}

/// Formats that are opened as what is inside.
const GZIP: ForeignFormat = foreign("a gzip file", Conversion::Unpack("gunzip -k"));
const ZIP: ForeignFormat = foreign("a ZIP archive", Conversion::Unpack("unzip"));

/// Makes a format that is not read.
const fn foreign(name: &'static str, conversion: Conversion) -> ForeignFormat {
    ForeignFormat { name, conversion }
}

fn is_tiff(head: &[u8]) -> bool {
    matches!(head, [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] | [b'I', b'I'] | [b'M', b'M'])
}

/// Returns the binary format of some first bytes that is not read.
fn of_binary(head: &[u8]) -> Option<ForeignFormat> {
    use Conversion::{Fcb, GdalTranslate, Mesh, None as Nothing, Ogr2Ogr, Unpack};
    const MAGIC: [(&[u8], ForeignFormat); 25] = [
        (b"\x1f\x8b", GZIP),
        (b"PK\x03\x04", ZIP),
        (b"BZh", foreign("a bzip2 file", Unpack("bunzip2 -k"))),
        (b"\xfd7zXZ", foreign("an xz file", Unpack("unxz -k"))),
        (b"\x28\xb5\x2f\xfd", foreign("a zstd file", Unpack("unzstd"))),
        (b"7z\xbc\xaf\x27\x1c", foreign("a 7z archive", Unpack("7z x"))),
        (b"Rar!", foreign("a RAR archive", Unpack("unrar x"))),
        (b"fcb", foreign("a FlatCityBuf file", Fcb)),
        (b"glTF", foreign("a glTF mesh", Mesh)),
        (b"b3dm", foreign("a tile of 3D Tiles", Mesh)),
        (b"AC10", foreign("a DWG drawing", Nothing)),
        (b"AutoCAD Binary DXF", foreign("a DXF drawing", Ogr2Ogr)),
        (b"\x89HDF", foreign("an HDF5 file", GdalTranslate)),
        (b"CDF", foreign("a netCDF file", GdalTranslate)),
        (b"GRIB", foreign("a GRIB file", GdalTranslate)),
        (b"EHFA_HEADER_TAG", foreign("an Erdas Imagine raster", GdalTranslate)),
        (b"\x00\x00\x00\x0cjP", foreign("a JPEG 2000 picture", GdalTranslate)),
        (b"SQLite format 3", foreign("an SQLite database", Ogr2Ogr)),
        (b"\x89PNG", foreign("a PNG picture", GdalTranslate)),
        (b"\xff\xd8\xff", foreign("a JPEG picture", Nothing)),
        (b"GIF8", foreign("a GIF picture", Nothing)),
        (b"RIFF", foreign("a RIFF file (WebP?)", Nothing)),
        (b"v/1\x01", foreign("an OpenEXR picture", Nothing)),
        (b"%PDF", foreign("a PDF document", Nothing)),
        (b"\x00\x00\x27\x0b", foreign("an index of a Shapefile", Conversion::Sibling("shp"))),
    ];
    MAGIC.iter().find(|(magic, _)| head.starts_with(magic)).map(|(_, format)| *format)
}

/// Returns the format of some leading text; `None` where only the name can tell.
fn of_text(text: &str) -> Option<FileFormat> {
    let text = text.trim_start();
    let first = text.split_whitespace().next()?;
    if crate::formats::is_grid_header_key(first) {
        return Some(FileFormat::AsciiGrid);
    }
    match text.chars().next()? {
        '{' if is_overpass(text) => Some(FileFormat::Osm),
        '{' | '[' | '\u{1e}' => Some(of_json(text)),
        '<' if text.contains("<VRTDataset") => Some(FileFormat::VirtualRaster),
        '<' if is_city_gml(text) => Some(FileFormat::CityGml),
        '<' if text.contains("<osm ") || text.contains("<osm>") => Some(FileFormat::Osm),
        '<' => Some(FileFormat::Foreign(of_xml(text))),
        _ => of_plain_text(text),
    }
}

/// Returns the format of JSON; GeoJSON where nothing tells.
fn of_json(text: &str) -> FileFormat {
    let has = |word: &str| text.contains(word);
    if has("\"CityJSON\"") || has("\"CityJSONFeature\"") || has("\"CityObjects\"") {
        return FileFormat::CityJson;
    }
    FileFormat::Foreign(match () {
        () if has("\"Topology\"") => foreign("TopoJSON", Conversion::Ogr2Ogr),
        () if has("\"esriGeometry") => foreign("Esri JSON", Conversion::Ogr2Ogr),
        () if has("\"geometricError\"") => foreign("a tileset of 3D Tiles", Conversion::Mesh),
        () if has("\"asset\"") && (has("\"meshes\"") || has("\"buffers\"")) => foreign("a glTF mesh", Conversion::Mesh),
        () => return FileFormat::GeoJson,
    })
}

/// Returns `true` for an answer of the Overpass API.
fn is_overpass(text: &str) -> bool {
    let has = |word: &str| text.contains(word);
    has("\"elements\"") && (has("\"generator\"") || has("\"osm3s\"")) && !has("\"FeatureCollection\"")
}

/// Returns `true` for CityGML, and for buildings of INSPIRE.
fn is_city_gml(text: &str) -> bool {
    text.contains("CityModel") || text.contains("ec.europa.eu/schemas/bu-")
}

/// Returns the format of XML that is not read.
fn of_xml(text: &str) -> ForeignFormat {
    let has = |word: &str| text.contains(word);
    match () {
        () if has("<osmChange") => foreign("a change of OpenStreetMap data", Conversion::None),
        () if has("<kml") => foreign("a KML file", Conversion::Ogr2Ogr),
        () if has("<gpx") => foreign("a GPX track", Conversion::Ogr2Ogr),
        () if has("opengis.net/gml") => foreign("a GML file", Conversion::Ogr2Ogr),
        () if has("<COLLADA") => foreign("a COLLADA mesh", Conversion::Mesh),
        () if has("<html") || has("<!DOCTYPE html") || has("<HTML") => foreign("a web page", Conversion::Download),
        () if has("<Error>") => foreign("a message of a server", Conversion::Download),
        () => foreign("XML text of an unknown kind", Conversion::None),
    }
}

/// Returns the format of text that is neither JSON nor XML, if it tells.
fn of_plain_text(text: &str) -> Option<FileFormat> {
    let mut lines = text.lines().map(str::trim);
    let first = lines.next()?;
    let is = |format| Some(FileFormat::Foreign(format));
    match first {
        "ISO-10303-21;" => is(foreign("an IFC or STEP model", Conversion::Mesh)),
        "0" | "999" if text.contains("SECTION") => is(foreign("a DXF drawing", Conversion::Ogr2Ogr)),
        _ if first.starts_with("!table") => is(foreign("a MapInfo table", Conversion::Ogr2Ogr)),
        _ if first.starts_with("Version ") && text.contains("Columns") => {
            is(foreign("a MapInfo file", Conversion::Ogr2Ogr))
        }
        _ if crate::formats::begins_with_points(text) => Some(FileFormat::Xyz),
        _ if first.starts_with("mtllib ") || first.starts_with("v ") => Some(FileFormat::Obj),
        _ => None,
    }
}

/// Returns the format of a folder: a database of features, or rasters.
fn of_folder(folder: &Path) -> FileFormat {
    let is_table = |entry: std::io::Result<std::fs::DirEntry>| {
        entry.is_ok_and(|entry| entry.path().extension().is_some_and(|e| e.eq_ignore_ascii_case("gdbtable")))
    };
    match std::fs::read_dir(folder).is_ok_and(|mut entries| entries.any(is_table)) {
        true => FileFormat::Foreign(foreign("an Esri file geodatabase", Conversion::Ogr2Ogr)),
        false => FileFormat::RasterFolder,
    }
}

/// Returns what can be said of bytes of no known format.
fn unknown(head: &[u8]) -> ForeignFormat {
    let name = match leading_text(head) {
        _ if head.is_empty() => "empty",
        None => "a binary file of an unknown kind",
        Some(text) if text.trim().is_empty() => "blank text",
        Some(_) => "text",
    };
    foreign(name, Conversion::GdalTranslate)
}

/// Returns the start of a file as text; `None` if it is binary.
fn leading_text(head: &[u8]) -> Option<&str> {
    let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    let text = match std::str::from_utf8(head) {
        Ok(text) => text,
        // The last character may be cut off.
        Err(error) => std::str::from_utf8(&head[..error.valid_up_to()]).unwrap_or_default(),
    };
    let is_text =
        text.len() + 4 > head.len() && text.chars().all(|c| !c.is_control() || c.is_whitespace() || c == '\u{1e}');
    is_text.then_some(text)
}
