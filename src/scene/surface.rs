//! Scenes from rasters: a surface model, with a terrain model, flat ground, or nothing below it.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::heights::{HeightFile, Heights};
use super::terrain::terrain_on_grid;
use super::{Ground, NodataAs, Scene, Solids, Source, name_of};
use crate::error::{Error, Result, Warning};
use crate::quantity::{BLOCKS_ALL, VOID, counted, height_steps};
use crate::raster::{Crs, Raster};

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

/// Reads a surface model (GeoTIFF, Esri ASCII grid, GDAL virtual raster or folder of tiles) and what lies below it.
///
/// # Errors
/// File errors for rasters that cannot be read, are in degrees, differ in CRS, or do not overlap; limit errors for huge ones; usage
/// errors for bad numbers.
pub fn read_surface(path: &Path, options: &SurfaceOptions, warnings: &mut Vec<Warning>) -> Result<Scene> {
    let file = HeightFile::open(path, options.crs.as_ref(), warnings)?.in_meters(warnings)?;
    let Heights { raster: surface, n_void, sources } = file.read(options.always_hash, warnings)?;
    if n_void > 0 {
        let effect = match options.nodata_as {
            NodataAs::Clear => "blocks nothing",
            NodataAs::Block => "blocks everything",
        };
        warnings.push(Warning::new(
            340,
            format!(
                "{}: {} without a height: nodata {effect} and holds no receiver (`--nodata-as`)",
                path.display(),
                counted(n_void, "cell", "cells")
            ),
        ));
    }
    scene_of(path, (surface, Empty::Nodata), sources, options, warnings)
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
            let file = HeightFile::open(terrain_path, options.crs.as_ref(), warnings)?.in_meters(warnings)?;
            let mut heights = file.read(options.always_hash, warnings)?;
            sources.append(&mut heights.sources);
            let terrain = terrain_on_grid(path, surface.georef(), terrain_path, heights.raster, warnings)?;
            let cells = surface.cells().par_iter().with_min_len(PART).zip(terrain.cells());
            let above = cells.filter(|(s, t)| **s != VOID && t > s).count();
            if above > 0 {
                warnings.push(Warning::new(
                    341,
                    format!(
                        "{}: the terrain is above the surface in {above} of {} cells; the higher one is used there",
                        terrain_path.display(),
                        surface.cells().len()
                    ),
                ));
            }
            Ground::Terrain(terrain)
        }
        (None, Some(ground_m)) => {
            let z = ground_steps(ground_m)?;
            // A surface that is flat where it is ground is often a rounding below the ground that was typed.
            let buried = surface.cells().par_iter().with_min_len(PART).filter(|s| **s != VOID && **s < z - 1).count();
            if buried > 0 {
                warnings.push(Warning::new(
                    341,
                    format!(
                        "{}: the ground at {ground_m} m is above the surface in {buried} of {} cells; the higher one is \
                         used there",
                        path.display(),
                        surface.cells().len()
                    ),
                ));
            }
            Ground::Flat(z)
        }
        (None, None) => {
            warnings.push(Warning::new(
                342,
                format!(
                    "{}: a surface model alone, so receivers stand on the surface, roofs included; give `--terrain FILE` \
                     or `--ground Z` to put them on the ground",
                    path.display()
                ),
            ));
            Ground::Surface
        }
    };
    let georef = surface.georef().clone();
    let blocking_void = if options.nodata_as == NodataAs::Block { BLOCKS_ALL } else { VOID };
    let mut cells = surface.into_cells();
    // VOID is below every height, so an empty cell that is ground takes the ground's.
    let is_raised = |s: i32| s != VOID || empty == Empty::Ground;
    if let Ground::Terrain(terrain) = &ground {
        cells.par_iter_mut().with_min_len(PART).zip(terrain.cells()).for_each(|(s, t)| {
            if is_raised(*s) {
                *s = (*s).max(*t);
            }
        });
    }
    if let Ground::Flat(z) = &ground {
        cells.par_iter_mut().with_min_len(PART).filter(|s| is_raised(**s)).for_each(|s| *s = (*s).max(*z));
    }
    if blocking_void != VOID {
        // Marked by their height: no real top reaches it.
        cells.iter_mut().filter(|s| **s == VOID).for_each(|s| *s = blocking_void);
    }
    surface = Raster::new(georef.clone(), cells);
    let building_threshold = height_steps(options.building_threshold_m)
        .filter(|t| *t >= 0)
        .ok_or_else(|| bad_number("--building-threshold", options.building_threshold_m, "0 m or more"))?;
    Ok(Scene {
        name: name_of(path),
        grid: georef,
        solids: Solids::Raster { surface, ground, building_threshold },
        built_up: None,
        sources,
        attribution: None,
    })
}

pub(super) fn bad_number(flag: &str, value: f64, wanted: &str) -> Error {
    Error::usage(113, format!("`{flag}` is `{value}`, wanted {wanted}"))
}

/// Ground height on the lattice.
pub(super) fn ground_steps(ground_m: f64) -> Result<i32> {
    height_steps(ground_m).ok_or_else(|| bad_number("--ground", ground_m, "a height within ±32768 m"))
}
