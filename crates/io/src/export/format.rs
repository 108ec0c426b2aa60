//! Formats of outputs, chosen by their extensions.

/// File format of an output, chosen by the extension.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    /// Picture, or one pixel per cell with `--bare`.
    Png,
    /// Picture as vectors.
    Svg,
    /// Picture as vectors on a page.
    Pdf,
    /// GeoTIFF.
    GeoTiff,
    /// OpenEXR.
    Exr,
    /// Esri ASCII grid.
    AsciiGrid,
    /// Raw numbers with a header.
    Bil,
    /// Numpy archive.
    Npz,
    /// Overlays for Google Earth.
    Kmz,
    /// Table.
    Csv,
    /// Document.
    Json,
    /// Features.
    GeoJson,
    /// Features with a spatial index.
    FlatGeobuf,
    /// Scene of Mitsuba, with its meshes.
    Mitsuba,
    /// Web page.
    Html,
    /// Table in columns.
    Parquet,
    /// Mosaic of rasters.
    Vrt,
    /// Lines for navigation.
    Gpx,
    /// Lines for Google Earth.
    Kml,
    /// The document on standard output.
    Stdout,
}

/// Extensions of the formats; the first of several is the usual one.
const EXTENSIONS: [(&str, Format); 20] = [
    ("png", Format::Png),
    ("svg", Format::Svg),
    ("pdf", Format::Pdf),
    ("tif", Format::GeoTiff),
    ("tiff", Format::GeoTiff),
    ("exr", Format::Exr),
    ("asc", Format::AsciiGrid),
    ("bil", Format::Bil),
    ("npz", Format::Npz),
    ("kmz", Format::Kmz),
    ("csv", Format::Csv),
    ("json", Format::Json),
    ("geojson", Format::GeoJson),
    ("fgb", Format::FlatGeobuf),
    ("xml", Format::Mitsuba),
    ("html", Format::Html),
    ("parquet", Format::Parquet),
    ("vrt", Format::Vrt),
    ("gpx", Format::Gpx),
    ("kml", Format::Kml),
];

impl Format {
    /// Returns the format of an extension (lower case, without its point).
    pub(super) fn of_extension(extension: &str) -> Option<Format> {
        EXTENSIONS.iter().find(|(known, _)| *known == extension).map(|(_, format)| *format)
    }

    /// Returns `true` if this build can write the format: some are features.
    pub(super) fn is_built(self) -> bool {
        (self != Format::Exr || cfg!(feature = "exr")) && (self != Format::Parquet || cfg!(feature = "parquet"))
    }

    /// Returns `true` for a picture.
    pub fn is_picture(self) -> bool {
        matches!(self, Format::Png | Format::Svg | Format::Pdf)
    }

    /// Returns the usual extension, without its point; `None` for standard output.
    pub fn extension(self) -> Option<&'static str> {
        EXTENSIONS.iter().find(|(_, format)| *format == self).map(|(extension, _)| *extension)
    }
}
