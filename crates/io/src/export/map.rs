//! The coverage of a run as raster files.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use skyshed_request::Layer;

use super::Batch;
use super::files::with_suffix;
use super::format::Format;
use super::map_arrays::npz;
use super::map_result::{Band, MapResult, MaskValues, NO_COUNT, NODATA, band_name, exact_f32, finite, n_bands};
use super::single_band::{ascii_grid, bil};
use crate::coverage::class;
use crate::error::{Error, Fault, Result, WriteFault};
use crate::formats::{
    Bands, ClassColor, ClassImage, ClassPyramid, ExrChannel, GeoTiffImage, pam_sidecar, write_exr, write_geotiff,
};
use crate::raster::GeoRef;

/// Largest number of sites whose set fits the 24 bits that an f32 holds exactly.
const MOST_SITES_AS_F32: usize = 24;

/// Refuses layers that a format cannot hold. Called before any work, too.
///
/// # Errors
/// Usage error (E107).
pub fn check_layers(layers: &[Layer], n_sites: usize, path: &Path, format: Format) -> Result<()> {
    let n_bands = n_bands(layers, n_sites);
    let has = |layer| layers.contains(&layer);
    let fault = match format {
        Format::AsciiGrid | Format::Bil if n_bands != 1 => WriteFault::OneLayer(format, n_bands),
        Format::Kmz | Format::FlatGeobuf if !has(Layer::Los) => WriteFault::Without(Layer::Los),
        Format::GeoTiff
            if has(Layer::Which)
                && n_sites > MOST_SITES_AS_F32
                && layers.iter().any(|layer| layer.is_measure() || layer.is_of_time()) =>
        {
            WriteFault::SetsBesideMeasures
        }
        // Nodata of counts is also the set of 32 UAVs.
        Format::GeoTiff if has(Layer::Which) && (has(Layer::Count) || has(Layer::BestServer)) && n_sites >= 32 => {
            WriteFault::SetsBesideCounts
        }
        _ => return Ok(()),
    };
    Err(Error::write(path.display(), fault))
}

/// Adds a raster file of a map to a batch, and its sidecars.
///
/// # Errors
/// Usage error (E107) if the layers do not fit the format; those of [`Batch::add`]; internal errors
/// from the encoders.
pub fn add_map(batch: &mut Batch, result: &MapResult<'_>, path: &Path, format: Format) -> Result<()> {
    check_layers(result.layers, result.n_uavs, path, format)?;
    let files = match format {
        Format::GeoTiff => return add_geotiff(batch, result, path),
        Format::Exr => exr(result, path)?,
        Format::AsciiGrid => ascii_grid(result, path)?,
        Format::Bil => bil(result, path)?,
        Format::Npz => npz(result, path)?,
        _ => return Err(Fault::NoRasterFormat.into()),
    };
    files.iter().try_for_each(|(file, bytes)| batch.add(file, bytes))
}

