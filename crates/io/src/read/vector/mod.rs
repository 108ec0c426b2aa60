//! Vector data in any format: a list of features with properties and polygons.
//!
//! One file per format makes a [`FeatureSet`] of it and knows nothing of buildings;
//! [`super::building`] reads a feature's properties as a building. Readers trust no length or count
//! in a file: nothing is reserved beyond what the file's own size allows.

mod citygml;
mod cityjson;
mod feature;
mod flatgeobuf;
pub(super) mod geojson;
#[cfg(feature = "geopackage")]
mod geopackage;
#[cfg(feature = "parquet")]
mod geoparquet;
#[cfg(feature = "shapefiles")]
mod rings;
#[cfg(feature = "shapefiles")]
mod shapefile;
mod unique;
pub(super) mod wkb;

pub(super) use feature::{Feature, FeatureSet, Property, Selection, SolidHeight, bounds, opened};

use super::scene_files::SceneFiles;
#[cfg(not(all(feature = "geopackage", feature = "parquet", feature = "shapefiles")))]
use crate::error::Cause;
use std::collections::HashSet;

#[cfg(not(all(feature = "geopackage", feature = "parquet", feature = "shapefiles")))]
use crate::error::Error;
use crate::error::{Pair, Result, two_crs};
use crate::format::{FileFormat, FileKind};
use crate::input::Input;
use crate::quantity::STEPS_PER_UNIT;
use crate::raster::CrsKind;

/// Reads the features of all files of a scene.
///
/// # Errors
/// E302 for a format without features; errors of the files; E308 for files in two reference
/// systems.
pub(super) fn read_features(scene: &SceneFiles, selection: Selection<'_>) -> Result<FeatureSet> {
    let read = |input: &Input| -> Result<FeatureSet> {
        let mut set = read_file(input, scene.format, selection)?;
        set.features.iter_mut().for_each(Feature::open_tags);
        Ok(set)
    };
    let [first, others @ ..] = scene.files.as_slice() else { return Ok(FeatureSet::default()) };
    let mut whole = read(first)?;
    if others.is_empty() {
        return Ok(whole);
    }
    whole.name = None;
    // Steps of the lattice, or of a millimeter where units are degrees.
    let is_geographic = matches!(&whole.crs, Ok(Some(crs)) if matches!(crs.kind(), CrsKind::Geographic));
    let steps = if is_geographic || whole.crs.is_err() { 1e8 } else { f64::from(STEPS_PER_UNIT) };
    let mut seen: HashSet<_> = whole.features.iter().filter_map(|feature| likeness(feature, steps)).collect();
    for input in others {
        let set = read(input)?;
        if let (Ok(Some(one)), Ok(Some(other))) = (&whole.crs, &set.crs)
            && !one.same_as(other)
        {
            return Err(two_crs((first, one), (input, other), Pair::Tiles));
        }
        if !matches!(whole.crs, Ok(Some(_))) {
            whole.crs = set.crs;
        }
        whole.attribution = whole.attribution.take().or(set.attribution);
        // A building on the seam of two tiles stands in both, and counts once.
        let of_file: Vec<_> = set.features.iter().map(|feature| likeness(feature, steps)).collect();
        let is_new = |like: &Option<Likeness>| like.as_ref().is_none_or(|like| !seen.contains(like));
        let features = set.features.into_iter().zip(&of_file).filter(|(_, like)| is_new(like));
        whole.features.extend(features.map(|(feature, _)| feature));
        seen.extend(of_file.into_iter().flatten());
    }
    Ok(whole)
}

/// Id and areas of a feature, by which it is known in two files.
type Likeness = (String, Vec<[i64; 2]>);

/// Returns the likeness of a feature with an id, its corners in some steps of a unit.
fn likeness(feature: &Feature, steps: f64) -> Option<Likeness> {
    let id = feature.id.clone()?;
    #[expect(clippy::cast_possible_truncation, reason = "saturates")]
    let corner = |p: &[f64; 2]| p.map(|v| (v * steps).round() as i64);
    Some((id, feature.polygons.iter().flatten().flatten().map(corner).collect()))
}

fn read_file(input: &Input, format: FileFormat, selection: Selection<'_>) -> Result<FeatureSet> {
    match format {
        FileFormat::Json => geojson::read(input),
        FileFormat::CityGml => citygml::read(input),
        #[cfg(feature = "shapefiles")]
        FileFormat::Shapefile => shapefile::read(input),
        #[cfg(not(feature = "shapefiles"))]
        FileFormat::Shapefile => {
            Err(Error::unsupported(input, "this build reads no Shapefile").because(Cause::NotBuilt))
        }
        FileFormat::FlatGeobuf => flatgeobuf::read(input, selection.bounds),
        #[cfg(feature = "geopackage")]
        FileFormat::GeoPackage => geopackage::read(input, selection.layer),
        #[cfg(not(feature = "geopackage"))]
        FileFormat::GeoPackage => {
            Err(Error::unsupported(input, "this build reads no GeoPackage").because(Cause::NotBuilt))
        }
        #[cfg(feature = "parquet")]
        FileFormat::GeoParquet => geoparquet::read(input, selection.bounds),
        #[cfg(not(feature = "parquet"))]
        FileFormat::GeoParquet => {
            Err(Error::unsupported(input, "this build reads no GeoParquet").because(Cause::NotBuilt))
        }
        format => Err(format.unwanted(input, FileKind::Vector)),
    }
}
