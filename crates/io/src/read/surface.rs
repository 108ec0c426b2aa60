//! Scenes from rasters: a surface model, with a terrain model, flat ground, or nothing below it.

use rayon::prelude::*;

use super::heights::{HeightFile, Heights, is_of_web_mercator};
use super::projection::Projection;
use super::reprojected::Reprojection;
use super::source::name_of;
use super::terrain::{Placed, terrain_on_grid, way_to_terrain};
use skyshed_request::Band;

use crate::city::{City, Ground, NodataAs, Solids, Source};
use crate::error::{OddFile, OptionError, Result, Warning};
use crate::input::Input;
use crate::quantity::{BLOCKS_ALL, VOID, height_steps};
use crate::raster::{BitGrid, Crs, GeoRef, LargeVec, Raster, RowGroup};

/// Least number of cells that is worth a thread.
const PART: usize = 1 << 16;

/// Options for reading a raster scene.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceOptions {
    /// Terrain model in the same CRS, unless `project` is given; resampled to the surface's grid if
    /// it is on another.
    pub terrain: Option<Input>,
    /// Height of flat ground \[m above the datum\]; not together with `terrain`.
    pub ground_m: Option<f64>,
    /// Height above the ground beyond which a surface is a building \[m\].
    pub building_threshold_m: f64,
    /// Effect of nodata cells.
    pub nodata_as: NodataAs,
    /// Band that holds the heights of the surface; a terrain is read from its first band.
    pub band: Band,
    /// CRS to assume where the file names none, or to override the one it names.
    pub crs: Option<Crs>,
    /// CRS of the scene, if it is not that of the file; a terrain in a third one is looked up
    /// there.
    pub project: Option<Projection>,
    /// Cell size in that CRS \[m\]; by default as many cells diagonally as the file has.
    pub cell_m: Option<f64>,
    /// `true` to hash inputs of any size.
    pub always_hash: bool,
    /// Box that limits reading to the cells that touch it: west, south, east, north \[CRS units\];
    /// not together with `project`.
    pub around: Option<[f64; 4]>,
}

impl Default for SurfaceOptions {
    /// Returns the default: a surface model alone; with a terrain, cells more than 0.25 m above it
    /// are buildings.
    fn default() -> Self {
        SurfaceOptions {
            terrain: None,
            ground_m: None,
            building_threshold_m: 0.25,
            nodata_as: NodataAs::default(),
            band: Band::First,
            crs: None,
            project: None,
            cell_m: None,
            always_hash: false,
            around: None,
        }
    }
}

/// Reads a surface model (GeoTIFF, Esri ASCII grid, GDAL virtual raster or folder of tiles) and the
/// ground below it.
///
/// # Errors
/// File errors for rasters that cannot be read, are in degrees, differ in CRS, or do not overlap;
/// limit errors for huge ones; usage errors for bad numbers.
pub fn read_surface(input: impl Into<Input>, options: &SurfaceOptions, warnings: &mut Vec<Warning>) -> Result<City> {
    let input = &input.into();
    let Heights { raster: surface, n_void, sources } = surface_heights(input, options, warnings)?;
    warnings.extend(warning_of_voids(input, n_void, options.nodata_as));
    scene_of(input, (surface, Empty::Nodata), sources, options, warnings)
}

/// Reads the heights of the surface, in the wanted system.
fn surface_heights(input: &Input, options: &SurfaceOptions, warnings: &mut Vec<Warning>) -> Result<Heights> {
    let file = HeightFile::open(input, (options.crs.as_ref(), &options.band), warnings)?;
    let reprojection = reprojection_of(input, file.georef(), options)?;
    if reprojection.is_some() {
        // Its meters are then those of another system.
        warnings.retain(|odd| !is_of_web_mercator(odd));
    }
    let file = match options.around {
        Some(around) => file.around(around),
        None => file,
    };
    Reprojection::read(reprojection, file, options.always_hash, warnings)
}

/// Plans the reprojection of a surface; `None` where it stays in its own system.
pub(super) fn reprojection_of<'a>(
    input: &'a Input,
    grid: &GeoRef,
    options: &SurfaceOptions,
) -> Result<Option<Reprojection<'a>>> {
    let reprojection = match &options.project {
        None => None,
        Some(projection) => Reprojection::plan(input, grid, projection, options.cell_m)?,
    };
    if reprojection.is_none() && options.cell_m.is_some() {
        return Err(OptionError::CellKept(input.to_string()).into());
    }
    Ok(reprojection)
}

