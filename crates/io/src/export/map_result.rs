//! The coverage of a run, ready for files: its layers as bands, and the numbers that stand for nothing.

use std::borrow::Cow;

use crate::coverage::{Overlay, SiteCoverage, class};
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
    /// Who is in line of sight whatever heights are within their errors: 0 never, 1 surely, 2 possibly.
    Sure,
    /// Probability of line of sight with errors of heights.
    PLos,
    /// Which of all UAVs see each cell, a bit for each.
    Which,
    /// The mask of all UAVs together.
    Union,
    /// The nearest of all UAVs that see each cell, by its number.
    BestServer,
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
            Layer::Sure => "sure",
            Layer::PLos => "p-los",
            Layer::Count => "count",
            Layer::Which => "which",
            Layer::Union => "union",
            Layer::BestServer => "best-server",
        }
    }

    /// Whether the layer is one of all UAVs together.
    pub fn is_of_all(self) -> bool {
        matches!(self, Layer::Count | Layer::Which | Layer::Union | Layer::BestServer)
    }

    /// Whether the layer holds a float for each receiver: meters, the number of moves that turn it, how sure it is, or a probability.
    pub fn is_measure(self) -> bool {
        use Layer::{LeastHeight, LeastReceiverHeight, Margin, PLos, Stability, Sure};
        matches!(self, Margin | LeastReceiverHeight | LeastHeight | Stability | Sure | PLos)
    }

    /// The values of a layer that is a measure, if they were made.
    pub(super) fn measure_of(self, site: &SiteCoverage) -> Option<&[f32]> {
        match self {
            Layer::Margin => site.margin.as_deref(),
            Layer::LeastReceiverHeight => site.least_receiver_height.as_deref(),
            Layer::LeastHeight => site.least_height.as_deref(),
            Layer::Stability => site.stability.as_ref().map(|s| s.turns.as_slice()),
            Layer::Sure => site.sure.as_deref(),
            Layer::PLos => site.p_los.as_deref(),
            _ => None,
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
    /// How many UAVs there are in the list of all, of which these are some.
    pub n_uavs: usize,
    /// All of them together, where a layer tells of that.
    pub overlay: Option<&'a Overlay>,
    /// The layers that were asked for, in order.
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
        Layer::Count | Layer::Union | Layer::BestServer => 1,
        Layer::Which => n_uavs.div_ceil(32),
        _ => n_uavs,
    };
    layers.iter().map(of_layer).sum()
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

/// Numbers of a layer of all UAVs where a cell is a receiver of one, [`NO_COUNT`] elsewhere.
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
                    _ => layer.measure_of(site).map(Band::Measure),
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
