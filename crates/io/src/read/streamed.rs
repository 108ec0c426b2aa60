//! Raster scenes that do not fit in memory: their heights are in tiles on disk, and are read window
//! by window.

use std::path::Path;

use super::heights::{HeightFile, StoredHeights};
use super::source::name_of;
use super::surface::{
    Empty, SurfaceOptions, building_threshold, ground_steps, raise, warning_of_high_ground, warning_of_high_terrain,
    warning_of_voids,
};
use super::systems::refuse_two_crs;
use super::terrain::{Placed, looked_up, no_terrain_below, warning_of_other_grid};
use crate::city::{City, Ground, NodataAs, Solids, Source};
use crate::city::{WindowedBase, WindowedSolids, strips};
use crate::error::{OddFile, Pair, Result, Warning};
use crate::formats::TileStore;
use crate::input::Input;
use crate::quantity::VOID;
use crate::raster::{CellWindow, GeoRef, LargeVec, Raster};

/// A surface model in tiles on disk, and the ground below it.
#[derive(Debug)]
pub struct StreamedSurface {
    /// Name of the scene in captions.
    pub name: String,
    /// Files that it was read from.
    pub sources: Vec<Source>,
    grid: GeoRef,
    surface: TileStore,
    ground: StreamedGround,
    building_threshold: i32,
    nodata_as: NodataAs,
}

#[derive(Debug)]
enum StreamedGround {
    Surface,
    Flat(i32),
    /// A terrain on a grid of its own, or on the surface's.
    Terrain(TileStore, Box<GeoRef>),
}

impl StreamedSurface {
    /// Copies a surface model, and the terrain below it, to tiles in files without a name in
    /// `scratch`.
    ///
    /// Memory is that of a row of tiles, and of a row of blocks of the file. Refusals and warnings
    /// are those of [`super::read_surface`].
    ///
    /// # Errors
    /// Errors of [`super::read_surface`], and E401 if there is no room on the disk.
    pub fn read(
        input: impl Into<Input>,
        options: &SurfaceOptions,
        scratch: &Path,
        warnings: &mut Vec<Warning>,
    ) -> Result<StreamedSurface> {
        let input = &input.into();
        let building_threshold = building_threshold(options)?;
        let of_file = (options.crs.as_ref(), &options.band);
        let file = HeightFile::open(input, of_file, warnings)?.in_meters(warnings)?;
        let file = match options.around {
            Some(around) => file.around(around),
            None => file,
        };
        let StoredHeights { tiles: surface, georef: grid, n_void, mut sources } =
            file.store(scratch, options.always_hash, warnings)?;
        warnings.extend(warning_of_voids(input, n_void, options.nodata_as));
        let ground = match (&options.terrain, options.ground_m) {
            (Some(terrain_path), _) => {
                let file = HeightFile::open_terrain(terrain_path, options.crs.as_ref(), warnings)?;
                let file = file.in_meters(warnings)?;
                let found = (terrain_path, file.georef().crs());
                refuse_two_crs((input, grid.crs()), found, Pair::SurfaceTerrain)?;
                let file = if options.around.is_some() { file.under((input, &grid))? } else { file };
                let mut terrain = file.store(scratch, options.always_hash, warnings)?;
                sources.append(&mut terrain.sources);
                StreamedGround::Terrain(terrain.tiles, Box::new(terrain.georef))
            }
            (None, Some(ground_m)) => StreamedGround::Flat(ground_steps(ground_m)?),
            (None, None) => {
                warnings.push(Warning::of(input, OddFile::SurfaceAlone));
                StreamedGround::Surface
            }
        };
        let scene = StreamedSurface {
            name: name_of("surface", input),
            sources,
            grid,
            surface,
            ground,
            building_threshold,
            nodata_as: options.nodata_as,
        };
        scene.compare_ground((input, options), warnings)?;
        Ok(scene)
    }

    /// Returns the bytes on disk that the heights of a grid take.
    pub fn bytes_on_disk(grid: &GeoRef) -> u64 {
        TileStore::bytes_on_disk((grid.n_rows(), grid.n_cols()))
    }

