//! Vector data in any format: a list of features with properties and polygons.
//!
//! One file per format makes a [`FeatureSet`] of it and knows nothing of buildings;
//! [`super::building`] reads a feature's properties as a building. Readers trust no length or count
//! in a file: nothing is reserved beyond what the file's own size allows.

mod cityjson;
mod feature;
mod flatgeobuf;
pub(super) mod geojson;
#[cfg(feature = "geopackage")]
mod geopackage;
#[cfg(feature = "shapefiles")]
mod rings;
#[cfg(feature = "shapefiles")]
mod shapefile;
mod unique;
pub(super) mod wkb;

pub(super) use feature::{Feature, FeatureSet, Property, Selection, SolidHeight, bounds, opened};

use std::path::Path;

use crate::error::Result;
#[cfg(not(all(feature = "geopackage", feature = "shapefiles")))]
use crate::error::{Cause, Error};
use crate::input::Input;

/// Format of a file of vector data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VectorFormat {
    /// GeoJSON, or CityJSON, recognized by its text.
    Json,
    /// Shapefile with its sidecar files.
    Shapefile,
    /// FlatGeobuf.
    FlatGeobuf,
    /// GeoPackage.
    GeoPackage,
}

impl VectorFormat {
    /// Returns the format of an extension (lower case, without the point).
    pub fn of_extension(extension: &str) -> Option<VectorFormat> {
        match extension {
            "geojson" | "json" => Some(VectorFormat::Json),
            "shp" => Some(VectorFormat::Shapefile),
            "fgb" => Some(VectorFormat::FlatGeobuf),
            "gpkg" => Some(VectorFormat::GeoPackage),
            _ => None,
        }
    }

    /// Returns the format of the extension of a path.
    pub fn of_path(path: &Path) -> Option<VectorFormat> {
        VectorFormat::of_extension(&path.extension()?.to_string_lossy().to_lowercase())
    }

    /// Returns the format of a file by its name; GeoJSON for any other name.
    fn of(input: &Input) -> VectorFormat {
        VectorFormat::of_extension(&input.extension()).unwrap_or(VectorFormat::Json)
    }
}

/// Reads the features of a file.
pub(super) fn read_features(input: &Input, selection: Selection<'_>) -> Result<FeatureSet> {
    let mut set = match VectorFormat::of(input) {
        VectorFormat::Json => geojson::read(input),
        #[cfg(feature = "shapefiles")]
        VectorFormat::Shapefile => shapefile::read(input),
        #[cfg(not(feature = "shapefiles"))]
        VectorFormat::Shapefile => {
            Err(Error::unsupported(input, "this build reads no Shapefile").because(Cause::NotBuilt))
        }
        VectorFormat::FlatGeobuf => flatgeobuf::read(input, selection.bounds),
        #[cfg(feature = "geopackage")]
        VectorFormat::GeoPackage => geopackage::read(input, selection.layer),
        #[cfg(not(feature = "geopackage"))]
        VectorFormat::GeoPackage => {
            Err(Error::unsupported(input, "this build reads no GeoPackage").because(Cause::NotBuilt))
        }
    }?;
    set.features.iter_mut().for_each(Feature::open_tags);
    Ok(set)
}
