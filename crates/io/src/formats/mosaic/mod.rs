//! Mosaics: one raster made of many, as a GDAL virtual raster (`.vrt`) or a folder of tiles.
//!
//! * A **virtual raster** says where each part of each source goes. It is read as GDAL reads it, number for number: cells
//!   in no source hold its nodata value (0 if it has none, which is told), later sources lie over earlier ones, a
//!   `ComplexSource` leaves out its own nodata value and scales the rest, numbers are rounded to the type of the band. Of
//!   the tiles only the numbers count, not their nodata value, scale, mask or place.
//! * Of a **folder** every `.tif`, `.tiff` and `.asc` file in it is a tile, in the order of their names; other files,
//!   folders in it and names that begin with a dot are left alone. The tiles lie on one grid, to a thousandth of a cell.
//!   Where they overlap the later one counts where it holds a height, and cells that differ are told. Cells in no tile
//!   are nodata.
//!
//! Opening reads the headers of all tiles and keeps little of each; no file stays open. Reading a window opens the tiles
//! that touch it, so that it costs what the window costs; several threads may read at once.
//!
//! Codes are those of the GeoTIFF reader, and: E308 a folder without rasters; E311 tiles in different reference systems;
//! E307 tiles on different grids; W336 overlapping tiles that differ, W337 cells in no source of a virtual raster without
//! a nodata value.
//!
//! # References
//! GDAL, "VRT -- GDAL Virtual Format"; the rules of rounding are those of GDAL 3.6.

mod covered;
mod folder;
mod numbers;
mod placed;
mod tile;
mod vrt;
mod vrt_source;

use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicUsize;

use numbers::Rule;
use tile::Tile;

use super::file::reserve_cells;
use super::sample::Sample;
use super::voids::Voids;
use crate::crs::VerticalCrs;
use crate::error::{Result, Warning};
use crate::quantity::counted;
use crate::raster::{CellWindow, GeoRef, Raster};

/// Cells that are put together at a time, unless one row has more.
const BAND_CELLS: usize = 1 << 24;
/// Most virtual rasters inside of each other.
const MAX_DEPTH: usize = 4;
/// Most columns or rows, as in GDAL.
const MAX_SIDE: f64 = 2_147_483_647.0;

/// Where a file stands among virtual rasters that are in each other.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nesting<'a> {
    /// Those that it is in, outermost first.
    pub(super) ancestors: &'a [PathBuf],
    /// Files that were opened for all but the outermost.
    pub(super) n_opened: &'a AtomicUsize,
}

/// A raster made of many, the headers of its tiles read and checked.
#[derive(Debug, Clone)]
pub struct Mosaic {
    path: PathBuf,
    kind: Kind,
    georef: GeoRef,
    tiles: Vec<Tile>,
    /// In the order in which they lie over each other, the lowest first.
    pieces: Vec<Piece>,
    /// The number of cells in no tile.
    empty: f64,
    /// The number of cells without a height.
    nodata: Option<f64>,
    /// Factor and summand that turn numbers into heights.
    scaling: (f64, f64),
    meters_per_height_unit: Option<f64>,
    vertical: Option<VerticalCrs>,
    /// Cells in no tile.
    n_gaps: u64,
}

/// What a mosaic was opened from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    VirtualRaster { numbers: Sample, n_bands: usize },
    Folder,
}

/// A part of a tile, or all of it, in its place.
#[derive(Debug, Clone)]
struct Piece {
    /// Index of the tile, and its band.
    tile: usize,
    band: usize,
    /// Row and column of the mosaic at which the tile would begin.
    row: i64,
    col: i64,
    /// The cells of the mosaic that it covers, inside of both.
    area: CellWindow,
    rule: Rule,
}

/// What tiles of a folder hold that deserves a word.
#[derive(Debug, Default)]
struct Oddities {
    /// Times that a height was laid over another one.
    n_differing: u64,
    /// Cells of tiles that hold NaN or an infinite number.
    n_not_finite: u64,
}

impl Mosaic {
    /// Where the cells lie.
    pub fn georef(&self) -> &GeoRef {
        &self.georef
    }

