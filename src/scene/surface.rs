//! Scenes from rasters: a surface model, with a terrain model, flat ground, or nothing below it.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::{Ground, NodataAs, Scene, Solids, Source, name_of, refuse_degrees, refuse_two_crs};
use crate::error::{Error, Result, Warning};
use crate::quantity::{BLOCKS_ALL, MAX_EXTENT_UNITS, VOID, counted, height_steps};
use crate::raster::{Crs, CrsKind, GeoRef, InputKind, Raster, RasterFile};

/// Fewest cells that are worth handing to a thread.
const PART: usize = 1 << 16;

/// How a raster scene is read.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfaceOptions {
    /// A terrain model in the same CRS; brought to the surface's grid if it is on another.
    pub terrain: Option<PathBuf>,
    /// Height of flat ground \[m above the datum\]; not together with `terrain`.
    pub ground_m: Option<f64>,
    /// A cell whose surface is more than this above the ground is a building \[m\].
    pub building_threshold_m: f64,
    /// What nodata cells do.
    pub nodata_as: NodataAs,
    /// The CRS to assume where the file names none (or to override what it names).
    pub crs: Option<Crs>,
    /// Whether to hash inputs of any size.
    pub always_hash: bool,
}

impl Default for SurfaceOptions {
    /// A surface model alone; with a terrain, cells more than 0.25 m above it are buildings.
    fn default() -> Self {
        SurfaceOptions {
            terrain: None,
            ground_m: None,
            building_threshold_m: 0.25,
            nodata_as: NodataAs::default(),
            crs: None,
            always_hash: false,
        }
    }
}

/// Reads a surface model (GeoTIFF or Esri ASCII grid) and what lies below it.
///
/// # Errors
/// File errors for rasters that cannot be read, are in degrees, differ in CRS, or do not overlap; limit errors for huge ones; usage
/// errors for bad numbers.
pub fn read_surface(path: &Path, options: &SurfaceOptions, warnings: &mut Vec<Warning>) -> Result<Scene> {
    let (surface, n_void) = read_heights(path, options, warnings)?;
    let sources = vec![Source::of(path, options.always_hash)?];
    warnings.extend(warning_of_voids(path, n_void, options.nodata_as));
    scene_of(path, (surface, Empty::Nodata), sources, options, warnings)
}

/// What is said of cells without a height, if there are any.
pub(super) fn warning_of_voids(path: &Path, n_void: u64, nodata_as: NodataAs) -> Option<Warning> {
    let effect = match nodata_as {
        NodataAs::Clear => "blocks nothing",
        NodataAs::Block => "blocks everything",
    };
    let (path, cells) = (path.display(), counted(n_void, "cell", "cells"));
    let text = format!("{path}: {cells} without a height: nodata {effect} and holds no receiver (`--nodata-as`)");
    (n_void > 0).then(|| Warning::new(340, text))
}

/// What the cells of a surface are that hold no height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Empty {
    /// Not known.
    Nodata,
    /// Bare ground, where the ground is known.
    Ground,
}

/// The scene of a surface and of what lies below it.
pub(super) fn scene_of(
    path: &Path,
    (mut surface, empty): (Raster<i32>, Empty),
    mut sources: Vec<Source>,
    options: &SurfaceOptions,
    warnings: &mut Vec<Warning>,
) -> Result<Scene> {
    let ground = match (&options.terrain, options.ground_m) {
        (Some(terrain_path), _) => {
            let (terrain, _) = read_heights(terrain_path, options, warnings)?;
            let terrain = terrain_on_grid(path, surface.georef(), terrain_path, terrain, warnings)?;
            sources.push(Source::of(terrain_path, options.always_hash)?);
            let cells = surface.cells().par_iter().with_min_len(PART).zip(terrain.cells());
            let above = cells.filter(|(s, t)| **s != VOID && t > s).count();
            warnings.extend(warning_of_high_terrain(terrain_path, above as u64, surface.cells().len()));
            Ground::Terrain(terrain)
        }
        (None, Some(ground_m)) => {
            let z = ground_steps(ground_m)?;
            // A surface that is flat where it is ground is often a rounding below the ground that was typed.
            let buried = surface.cells().par_iter().with_min_len(PART).filter(|s| **s != VOID && **s < z - 1).count();
            warnings.extend(warning_of_high_ground(path, ground_m, buried as u64, surface.cells().len()));
            Ground::Flat(z)
        }
        (None, None) => {
            warnings.push(warning_of_surface_alone(path));
            Ground::Surface
        }
    };
    let georef = surface.georef().clone();
    let mut cells = surface.into_cells();
    raise(&mut cells, &ground, (options.nodata_as, empty));
    surface = Raster::new(georef.clone(), cells);
    let building_threshold = building_threshold(options)?;
    Ok(Scene {
        name: name_of(path),
        grid: georef,
        solids: Solids::Raster { surface, ground, building_threshold },
        built_up: None,
        sources,
        attribution: None,
    })
}

