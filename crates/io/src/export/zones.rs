//! The zones of a scene as a raster of codes.

use std::path::Path;

use skyshed_request::TiffLayout;

use super::{Batch, with_suffix};
use crate::error::Result;
use crate::formats::{Bands, ClassColor, GeoTiffImage, pam_sidecar, write_geotiff};
use crate::zones::{NONE, Zone, ZoneMap};

/// Adds a GeoTIFF of [`Zone::code`]s, one byte a cell, with [`NONE`] as nodata, and the sidecar
/// that names them.
///
/// # Errors
/// Errors of [`Batch::add`]; internal errors from the encoder.
pub fn add_zones(batch: &mut Batch, zones: &ZoneMap, provenance: &str, path: &Path) -> Result<()> {
    let palette: Vec<ClassColor> = Zone::ALL
        .into_iter()
        .map(|zone| {
            let [r, g, b] = zone.color();
            ClassColor { value: zone.code(), name: zone.name().into(), rgba: [r, g, b, 255] }
        })
        .collect();
    let metadata = [("SKYSHED".to_string(), provenance.to_string())];
    let image = GeoTiffImage {
        georef: zones.grid(),
        bands: Bands::Byte(vec![("zone".into(), zones.codes())]),
        nodata: Some(f64::from(NONE)),
        palette: Some(&palette),
        metadata: &metadata,
        layout: TiffLayout::Cog,
    };
    batch.add_streamed(path, |file| write_geotiff(file, &image))?;
    batch.add(&with_suffix(path, ".aux.xml"), pam_sidecar(&palette, 1).as_bytes())
}
