//! A grid in longitude and latitude over a grid in another system, for programs that know nothing else.

use rayon::prelude::*;

use super::{Crs, CrsKind, GeoRef, Transformation};
use crate::error::{Error, Result};

/// Length of a degree of latitude \[m\], to half a percent everywhere.
const METERS_PER_DEGREE: f64 = 111_195.0;
/// Largest number of columns or rows: what globes take as one picture.
const LARGEST_SIDE: f64 = 4096.0;
/// Points along each side of a grid between which its outline in degrees is taken for straight.
const POINTS_PER_SIDE: usize = 32;
/// No cell of the source.
const NONE: u32 = u32::MAX;

/// Cells of equal steps in degrees of WGS 84 over a grid, as large as those of the grid or larger, and the cell of the grid
/// at the center of each.
#[derive(Debug, Clone)]
pub struct LonLatGrid {
    georef: GeoRef,
    sources: Vec<u32>,
    to_degrees: Transformation,
}

impl LonLatGrid {
    /// A grid over all of `grid`; `None` if that has no CRS.
    ///
    /// Cost: one transformation per cell.
    ///
    /// # Errors
    /// E310 if the registry has no way from the CRS to WGS 84, E502 beyond 2^32 − 1 cells.
    pub fn over(grid: &GeoRef) -> Result<Option<LonLatGrid>> {
        let Some(crs) = grid.crs() else { return Ok(None) };
        if u32::try_from(grid.n_cells()).is_err() {
            return Err(Error::limit(502, format!("cannot reproject {} cells: wanted below 2^32", grid.n_cells())));
        }
        let wgs84 = Crs::from_epsg(4326)?;
        let middle = ((grid.x_min() + grid.x_max()) / 2.0, (grid.y_min() + grid.y_max()) / 2.0);
        let to_degrees = Transformation::new(crs, &wgs84, middle)?;
        let (lon, lat) = to_degrees.apply(middle)?;
        let from_degrees = Transformation::new(&wgs84, crs, (lon, lat))?;
        let [west, south, east, north] = bounds(grid, &to_degrees)?;
        let unit = match crs.kind() {
            CrsKind::Projected { meters_per_unit } => meters_per_unit,
            CrsKind::Geographic | CrsKind::Other => 1.0,
        };
        let per_degree = (METERS_PER_DEGREE * lat.to_radians().cos(), METERS_PER_DEGREE);
        let columns = (east - west) * per_degree.0 / (grid.cell_width() * unit);
        let rows = (north - south) * per_degree.1 / (grid.cell_height() * unit);
        let shrink = (columns.max(rows) / LARGEST_SIDE).max(1.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 4096")]
        let shape = [rows, columns].map(|n| (n / shrink).ceil().clamp(1.0, LARGEST_SIDE) as usize);
        let step = ((east - west) / shape[1] as f64, (north - south) / shape[0] as f64);
        let georef = GeoRef::new((west, north), step, (shape[0], shape[1]), Some(wgs84));
        let georef = georef.ok_or_else(|| Error::internal(903, "a grid in degrees has no extent"))?;
        let sources = (0..georef.n_cells())
            .into_par_iter()
            .map(|cell| {
                let center = georef.world_from_cell(cell / georef.n_cols(), cell % georef.n_cols());
                // A point that the projection does not know lies in no cell.
                from_degrees.apply(center).map_or(NONE, |place| cell_at(grid, place))
            })
            .collect();
        Ok(Some(LonLatGrid { georef, sources, to_degrees }))
    }

    /// Where the cells lie \[deg\].
    pub fn georef(&self) -> &GeoRef {
        &self.georef
    }

    /// Longitude and latitude of a place in the CRS of the source \[deg\].
    ///
    /// # Errors
    /// E310 outside the domain of the projection.
    pub fn degrees(&self, place: (f64, f64)) -> Result<(f64, f64)> {
        self.to_degrees.apply(place)
    }

    /// The values of the cells of the source at the centers of these cells, `outside` where there is none.
    pub fn resampled<T: Copy>(&self, values: &[T], outside: T) -> Vec<T> {
        self.sources.iter().map(|source| values.get(*source as usize).copied().unwrap_or(outside)).collect()
    }
}

/// West, south, east, north of a grid in degrees: an outline that is bent reaches beyond its corners.
fn bounds(grid: &GeoRef, to_degrees: &Transformation) -> Result<[f64; 4]> {
    let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for k in 0..=POINTS_PER_SIDE {
        let share = k as f64 / POINTS_PER_SIDE as f64;
        let x = grid.x_min() + share * (grid.x_max() - grid.x_min());
        let y = grid.y_min() + share * (grid.y_max() - grid.y_min());
        for place in [(x, grid.y_min()), (x, grid.y_max()), (grid.x_min(), y), (grid.x_max(), y)] {
            let (lon, lat) = to_degrees.apply(place)?;
            bounds = [bounds[0].min(lon), bounds[1].min(lat), bounds[2].max(lon), bounds[3].max(lat)];
        }
    }
    Ok(bounds)
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Each cell knows its own place.
    #[test]
    fn cells_in_degrees_hold_the_nearest_cell_of_the_source() {
        let crs = Crs::from_epsg(25832).unwrap();
        let grid = GeoRef::new((691_600.0, 5_334_790.0), (1.0, 1.0), (40, 60), Some(crs)).unwrap();
        let degrees = LonLatGrid::over(&grid).unwrap().unwrap();
        let ids: Vec<u32> = (0..2400).collect();
        let found = degrees.resampled(&ids, NONE);
        let mut seen = vec![false; 2400];
        for (cell, id) in found.iter().enumerate().filter(|(_, id)| **id != NONE) {
            let (row, col) = (cell / degrees.georef().n_cols(), cell % degrees.georef().n_cols());
            let (lon, lat) = degrees.georef().world_from_cell(row, col);
            let id = *id as usize;
            let (x, y) = grid.world_from_cell(id / 60, id % 60);
            let source = degrees.degrees((x, y)).unwrap();
            // Half a cell is at most 0.71 m off.
            let away = ((source.0 - lon) * METERS_PER_DEGREE * lat.to_radians().cos())
                .hypot((source.1 - lat) * METERS_PER_DEGREE);
            assert!(away < 0.72, "{away}");
            seen[id] = true;
        }
        // Of as many cells as the source has, a few fall between the others.
        assert!(seen.iter().filter(|s| **s).count() > 2100);
        // The grid is turned by its convergence, so the corners of the box are empty.
        assert!(found.contains(&NONE));
        assert!(LonLatGrid::over(&grid.with_crs(None)).unwrap().is_none());
    }
}
