//! Position and reference system of cells, as Python has them.

use skyshed_core::raster::GeoRef;

/// Rows and columns; west edge, width of a cell, north edge, height of a cell; label and WKT of the reference system.
pub(crate) type Place = ((usize, usize), (f64, f64, f64, f64), Option<(String, Option<String>)>);

pub(crate) fn place_of(grid: &GeoRef) -> Place {
    let crs = grid.crs().map(|crs| (crs.label().to_string(), skyshed_io::crs::wkt_of(crs)));
    let place = (grid.x_min(), grid.cell_width(), grid.y_max(), grid.cell_height());
    ((grid.n_rows(), grid.n_cols()), place, crs)
}
