//! Vector data: whatever the format, a list of features with properties and polygons.
//!
//! One file per format makes a [`FeatureSet`] of it and knows nothing of buildings; what a feature says of a building is
//! read in [`super::building`]. Readers trust no length or count that a file names: nothing is reserved that the file's
//! own size does not bear out.

mod cityjson;
mod feature;
mod flatgeobuf;
pub(super) mod geojson;
#[cfg(feature = "geopackage")]
mod geopackage;
mod rings;
mod shapefile;
pub(super) mod wkb;

pub(super) use feature::{Feature, FeatureSet, Polygon, Property, Selection, SolidHeight, bounds, opened};
pub(super) use rings::doubled_area;

use std::path::Path;

use crate::error::Result;
#[cfg(not(feature = "geopackage"))]
use crate::error::{Cause, Error};
use crate::input::Input;

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

    /// The format that the extension of a path stands for.
    pub fn of_path(path: &Path) -> Option<VectorFormat> {
        VectorFormat::of_extension(&path.extension()?.to_string_lossy().to_lowercase())
    }

    /// The format of a file by its name; GeoJSON where the name says nothing.
    fn of(input: &Input) -> VectorFormat {
        VectorFormat::of_extension(&input.extension()).unwrap_or(VectorFormat::Json)
    }
}

/// Reads the features of a file.
pub(super) fn read_features(input: &Input, selection: Selection<'_>) -> Result<FeatureSet> {
    let mut set = match VectorFormat::of(input) {
        VectorFormat::Json => geojson::read(input),
        VectorFormat::Shapefile => shapefile::read(input),
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
