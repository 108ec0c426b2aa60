//! The coverage of a run, ready for files: its layers as bands, and the numbers that stand for nothing.

use std::borrow::Cow;

use crate::coverage::{Overlay, SiteCoverage, class, which_layer};
use crate::formats::TiffLayout;
use crate::raster::GeoRef;

/// Nodata of float rasters in GeoTIFF and ASCII grids.
pub(super) const NODATA: f32 = -9999.0;
/// Nodata of counts.
pub(super) const NO_COUNT: u32 = u32::MAX;

/// A layer of a map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Layer {
    /// The mask.
    Los,
    /// Receiver height less the least visible height \[m\].
    Margin,
    /// Least receiver height \[m above the datum\].
    LeastReceiverHeight,
    /// Least UAV height \[m above the datum\].
    LeastHeight,
    /// How many of all UAVs see each cell.
    Count,
    /// How many of eight moves by one lattice step turn the answer.
    Stability,
    /// Which of all UAVs see each cell, a bit for each.
    Which,
}

impl Layer {
    /// The word for it on the command line and in band names.
    pub fn name(self) -> &'static str {
        match self {
            Layer::Los => "los",
            Layer::Margin => "margin",
            Layer::LeastReceiverHeight => "least-receiver-height",
            Layer::LeastHeight => "least-height",
            Layer::Stability => "stability",
            Layer::Count => "count",
            Layer::Which => "which",
        }
    }

    /// Whether the layer holds a float for each receiver: meters, or the number of moves that turn it.
    pub fn is_measure(self) -> bool {
        matches!(self, Layer::Margin | Layer::LeastReceiverHeight | Layer::LeastHeight | Layer::Stability)
    }

    /// The values of a layer that is a measure, if they were made.
    pub(super) fn measure_of(self, site: &SiteCoverage) -> Option<&[f32]> {
        match self {
            Layer::Margin => site.margin.as_deref(),
            Layer::LeastReceiverHeight => site.least_receiver_height.as_deref(),
            Layer::LeastHeight => site.least_height.as_deref(),
            Layer::Stability => site.stability.as_ref().map(|s| s.turns.as_slice()),
            Layer::Los | Layer::Count | Layer::Which => None,
        }
    }
}

/// The coverage of a run, ready for files.
#[derive(Debug)]
pub struct MapResult<'a> {
    /// The grid.
    pub georef: &'a GeoRef,
    /// One coverage per UAV.
    pub sites: &'a [SiteCoverage],
    /// The layers that were asked for, in order.
    pub layers: &'a [Layer],
    /// Provenance as one JSON text.
    pub provenance: &'a str,
    /// Arrangement of the cells in GeoTIFF files.
    pub tif_layout: TiffLayout,
    /// The values of masks in GeoTIFF and .bil files.
    pub mask_values: MaskValues,
}

/// The values that stand for line of sight in a mask.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum MaskValues {
    /// The [`class`]es.
    #[default]
    Classes,
    /// 255 for line of sight and 0 for everything else, whatever its reason, as `gdal_viewshed` writes by default; without
    /// nodata, colors or names.
    Gdal,
}

impl MaskValues {
    /// A mask with these values.
    pub fn of<'a>(self, mask: &'a [u8]) -> Cow<'a, [u8]> {
        match self {
            MaskValues::Classes => Cow::Borrowed(mask),
            MaskValues::Gdal => mask.iter().map(|c| if *c == class::LOS { 255 } else { 0 }).collect(),
        }
    }

    /// The value that means no data, if one does.
    pub(super) fn nodata(self) -> Option<u8> {
        (self == MaskValues::Classes).then_some(class::NODATA)
    }
}

/// All masks laid over each other.
fn overlay_of(masks: &[&[u8]]) -> Overlay {
    let mut overlay = Overlay::new(masks.first().map_or(0, |mask| mask.len()));
    masks.iter().for_each(|mask| overlay.add(mask));
    overlay
}

/// How many UAVs see each cell, [`NO_COUNT`] where it is a receiver of none.
pub(super) fn count_of(masks: &[&[u8]]) -> Vec<u32> {
    let overlay = overlay_of(masks);
    let count = overlay.count().iter().zip(overlay.union());
    count.map(|(n, c)| if matches!(*c, class::LOS | class::NLOS) { *n } else { NO_COUNT }).collect()
}

/// One band: a name and its values.
pub(super) enum Band<'a> {
    Class(&'a [u8]),
    Measure(&'a [f32]),
    Count(Vec<u32>),
    Bits(Vec<u32>),
}

impl<'a> MapResult<'a> {
    pub(super) fn bands(&self) -> Vec<(String, Band<'a>)> {
        let masks: Vec<&[u8]> = self.sites.iter().map(|s| s.mask.as_slice()).collect();
        let mut bands: Vec<(String, Band<'a>)> = Vec::new();
        for &layer in self.layers {
            for site in self.sites {
                let name = band_name(&site.uav.id, layer);
                let band = match layer {
                    Layer::Los => Some(Band::Class(&site.mask)),
                    _ => layer.measure_of(site).map(Band::Measure),
                };
                bands.extend(band.map(|b| (name, b)));
            }
            match layer {
                Layer::Count => {
                    bands.push(("count".into(), Band::Count(count_of(&masks))));
                }
                Layer::Which => {
                    for (word, bits) in which_layer(&masks).into_iter().enumerate() {
                        bands.push((format!("which.{word}"), Band::Bits(bits)));
                    }
                }
                _ => {}
            }
        }
        bands
    }
}

/// The name of the band of a layer of one UAV.
pub(super) fn band_name(site: &str, layer: Layer) -> String {
    format!("{site}.{}", layer.name())
}

/// A measure for formats whose readers stumble over what is not finite: nodata for none, ±32768 m, the end of the proven
/// range, for no height that is enough.
pub(super) fn finite(v: f32) -> f32 {
    const END: f32 = 32_768.0;
    if v.is_nan() { NODATA } else { v.clamp(-END, END) }
}

#[expect(clippy::cast_precision_loss, reason = "counts of UAVs and sets of at most 24 bits are exact in f32")]
pub(super) fn exact_f32(n: u32) -> f32 {
    n as f32
}