/// Returns the grid of a surface, without reading its cells.
///
/// # Errors
/// Errors of [`read_surface`] about the file as such.
pub fn surface_grid(input: impl Into<Input>, options: &SurfaceOptions) -> Result<GeoRef> {
    let input = &input.into();
    let mut said = Vec::new();
    let file = HeightFile::open(input, (options.crs.as_ref(), &options.band), &mut said)?.in_meters(&mut said)?;
    Ok(file.georef().clone())
}

/// Returns the warning about cells without a height, if there are any.
pub(super) fn warning_of_voids(input: &Input, n_void: u64, nodata_as: NodataAs) -> Option<Warning> {
    (n_void > 0).then(|| Warning::of(input, OddFile::Voids { n: n_void, nodata_as }))
}

/// Meaning of surface cells without a height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Empty {
    /// Unknown.
    Nodata,
    /// Bare ground, where the ground is known.
    Ground,
}

/// Returns the scene of a surface and of the ground below it.
pub(super) fn scene_of(
    input: &Input,
    surface: (Raster<i32>, Empty),
    mut sources: Vec<Source>,
    options: &SurfaceOptions,
    warnings: &mut Vec<Warning>,
) -> Result<City> {
    let terrain = match &options.terrain {
        None => None,
        Some(path) => {
            let mut heights = terrain_heights(path, (input, surface.0.georef()), options, warnings)?;
            sources.append(&mut heights.sources);
            Some(Placed { input: path, on: heights.raster })
        }
    };
    scene_over(input, surface, terrain, sources, options, warnings)
}

/// Reads the heights of a terrain model onto the grid of the surface above it.
fn terrain_heights(
    path: &Input,
    (input, grid): (&Input, &GeoRef),
    options: &SurfaceOptions,
    warnings: &mut Vec<Warning>,
) -> Result<Heights> {
    let file = HeightFile::open_terrain(path, options.crs.as_ref(), warnings)?;
    let way = way_to_terrain(grid, file.georef(), options.project.is_some())?;
    let file = if way.is_none() { file.in_meters(warnings)? } else { file };
    let file = match options.around {
        Some(_) if way.is_none() => file.under((input, grid))?,
        _ => file,
    };
    let heights = file.read(options.always_hash, warnings)?;
    let (above, below) = (Placed { input, on: grid }, Placed { input: path, on: heights.raster });
    Ok(Heights { raster: terrain_on_grid(above, below, way.as_ref(), warnings)?, ..heights })
}

/// Returns the scene of a surface over a terrain on its grid, or over the ground of the options.
pub(super) fn scene_over(
    input: &Input,
    (mut surface, empty): (Raster<i32>, Empty),
    terrain: Option<Placed<'_, Raster<i32>>>,
    sources: Vec<Source>,
    options: &SurfaceOptions,
    warnings: &mut Vec<Warning>,
) -> Result<City> {
    let ground = match (terrain, options.ground_m) {
        (Some(Placed { input: terrain_path, on: terrain }), _) => {
            let parts = surface.cells().par_chunks(PART).zip(terrain.cells().par_chunks(PART));
            let above: usize = parts.map(|(s, t)| s.iter().zip(t).filter(|(s, t)| **s != VOID && t > s).count()).sum();
            warnings.extend(warning_of_high_terrain(terrain_path, above as u64, surface.cells().len()));
            Ground::Terrain(terrain)
        }
        (None, Some(ground_m)) => {
            let z = ground_steps(ground_m)?;
            // A surface that shows flat ground is often a rounding below the typed ground.
            let n_cells = surface.georef().n_cells();
            let buried = n_cells_of(&surface, |s| s != VOID && s < z - 1);
            warnings.extend(warning_of_high_ground(input, ground_m, buried, n_cells));
            Ground::Flat(z)
        }
        (None, None) => {
            warnings.push(Warning::of(input, OddFile::SurfaceAlone));
            Ground::Surface
        }
    };
    let georef = surface.georef().clone();
    let mut cells = surface.into_cells();
    let voids = match (&ground, options.nodata_as) {
        // `VOID` itself marks the cells without a height.
        (Ground::Surface, NodataAs::Clear) => None,
        _ => raise(&mut cells, (georef.n_rows(), georef.n_cols()), &ground, (options.nodata_as, empty)),
    };
    surface = Raster::new(georef.clone(), cells);
    let building_threshold = building_threshold(options)?;
    Ok(City {
        name: name_of("surface", input),
        grid: georef,
        solids: Solids::Raster { surface, ground, building_threshold, voids },
        built_up: None,
        sources,
        attribution: None,
        heights: None,
    })
}

