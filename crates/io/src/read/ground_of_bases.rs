//! A terrain through the ground below buildings.

use rayon::prelude::*;
use spade::Point2;

use super::building::RawFootprint;
use super::triangulated_heights::{KnownHeight, TriangulatedHeights};
use crate::error::Result;
use crate::formats::reserve_cells;
use crate::input::Input;
use crate::quantity::{VOID, height_steps};
use crate::raster::{GeoRef, Raster};

/// Returns a terrain through the ground below buildings, on the cells of a grid that is grown to
/// hold them all. It is linear between the corners of buildings, which are triangulated (Delaunay).
/// Beyond their hull it is as high as the nearest corner. Where corners of several buildings meet,
/// the lowest counts.
///
/// # Errors
/// E501 if the cells do not fit in memory.
pub(super) fn terrain_through<'a>(
    input: &Input,
    buildings: impl Iterator<Item = &'a RawFootprint>,
    grid: &GeoRef,
) -> Result<Raster<i32>> {
    let corners_of = |building: &'a RawFootprint| {
        let base_m = building.base_m;
        let corners = building.polygons.iter().flatten().flatten();
        corners.filter_map(move |[x, y]| Some(KnownHeight { at: Point2::new(*x, *y), height_m: base_m? }))
    };
    // At one place the last corner is kept: the lowest.
    let mut corners: Vec<KnownHeight> = buildings.flat_map(corners_of).collect();
    corners.sort_by(|a, b| b.height_m.total_cmp(&a.height_m));
    let georef = grown(grid, &corners);
    let ground = TriangulatedHeights::through(corners.into_iter());
    let mut cells = reserve_cells(input, &georef)?;
    cells.resize(georef.n_cells(), VOID);
    let n_cols = georef.n_cols();
    cells.par_chunks_mut(n_cols).enumerate().for_each(|(row, cells)| {
        let height = ground.lookup();
        for (col, cell) in cells.iter_mut().enumerate() {
            let (x, y) = georef.world_from_cell(row, col);
            *cell = height(x, y).and_then(height_steps).unwrap_or(VOID);
        }
    });
    Ok(Raster::new(georef, cells))
}

/// Grows a grid by as many cells on each side as hold all corners.
fn grown(grid: &GeoRef, corners: &[KnownHeight]) -> GeoRef {
    let (width, height) = (grid.cell_width(), grid.cell_height());
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates, and is not below 0")]
    let n = |length: f64, cell: f64| (length / cell).ceil().max(0.0) as usize;
    let most = |of: fn(&KnownHeight) -> f64| corners.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
    let west = n(grid.x_min() + most(|c| -c.at.x), width);
    let east = n(most(|c| c.at.x) - grid.x_max(), width);
    let south = n(grid.y_min() + most(|c| -c.at.y), height);
    let north = n(most(|c| c.at.y) - grid.y_max(), height);
    let corner = (grid.x_min() - west as f64 * width, grid.y_max() + north as f64 * height);
    let shape = (grid.n_rows() + south + north, grid.n_cols() + west + east);
    GeoRef::new(corner, (width, height), shape, grid.crs().cloned()).unwrap_or_else(|| grid.clone())
}
