//! A comparison of placements as GeoTIFF.

use std::path::Path;

use skyshed_request::TiffLayout;

use super::Batch;
use crate::coverage::{Overlay, class, difference_layer};
use crate::error::Result;
use crate::formats::{Bands, GeoTiffImage, write_geotiff};
use crate::raster::GeoRef;

/// Placements side by side, ready for a file.
#[derive(Debug, Clone, Copy)]
pub struct Comparison<'a> {
    /// The grid.
    pub georef: &'a GeoRef,
    /// Names of the placements.
    pub ids: &'a [&'a str],
    /// Their masks.
    pub masks: &'a [&'a [u8]],
    /// The pairs to compare, as indices of the placements.
    pub pairs: &'a [(usize, usize)],
    /// All masks laid over each other; at most 254.
    pub overlay: &'a Overlay,
    /// Provenance as one JSON text.
    pub provenance: &'a str,
}

/// Adds a GeoTIFF of byte bands to a batch; 255 is nodata in all of them.
///
/// * `SITE.los`: the mask of each placement.
/// * `A-B.difference`: [`crate::coverage::difference_layer`] of each pair. Nodata where the cell is
///   not a receiver of both.
/// * `count`: number of placements that see a cell. Nodata where it is a receiver of none.
///
/// # Errors
/// Errors of [`Batch::add`] and of the encoder.
pub fn add_comparison(batch: &mut Batch, comparison: &Comparison<'_>, path: &Path) -> Result<()> {
    let Comparison { ids, masks, overlay, .. } = comparison;
    let differences: Vec<(String, Vec<u8>)> = comparison
        .pairs
        .iter()
        .map(|&(a, b)| (format!("{}-{}.difference", ids[a], ids[b]), difference_layer(masks[a], masks[b])))
        .collect();
    let count = |(class, count): (&u8, &u32)| match *class {
        class::NLOS | class::LOS => u8::try_from(*count).unwrap_or(class::NODATA - 1),
        _ => class::NODATA,
    };
    let count: Vec<u8> = overlay.union().iter().zip(overlay.count()).map(count).collect();
    let mut bands: Vec<(String, &[u8])> =
        ids.iter().zip(*masks).map(|(id, mask)| (format!("{id}.los"), *mask)).collect();
    bands.extend(differences.iter().map(|(name, values)| (name.clone(), values.as_slice())));
    bands.push(("count".into(), &count));
    let image = GeoTiffImage {
        georef: comparison.georef,
        bands: Bands::Byte(bands),
        nodata: Some(f64::from(class::NODATA)),
        palette: None,
        metadata: &[("SKYSHED".to_string(), comparison.provenance.to_string())],
        layout: TiffLayout::Cog,
    };
    batch.add_streamed(path, |file| write_geotiff(file, &image))
}
