//! Vector data: whatever the format, a list of features with properties and polygons.
//!
//! One file per format makes a [`FeatureSet`] of it and knows nothing of buildings; what a feature says of a building is
//! read in [`super::building`]. Readers trust no length or count that a file names: nothing is reserved that the file's
//! own size does not bear out.

mod cityjson;
mod flatgeobuf;
#[cfg(feature = "geopackage")]
mod geopackage;
mod rings;
mod shapefile;
#[cfg(feature = "geopackage")]
mod wkb;

use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use crate::crs;
use crate::error::{Error, Result};
use crate::formats::cannot_read;
use crate::raster::Crs;

/// Rings of positions \[CRS units\], the shell first; inside by the even-odd rule.
pub(super) type Polygon = Vec<Vec<[f64; 2]>>;

/// What a file of vector data holds.
#[derive(Debug)]
pub(super) struct FeatureSet {
    /// The CRS that the file names; an error that counts only where no other CRS is given.
    pub(super) crs: Result<Option<Crs>>,
    /// Whom a picture must credit.
    pub(super) attribution: Option<String>,
    /// Most characters that the format keeps of a property's name.
    pub(super) name_limit: Option<usize>,
    /// In the order of the file.
    pub(super) features: Vec<Feature>,
}

/// A feature as found.
#[derive(Debug, Default)]
pub(super) struct Feature {
    /// What the file calls it, if anything.
    pub(super) id: Option<String>,
    /// What is said of it.
    pub(super) properties: Properties,
    /// Its areas; empty where it is none.
    pub(super) polygons: Vec<Polygon>,
    /// Whether it has points or lines beside its areas.
    pub(super) has_other_parts: bool,
    /// Lowest and highest point of a solid \[m above the datum\].
    pub(super) heights: Option<[f64; 2]>,
}

/// Properties by name; formats with columns share the names.
pub(super) type Properties = Vec<(Arc<str>, Property)>;

/// The value of a property.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Property {
    /// A number.
    Number(f64),
    /// Text.
    Text(String),
    /// Nothing, or what can be neither a height nor a word.
    Null,
}

/// Which part of a file is wanted.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Selection<'a> {
    /// The table of a GeoPackage.
    #[cfg_attr(not(feature = "geopackage"), expect(dead_code, reason = "no other format has tables"))]
    pub(super) layer: Option<&'a str>,
    /// West, south, east, north \[CRS units\]: features that do not meet it need not be read.
    pub(super) bounds: Option<[f64; 4]>,
}

/// The format of a file of vector data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VectorFormat {
    /// GeoJSON, or CityJSON, which its text tells apart.
    Json,
    /// Shapefile with its sidecar files.
    Shapefile,
    /// FlatGeobuf.
    FlatGeobuf,
    /// GeoPackage.
    GeoPackage,
}

impl VectorFormat {
    /// The format that an extension (lower case, without the point) stands for.
    pub fn of_extension(extension: &str) -> Option<VectorFormat> {
        match extension {
            "geojson" | "json" => Some(VectorFormat::Json),
            "shp" => Some(VectorFormat::Shapefile),
            "fgb" => Some(VectorFormat::FlatGeobuf),
            "gpkg" => Some(VectorFormat::GeoPackage),
            _ => None,
        }
    }

    /// The format of a file by its name; GeoJSON where the name says nothing.
    fn of(path: &Path) -> VectorFormat {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        VectorFormat::of_extension(&extension).unwrap_or(VectorFormat::Json)
    }
}

/// Reads the features of a file.
///
/// # Errors
/// File errors that name the file and, where there is one, the feature; `E304` for what the format allows but is not
/// read.
pub(super) fn read_features(path: &Path, selection: Selection<'_>) -> Result<FeatureSet> {
    match VectorFormat::of(path) {
        VectorFormat::Json => {
            let document = super::geojson_file::read_document(path)?;
            if cityjson::is_cityjson(&document) {
                cityjson::features(path, &document)
            } else {
                super::geojson_file::feature_set(path, document)
            }
        }
        VectorFormat::Shapefile => shapefile::read(path),
        VectorFormat::FlatGeobuf => flatgeobuf::read(path, selection.bounds),
        #[cfg(feature = "geopackage")]
        VectorFormat::GeoPackage => geopackage::read(path, selection.layer),
        #[cfg(not(feature = "geopackage"))]
        VectorFormat::GeoPackage => {
            let text = format!("cannot read {}: this build reads no GeoPackage", path.display());
            Err(Error::file(304, text).with_hint("convert it, for example with `ogr2ogr city.fgb city.gpkg`"))
        }
    }
}

impl Feature {
    /// The value of a property; where the format cuts names, also of the one that `name` is cut to.
    pub(super) fn property(&self, name: &str, name_limit: Option<usize>) -> Option<&Property> {
        let find = |name: &str| self.properties.iter().find(|(n, _)| **n == *name).map(|(_, value)| value);
        let found = find(name).or_else(|| {
            let cut: String = name.chars().take(name_limit?).collect();
            // GDAL writes an underscore for a colon, too.
            find(&cut).or_else(|| find(&cut.replace(':', "_")))
        });
        found.filter(|value| **value != Property::Null)
    }
}

impl Property {
    /// As text.
    pub(super) fn text(&self) -> Option<String> {
        match self {
            Property::Number(n) => Some(n.to_string()),
            Property::Text(text) => Some(text.clone()),
            Property::Null => None,
        }
    }
}

/// The whole of a file that is read at once.
fn read_bytes(path: &Path) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    let mut file = std::fs::File::open(path).map_err(|e| cannot_read(path, &e))?;
    file.read_to_end(&mut bytes).map_err(|e| cannot_read(path, &e))?;
    Ok(bytes)
}

/// E302: the file is not what its name says.
fn malformed(path: &Path, found: &str, wanted: &str) -> Error {
    Error::file(302, format!("cannot read {}: {found}, wanted {wanted}", path.display()))
}

/// The CRS that a text in a file describes.
///
/// # Errors
/// E310 if it is not known.
fn crs_of(path: &Path, text: &str) -> Result<Option<Crs>> {
    if text.trim().is_empty() {
        return Ok(None);
    }
    crs::parse(text).map(Some).map_err(|e| {
        Error::file(310, format!("cannot read {}: its coordinate reference system: {e}", path.display()))
            .with_hint("override it with `--crs EPSG:n`")
    })
}