/// What is said of a terrain that is above the surface in some cells, if there are any.
pub(super) fn warning_of_high_terrain(terrain_path: &Path, above: u64, n_cells: usize) -> Option<Warning> {
    let terrain_path = terrain_path.display();
    let text = format!(
        "{terrain_path}: the terrain is above the surface in {above} of {n_cells} cells; the higher one is used there"
    );
    (above > 0).then(|| Warning::new(341, text))
}

/// The same of flat ground.
pub(super) fn warning_of_high_ground(path: &Path, ground_m: f64, buried: u64, n_cells: usize) -> Option<Warning> {
    let path = path.display();
    let text = format!(
        "{path}: the ground at {ground_m} m is above the surface in {buried} of {n_cells} cells; the higher one is used \
         there"
    );
    (buried > 0).then(|| Warning::new(341, text))
}

/// What is said where nothing but a surface is known.
pub(super) fn warning_of_surface_alone(path: &Path) -> Warning {
    Warning::new(
        342,
        format!(
            "{}: a surface model alone, so receivers stand on the surface, roofs included; give `--terrain FILE` or \
             `--ground Z` to put them on the ground",
            path.display()
        ),
    )
}

/// Raises surface cells to the ground below them, and those that block everything to a height that no real top reaches.
pub(super) fn raise(cells: &mut [i32], ground: &Ground, (nodata_as, empty): (NodataAs, Empty)) {
    // VOID is below every height, so an empty cell that is ground takes the ground's.
    let is_raised = |s: i32| s != VOID || empty == Empty::Ground;
    if let Ground::Terrain(terrain) = ground {
        cells.par_iter_mut().with_min_len(PART).zip(terrain.cells()).for_each(|(s, t)| {
            if is_raised(*s) {
                *s = (*s).max(*t);
            }
        });
    }
    if let Ground::Flat(z) = ground {
        cells.par_iter_mut().with_min_len(PART).filter(|s| is_raised(**s)).for_each(|s| *s = (*s).max(*z));
    }
    if nodata_as == NodataAs::Block {
        cells.iter_mut().filter(|s| **s == VOID).for_each(|s| *s = BLOCKS_ALL);
    }
}

/// How far above the ground a surface is a building \[1/1024 m\].
pub(super) fn building_threshold(options: &SurfaceOptions) -> Result<i32> {
    height_steps(options.building_threshold_m)
        .filter(|t| *t >= 0)
        .ok_or_else(|| bad_number("--building-threshold", options.building_threshold_m, "0 m or more"))
}

pub(super) fn bad_number(flag: &str, value: f64, wanted: &str) -> Error {
    Error::usage(113, format!("`{flag}` is `{value}`, wanted {wanted}"))
}

/// Ground height on the lattice.
pub(super) fn ground_steps(ground_m: f64) -> Result<i32> {
    height_steps(ground_m).ok_or_else(|| bad_number("--ground", ground_m, "a height within ±32768 m"))
}

/// Opens a raster of heights; its grid has the CRS to assume.
pub(super) fn open_surface(
    path: &Path,
    options: &SurfaceOptions,
    warnings: &mut Vec<Warning>,
) -> Result<(RasterFile, GeoRef)> {
    let before = warnings.len();
    let file = RasterFile::open(path, warnings)?;
    if options.crs.is_some() {
        // What the file says of its CRS, or does not, is overridden.
        let said: Vec<Warning> = warnings.drain(before..).collect();
        warnings.extend(said.into_iter().filter(|w| !["W325", "W326", "W331"].contains(&w.code().as_str())));
    }
    let georef = file.georef().clone();
    let georef = match &options.crs {
        Some(crs) => georef.with_crs(Some(crs.clone())),
        None => georef,
    };
    check_crs(path, &georef, warnings)?;
    Ok((file, georef))
}

/// Reads heights onto the lattice, with the number of cells that have none and become [`VOID`].
pub(super) fn read_heights(
    path: &Path,
    options: &SurfaceOptions,
    warnings: &mut Vec<Warning>,
) -> Result<(Raster<i32>, u64)> {
    let (file, georef) = open_surface(path, options, warnings)?;
    if let Some((raster, n_void)) = file.read_plain_heights(warnings)? {
        return Ok((Raster::new(georef, raster.into_cells()), n_void));
    }
    let mut out_of_range: Option<f64> = None;
    let meters_per_unit = file.meters_per_height_unit().unwrap_or(1.0);
    let raster = file.read(file.georef().window(), warnings, |v| {
        let v = v * meters_per_unit;
        if v.is_nan() {
            return VOID;
        }
        height_steps(v).unwrap_or_else(|| {
            out_of_range.get_or_insert(v);
            VOID
        })
    })?;
    refuse_out_of_range(path, out_of_range)?;
    let n_void = raster.cells().iter().filter(|h| **h == VOID).count() as u64;
    refuse_all_void(path, n_void, &georef)?;
    Ok((Raster::new(georef, raster.into_cells()), n_void))
}