    /// Meters per unit of height, where the virtual raster or the tiles say so; [`Mosaic::read`] converts nothing.
    pub fn meters_per_height_unit(&self) -> Option<f64> {
        self.meters_per_height_unit
    }

    /// What heights are above, where a tile names it.
    pub fn vertical(&self) -> Option<&VerticalCrs> {
        self.vertical.as_ref()
    }

    /// What it is made of, in a few words: `mosaic of 24 tiles, 1200 cells in no tile`.
    pub fn description(&self) -> String {
        let tiles = counted(self.tiles.len() as u64, "tile", "tiles");
        let mut text = match self.kind {
            Kind::VirtualRaster { numbers, .. } => format!("virtual raster of {tiles}, {}", numbers.name()),
            Kind::Folder => format!("mosaic of {tiles}"),
        };
        if let (Kind::VirtualRaster { .. }, Some(nodata)) = (self.kind, self.nodata) {
            text += &format!(", nodata {nodata}");
        }
        if self.n_gaps > 0 {
            text += &format!(", {} in no tile", counted(self.n_gaps, "cell", "cells"));
        }
        text
    }

    /// The files of the tiles, each once, in their order.
    pub fn tile_paths(&self) -> Vec<&Path> {
        let mut paths: Vec<&Path> = Vec::with_capacity(self.tiles.len());
        let mut seen = std::collections::HashSet::new();
        for tile in &self.tiles {
            paths.extend(std::iter::once(tile.path.as_path()).chain(tile.parts()).filter(|path| seen.insert(*path)));
        }
        paths
    }

    /// Reads a part of the mosaic; `convert` turns a height into what the raster holds, row by row from the north.
    ///
    /// Cells that hold no height arrive in `convert` as NaN. Memory is that of the result and of one band of rows.
    ///
    /// # Errors
    /// If the part does not fit in memory, a tile cannot be read or decoded (the error names it), or no cell of the part
    /// holds a height.
    ///
    /// # Panics
    /// If `window` is empty or reaches beyond the grid.
    pub fn read<T: bytemuck::Pod>(
        &self,
        window: CellWindow,
        warnings: &mut Vec<Warning>,
        mut convert: impl FnMut(f64) -> T,
    ) -> Result<Raster<T>> {
        let georef = self.georef.part(window);
        let mut cells = reserve_cells(&self.path, &georef)?;
        let mut voids = Voids::new(self.nodata);
        let (scale, offset) = self.scaling;
        let odd = self.for_each_number(window, |row, col, number| {
            cells.push(convert(voids.height(row, col, number) * scale + offset));
        })?;
        self.warn(&odd, warnings);
        voids.report(&self.path, warnings)?;
        Ok(Raster::new(georef, cells))
    }

    /// Calls `visit` with row, column and number of each cell of a part, row by row from the north.
    fn for_each_number(&self, window: CellWindow, mut visit: impl FnMut(usize, usize, f64)) -> Result<Oddities> {
        let mut odd = Oddities::default();
        let mut rest = window;
        while rest.n_rows > 0 {
            let band = CellWindow { n_rows: self.rows_at_once(rest), ..rest };
            let numbers = self.put_together(band, &mut odd)?;
            for (row, numbers) in (band.row..).zip(numbers.chunks_exact(band.n_cols)) {
                (band.col..).zip(numbers).for_each(|(col, number)| visit(row, col, *number));
            }
            rest = CellWindow { row: rest.row + band.n_rows, n_rows: rest.n_rows - band.n_rows, ..rest };
        }
        Ok(odd)
    }

    /// How many of the first rows of a window to put together: up to the edge of a tile where one is near, so that no tile
    /// is opened twice without need.
    fn rows_at_once(&self, window: CellWindow) -> usize {
        let most = (BAND_CELLS / window.n_cols).clamp(1, window.n_rows);
        if most == window.n_rows {
            return most;
        }
        let ends = self.pieces.iter().filter(|piece| overlap(piece.area, window).is_some()).map(|piece| {
            let end = piece.area.row + piece.area.n_rows;
            end.saturating_sub(window.row)
        });
        ends.filter(|rows| (1..=most).contains(rows)).max().unwrap_or(most)
    }

