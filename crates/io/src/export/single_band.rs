//! One layer of one site in the formats that hold no more: Esri ASCII grids, and .bil files with
//! their header.

use std::path::{Path, PathBuf};

use super::files::with_suffix;
use super::map_result::{Band, MapResult, NO_COUNT, NODATA, finite};
use crate::coverage::class;
use crate::crs::wkt_of;
use crate::error::{Error, Fault, Result};
use crate::formats::{BilValues, bil_header, write_ascii_grid};

/// Encodes the layer as text, with its `.prj` and its provenance.
pub(super) fn ascii_grid(result: &MapResult<'_>, path: &Path) -> Result<Vec<(PathBuf, Vec<u8>)>> {
    let band = only_band(result)?;
    let mut bytes = Vec::new();
    let failed = |e: std::io::Error| Error::encode(path.display(), e);
    let mut write = |nodata: f64, values: &mut dyn Iterator<Item = f64>| {
        write_ascii_grid(&mut bytes, result.georef, nodata, values, None).map_err(failed)
    };
    match &band {
        Band::Class(mask) => write(f64::from(class::NODATA), &mut mask.iter().map(|c| f64::from(*c)))?,
        Band::Measure(v) => {
            let value = |v: &f32| f64::from(finite(*v));
            write(f64::from(NODATA), &mut v.iter().map(value))?;
        }
        Band::Count(n) => {
            let value = |n: &u32| if *n == NO_COUNT { f64::from(NODATA) } else { f64::from(*n) };
            write(f64::from(NODATA), &mut n.iter().map(value))?;
        }
        Band::Bits(n) => write(f64::from(NODATA), &mut n.iter().map(|n| f64::from(*n)))?,
    }
    Ok(with_sidecars(result, path, vec![(path.to_path_buf(), bytes)]))
}

/// Encodes the layer as raw numbers, with the header that describes them, its `.prj` and its
/// provenance.
pub(super) fn bil(result: &MapResult<'_>, path: &Path) -> Result<Vec<(PathBuf, Vec<u8>)>> {
    let (kind, nodata, bytes) = match only_band(result)? {
        Band::Class(mask) => {
            (BilValues::Byte, result.mask_values.nodata().map(f64::from), result.mask_values.of(mask).into_owned())
        }
        Band::Measure(v) => {
            (BilValues::Float, Some(f64::from(NODATA)), v.iter().flat_map(|v| finite(*v).to_le_bytes()).collect())
        }
        Band::Count(n) => {
            (BilValues::UInt32, Some(f64::from(NO_COUNT)), n.iter().flat_map(|n| n.to_le_bytes()).collect())
        }
        Band::Bits(n) => (BilValues::UInt32, None, n.iter().flat_map(|n| n.to_le_bytes()).collect()),
    };
    let header = bil_header(result.georef, kind, nodata).into_bytes();
    Ok(with_sidecars(result, path, vec![(path.to_path_buf(), bytes), (path.with_extension("hdr"), header)]))
}

fn only_band<'a>(result: &MapResult<'a>) -> Result<Band<'a>> {
    match <[_; 1]>::try_from(result.bands()) {
        Ok([(_, band)]) => Ok(band),
        Err(_) => Err(Fault::SeveralBands.into()),
    }
}

/// Adds the sidecars: the `.prj` file and the provenance.
fn with_sidecars(result: &MapResult<'_>, path: &Path, mut files: Vec<(PathBuf, Vec<u8>)>) -> Vec<(PathBuf, Vec<u8>)> {
    if let Some(wkt) = result.georef.crs().and_then(wkt_of) {
        files.push((path.with_extension("prj"), wkt.into_bytes()));
    }
    files.push((with_suffix(path, ".json"), result.provenance.as_bytes().to_vec()));
    files
}
