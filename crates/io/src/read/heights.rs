//! Heights of a raster file on the lattice, for surfaces and terrains alike.

use std::path::Path;

use super::source::sources_of_raster;
use super::systems::refuse_degrees;
use super::terrain::no_terrain_below;
use crate::city::Source;
use crate::error::{Error, HeightOf, InputKind, OddFile, OddRaster, Oddity, ReadFault, Result, Warning};
use skyshed_request::Band;

use crate::formats::{RasterFile, TileStore, TileStoreWriter, with_true_lengths};
use crate::input::Input;
use crate::quantity::{MAX_EXTENT_UNITS, VOID, height_steps};
use crate::raster::{CellWindow, Crs, CrsKind, GeoRef, LargeVec, Raster};

/// A raster of heights, opened but not read.
#[derive(Debug)]
pub(super) struct HeightFile<'a> {
    input: &'a Input,
    file: RasterFile,
    /// Part of the file that is read, and its grid.
    window: CellWindow,
    georef: GeoRef,
}

/// Heights of a raster.
#[derive(Debug)]
pub(super) struct Heights {
    /// Heights on the lattice, [`VOID`] where there is none.
    pub(super) raster: Raster<i32>,
    /// Number of cells without a height.
    pub(super) n_void: u64,
    /// Files that were read.
    pub(super) sources: Vec<Source>,
}

/// Heights of a raster, in tiles on disk.
#[derive(Debug)]
pub(super) struct StoredHeights {
    /// Heights on the lattice, [`VOID`] where there is none.
    pub(super) tiles: TileStore,
    /// Grid of the cells.
    pub(super) georef: GeoRef,
    /// Number of cells without a height.
    pub(super) n_void: u64,
    /// Files that were read.
    pub(super) sources: Vec<Source>,
}

