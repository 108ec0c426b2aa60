//! A terrain model brought onto the grid of the surface above it.

use super::systems::refuse_two_crs;
use crate::crs::Transformation;
use crate::error::{CombineError, Error, OddFile, OddPair, Pair, Result, Warning};
use crate::formats::CellSources;
use crate::input::Input;
use crate::quantity::VOID;
use crate::raster::{GeoRef, Raster};

/// A raster and the file that it came from.
#[derive(Debug, Clone, Copy)]
pub(super) struct Placed<'a, T> {
    pub(super) input: &'a Input,
    pub(super) on: T,
}

/// Returns the transformation from the reference system of a scene to that of its terrain, if
/// `projects` and they differ.
pub(super) fn way_to_terrain(grid: &GeoRef, terrain: &GeoRef, projects: bool) -> Result<Option<Transformation>> {
    match (grid.crs(), terrain.crs()) {
        (Some(from), Some(to)) if projects && !from.same_as(to) => {
            let middle = ((grid.x_min() + grid.x_max()) / 2.0, (grid.y_min() + grid.y_max()) / 2.0);
            Transformation::new(from, to, middle).map(Some)
        }
        _ => Ok(None),
    }
}

/// Resamples a terrain to the grid of the surface. Each cell takes the height of the terrain cell
/// that holds its center. A center on an edge, to within a millionth of a cell, takes the cell to
/// its north-east. Where the systems differ, `way` transforms from that of the surface to that of
/// the terrain.
pub(super) fn terrain_on_grid(
    surface: Placed<'_, &GeoRef>,
    terrain: Placed<'_, Raster<i32>>,
    way: Option<&Transformation>,
    warnings: &mut Vec<Warning>,
) -> Result<Raster<i32>> {
    let Placed { input: surface_path, on: grid } = surface;
    let Placed { input: terrain_path, on: terrain } = terrain;
    let from = terrain.georef();
    if way.is_none() {
        refuse_two_crs((surface_path, grid.crs()), (terrain_path, from.crs()), Pair::SurfaceTerrain)?;
        if grid.same_grid(from) {
            let n_void = terrain.cells().iter().filter(|z| **z == VOID).count();
            if n_void == grid.n_cells() {
                return Err(no_terrain_below((surface_path, grid), (terrain_path, from)));
            }
            if n_void > 0 {
                let odd = OddFile::TerrainVoids { n: n_void, of: grid.n_cells() };
                warnings.push(Warning::of(terrain_path, odd));
            }
            return Ok(terrain);
        }
    }
    let cells = match way {
        None => looked_up(grid, &terrain),
        Some(way) => CellSources::new(grid, from, way)?.resampled(terrain.cells(), VOID),
    };
    let n_void = cells.iter().filter(|z| **z == VOID).count();
    if n_void == cells.len() {
        return Err(no_terrain_below((surface_path, grid), (terrain_path, from)));
    }
    let brought = match (way, from.crs()) {
        (Some(_), Some(crs)) => format!(" in {}", crs.label()),
        _ => String::new(),
    };
    warnings.push(warning_of_other_grid(surface, (terrain_path, from, &brought), n_void));
    Ok(Raster::new(grid.clone(), cells))
}

/// Returns the error of a terrain that lies elsewhere than the surface.
pub(super) fn no_terrain_below((surface, grid): (&Input, &GeoRef), (terrain, from): (&Input, &GeoRef)) -> Error {
    let [surface, terrain] =
        [(surface, grid), (terrain, from)].map(|(input, grid)| format!("{input} ({})", grid.description()));
    CombineError::NoTerrainBelow(surface, terrain).into()
}

/// Returns the warning about a terrain on another grid than the surface; `n_void` cells of the
/// surface have no ground.
pub(super) fn warning_of_other_grid(
    surface: Placed<'_, &GeoRef>,
    (terrain, from, brought): (&Input, &GeoRef, &str),
    n_void: usize,
) -> Warning {
    let of = surface.on.n_cells();
    let terrain = format!("{terrain} ({}{brought})", from.description());
    let surface = format!("{} ({})", surface.input, surface.on.description());
    OddPair::OtherGrid { terrain, surface, n_void, of }.into()
}

/// Returns the heights of a terrain in the same system at the centers of cells, [`VOID`] outside.
pub(super) fn looked_up(grid: &GeoRef, terrain: &Raster<i32>) -> Vec<i32> {
    let from = terrain.georef();
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
    cells
}
