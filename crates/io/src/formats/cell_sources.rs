//! One grid over another in another reference system: for each cell of one, the cell of the other
//! that holds its center.

use rayon::prelude::*;

use crate::crs::Transformation;
use crate::error::{CrsError, Result};
use crate::raster::{Crs, CrsKind, GeoRef};

/// Points along each side of a grid; its outline in another system is taken as straight between
/// them.
const POINTS_PER_SIDE: usize = 32;
/// Marker of a center outside of the source.
const NONE: u32 = u32::MAX;

/// Cells of a source that hold the centers of the cells of a grid.
#[derive(Debug, Clone)]
pub struct CellSources {
    sources: Vec<u32>,
}

impl CellSources {
    /// Looks up the center of each cell of `grid` in `source`; `way` transforms from the system of
    /// `grid` to that of `source`.
    ///
    /// A center on an edge between cells of the source belongs to the cell north or east of it. A
    /// point that the projection does not know lies in no cell. Degrees of longitude are shifted by
    /// a turn where that leads into the source.
    ///
    /// Cost: one transformation per cell.
    ///
    /// # Errors
    /// E502 if the source has more than 2^32 − 1 cells.
    pub fn new(grid: &GeoRef, source: &GeoRef, way: &Transformation) -> Result<CellSources> {
        if u32::try_from(source.n_cells()).is_err() {
            return Err(CrsError::TooManyCells(source.n_cells()).into());
        }
        let is_round = matches!(source.crs().map(Crs::kind), Some(CrsKind::Geographic));
        let turned = |x: f64| match x {
            _ if is_round && x < source.x_min() => x + 360.0,
            _ if is_round && x >= source.x_max() => x - 360.0,
            _ => x,
        };
        let sources = (0..grid.n_cells()).into_par_iter().map(|cell| {
            let center = grid.world_from_cell(cell / grid.n_cols(), cell % grid.n_cols());
            way.apply(center).map_or(NONE, |(x, y)| cell_at(source, (turned(x), y)))
        });
        Ok(CellSources { sources: sources.collect() })
    }

    /// Returns the values of the source's cells at the centers of these cells, `outside` where
    /// there is none.
    pub fn resampled<T: Copy + Send + Sync>(&self, values: &[T], outside: T) -> Vec<T> {
        let value = |source: &u32| values.get(*source as usize).copied().unwrap_or(outside);
        self.sources.par_iter().map(value).collect()
    }

    /// Returns the number of cells whose center lies in no cell of the source.
    pub fn n_outside(&self) -> usize {
        self.sources.iter().filter(|source| **source == NONE).count()
    }
}

fn cell_at(grid: &GeoRef, (x, y): (f64, f64)) -> u32 {
    let (east, north) = grid.cells_from_world(x, y);
    let is_inside = east >= 0.0 && north >= 0.0 && east < grid.n_cols() as f64 && north < grid.n_rows() as f64;
    if !is_inside {
        return NONE;
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "inside the grid")]
    let (col, from_south) = (east as usize, north as usize);
    u32::try_from((grid.n_rows() - 1 - from_south) * grid.n_cols() + col).unwrap_or(NONE)
}

/// Returns points around a grid, its corners among them.
fn outline(grid: &GeoRef) -> impl Iterator<Item = (f64, f64)> {
    let (west, east, south, north) = (grid.x_min(), grid.x_max(), grid.y_min(), grid.y_max());
    (0..=POINTS_PER_SIDE).flat_map(move |k| {
        let share = k as f64 / POINTS_PER_SIDE as f64;
        let (x, y) = (west + share * (east - west), south + share * (north - south));
        [(x, south), (x, north), (west, y), (east, y)]
    })
}

/// Returns west, south, east, north of a grid in another system. Points along its sides count,
/// because a bent outline reaches beyond its corners.
///
/// # Errors
/// E310 if a part of it is outside the domain of the projection.
pub fn bounds_through(grid: &GeoRef, way: &Transformation) -> Result<[f64; 4]> {
    let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for place in outline(grid) {
        let (x, y) = way.apply(place)?;
        bounds = [bounds[0].min(x), bounds[1].min(y), bounds[2].max(x), bounds[3].max(y)];
    }
    Ok(bounds)
}

/// Returns the largest distance of a point from the center of its cell, in units of another system:
/// half the longest diagonal of the cells around a grid.
///
/// # Errors
/// E310 if a cell is outside the domain of the projection.
pub fn half_diagonal_through(grid: &GeoRef, way: &Transformation) -> Result<f64> {
    let (width, height) = (grid.cell_width(), grid.cell_height());
    let mut longest: f64 = 0.0;
    for (x, y) in outline(grid) {
        // The cell at the point, inside of the grid.
        let (west, south) = (x.min(grid.x_max() - width), y.min(grid.y_max() - height));
        let corner = |dx: f64, dy: f64| way.apply((west + dx * width, south + dy * height));
        for (a, b) in [(corner(0.0, 0.0)?, corner(1.0, 1.0)?), (corner(1.0, 0.0)?, corner(0.0, 1.0)?)] {
            longest = longest.max((a.0 - b.0).hypot(a.1 - b.1));
        }
    }
    Ok(longest / 2.0)
}

/// Returns a north-up grid of square cells over a grid in another system, with as many cells along
/// its diagonal. This is the choice of `gdalwarp` where no cell size is given. `None` where the
/// grid shrinks to nothing.
///
/// # Errors
/// E310 if a part of the grid is outside the domain of the projection.
pub fn suggested_grid(source: &GeoRef, way: &Transformation, crs: Crs) -> Result<Option<GeoRef>> {
    let [west, south, east, north] = bounds_through(source, way)?;
    let cell = (east - west).hypot(north - south) / (source.n_cols() as f64).hypot(source.n_rows() as f64);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "about as many as the source has")]
    let cells = |length: f64| (length / cell).round().max(1.0) as usize;
    Ok(GeoRef::new((west, north), (cell, cell), (cells(north - south), cells(east - west)), Some(crs)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn degrees(west: f64, north: f64) -> GeoRef {
        let wgs84 = crate::crs::from_epsg(4326).unwrap();
        GeoRef::new((west, north), (0.001, 0.001), (40, 60), Some(wgs84)).unwrap()
    }

    fn ways(to: u32, near: (f64, f64)) -> (Crs, Transformation, Transformation) {
        let (wgs84, utm) = (crate::crs::from_epsg(4326).unwrap(), crate::crs::from_epsg(to).unwrap());
        let way = Transformation::new(&wgs84, &utm, near).unwrap();
        let back = Transformation::new(&utm, &wgs84, way.apply(near).unwrap()).unwrap();
        (utm, way, back)
    }

    #[test]
    fn longitudes_a_turn_on_are_the_same_places() {
        let (utm, way, back) = ways(32760, (179.9, -17.0));
        let east = degrees(179.9, -17.0);
        let grid = suggested_grid(&east, &way, utm).unwrap().unwrap();
        let west = degrees(179.9 - 360.0, -17.0);
        let found = |source: &GeoRef| CellSources::new(&grid, source, &back).unwrap();
        assert_eq!(found(&east).n_outside(), found(&west).n_outside());
        assert!(found(&west).n_outside() < grid.n_cells() / 2);
    }
}
