//! Vector data in any format: a list of features with properties and polygons.
//!
//! One file per format makes a [`FeatureSet`] of it and knows nothing of buildings;
//! [`super::building`] reads a feature's properties as a building. Readers trust no length or count
//! in a file: nothing is reserved beyond what the file's own size allows.

mod bounded;
mod citygml;
mod cityjson;
mod feature;
mod flatgeobuf;
pub(super) mod geojson;
#[cfg(feature = "geopackage")]
mod geopackage;
#[cfg(feature = "parquet")]
mod geoparquet;
mod osm;
#[cfg(feature = "shapefiles")]
mod patches;
mod rings;
#[cfg(feature = "shapefiles")]
mod shapefile;
mod selection;
mod surfaces;
mod tiles;
mod unique;
pub(super) mod wkb;

pub(super) use feature::{Feature, FeatureSet, Property, SolidHeight, bounds, opened};
pub(super) use selection::{Selection, Within};
pub(super) use surfaces::CornerHeights;

use super::scene_files::SceneFiles;
#[cfg(not(all(feature = "geopackage", feature = "parquet", feature = "shapefiles")))]
use crate::error::{Cause, Error};
use crate::error::{Result, Warning};
use crate::format::{FileFormat, FileKind};
use crate::input::Input;
use tiles::Tiles;

/// Reads the features of all files of a scene.
///
/// # Errors
/// E302 for a format without features; errors of the files; E308 for files in two reference
/// systems.
pub(super) fn read_features(
    scene: &Input,
    files: &SceneFiles,
    selection: Selection<'_>,
    warnings: &mut Vec<Warning>,
) -> Result<FeatureSet> {
    let read = |input: &Input| -> Result<FeatureSet> {
        let mut set = read_file(input, files.format, selection)?;
        set.features.iter_mut().for_each(Feature::open_tags);
        if selection.swap_axes {
            set.features.iter_mut().for_each(Feature::swap_axes);
        }
        Ok(set)
    };
    let mut set = match files.files.as_slice() {
        [input] => read(input)?,
        inputs => {
            let mut tiles = Tiles::default();
            inputs.iter().try_for_each(|input| tiles.add(input, read(input)))?;
            tiles.whole(files, warnings, scene)?
        }
    };
    warnings.extend(set.oddity.take().map(|odd| Warning::of(scene, odd)));
    Ok(set)
}

fn read_file(input: &Input, format: FileFormat, selection: Selection<'_>) -> Result<FeatureSet> {
    match format {
        FileFormat::GeoJson | FileFormat::CityJson => geojson::read(input),
        FileFormat::CityGml => citygml::read(input, selection),
        FileFormat::Osm => osm::read(input, selection),
        #[cfg(feature = "shapefiles")]
        FileFormat::Shapefile => shapefile::read(input, selection),
        #[cfg(not(feature = "shapefiles"))]
        FileFormat::Shapefile => {
            Err(Error::unsupported(input, "this build reads no Shapefile").because(Cause::NotBuilt))
        }
        FileFormat::FlatGeobuf => flatgeobuf::read(input, selection),
        #[cfg(feature = "geopackage")]
        FileFormat::GeoPackage => geopackage::read(input, selection),
        #[cfg(not(feature = "geopackage"))]
        FileFormat::GeoPackage => {
            Err(Error::unsupported(input, "this build reads no GeoPackage").because(Cause::NotBuilt))
        }
        #[cfg(feature = "parquet")]
        FileFormat::GeoParquet => geoparquet::read(input, selection),
        #[cfg(not(feature = "parquet"))]
        FileFormat::GeoParquet => {
            Err(Error::unsupported(input, "this build reads no GeoParquet").because(Cause::NotBuilt))
        }
        format => Err(format.unwanted(input, FileKind::Vector)),
    }
}