    /// Returns the part of the scene over a window.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn part(&self, window: CellWindow) -> Result<City> {
        Ok(City {
            name: self.name.clone(),
            grid: self.grid.part(window),
            solids: self.solids(window)?,
            built_up: None,
            sources: self.sources.clone(),
            attribution: None,
            heights: None,
        })
    }

    /// Returns the scene in cells `factor` times as large, with the highest surface and ground in
    /// each: for pictures.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn highest(&self, factor: usize) -> Result<Solids> {
        let grid = self.grid.coarser(factor);
        let n_cols = self.grid.n_cols();
        let highest = |cells: &[i32], above: &mut Vec<i32>| {
            for rows in cells.chunks(factor * n_cols) {
                let of_col = |col: usize| {
                    let cols = col * factor..((col + 1) * factor).min(n_cols);
                    rows.chunks(n_cols).flat_map(|row| &row[cols.clone()]).fold(VOID, |top, z| top.max(*z))
                };
                above.extend((0..grid.n_cols()).map(of_col));
            }
        };
        let (mut surface, mut ground) = (Vec::new(), Vec::new());
        for window in strips(&self.grid) {
            let Solids::Raster { surface: tops, ground: below, .. } = self.solids(window)? else { continue };
            highest(tops.cells(), &mut surface);
            if let Ground::Terrain(terrain) = below {
                highest(terrain.cells(), &mut ground);
            }
        }
        Ok(Solids::Raster {
            surface: Raster::new(grid.clone(), surface),
            ground: match &self.ground {
                StreamedGround::Surface => Ground::Surface,
                StreamedGround::Flat(z) => Ground::Flat(*z),
                StreamedGround::Terrain(..) => Ground::Terrain(Raster::new(grid, ground)),
            },
            building_threshold: self.building_threshold,
            voids: None,
        })
    }

    /// Warns where the ground is above the surface, and where it is not known.
    fn compare_ground(&self, (input, options): (&Input, &SurfaceOptions), warnings: &mut Vec<Warning>) -> Result<()> {
        if matches!(self.ground, StreamedGround::Surface) {
            return Ok(());
        }
        let (mut above, mut n_void) = (0, 0);
        for window in strips(&self.grid) {
            let mut cells = Vec::new();
            self.surface.read(window, &mut cells)?;
            let known = cells.iter().enumerate().filter(|(_, s)| **s != VOID);
            match self.ground(window)? {
                Ground::Surface => {}
                // A surface that shows flat ground is often a rounding below the typed ground.
                Ground::Flat(z) => above += known.filter(|(_, s)| **s < z - 1).count() as u64,
                Ground::Terrain(terrain) => {
                    let terrain = terrain.cells();
                    above += known.filter(|(k, s)| terrain[*k] > **s).count() as u64;
                    n_void += terrain.iter().filter(|z| **z == VOID).count();
                }
            }
        }
        let n_cells = self.grid.n_cells();
        let (Some(terrain_path), StreamedGround::Terrain(_, from)) = (&options.terrain, &self.ground) else {
            let ground_m = options.ground_m.unwrap_or_default();
            warnings.extend(warning_of_high_ground(input, ground_m, above, n_cells));
            return Ok(());
        };
        if n_void == n_cells {
            return Err(no_terrain_below((input, &self.grid), (terrain_path, from)));
        }
        if !self.grid.same_grid(from) {
            let surface = Placed { input, on: &self.grid };
            warnings.push(warning_of_other_grid(surface, (terrain_path, from, ""), n_void));
        }
        warnings.extend(warning_of_high_terrain(terrain_path, above, n_cells));
        Ok(())
    }

    /// Returns the ground below the surface of a window.
    fn ground(&self, window: CellWindow) -> Result<Ground> {
        let grid = self.grid.part(window);
        let (store, from) = match &self.ground {
            StreamedGround::Surface => return Ok(Ground::Surface),
            StreamedGround::Flat(z) => return Ok(Ground::Flat(*z)),
            StreamedGround::Terrain(store, from) => (store, from),
        };
        let mut cells = Vec::new();
        if self.grid.same_grid(from) {
            store.read(window, &mut cells)?;
            return Ok(Ground::Terrain(Raster::new(grid, cells)));
        }
        let Some(part) = from.window_over(&grid) else {
            return Ok(Ground::Terrain(Raster::new(grid.clone(), vec![VOID; grid.n_cells()])));
        };
        store.read(part, &mut cells)?;
        let terrain = Raster::new(from.part(part), cells);
        let cells = looked_up(&grid, &terrain);
        Ok(Ground::Terrain(Raster::new(grid, cells)))
    }
}

impl WindowedSolids for StreamedSurface {
    fn grid(&self) -> &GeoRef {
        &self.grid
    }

    fn base(&self) -> WindowedBase {
        match &self.ground {
            StreamedGround::Surface => WindowedBase::Surface,
            StreamedGround::Flat(z) => WindowedBase::Flat(*z),
            StreamedGround::Terrain(..) => WindowedBase::Terrain,
        }
    }

    fn solids(&self, window: CellWindow) -> skyshed_core::Result<Solids> {
        let ground = self.ground(window)?;
        let mut cells = Vec::new();
        self.surface.read(window, &mut cells)?;
        let mut cells = LargeVec::from(cells);
        let voids = match ground {
            Ground::Surface if self.nodata_as == NodataAs::Clear => None,
            _ => raise(&mut cells, (window.n_rows, window.n_cols), &ground, (self.nodata_as, Empty::Nodata)),
        };
        let surface = Raster::new(self.grid.part(window), cells);
        Ok(Solids::Raster { surface, ground, building_threshold: self.building_threshold, voids })
    }
}
