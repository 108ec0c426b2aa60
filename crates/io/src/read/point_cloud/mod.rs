//! Scenes from point clouds in LAS, LAZ and COPC: a surface and the ground below it, cell by cell.
//!
//! * The *ground* of a cell is the mean of its points of the classes 2, 8, 9, 10 and 11: ground, key
//!   points, water, rails, roads. Cells without any, such as those under roofs, are filled by
//!   triangulation ([`gaps`]).
//! * The *surface* of a cell is its highest point of class 6, a roof; without one it is the ground.
//! * Vegetation (3 to 5), wires (13 to 16) and bridge decks (17) are neither. Noise (7, 18) and
//!   withheld points are left out; synthetic points count.
//! * In a cloud without any point of class 6, the highest last or only return of a cell is its
//!   surface, but for returns of the classes above. Trees then count as walls, as a warning says.
//!
//! Corners of cells are multiples of the cell size, so that neighboring tiles meet; with an extent
//! they count from its south-west corner. Several files are one cloud. Memory is that of the cells,
//! not of the points. Headers give the size of the grid before points are read, and points beyond
//! what they promise are left out and counted.

mod cells;
mod file;
mod gaps;
mod octree;
mod points;
mod systems;

use self::cells::{Cells, Grid};
use self::file::CloudFile;
use super::heights::warn_of_units;
use super::receivers_grid::{GridRequest, receivers_grid};
use super::scene_files::SceneFiles;
use super::surface::{Empty, SurfaceOptions, scene_of, scene_over};
use super::systems::{refuse_degrees, refuse_two_crs};
use super::terrain::Placed;
use crate::city::City;
use crate::crs::{Stretch, VerticalCrs};
use crate::error::{
    Error, HeightOf, InputKind, OddFile, Oddity, OptionError, Pair, ReadFault, Result, Wanted, Warning,
};
use crate::formats::reserve_cells;
use crate::input::Input;
use crate::quantity::{MAX_EXTENT_UNITS, whole};
use crate::raster::{Crs, Raster};

/// Share of the open cells with points that must hold ground, unless the size of cells is set.
const LEAST_GROUND: f64 = 0.9;

/// Options for reading a point cloud.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PointCloudOptions {
    /// Options of any surface model. A ground that is set counts in place of the cloud's own.
    pub surface: SurfaceOptions,
    /// Extent of the grid: west, south, east, north \[CRS units\]; by default that of the points.
    pub extent: Option<[f64; 4]>,
    /// Cell size \[m\]; by default 1, 2, 4 …, the first where 90 % of the open cells hold ground.
    pub cell_m: Option<f64>,
}

/// Reads a scene from one or several files in LAS, LAZ or COPC.
///
/// # Errors
/// E302 to E304 for damaged files; E308 for clouds without points or ground; E310 for degrees; E311
/// for several reference systems; E205 for heights out of range; limit errors for huge grids.
pub fn read_point_cloud(
    input: impl Into<Input>,
    options: &PointCloudOptions,
    warnings: &mut Vec<Warning>,
) -> Result<City> {
    let input = &input.into();
    let scene_files = SceneFiles::of(input)?;
    let mut files = scene_files.files.iter().map(CloudFile::open).collect::<Result<Vec<_>>>()?;
    let crs = crs_of(&files, options, warnings)?;
    let crs = crs.as_ref();
    if let Some(extent) = options.extent {
        files.retain(|file| file.meets(extent));
    }
    let Some(bounds) = bounds_of(&files) else {
        return Err(Error::read(input, ReadFault::Nothing(Wanted::PointsInExtent)));
    };
    let grid = grid_of(input, options, bounds, crs)?;
    let cells = read_cells((input, grid, crs), &files, options, warnings)?;
    let sources = scene_files.sources(options.surface.always_hash)?;
    let has_own_ground = options.surface.terrain.is_none() && options.surface.ground_m.is_none();
    if has_own_ground && !cells.has_ground() {
        return Err(Error::read(input, ReadFault::Nothing(Wanted::Ground)));
    }
    if !cells.has_roofs() {
        warnings.push(Warning::of(input, OddFile::NoRoofClass));
    }
    let cells = match (options.cell_m, has_own_ground) {
        (None, true) => coarse_enough(input, cells, warnings),
        _ => cells,
    };
    let georef = cells.grid().georef(crs).ok_or(OptionError::Extent(bounds))?;
    let mut surface: Vec<i32> = reserve_cells(input, &georef)?;
    surface.extend(cells.roofs());
    if !has_own_ground {
        drop(cells);
        let surface = (Raster::new(georef, surface), Empty::Ground);
        return scene_of(input, surface, sources, &options.surface, warnings);
    }
    let mut ground: Vec<i32> = reserve_cells(input, &georef)?;
    ground.extend(cells.terrain());
    drop(cells);
    gaps::fill_gaps(&mut ground, georef.n_cols());
    // A return below the mean of the ground around it is one of the ground.
    surface.iter_mut().zip(&ground).for_each(|(surface, ground)| *surface = (*surface).max(*ground));
    let terrain = Placed { input, on: Raster::new(georef.clone(), ground) };
    let surface = (Raster::new(georef, surface), Empty::Ground);
    scene_over(input, surface, Some(terrain), sources, &options.surface, warnings)
}

/// Returns the vertical system that a point cloud names; `None` if it names none, or cannot be
/// opened.
pub(super) fn vertical_of(input: &Input) -> Option<VerticalCrs> {
    CloudFile::open(input).ok()?.systems.vertical
}

