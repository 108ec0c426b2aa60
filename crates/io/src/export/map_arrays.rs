//! The coverage of a run as NumPy arrays.
//!
//! | array | shape | content |
//! |---|---|---|
//! | layers per site | `[n_sites, n_rows, n_cols]` | values of each site |
//! | `count`, `best_server` | `[n_rows, n_cols]` | 4294967295, the nodata of GeoTIFF, where nobody receives |
//! | `union`, `all` | `[n_rows, n_cols]` | classes |
//! | `uptime`, `gap` | `[n_rows, n_cols]` | share of time, and minutes |
//! | `which` | `[n_words, n_rows, n_cols]` | sets of UAVs as bits |
//! | `x`, `y` | `[n_cols]`, `[n_rows]` | centers of columns and rows \[CRS units\] |
//! | `sites` | `[n_sites, 3]` | x, y, height \[m above the datum\] per UAV |
//! | `site_ids` | `[n_sites]` | names of the UAVs |
//! | `crs` | text | WKT, or the name if no more is known; empty if local |
//! | `meta` | text | provenance as JSON |

use std::path::{Path, PathBuf};

use skyshed_request::Layer;

use super::map_result::{Band, MapResult, measure_of};
use crate::crs::wkt_of;
use crate::error::Result;
use crate::formats::{NpyArray, write_npz};

/// Encodes the layers as arrays, with the coordinates of cell centers, the sites, the CRS and the
/// provenance.
pub(super) fn npz(result: &MapResult<'_>, path: &Path) -> Result<Vec<(PathBuf, Vec<u8>)>> {
    let (n_rows, n_cols) = (result.georef.n_rows(), result.georef.n_cols());
    let n_sites = result.sites.len();
    let shape = vec![n_sites, n_rows, n_cols];
    let of_grid = vec![n_rows, n_cols];
    let bands = result.bands();
    let mut arrays: Vec<(String, NpyArray<'_>)> = Vec::new();
    let classes: Vec<u8> = match result.layers.contains(&Layer::Los) {
        true => result.sites.iter().flat_map(|site| site.mask.iter().copied()).collect(),
        false => Vec::new(),
    };
    if !classes.is_empty() {
        arrays.push(("los".into(), NpyArray::U8(&classes, shape.clone())));
    }
    let measures: Vec<(Layer, Vec<f32>)> = result
        .layers
        .iter()
        .filter(|layer| layer.is_measure())
        .map(|layer| {
            let values = result.sites.iter().filter_map(|site| measure_of(*layer, site));
            (*layer, values.flatten().copied().collect())
        })
        .collect();
    for (layer, values) in &measures {
        arrays.push((layer.name().replace('-', "_"), NpyArray::F32(values, shape.clone())));
    }
    let words: Vec<u32> = bands
        .iter()
        .filter_map(|(_, band)| match band {
            Band::Bits(bits) => Some(bits.iter().copied()),
            _ => None,
        })
        .flatten()
        .collect();
    for (name, band) in &bands {
        match band {
            Band::Count(values) => arrays.push((name.replace('-', "_"), NpyArray::U32(values, of_grid.clone()))),
            Band::Class(mask) if [Layer::Union, Layer::All].iter().any(|layer| name == layer.name()) => {
                arrays.push((name.clone(), NpyArray::U8(mask, of_grid.clone())));
            }
            Band::Measure(values) if [Layer::Uptime, Layer::Gap].iter().any(|layer| name == layer.name()) => {
                arrays.push((name.clone(), NpyArray::F32(values, of_grid.clone())));
            }
            _ => {}
        }
    }
    if !words.is_empty() {
        let n_words = words.len() / (n_rows * n_cols);
        arrays.push(("which".into(), NpyArray::U32(&words, vec![n_words, n_rows, n_cols])));
    }
    let xs: Vec<f64> = (0..n_cols).map(|c| result.georef.world_from_cell(0, c).0).collect();
    let ys: Vec<f64> = (0..n_rows).map(|r| result.georef.world_from_cell(r, 0).1).collect();
    let sites: Vec<f64> = result
        .sites
        .iter()
        .flat_map(|s| [s.uav.station.place.x, s.uav.station.place.y, s.uav.height_amsl_m()])
        .collect();
    arrays.push(("x".into(), NpyArray::F64(&xs, vec![n_cols])));
    arrays.push(("y".into(), NpyArray::F64(&ys, vec![n_rows])));
    arrays.push(("sites".into(), NpyArray::F64(&sites, vec![n_sites, 3])));
    let ids: Vec<String> = result.sites.iter().map(|s| s.uav.id.clone()).collect();
    arrays.push(("site_ids".into(), NpyArray::Texts(&ids)));
    // WKT where it can be written, else the name; empty for local coordinates.
    let crs = result.georef.crs().map_or(String::new(), |crs| wkt_of(crs).unwrap_or_else(|| crs.label()));
    arrays.push(("crs".into(), NpyArray::Text(&crs)));
    arrays.push(("meta".into(), NpyArray::Text(result.provenance)));
    let mut out = std::io::Cursor::new(Vec::new());
    write_npz(&mut out, &arrays)?;
    Ok(vec![(path.to_path_buf(), out.into_inner())])
}
