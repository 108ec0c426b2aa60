//! Coverage of a run, ready for files: its layers as bands, and their nodata values.

use std::borrow::Cow;

use skyshed_request::{Layer, TiffLayout};

use crate::coverage::{Overlay, SiteCoverage, class};
use crate::raster::GeoRef;

/// Nodata of float rasters in GeoTIFF and ASCII grids.
pub(super) const NODATA: f32 = -9999.0;
/// Nodata of counts.
pub(super) const NO_COUNT: u32 = u32::MAX;

/// Returns the values of a layer that is a measure, if they were made.
pub(super) fn measure_of(layer: Layer, site: &SiteCoverage) -> Option<&[f32]> {
    match layer {
        Layer::Margin => site.margin.as_deref(),
        Layer::LeastReceiverHeight => site.least_receiver_height.as_deref(),
        Layer::LeastHeight => site.least_height.as_deref(),
        Layer::Stability => site.stability.as_ref().map(|s| s.turns.as_slice()),
        Layer::Sure => site.sure.as_deref(),
        Layer::PLos => site.p_los.as_deref(),
        _ => None,
    }
}

/// The coverage of a run, ready for files.
#[derive(Debug)]
pub struct MapResult<'a> {
    /// The grid.
    pub georef: &'a GeoRef,
    /// One coverage per UAV.
    pub sites: &'a [SiteCoverage],
    /// Number of all UAVs, of which `sites` are some.
    pub n_uavs: usize,
    /// Masks of all UAVs laid over each other, if a layer needs them.
    pub overlay: Option<&'a Overlay>,
    /// Requested layers, in order.
    pub layers: &'a [Layer],
    /// Provenance as one JSON text.
    pub provenance: &'a str,
    /// Arrangement of the cells in GeoTIFF files.
    pub tif_layout: TiffLayout,
    /// The values of masks in GeoTIFF and .bil files.
    pub mask_values: MaskValues,
}

/// Returns the number of bands that layers of so many UAVs take in a file.
pub fn n_bands(layers: &[Layer], n_uavs: usize) -> usize {
    let of_layer = |layer: &Layer| match layer {
        Layer::Which => n_uavs.div_ceil(32),
        layer if layer.is_of_all() => 1,
        _ => n_uavs,
    };
    layers.iter().map(of_layer).sum()
}

/// Values for line of sight in a mask.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MaskValues {
    /// The [`class`]es.
    #[default]
    Classes,
    /// 255 for line of sight and 0 for everything else, whatever its reason, as `gdal_viewshed`
    /// writes by default. There is no nodata, and no colors or names.
    Gdal,
}

impl MaskValues {
    /// Returns a mask with these values.
    pub fn of<'a>(self, mask: &'a [u8]) -> Cow<'a, [u8]> {
        match self {
            MaskValues::Classes => Cow::Borrowed(mask),
            MaskValues::Gdal => mask.iter().map(|c| if *c == class::LOS { 255 } else { 0 }).collect(),
        }
    }

    /// Returns the nodata value, if there is one.
    pub(super) fn nodata(self) -> Option<u8> {
        (self == MaskValues::Classes).then_some(class::NODATA)
    }
}

/// Returns the numbers of a layer of all UAVs in cells that are a receiver of one, [`NO_COUNT`]
/// elsewhere.
fn of_receivers(values: &[u32], overlay: &Overlay) -> Vec<u32> {
    let both = values.iter().zip(overlay.union());
    both.map(|(n, class)| if matches!(*class, class::LOS | class::NLOS) { *n } else { NO_COUNT }).collect()
}

/// One band: a name and its values.
pub(super) enum Band<'a> {
    Class(&'a [u8]),
    Measure(&'a [f32]),
    /// Numbers, [`NO_COUNT`] where there is none.
    Count(Vec<u32>),
    Bits(&'a [u32]),
}

impl<'a> MapResult<'a> {
    pub(super) fn bands(&self) -> Vec<(String, Band<'a>)> {
        let mut bands: Vec<(String, Band<'a>)> = Vec::new();
        for &layer in self.layers {
            for site in self.sites {
                let name = band_name(&site.uav.id, layer);
                let band = match layer {
                    Layer::Los => Some(Band::Class(&site.mask)),
                    _ => measure_of(layer, site).map(Band::Measure),
                };
                bands.extend(band.map(|b| (name, b)));
            }
            let Some(overlay) = self.overlay else { continue };
            let name = || layer.name().to_string();
            match layer {
                Layer::Count => bands.push((name(), Band::Count(of_receivers(overlay.count(), overlay)))),
                Layer::BestServer => {
                    let numbers = overlay.best_server().unwrap_or_default();
                    bands.push((name(), Band::Count(of_receivers(numbers, overlay))));
                }
                Layer::Union => bands.push((name(), Band::Class(overlay.union()))),
                Layer::All => bands.extend(overlay.all().map(|mask| (name(), Band::Class(mask)))),
                Layer::Uptime => bands.extend(overlay.uptime().map(|values| (name(), Band::Measure(values)))),
                Layer::Gap => bands.extend(overlay.gap().map(|values| (name(), Band::Measure(values)))),
                Layer::Which => {
                    let words = overlay.which().iter().enumerate();
                    bands.extend(words.map(|(k, bits)| (format!("which.{k}"), Band::Bits(bits))));
                }
                _ => {}
            }
        }
        bands
    }
}

/// Returns the band name of a layer of one UAV.
pub(super) fn band_name(site: &str, layer: Layer) -> String {
    format!("{site}.{}", layer.name())
}

/// Replaces values that are not finite, for formats whose readers reject them. NaN becomes nodata.
/// Infinity, which means that no height suffices, becomes ±32768 m, the end of the proven range.
pub(super) fn finite(v: f32) -> f32 {
    const END: f32 = 32_768.0;
    if v.is_nan() { NODATA } else { v.clamp(-END, END) }
}

#[expect(clippy::cast_precision_loss, reason = "counts of UAVs and sets of at most 24 bits are exact in f32")]
pub(super) fn exact_f32(n: u32) -> f32 {
    n as f32
}
