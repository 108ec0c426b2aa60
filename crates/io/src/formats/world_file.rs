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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_world_file_holds_the_center_of_the_first_cell() {
        let georef = GeoRef::new((500_000.0, 5_400_000.0), (0.5, 0.25), (4, 4), None).unwrap();
        assert_eq!(world_file(&georef), "0.5\n0\n0\n-0.25\n500000.25\n5399999.875\n");
    }
}
