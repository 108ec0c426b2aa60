//! Rasters that are reprojected before they become a scene.
//!
//! Each cell of the new grid takes the height of the source cell that holds its center. So no
//! height is invented, and flat roofs stay flat.

use super::heights::{HeightFile, Heights, check_grid};
use super::projection::Projection;
use super::receivers_grid::{GridRequest, receivers_grid};
use crate::crs::{Stretch, Transformation, is_web_mercator};
use crate::error::{Cause, Error, OddFile, Oddity, ReadFault, Result, Warning};
use crate::formats::{CellSources, bounds_through, half_diagonal_through, reserve_cells, suggested_grid};
use crate::input::Input;
use crate::quantity::VOID;
use crate::raster::{Crs, GeoRef, Raster};

/// Grid in the wanted system, and the source cells of its own.
#[derive(Debug)]
pub(super) struct Reprojection<'a> {
    input: &'a Input,
    from: Crs,
    to: Crs,
    grid: GeoRef,
    sources: CellSources,
    /// Largest distance of the center of a cell from that of its source \[CRS units\].
    farthest: f64,
    /// Stretch of lengths in the wanted system there.
    stretch: Option<Stretch>,
}

impl<'a> Reprojection<'a> {
    /// Plans a grid over that of a file; `None` if the file is in the wanted system. Square cells
    /// of `cell_m` meters lie on whole multiples of them. By default the grid has as many cells
    /// diagonally as the file.
    pub(super) fn plan(
        input: &'a Input,
        file: &GeoRef,
        projection: &Projection,
        cell_m: Option<f64>,
    ) -> Result<Option<Reprojection<'a>>> {
        let from = file.crs().ok_or_else(|| Error::read(input, ReadFault::NoCrs))?;
        let middle = ((file.x_min() + file.x_max()) / 2.0, (file.y_min() + file.y_max()) / 2.0);
        let to = projection.target(from, middle)?;
        if from.same_as(&to) {
            return Ok(None);
        }
        let way = Transformation::new(from, &to, middle)?;
        let back = Transformation::new(&to, from, way.apply(middle)?)?;
        let stretch = if is_web_mercator(&to) { Stretch::of(&to, bounds_through(file, &way)?) } else { None };
        let to = stretch.map_or(to.clone(), |stretch| stretch.apply(to));
        let grid = match cell_m {
            None => suggested_grid(file, &way, to.clone())?,
            Some(_) => {
                let request = GridRequest { extent: None, cell_m };
                let bounds = Some(bounds_through(file, &way)?);
                Some(receivers_grid(input, request, None, bounds, Some(&to))?.with_crs(Some(to.clone())))
            }
        };
        let grid = grid.ok_or_else(|| {
            let what = format!("nothing is left of {} in {}", file.description(), to.label());
            Error::read(input, ReadFault::Irregular(what))
        })?;
        drop(reserve_cells::<u32>(input, &grid)?);
        let sources = CellSources::new(&grid, file, &back)?;
        let farthest = half_diagonal_through(file, &way)?;
        Ok(Some(Reprojection { input, from: from.clone(), to, grid, sources, farthest, stretch }))
    }

    /// Reads the heights of a file onto the planned grid, with a warning; without a plan, as they
    /// are.
    pub(super) fn read(
        plan: Option<Reprojection<'_>>,
        file: HeightFile<'_>,
        always_hash: bool,
        warnings: &mut Vec<Warning>,
    ) -> Result<Heights> {
        match plan {
            None => file.in_meters(warnings)?.read(always_hash, warnings),
            Some(plan) => {
                check_grid(plan.input, &plan.grid, warnings)?;
                let heights = file.read(always_hash, warnings)?;
                plan.apply(heights, warnings)
            }
        }
    }

    /// Puts heights in memory onto the planned grid, with a warning; without a plan, returns them
    /// as they are.
    pub(super) fn of_held(
        plan: Option<Reprojection<'_>>,
        (input, heights): (&Input, Heights),
        warnings: &mut Vec<Warning>,
    ) -> Result<Heights> {
        let grid = plan.as_ref().map_or(heights.raster.georef(), |plan| &plan.grid);
        check_grid(input, grid, warnings)?;
        match plan {
            None => Ok(heights),
            Some(plan) => plan.apply(heights, warnings),
        }
    }

    fn apply(self, heights: Heights, warnings: &mut Vec<Warning>) -> Result<Heights> {
        let Reprojection { input, from, to, grid, sources, farthest, stretch } = self;
        let cells = sources.resampled(heights.raster.cells(), VOID);
        let n_void = cells.iter().filter(|z| **z == VOID).count();
        if n_void == cells.len() {
            let over = ReadFault::AllVoid(n_void as u64, format!("in {} lies over", to.label()));
            return Err(Error::read(input, over).because(Cause::LargeCells));
        }
        let unit = to.meters_per_unit();
        let odd = OddFile::Resampled {
            from: from.label(),
            to: to.label(),
            name: to.name().to_string(),
            shape: [grid.n_cols(), grid.n_rows()],
            cell_m: grid.cell_width() * unit,
            farthest_m: farthest * unit,
            n_outside: sources.n_outside() as u64,
        };
        warnings.push(Warning::of(input, odd));
        warnings.extend(stretch.map(|stretch| Oddity::new(input, stretch.into()).into()));
        Ok(Heights { raster: Raster::new(grid, cells), n_void: n_void as u64, sources: heights.sources })
    }
}