/// Adds the GeoTIFF. It is written as it is made: the strips of a mask are the mask itself.
fn add_geotiff(batch: &mut Batch, result: &MapResult<'_>, path: &Path) -> Result<()> {
    let mut add = |image: &GeoTiffImage<'_>| batch.add_streamed(path, |file| write_geotiff(file, image));
    let bands = result.bands();
    let metadata = vec![("SKYSHED".to_string(), result.provenance.to_string())];
    let image = |bands, nodata, palette| {
        let layout = result.tif_layout;
        GeoTiffImage { georef: result.georef, bands, nodata, palette, metadata: &metadata, layout }
    };
    if bands.iter().all(|(_, b)| matches!(b, Band::Class(_))) {
        let masks: Vec<(String, Cow<'_, [u8]>)> = bands
            .iter()
            .filter_map(|(name, b)| match b {
                Band::Class(mask) => Some((name.clone(), result.mask_values.of(mask))),
                _ => None,
            })
            .collect();
        let palette = palette();
        let named = result.mask_values == MaskValues::Classes;
        let is_colored = named && masks.len() == 1;
        let borrowed = masks.iter().map(|(name, mask)| (name.clone(), mask.as_ref())).collect();
        let nodata = result.mask_values.nodata().map(f64::from);
        add(&image(Bands::Byte(borrowed), nodata, is_colored.then_some(palette.as_slice())))?;
        if named {
            add_class_names(batch, path, masks.len())?;
        }
        return Ok(());
    }
    if bands.iter().all(|(_, b)| !matches!(b, Band::Measure(_))) {
        let has_bits = bands.iter().any(|(_, b)| matches!(b, Band::Bits(_)));
        let is_any_number_a_set = has_bits && result.n_uavs >= u32::BITS as usize;
        let values: Vec<(String, Vec<u32>)> = bands
            .into_iter()
            .map(|(name, band)| {
                let values = match band {
                    // A file has one nodata for all its bands.
                    Band::Class(mask) if !is_any_number_a_set => {
                        mask.iter().map(|c| if *c == class::NODATA { NO_COUNT } else { u32::from(*c) }).collect()
                    }
                    Band::Class(mask) => mask.iter().map(|c| u32::from(*c)).collect(),
                    Band::Count(n) => n,
                    Band::Bits(bits) => bits.to_vec(),
                    Band::Measure(_) => Vec::new(),
                };
                (name, values)
            })
            .collect();
        let borrowed = values.iter().map(|(n, v)| (n.clone(), v.as_slice())).collect();
        let nodata = (!is_any_number_a_set).then_some(f64::from(NO_COUNT));
        return add(&image(Bands::UInt32(borrowed), nodata, None));
    }
    let mut values: Vec<(String, Vec<f32>)> = Vec::new();
    for (name, band) in bands {
        let band: Vec<f32> = match band {
            Band::Class(mask) => {
                mask.iter().map(|c| if *c == class::NODATA { NODATA } else { f32::from(*c) }).collect()
            }
            Band::Measure(v) => v.iter().map(|v| finite(*v)).collect(),
            Band::Count(n) => n.iter().map(|n| if *n == NO_COUNT { NODATA } else { exact_f32(*n) }).collect(),
            Band::Bits(bits) => bits.iter().map(|n| exact_f32(*n)).collect(),
        };
        values.push((name, band));
    }
    let borrowed = values.iter().map(|(n, v)| (n.clone(), v.as_slice())).collect();
    add(&image(Bands::Float(borrowed), Some(f64::from(NODATA)), None))
}

/// Adds the GeoTIFF of one UAV's mask, of which all rows were pushed, and the names of its classes.
///
/// # Errors
/// Errors of [`Batch::add`]; internal errors from the encoder.
pub fn add_mask_geotiff(
    batch: &mut Batch,
    path: &Path,
    pyramid: &ClassPyramid,
    (georef, site, provenance): (&GeoRef, &str, &str),
    mask_values: MaskValues,
) -> Result<()> {
    add_described(batch, path, (georef, site, provenance), mask_values, |batch, image, metadata| {
        batch.add_streamed(path, |file| pyramid.write(file, image, metadata))
    })
}

/// Adds the mask of one UAV, which `add` writes with the given description, and the names of its
/// classes.
pub(super) fn add_described(
    batch: &mut Batch,
    path: &Path,
    (georef, site, provenance): (&GeoRef, &str, &str),
    mask_values: MaskValues,
    add: impl FnOnce(&mut Batch, &ClassImage<'_>, &[(String, String)]) -> Result<()>,
) -> Result<()> {
    let palette = palette();
    let is_named = mask_values == MaskValues::Classes;
    let image = ClassImage {
        georef,
        nodata: mask_values.nodata().map(f64::from),
        palette: is_named.then_some(palette.as_slice()),
        name: &band_name(site, Layer::Los),
    };
    let metadata = [("SKYSHED".to_string(), provenance.to_string())];
    add(batch, &image, &metadata)?;
    if is_named { add_class_names(batch, path, 1) } else { Ok(()) }
}

/// Adds the sidecar with the names and colors of the classes of `n_bands` masks.
fn add_class_names(batch: &mut Batch, path: &Path, n_bands: usize) -> Result<()> {
    batch.add(&with_suffix(path, ".aux.xml"), pam_sidecar(&named_classes(), n_bands).as_bytes())
}

/// Returns the classes that legends name. Nodata has no name: names are a list from 0, and nobody
/// wants 250 blanks.
pub(super) fn named_classes() -> Vec<ClassColor> {
    palette().into_iter().filter(|class| class.value != class::NODATA).collect()
}

/// Returns the classes with their names and colors.
fn palette() -> Vec<ClassColor> {
    let color = |(value, name): &(u8, &str)| ClassColor {
        value: *value,
        name: (*name).to_string(),
        rgba: class::color(*value),
    };
    class::NAMES.iter().map(color).collect()
}

fn exr(result: &MapResult<'_>, path: &Path) -> Result<Vec<(PathBuf, Vec<u8>)>> {
    enum Owned<'a> {
        Float(Cow<'a, [f32]>),
        UInt(Vec<u32>),
    }
    let bands = result.bands();
    let channels: Vec<(String, Owned<'_>)> = bands
        .into_iter()
        .map(|(name, band)| {
            let channel = match band {
                Band::Class(mask) => Owned::UInt(mask.iter().map(|c| u32::from(*c)).collect()),
                Band::Measure(v) => Owned::Float(v.into()),
                Band::Count(n) => {
                    Owned::Float(n.iter().map(|n| if *n == NO_COUNT { f32::NAN } else { exact_f32(*n) }).collect())
                }
                Band::Bits(n) => Owned::UInt(n.to_vec()),
            };
            (name, channel)
        })
        .collect();
    let borrowed: Vec<(String, ExrChannel<'_>)> = channels
        .iter()
        .map(|(name, c)| {
            let channel = match c {
                Owned::Float(v) => ExrChannel::Float(v),
                Owned::UInt(v) => ExrChannel::UInt(v),
            };
            (name.clone(), channel)
        })
        .collect();
    let mut bytes = Vec::new();
    let metadata = [("SKYSHED".to_string(), result.provenance.to_string())];
    write_exr(&mut bytes, result.georef, &borrowed, &metadata)?;
    Ok(vec![(path.to_path_buf(), bytes)])
}

/// Returns the name of one site's bare picture beside that of all sites: `NAME.SITE.png`, odd
/// characters replaced.
pub fn bare_name(path: &Path, site: &str) -> PathBuf {
    path.with_extension(format!("{}.png", site_in_names(site)))
}

/// Returns the name of a site for file names: odd characters replaced.
pub fn site_in_names(site: &str) -> String {
    site.chars().map(|c| if c.is_alphanumeric() || "-_".contains(c) { c } else { '_' }).collect()
}