/// Returns the reference system of all files, with the units that its lengths have.
fn crs_of(files: &[CloudFile<'_>], options: &PointCloudOptions, warnings: &mut Vec<Warning>) -> Result<Option<Crs>> {
    let Some(first) = files.iter().find(|file| file.systems.crs.is_some()).or(files.first()) else { return Ok(None) };
    let input = first.input;
    let crs = first.systems.used(input, options.surface.crs.as_ref(), warnings);
    if options.surface.crs.is_none() {
        for other in files {
            refuse_two_crs((input, crs.as_ref()), (other.input, other.systems.crs.as_ref()), Pair::Tiles)?;
        }
    }
    let (Some(crs), Some(bounds)) = (crs, bounds_of(files)) else { return Ok(None) };
    let stretch = Stretch::of(&crs, bounds);
    warnings.extend(stretch.map(|stretch| Oddity::new(input, stretch.into()).into()));
    let crs = stretch.map_or(crs.clone(), |stretch| stretch.apply(crs));
    refuse_degrees(input, &crs, bounds, InputKind::PointCloud)?;
    warn_of_units(input, &crs, warnings);
    Ok(Some(crs))
}

/// Returns the box around the bounds of all files.
fn bounds_of(files: &[CloudFile<'_>]) -> Option<[f64; 4]> {
    let join = |[w, s, e, n]: [f64; 4], [west, south, east, north]: [f64; 4]| {
        [w.min(west), s.min(south), e.max(east), n.max(north)]
    };
    files.iter().map(|file| file.bounds).reduce(join)
}

/// Returns the grid of an extent, or the one whose cells cover some bounds.
fn grid_of(input: &Input, options: &PointCloudOptions, bounds: [f64; 4], crs: Option<&Crs>) -> Result<Grid> {
    let request = GridRequest { extent: options.extent, cell_m: options.cell_m };
    if options.extent.is_some() {
        let georef = receivers_grid(input, request, None, None, crs)?;
        let anchor = [georef.x_min(), georef.y_min()];
        let (n_cols, n_rows) = (georef.n_cols(), georef.n_rows());
        return Ok(Grid { anchor, first: [0, 0], cell: georef.cell_width(), n_cols, n_rows });
    }
    let cell_m = options.cell_m.unwrap_or(1.0);
    if !(cell_m > 0.0 && cell_m.is_finite()) {
        return Err(OptionError::Cell(cell_m).into());
    }
    let cell = cell_m / crs.map_or(1.0, Crs::meters_per_unit);
    let [west, south, east, north] = bounds.map(|v| whole(v / cell).floor());
    // A point on the last edge belongs to the cell beyond.
    let (n_cols, n_rows) = (east - west + 1.0, north - south + 1.0);
    if !(n_cols.max(n_rows) <= MAX_EXTENT_UNITS && west.abs().max(south.abs()) < 1e15) {
        return Err(Error::read(input, ReadFault::GridTooLarge(n_cols, n_rows)));
    }
    #[expect(clippy::cast_possible_truncation, reason = "whole numbers below 10^15")]
    let first = [west as i64, south as i64];
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 ≤ n ≤ 65536")]
    let (n_cols, n_rows) = (n_cols as usize, n_rows as usize);
    Ok(Grid { anchor: [0.0, 0.0], first, cell, n_cols, n_rows })
}

/// Reads the points of all files into the cells of a grid, which shrinks to those with points
/// unless an extent is set.
fn read_cells(
    (input, grid, crs): (&Input, Grid, Option<&Crs>),
    files: &[CloudFile<'_>],
    options: &PointCloudOptions,
    warnings: &mut Vec<Warning>,
) -> Result<Cells> {
    let georef = grid.georef(crs).ok_or_else(|| Error::read(input, ReadFault::GridTooLarge(f64::NAN, f64::NAN)))?;
    // 20 bytes for points, and 8 for the heights that come of them.
    drop(reserve_cells::<[i32; 7]>(input, &georef)?);
    let within = options.extent.map(|_| [georef.x_min(), georef.y_min(), georef.x_max(), georef.y_max()]);
    let mut cells = Cells::new(grid);
    let mut told = None;
    for file in files {
        let mut of_unit = Vec::new();
        let meters = file.systems.height_unit(file.input, crs, &mut of_unit);
        if told.replace(meters) != Some(meters) {
            warnings.append(&mut of_unit);
        }
        points::for_each_batch(file, within, &mut |records| {
            let beyond = |z| Error::read(file.input, ReadFault::HeightRange(HeightOf::Point, z));
            cells.add(records, &file.records, meters).map_err(beyond)
        })?;
    }
    if let Some(z) = cells.beyond() {
        return Err(Error::read(input, ReadFault::HeightRange(HeightOf::Point, z)));
    }
    if options.extent.is_none() && cells.n_outside > 0 {
        warnings.push(Warning::of(input, OddFile::OutsideHeader { n: cells.n_outside }));
    }
    let wanted = if options.extent.is_some() { Wanted::PointsInExtent } else { Wanted::Points };
    let none = || Error::read(input, ReadFault::Nothing(wanted));
    match options.extent {
        Some(_) if cells.is_empty() => Err(none()),
        Some(_) => Ok(cells),
        None => cells.trimmed().ok_or_else(none),
    }
}

/// Doubles the cells until enough of them hold ground.
fn coarse_enough(input: &Input, mut cells: Cells, warnings: &mut Vec<Warning>) -> Cells {
    let (share, mut cell_m) = (cells.ground_share(), 1);
    let mut reached = share;
    while reached < LEAST_GROUND && cells.grid().n_cols.max(cells.grid().n_rows) > 1 {
        (cells, cell_m) = (cells.coarser(), 2 * cell_m);
        reached = cells.ground_share();
    }
    if cell_m > 1 {
        warnings.push(Warning::of(input, OddFile::LargerCells { cell_m, share }));
    }
    cells
}
