//! A terrain model brought onto the grid of the surface above it.

use std::path::Path;

use super::refuse_two_crs;
use crate::error::{Error, Result, Warning};
use crate::quantity::VOID;
use crate::raster::{GeoRef, Raster};

/// The terrain on the grid of the surface: each cell takes the height of the terrain cell that holds its center (the
/// one to its north-east where the center lies on an edge, to within a millionth of a cell).
pub(super) fn terrain_on_grid(
    surface_path: &Path,
    grid: &GeoRef,
    terrain_path: &Path,
    terrain: Raster<i32>,
    warnings: &mut Vec<Warning>,
) -> Result<Raster<i32>> {
    let from = terrain.georef();
    refuse_two_crs((surface_path, grid.crs()), (terrain_path, from.crs()), |wanted, _| {
        format!("gdalwarp -t_srs {} {} terrain_reprojected.tif", wanted.label(), terrain_path.display())
    })?;
    if grid.same_grid(from) {
        return Ok(terrain);
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "inside the grid by the check")]
    let index = |position: f64, n: usize| {
        let position = (position + 1e-6).floor();
        (position >= 0.0 && position < n as f64).then_some(position as usize)
    };
    let cols: Vec<Option<usize>> = (0..grid.n_cols())
        .map(|col| index(from.cells_from_world(grid.world_from_cell(0, col).0, from.y_max()).0, from.n_cols()))
        .collect();
    let rows = (0..grid.n_rows()).map(|row| {
        let from_south = from.cells_from_world(from.x_min(), grid.world_from_cell(row, 0).1).1;
        index(from_south, from.n_rows()).map(|from_south| from.n_rows() - 1 - from_south)
    });
    let mut cells = Vec::with_capacity(grid.n_cells());
    for row in rows {
        let row = row.map(|row| terrain.row(row));
        cells.extend(cols.iter().map(|col| row.zip(*col).map_or(VOID, |(row, col)| row[col])));
    }
    let n_void = cells.iter().filter(|z| **z == VOID).count();
    if n_void == cells.len() {
        return Err(Error::file(
            312,
            format!(
                "cannot combine {} ({}) with {} ({}): wanted a terrain below the surface, found none at any cell",
                surface_path.display(),
                grid.description(),
                terrain_path.display(),
                from.description()
            ),
        )
        .with_hint("compare the extents and coordinate reference systems that `skyshed info` gives for both"));
    }
    let without = if n_void > 0 {
        format!("; {n_void} of {} cells have no terrain and are no receivers", cells.len())
    } else {
        String::new()
    };
    warnings.push(Warning::new(
        346,
        format!(
            "{} ({}) is not on the grid of {} ({}): each cell takes the terrain that holds its center{without}",
            terrain_path.display(),
            from.description(),
            surface_path.display(),
            grid.description()
        ),
    ));
    Ok(Raster::new(grid.clone(), cells))
}
