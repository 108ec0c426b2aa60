//! Checks of the forms of files, made as early as possible.

use std::path::Path;

use skyshed_request::{Layer, SaveOptions};

use crate::answer::Output;
use crate::error::{Error, RequestError, Result};
use crate::export::{Format, MaskValues};
use crate::picture::Look;
use crate::quantity::counted;
use crate::scene::Scene;

/// Returns the look of files.
pub(crate) fn look_of(options: &SaveOptions) -> Look {
    Look::of(&options.picture, &options.writing)
}

/// Returns the values of masks in rasters.
pub(crate) fn mask_values(options: &SaveOptions) -> MaskValues {
    if options.forms.gdal_values { MaskValues::Gdal } else { MaskValues::Classes }
}

/// Refuses forms without a file that could have them, before any work.
///
/// # Errors
/// E116.
pub(crate) fn check_formats(options: &SaveOptions, outputs: &[Output]) -> Result<()> {
    let has = |wanted: Format| outputs.iter().any(|(_, format)| *format == wanted);
    if options.forms.bare && !has(Format::Png) {
        return Err(Error::idle("bare", "without a .png output"));
    }
    if options.forms.tif_layout.is_some() && !has(Format::GeoTiff) {
        return Err(Error::idle("tif_layout", "without a .tif output"));
    }
    Ok(())
}

/// Refuses forms that the outputs cannot have, once the scene is known and before any map is made.
///
/// # Errors
/// E109, E113, E116.
pub(crate) fn check_forms(options: &SaveOptions, scene: &Scene, outputs: &[Output]) -> Result<()> {
    let forms = &options.forms;
    let has = |wanted: &[Format]| outputs.iter().any(|(_, format)| wanted.contains(format));
    let has_no_meaning = |option, wanted| Err(Error::idle(option, format!("without a {wanted} output")));
    if forms.gdal_values && !has(&[Format::GeoTiff, Format::Bil]) {
        return has_no_meaning("gdal_values", ".tif or .bil");
    }
    if forms.polygons.is_some() && !has(&[Format::GeoJson, Format::FlatGeobuf]) {
        return has_no_meaning("polygons", ".geojson or .fgb");
    }
    if let Some(tolerance) = forms.simplify.filter(|m| *m <= 0.0) {
        return Err(Error::number("`simplify`", tolerance, "above 0 m"));
    }
    for (path, format) in outputs {
        match format {
            Format::FlatGeobuf if forms.polygons.is_none() => {
                return Err(RequestError::NoPolygons(path.display().to_string()).into());
            }
            Format::Kmz if scene.grid().crs().is_none() => return Err(no_crs(path)),
            _ => {}
        }
    }
    Ok(())
}

/// Refuses mask values of GDAL for anything but line of sight of one UAV.
///
/// # Errors
/// E107.
pub(crate) fn check_values(options: &SaveOptions, layers: &[Layer], n_sites: usize) -> Result<()> {
    if !options.forms.gdal_values || layers == [Layer::Los] && n_sites == 1 {
        return Ok(());
    }
    let names: Vec<&str> = layers.iter().map(|layer| layer.name()).collect();
    let (layers, uavs) = (names.join(","), counted(n_sites as u64, "UAV", "UAVs"));
    Err(RequestError::GdalValues { layers, uavs }.into())
}

/// Returns the error for an overlay of a scene without a reference system.
pub(crate) fn no_crs(path: &Path) -> Error {
    RequestError::NoCrs(path.display().to_string()).into()
}
