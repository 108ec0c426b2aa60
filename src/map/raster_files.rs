//! Raster files of a map, with the styles that programs for maps apply to them.

use std::path::Path;

use skyshed_request::Layer;

use crate::coverage::{Overlay, SiteCoverage};
use crate::error::Result;
use crate::export::{Batch, Format, MapResult, MaskValues, add_map, n_bands};
use crate::render::{FirstBand, qgis_style};

/// Adds a raster file of a map to a batch. A GeoTIFF of classes gets a style for QGIS beside it, if
/// [`style_of`] returns one.
///
/// # Errors
/// Errors of [`add_map`].
pub(crate) fn add_raster(batch: &mut Batch, result: &MapResult<'_>, path: &Path, format: Format) -> Result<()> {
    add_map(batch, result, path, format)?;
    let is_styled = format == Format::GeoTiff && result.mask_values == MaskValues::Classes;
    let style = is_styled.then(|| style_of(result.layers, result.n_uavs, result.sites, result.overlay)).flatten();
    match style {
        Some(style) => Ok(batch.add(&path.with_extension("qml"), style.as_bytes())?),
        None => Ok(()),
    }
}

/// Returns the style for a raster of layers of `n_uavs` UAVs, of which `sites` are the first.
///
/// `None` if no style is known, or none is needed: one band of classes has its colors in the file.
pub(crate) fn style_of(
    layers: &[Layer],
    n_uavs: usize,
    sites: &[SiteCoverage],
    overlay: Option<&Overlay>,
) -> Option<String> {
    let n = u32::try_from(n_uavs).unwrap_or(u32::MAX);
    let first = layers.first()?;
    let values = |of: fn(&SiteCoverage) -> Option<&[f32]>| sites.first().and_then(of).map(FirstBand::Values);
    let band = match first {
        Layer::Los | Layer::Union | Layer::All if n_bands(layers, n_uavs) == 1 => None,
        Layer::Los | Layer::Union | Layer::All => Some(FirstBand::Mask),
        Layer::Count => Some(FirstBand::Count(n)),
        Layer::BestServer => Some(FirstBand::BestServer(n)),
        Layer::Stability => Some(FirstBand::Stability),
        Layer::Sure => Some(FirstBand::Sure),
        Layer::Margin => values(|site| site.margin.as_deref()),
        Layer::LeastReceiverHeight => values(|site| site.least_receiver_height.as_deref()),
        Layer::LeastHeight => values(|site| site.least_height.as_deref()),
        Layer::PLos => values(|site| site.p_los.as_deref()),
        Layer::Uptime => overlay.and_then(Overlay::uptime).map(FirstBand::Values),
        Layer::Gap => overlay.and_then(Overlay::gap).map(FirstBand::Values),
        _ => None,
    };
    band.map(qgis_style)
}