/// Returns the number of cells whose height is of some kind.
fn n_cells_of(surface: &Raster<i32>, is_of_kind: impl Fn(i32) -> bool + Sync) -> u64 {
    match surface.runs() {
        Some(runs) => {
            let of_kind = |group: RowGroup<'_, i32>| {
                let cols = group.runs().filter(|(_, s)| is_of_kind(**s)).map(|(cols, _)| cols.len());
                (cols.sum::<usize>() * group.rows.len()) as u64
            };
            runs.groups().map(of_kind).sum()
        }
        None => {
            let parts = surface.cells().par_chunks(PART);
            parts.map(|part| part.iter().filter(|s| is_of_kind(**s)).count() as u64).sum()
        }
    }
}

/// Returns the warning about a terrain that is above the surface in some cells, if there are any.
pub(super) fn warning_of_high_terrain(terrain: &Input, above: u64, n_cells: usize) -> Option<Warning> {
    (above > 0).then(|| Warning::of(terrain, OddFile::HighTerrain { n: above, of: n_cells }))
}

/// Returns the warning about flat ground that is above the surface in some cells, if there are any.
pub(super) fn warning_of_high_ground(input: &Input, ground_m: f64, buried: u64, n_cells: usize) -> Option<Warning> {
    (buried > 0).then(|| Warning::of(input, OddFile::HighGround { ground_m, n: buried, of: n_cells }))
}

/// Raises surface cells to the ground below them, also cells without a height. Returns the latter,
/// since what stands on them is not known. Where they block everything, they get a height above any
/// real top instead.
pub(super) fn raise(
    cells: &mut LargeVec<i32>,
    (n_rows, n_cols): (usize, usize),
    ground: &Ground,
    (nodata_as, empty): (NodataAs, Empty),
) -> Option<BitGrid> {
    let mut voids = None;
    if let (Ground::Flat(z), Some(runs)) = (ground, cells.runs_mut())
        && !runs.values_mut().contains(&VOID)
    {
        runs.values_mut().iter_mut().for_each(|s| *s = (*s).max(*z));
        return None;
    }
    if empty == Empty::Nodata {
        match nodata_as {
            NodataAs::Block => cells.iter_mut().filter(|s| **s == VOID).for_each(|s| *s = BLOCKS_ALL),
            NodataAs::Clear => voids = voids_of(cells, (n_rows, n_cols)),
        }
    }
    // VOID is below every height, so a cell without one takes the ground's.
    match ground {
        Ground::Terrain(terrain) => {
            let parts = cells.par_chunks_mut(PART).zip(terrain.cells().par_chunks(PART));
            parts.for_each(|(s, t)| s.iter_mut().zip(t).for_each(|(s, t)| *s = (*s).max(*t)));
        }
        Ground::Flat(z) => cells.par_chunks_mut(PART).for_each(|part| part.iter_mut().for_each(|s| *s = (*s).max(*z))),
        Ground::Surface => {}
    }
    voids
}

/// Returns the cells without a height, if there are any.
fn voids_of(cells: &[i32], (n_rows, n_cols): (usize, usize)) -> Option<BitGrid> {
    cells.par_chunks(PART).any(|part| part.contains(&VOID)).then(|| {
        let mut voids = BitGrid::new(n_rows, n_cols);
        let per_row = voids.words_per_row();
        voids.words_mut().par_chunks_mut(per_row).zip(cells.par_chunks(n_cols)).for_each(|(words, cells)| {
            for (word, cells) in words.iter_mut().zip(cells.chunks(64)) {
                *word = cells.iter().rev().fold(0, |word, s| word << 1 | u64::from(*s == VOID));
            }
        });
        voids
    })
}

/// Returns the height above the ground beyond which a surface is a building \[1/1024 m\].
pub(super) fn building_threshold(options: &SurfaceOptions) -> Result<i32> {
    let m = options.building_threshold_m;
    let bad = OptionError::Number("building_threshold", m, "0 m or more");
    height_steps(m).filter(|t| *t >= 0).ok_or_else(|| bad.into())
}

/// Returns the ground height on the lattice.
pub(super) fn ground_steps(ground_m: f64) -> Result<i32> {
    let bad = OptionError::Number("ground", ground_m, "a height within ±32768 m");
    height_steps(ground_m).ok_or_else(|| bad.into())
}