    /// The numbers of a window, row by row.
    fn put_together(&self, window: CellWindow, odd: &mut Oddities) -> Result<Vec<f64>> {
        let mut numbers = reserve_cells(&self.path, &self.georef.part(window))?;
        numbers.resize(window.n_rows * window.n_cols, self.empty);
        for piece in &self.pieces {
            if let Some(area) = overlap(piece.area, window) {
                self.lay(piece, area, (window, &mut numbers), odd)?;
            }
        }
        Ok(numbers)
    }

    /// Lays the part of a piece that covers `area` over what is there.
    fn lay(
        &self,
        piece: &Piece,
        area: CellWindow,
        (window, numbers): (CellWindow, &mut [f64]),
        odd: &mut Oddities,
    ) -> Result<()> {
        let tile = &self.tiles[piece.tile];
        // `area` lies inside of the tile, so neither difference is negative.
        let in_tile = |at: usize, origin: i64| usize::try_from(at as i128 - i128::from(origin)).unwrap_or(0);
        let part = CellWindow { row: in_tile(area.row, piece.row), col: in_tile(area.col, piece.col), ..area };
        let is_folder = self.kind == Kind::Folder;
        let laid = tile.for_each_stored(piece.band, part, |row, col, stored| {
            let (row, col) = (area.row - window.row + (row - part.row), area.col - window.col + (col - part.col));
            let at = &mut numbers[row * window.n_cols + col];
            match piece.rule.number(tile, stored) {
                Some(number) => {
                    if is_folder {
                        odd.n_differing += u64::from(differ(*at, number));
                    }
                    *at = number;
                }
                None if is_folder => odd.n_not_finite += u64::from(tile.is_not_finite(stored)),
                None => {}
            }
        });
        laid.map_err(|error| error.within(format!("a tile of `{}`", self.path.display())))
    }

    fn warn(&self, odd: &Oddities, warnings: &mut Vec<Warning>) {
        let path = self.path.display();
        if let Kind::VirtualRaster { n_bands: n_bands @ 2.., .. } = self.kind {
            warnings.push(Warning::new(323, format!("`{path}` has {n_bands} bands: the first is read as heights")));
        }
        if odd.n_differing > 0 {
            let heights = counted(odd.n_differing, "height lies", "heights lie");
            let text = format!(
                "tiles of `{path}` overlap and differ: {heights} under another one of a later tile by name, which counts (a folder should hold one raster of each place)"
            );
            warnings.push(Warning::new(336, text));
        }
        if odd.n_not_finite > 0 {
            let cells = counted(odd.n_not_finite, "cell", "cells");
            let text = format!("tiles of `{path}` have {cells} with NaN or an infinite height: read as void");
            warnings.push(Warning::new(320, text));
        }
        if self.n_gaps > 0 && self.nodata.is_none() && self.kind != Kind::Folder {
            let cells = counted(self.n_gaps, "cell", "cells");
            let text = format!(
                "`{path}` has {cells} in no source and declares no nodata value: they are {} there, as in GDAL; give it one with `gdalbuildvrt -vrtnodata -9999`",
                self.empty
            );
            warnings.push(Warning::new(337, text));
        }
        if self.scaling != (1.0, 0.0) {
            let (scale, offset) = self.scaling;
            let text = format!("`{path}` stores its heights scaled: multiplied by {scale}, then {offset} added");
            warnings.push(Warning::new(333, text));
        }
    }
}

/// Whether a height is laid over another one; NaN is no height.
#[expect(clippy::float_cmp, reason = "copies of one height are equal to the last digit")]
fn differ(below: f64, above: f64) -> bool {
    !below.is_nan() && below != above
}

/// The cells that lie in both windows, if there are any.
fn overlap(a: CellWindow, b: CellWindow) -> Option<CellWindow> {
    let (row, col) = (a.row.max(b.row), a.col.max(b.col));
    let n_rows = (a.row + a.n_rows).min(b.row + b.n_rows).checked_sub(row)?;
    let n_cols = (a.col + a.n_cols).min(b.col + b.n_cols).checked_sub(col)?;
    (n_rows > 0 && n_cols > 0).then_some(CellWindow { row, col, n_rows, n_cols })
}