/// Refuses a raster with a height beyond the lattice.
pub(super) fn refuse_out_of_range(path: &Path, height: Option<f64>) -> Result<()> {
    let Some(v) = height else { return Ok(()) };
    let text = format!("cannot use {}: a cell has height `{v}` m, wanted within ±32768 m", path.display());
    Err(Error::site(205, text)
        .with_hint("if it stands for nodata, declare it: `gdal_translate -a_nodata VALUE in.tif out.tif`"))
}

/// Refuses a raster without any height.
pub(super) fn refuse_all_void(path: &Path, n_void: u64, georef: &GeoRef) -> Result<()> {
    if n_void < georef.n_cells() as u64 {
        return Ok(());
    }
    let text = format!("cannot use {}: all {} cells are nodata, wanted heights", path.display(), georef.n_cells());
    Err(Error::file(305, text))
}

/// Warns where coordinates are not meters.
pub(super) fn warn_of_units(path: &Path, crs: &Crs, warnings: &mut Vec<Warning>) {
    if let CrsKind::Projected { meters_per_unit } = crs.kind()
        && (meters_per_unit - 1.0).abs() > 1e-9
    {
        warnings.push(Warning::new(
            343,
            format!(
                "{}: coordinates are in units of {meters_per_unit} m; lengths such as `--radius` and `--cell`, and heights, \
                 are in meters",
                path.display()
            ),
        ));
    }
}

fn check_crs(path: &Path, georef: &GeoRef, warnings: &mut Vec<Warning>) -> Result<()> {
    let Some(crs) = georef.crs() else { return Ok(()) };
    refuse_degrees(path, crs, [georef.x_min(), georef.y_min(), georef.x_max(), georef.y_max()], InputKind::Raster)?;
    warn_of_units(path, crs, warnings);
    if georef.n_cols().max(georef.n_rows()) as f64 > MAX_EXTENT_UNITS {
        warnings.push(Warning::new(
            344,
            format!("{}: more than 65536 cells a side; give `--radius` so that one map fits", path.display()),
        ));
    }
    Ok(())
}

/// The height of the terrain cell that holds the center of each cell of a grid, [`VOID`] outside.
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

/// Refuses a terrain that lies elsewhere than the surface.
pub(super) fn no_terrain_below((surface, grid): (&Path, &GeoRef), (terrain, from): (&Path, &GeoRef)) -> Error {
    let (surface, terrain) = (surface.display(), terrain.display());
    let (grid, from) = (grid.description(), from.description());
    let text = format!(
        "cannot combine {surface} ({grid}) with {terrain} ({from}): wanted a terrain below the surface, found none at any cell"
    );
    Error::file(312, text)
        .with_hint("compare the extents and coordinate reference systems that `skyshed info` gives for both")
}

/// What is said of a terrain on another grid than the surface, `n_void` of whose cells it leaves without ground.
pub(super) fn resampled_warning(
    (surface, grid): (&Path, &GeoRef),
    (terrain, from): (&Path, &GeoRef),
    n_void: usize,
) -> Option<Warning> {
    let without = match n_void {
        0 => String::new(),
        _ => format!("; {n_void} of {} cells have no terrain and are no receivers", grid.n_cells()),
    };
    let (surface, terrain) = (surface.display(), terrain.display());
    let (on, to) = (from.description(), grid.description());
    let text = format!(
        "{terrain} ({on}) is not on the grid of {surface} ({to}): each cell takes the terrain that holds its center{without}"
    );
    (!grid.same_grid(from)).then(|| Warning::new(346, text))
}

/// The terrain on the grid of the surface: each cell takes the height of the terrain cell that holds its center (the
/// one to its north-east where the center lies on an edge, to within a millionth of a cell).
fn terrain_on_grid(
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
    let cells = looked_up(grid, &terrain);
    let n_void = cells.iter().filter(|z| **z == VOID).count();
    if n_void == cells.len() {
        return Err(no_terrain_below((surface_path, grid), (terrain_path, from)));
    }
    warnings.extend(resampled_warning((surface_path, grid), (terrain_path, from), n_void));
    Ok(Raster::new(grid.clone(), cells))
}
