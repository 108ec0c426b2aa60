//! A grid in longitude and latitude over a grid in another system, for programs that support no
//! other.

use super::CellSources;
use super::cell_sources::bounds_through;
use crate::crs;
use crate::crs::Transformation;
use crate::error::{Fault, Result};
use crate::raster::GeoRef;

/// Length of a degree of latitude \[m\], to half a percent everywhere.
const METERS_PER_DEGREE: f64 = 111_195.0;
/// Largest number of columns or rows: the limit of globes for one picture.
const LARGEST_SIDE: f64 = 4096.0;

/// Grid of equal steps in degrees of WGS 84 over another grid, with cells as large as those of that
/// grid or larger. It holds the source cell at the center of each.
#[derive(Debug, Clone)]
pub struct LonLatGrid {
    georef: GeoRef,
    sources: CellSources,
    to_degrees: Transformation,
}

impl LonLatGrid {
    /// Returns a grid over all of `grid`; `None` if that has no CRS.
    ///
    /// Cost: one transformation per cell.
    ///
    /// # Errors
    /// E310 if the registry has no way from the CRS to WGS 84, E502 beyond 2^32 − 1 cells.
    pub fn over(grid: &GeoRef) -> Result<Option<LonLatGrid>> {
        let Some(crs) = grid.crs() else { return Ok(None) };
        let wgs84 = crs::from_epsg(4326)?;
        let middle = ((grid.x_min() + grid.x_max()) / 2.0, (grid.y_min() + grid.y_max()) / 2.0);
        let to_degrees = Transformation::new(crs, &wgs84, middle)?;
        let (lon, lat) = to_degrees.apply(middle)?;
        let from_degrees = Transformation::new(&wgs84, crs, (lon, lat))?;
        let [west, south, east, north] = bounds_through(grid, &to_degrees)?;
        let unit = crs.meters_per_unit();
        let per_degree = (METERS_PER_DEGREE * lat.to_radians().cos(), METERS_PER_DEGREE);
        let columns = (east - west) * per_degree.0 / (grid.cell_width() * unit);
        let rows = (north - south) * per_degree.1 / (grid.cell_height() * unit);
        let shrink = (columns.max(rows) / LARGEST_SIDE).max(1.0);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 4096")]
        let shape = [rows, columns].map(|n| (n / shrink).ceil().clamp(1.0, LARGEST_SIDE) as usize);
        let step = ((east - west) / shape[1] as f64, (north - south) / shape[0] as f64);
        let georef = GeoRef::new((west, north), step, (shape[0], shape[1]), Some(wgs84));
        let georef = georef.ok_or(Fault::NoExtent)?;
        let sources = CellSources::new(&georef, grid, &from_degrees)?;
        Ok(Some(LonLatGrid { georef, sources, to_degrees }))
    }

    /// Returns the grid of the cells \[deg\].
    pub fn georef(&self) -> &GeoRef {
        &self.georef
    }

    /// Returns longitude and latitude of a place in the CRS of the source \[deg\].
    ///
    /// # Errors
    /// E310 outside the domain of the projection.
    pub fn degrees(&self, place: (f64, f64)) -> Result<(f64, f64)> {
        self.to_degrees.apply(place)
    }

    /// Returns the values of the source's cells at the centers of these cells, `outside` where
    /// there is none.
    pub fn resampled<T: Copy + Send + Sync>(&self, values: &[T], outside: T) -> Vec<T> {
        self.sources.resampled(values, outside)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const NONE: u32 = u32::MAX;

    /// Checks that each cell holds the source cell at its own place.
    #[test]
    fn cells_in_degrees_hold_the_nearest_cell_of_the_source() {
        let crs = crs::from_epsg(25832).unwrap();
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
        // The grid has as many cells as the source, so a few source cells lie between its centers.
        assert!(seen.iter().filter(|s| **s).count() > 2100);
        // The convergence turns the grid, so the corners of the box are empty.
        assert!(found.contains(&NONE));
        assert!(LonLatGrid::over(&grid.with_crs(None)).unwrap().is_none());
    }
}
