//! World files: the place of a picture that cannot say it itself (`.pgw` beside a `.png`).

use crate::raster::GeoRef;

/// The six lines of a world file: cell width, two rotations, minus cell height, and the center of the north-west cell.
///
/// A world file holds the *center* of that cell, everything else in this crate its outer corner. It names no coordinate
/// reference system: that goes into a `.prj` file.
pub fn world_file(georef: &GeoRef) -> String {
    let (x, y) = georef.world_from_cell(0, 0);
    format!("{}\n0\n0\n{}\n{x}\n{y}\n", georef.cell_width(), -georef.cell_height())
}
