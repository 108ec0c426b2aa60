//! The coverage of a run as NumPy arrays.
//!
//! Layers per site have the shape `[n_sites, n_rows, n_cols]`, `count` `[n_rows, n_cols]` (4294967295, the nodata of
//! GeoTIFF, where nobody receives), `which` `[n_words, n_rows, n_cols]`; `x` and `y` are the centers of columns and rows \[CRS units\]; `sites` has a row x, y, height \[m above the
//! datum\] per UAV and `site_ids` their names; `crs` is WKT (empty if local) and `meta` the provenance as JSON.

use std::path::{Path, PathBuf};

use super::map_result::{Layer, MapResult, count_of};
use crate::coverage::which_layer;
use crate::crs::wkt_of;
use crate::error::Result;
use crate::formats::{NpyArray, write_npz};

/// The layers as arrays, with the coordinates of cell centers, the sites, the CRS and the provenance.
pub(super) fn npz(result: &MapResult<'_>, path: &Path) -> Result<Vec<(PathBuf, Vec<u8>)>> {
    let (n_rows, n_cols) = (result.georef.n_rows(), result.georef.n_cols());
    let n_sites = result.sites.len();
    let shape = vec![n_sites, n_rows, n_cols];
    let masks: Vec<&[u8]> = result.sites.iter().map(|s| s.mask.as_slice()).collect();
    let mut classes: Vec<u8> = Vec::new();
    let mut measures: Vec<(Layer, Vec<f32>)> = Vec::new();
    let mut words: Vec<u32> = Vec::new();
    let mut counts: Vec<u32> = Vec::new();
    for &layer in result.layers {
        match layer {
            Layer::Los => classes = masks.concat(),
            Layer::Count => counts = count_of(&masks),
            Layer::Which => words = which_layer(&masks).concat(),
            Layer::Margin | Layer::LeastReceiverHeight | Layer::LeastHeight | Layer::Stability => {
                let values = result.sites.iter().filter_map(|site| layer.measure_of(site));
                measures.push((layer, values.flatten().copied().collect()));
            }
        }
    }
    let xs: Vec<f64> = (0..n_cols).map(|c| result.georef.world_from_cell(0, c).0).collect();
    let ys: Vec<f64> = (0..n_rows).map(|r| result.georef.world_from_cell(r, 0).1).collect();
    let sites: Vec<f64> = result
        .sites
        .iter()
        .flat_map(|s| [s.uav.station.place.x, s.uav.station.place.y, s.uav.height_amsl_m()])
        .collect();
    let mut arrays: Vec<(String, NpyArray<'_>)> = Vec::new();
    if !classes.is_empty() {
        arrays.push(("los".into(), NpyArray::U8(&classes, shape.clone())));
    }
    for (layer, values) in &measures {
        arrays.push((layer.name().replace('-', "_"), NpyArray::F32(values, shape.clone())));
    }
    if !counts.is_empty() {
        arrays.push(("count".into(), NpyArray::U32(&counts, vec![n_rows, n_cols])));
    }
    if !words.is_empty() {
        arrays.push(("which".into(), NpyArray::U32(&words, vec![n_sites.div_ceil(32), n_rows, n_cols])));
    }
    arrays.push(("x".into(), NpyArray::F64(&xs, vec![n_cols])));
    arrays.push(("y".into(), NpyArray::F64(&ys, vec![n_rows])));
    arrays.push(("sites".into(), NpyArray::F64(&sites, vec![n_sites, 3])));
    let ids: Vec<String> = result.sites.iter().map(|s| s.uav.id.clone()).collect();
    arrays.push(("site_ids".into(), NpyArray::Texts(&ids)));
    // WKT says all; a system of which only the name is known says that; local coordinates say nothing.
    let crs = result.georef.crs().map_or(String::new(), |crs| wkt_of(crs).unwrap_or_else(|| crs.label()));
    arrays.push(("crs".into(), NpyArray::Text(&crs)));
    arrays.push(("meta".into(), NpyArray::Text(result.provenance)));
    let mut out = std::io::Cursor::new(Vec::new());
    write_npz(&mut out, &arrays)?;
    Ok(vec![(path.to_path_buf(), out.into_inner())])
}
