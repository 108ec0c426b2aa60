//! World files: the place of a picture whose format cannot hold it (`.pgw` beside a `.png`).

use crate::raster::GeoRef;

/// Returns the six lines of a world file: cell width, two rotations, minus cell height, and the
/// center of the north-west cell.
///
/// A world file holds the *center* of that cell, a [`GeoRef`] its outer corner. It names no
/// coordinate reference system, which goes into a `.prj` file.
pub fn world_file(georef: &GeoRef) -> String {
    let (x, y) = georef.world_from_cell(0, 0);
    format!("{}\n0\n0\n{}\n{x}\n{y}\n", georef.cell_width(), -georef.cell_height())
}