impl<'a> HeightFile<'a> {
    /// Opens the raster of a scene; `crs` overrides the system of the file, or a missing one.
    pub(super) fn open(
        input: &'a Input,
        (crs, band): (Option<&Crs>, &Band),
        warnings: &mut Vec<Warning>,
    ) -> Result<HeightFile<'a>> {
        HeightFile::open_band(input, (crs, Some(band)), warnings)
    }

    /// Opens a raster; `band` is the one to read, where the caller can choose one.
    fn open_band(
        input: &'a Input,
        (crs, band): (Option<&Crs>, Option<&Band>),
        warnings: &mut Vec<Warning>,
    ) -> Result<HeightFile<'a>> {
        let mut odd = Vec::new();
        let file = RasterFile::open_told(input, band, &mut odd)?;
        let georef = file.georef().clone();
        let georef = match crs {
            None => {
                // A definition that is cut off may be one in feet: its cells are not taken for
                // meters.
                let said = odd
                    .iter()
                    .find(|oddity| matches!(oddity.odd, OddRaster::CrsIgnored(_) | OddRaster::DamagedKeys(_)));
                if let (Some(said), None) = (said, georef.crs()) {
                    let said = format!("`{}` {}", said.name, said.odd);
                    let said = said.trim_end_matches(": ignored").to_string();
                    return Err(Error::read(input, ReadFault::CrsNotUnderstood(said)));
                }
                georef
            }
            Some(crs) => {
                odd.retain(|oddity| !oddity.odd.is_of_crs());
                let mut tell = |of_grid| odd.push(Oddity::new(input, of_grid));
                with_true_lengths(georef.with_crs(Some(crs.clone())), &mut tell)
            }
        };
        warnings.extend(odd.into_iter().map(Warning::from));
        Ok(HeightFile { input, window: georef.window(), file, georef })
    }

    /// Opens a terrain model. Lengths are those of the surface or the footprints above it, whatever
    /// its own are.
    pub(super) fn open_terrain(
        input: &'a Input,
        crs: Option<&Crs>,
        warnings: &mut Vec<Warning>,
    ) -> Result<HeightFile<'a>> {
        let mut odd = Vec::new();
        let file = HeightFile::open_band(input, (crs, None), &mut odd)?;
        warnings.extend(odd.into_iter().filter(|odd| !is_of_web_mercator(odd)));
        Ok(file)
    }

    /// Limits the file to the cells that touch a box: west, south, east, north \[CRS units\].
    pub(super) fn around(self, around: [f64; 4]) -> HeightFile<'a> {
        let window = self.georef.window_within(around);
        HeightFile { window, georef: self.georef.part(window), ..self }
    }

    /// Limits the file to the cells under those of another grid; where the grids agree, to the same
    /// cells.
    pub(super) fn under(self, (surface, grid): (&Input, &GeoRef)) -> Result<HeightFile<'a>> {
        let window = self.georef.window_of(grid).or_else(|| self.georef.window_over(grid));
        let window = window.ok_or_else(|| no_terrain_below((surface, grid), (self.input, &self.georef)))?;
        Ok(HeightFile { window, georef: self.georef.part(window), ..self })
    }

    /// Returns the grid of the cells.
    pub(super) fn georef(&self) -> &GeoRef {
        &self.georef
    }

    /// Returns the file, if its coordinates can be used for a scene as they are.
    pub(super) fn in_meters(self, warnings: &mut Vec<Warning>) -> Result<HeightFile<'a>> {
        check_grid(self.input, &self.georef, warnings)?;
        Ok(self)
    }

    /// Reads all heights.
    pub(super) fn read(self, always_hash: bool, warnings: &mut Vec<Warning>) -> Result<Heights> {
        let HeightFile { input, file, window, georef } = self;
        let is_part = window != file.georef().window();
        let plain = file.read_plain_heights(window, warnings);
        let heights = match plain.transpose() {
            Some(plain) => plain.map(|(raster, n_void)| (raster.into_cells(), n_void)),
            None => lattice_heights((input, &file, window), warnings),
        };
        let (cells, n_void) = match heights {
            // A part without heights is no fault of the file.
            Err(Error::Read(error)) if is_part && matches!(error.fault, ReadFault::AllVoid(..)) => {
                (vec![VOID; georef.n_cells()].into(), georef.n_cells() as u64)
            }
            heights => heights?,
        };
        let sources = sources_of_raster(input, &file, always_hash, warnings)?;
        Ok(Heights { raster: Raster::new(georef, cells), n_void, sources })
    }

    /// Copies all heights to tiles on disk. Memory is that of a row of tiles, and of a row of
    /// blocks of the file.
    pub(super) fn store(self, scratch: &Path, always_hash: bool, warnings: &mut Vec<Warning>) -> Result<StoredHeights> {
        let HeightFile { input, file, window, georef } = self;
        if let Some((tiles, n_void)) = store_plain(&file, window, scratch)? {
            let sources = sources_of_raster(input, &file, always_hash, warnings)?;
            return Ok(StoredHeights { tiles, georef, n_void, sources });
        }
        let mut writer = TileStoreWriter::create(scratch, (georef.n_rows(), georef.n_cols()))?;
        let mut sorted = LatticeHeights::of(&file);
        let mut steps = vec![VOID; georef.n_cols()];
        let mut failed = Ok(());
        file.for_each_row(warnings, |row, heights| {
            let Some(row) = row.checked_sub(window.row).filter(|row| *row < window.n_rows && failed.is_ok()) else {
                return;
            };
            let heights = &heights[window.col..window.col + window.n_cols];
            steps.iter_mut().zip(heights).for_each(|(steps, height)| *steps = sorted.put(*height));
            failed = writer.put_row(row, &steps);
        })?;
        failed?;
        let n_void = sorted.finish(input)?;
        let sources = sources_of_raster(input, &file, always_hash, warnings)?;
        Ok(StoredHeights { tiles: writer.finish()?, georef, n_void, sources })
    }
}

/// Copies heights that are stored plainly to tiles on disk, and returns the number of cells without
/// one. `None` for other files, and where no cell has a height.
fn store_plain(file: &RasterFile, window: CellWindow, scratch: &Path) -> Result<Option<(TileStore, u64)>> {
    let mut writer = TileStoreWriter::create(scratch, (window.n_rows, window.n_cols))?;
    let mut n_void = 0;
    let mut first = 0;
    while first < window.n_rows {
        // Rows end at multiples in the file, so that no block is decoded twice.
        let n_rows = (ROWS_AT_ONCE - (window.row + first) % ROWS_AT_ONCE).min(window.n_rows - first);
        let rows = CellWindow { row: window.row + first, n_rows, ..window };
        match file.read_plain_heights(rows, &mut Vec::new()) {
            Ok(None) => return Ok(None),
            Ok(Some((heights, n))) => {
                n_void += n;
                (0..rows.n_rows).try_for_each(|row| writer.put_row(first + row, heights.row(row)))?;
            }
            Err(Error::Read(error)) if matches!(error.fault, ReadFault::AllVoid(..)) => {
                n_void += (rows.n_rows * rows.n_cols) as u64;
                let row = vec![VOID; rows.n_cols];
                (0..rows.n_rows).try_for_each(|k| writer.put_row(first + k, &row))?;
            }
            Err(error) => return Err(error),
        }
        first += n_rows;
    }
    let n_cells = (window.n_rows * window.n_cols) as u64;
    Ok(if n_void < n_cells { Some((writer.finish()?, n_void)) } else { None })
}

/// Number of rows that are read at once while heights are copied: those of a tile in most files.
const ROWS_AT_ONCE: usize = 256;

/// Reads the heights of a part of a file onto the lattice, with the number of cells that have none.
fn lattice_heights(
    (input, file, window): (&Input, &RasterFile, CellWindow),
    warnings: &mut Vec<Warning>,
) -> Result<(LargeVec<i32>, u64)> {
    let mut sorted = LatticeHeights::of(file);
    let raster = file.read(window, warnings, |height| sorted.put(height))?;
    let n_void = sorted.finish(input)?;
    Ok((raster.into_cells(), n_void))
}

/// Conversion of heights to the lattice one by one.
struct LatticeHeights {
    meters_per_unit: f64,
    n_void: u64,
    out_of_range: Option<f64>,
}

impl LatticeHeights {
    fn of(file: &RasterFile) -> Self {
        let meters_per_unit = file.meters_per_height_unit().unwrap_or(1.0);
        LatticeHeights { meters_per_unit, n_void: 0, out_of_range: None }
    }

    /// Returns a height on the lattice, [`VOID`] where there is none.
    #[inline]
    fn put(&mut self, height: f64) -> i32 {
        let height = height * self.meters_per_unit;
        let steps = if height.is_nan() { None } else { height_steps(height) };
        if steps.is_none() {
            self.n_void += 1;
            if !height.is_nan() {
                self.out_of_range.get_or_insert(height);
            }
        }
        steps.unwrap_or(VOID)
    }

    /// Returns the number of cells without a height.
    fn finish(self, input: &Input) -> Result<u64> {
        if let Some(v) = self.out_of_range {
            return Err(Error::read(input, ReadFault::HeightRange(HeightOf::Cell, v)));
        }
        Ok(self.n_void)
    }
}

/// Returns `true` when a warning is about lengths in web Mercator.
pub(super) fn is_of_web_mercator(warning: &Warning) -> bool {
    matches!(warning, Warning::Raster(odd) if odd.is_web_mercator())
}

/// Warns where coordinates are not meters.
pub(super) fn warn_of_units(input: &Input, crs: &Crs, warnings: &mut Vec<Warning>) {
    if let CrsKind::Projected { meters_per_unit } = crs.kind()
        && (meters_per_unit - 1.0).abs() > 1e-9
    {
        warnings.push(Warning::of(input, OddFile::NotInMeters(meters_per_unit)));
    }
}

/// Checks that a grid can be used for a scene.
pub(super) fn check_grid(input: &Input, georef: &GeoRef, warnings: &mut Vec<Warning>) -> Result<()> {
    let Some(crs) = georef.crs() else { return Ok(()) };
    refuse_degrees(input, crs, [georef.x_min(), georef.y_min(), georef.x_max(), georef.y_max()], InputKind::Raster)?;
    warn_of_units(input, crs, warnings);
    if georef.n_cols().max(georef.n_rows()) as f64 > MAX_EXTENT_UNITS {
        warnings.push(Warning::of(input, OddFile::ManyCells));
    }
    Ok(())
}
