//! A mosaic: its tiles, the place of each part of them, and the assembly of a window. Little is
//! kept of each tile, since thousands are common.

use std::cell::{Cell, RefCell};
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::atomic::AtomicUsize;

use rayon::prelude::*;
use skyshed_request::Band;

use super::numbers::{Rule, TileNumbers};
use crate::crs::VerticalCrs;
use crate::error::{Cause, Error, OddPair, OddRaster, Oddity, ReadFault, Result, Warning};
use crate::formats::reserve::reserve_cells;
use crate::formats::sample::Sample;
use crate::formats::voids::{Stored, Voids, is_nodata};
use crate::formats::{AsciiGrid, GeoTiff, XyzGrid};
use crate::input::Input;
use crate::quantity::counted;
use crate::raster::{CellWindow, GeoRef, Raster};

/// Cells that are assembled at a time, unless one row has more.
const BAND_CELLS: usize = 1 << 24;
/// Largest number of columns or rows, as in GDAL.
pub(super) const MAX_SIDE: f64 = 2_147_483_647.0;

/// Position of a file among nested virtual rasters.
#[derive(Debug, Clone, Copy)]
pub(in crate::formats) struct Nesting<'a> {
    /// Band to read, where the caller can choose one.
    pub(in crate::formats) band: Option<&'a Band>,
    /// Virtual rasters that the file is in, outermost first.
    pub(in crate::formats) ancestors: &'a [PathBuf],
    /// Number of files that were opened for all virtual rasters but the outermost.
    pub(in crate::formats) n_opened: &'a AtomicUsize,
    /// Function that reads the header of a tile of any format.
    pub(in crate::formats) open: fn(&Input, Nesting<'_>) -> Result<Header>,
}

/// A raster made of many tiles, whose headers are read and checked.
#[derive(Debug, Clone)]
pub struct Mosaic {
    pub(super) path: PathBuf,
    pub(super) kind: Kind,
    /// Warning of a virtual raster of several bands, of which none was named.
    pub(super) of_bands: Option<OddRaster>,
    pub(super) georef: GeoRef,
    pub(super) tiles: Vec<Tile>,
    /// Pieces in the order in which they lie over each other, the lowest first.
    pub(super) pieces: Vec<Piece>,
    /// Value of cells in no tile.
    pub(super) empty: f64,
    /// Value of cells without a height.
    pub(super) nodata: Option<f64>,
    /// Factor and summand that turn numbers into heights.
    pub(super) scaling: (f64, f64),
    pub(super) meters_per_height_unit: Option<f64>,
    pub(super) vertical: Option<VerticalCrs>,
    /// Number of cells in no tile.
    pub(super) n_gaps: u64,
}

/// Kind of a mosaic, by its source.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    VirtualRaster { numbers: Sample },
    Folder,
}

/// A part of a tile, or all of it, in its place.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    /// Index of the tile, and its band.
    pub(super) tile: usize,
    pub(super) band: usize,
    /// Row and column of the mosaic at which the tile would begin.
    pub(super) row: i64,
    pub(super) col: i64,
    /// Cells of the mosaic that the piece covers, inside of both.
    pub(super) area: CellWindow,
    pub(super) rule: Rule,
}

/// Counts of oddities in tiles of a folder.
#[derive(Debug, Default)]
struct Oddities {
    /// Number of times that a height was laid over a different one.
    n_differing: u64,
    /// Number of cells of tiles with NaN or an infinite number.
    n_not_finite: u64,
}

impl Mosaic {
    /// Returns the grid of the cells.
    pub fn georef(&self) -> &GeoRef {
        &self.georef
    }

    /// Returns the meters per unit of height, where the virtual raster or the tiles name it;
    /// [`Mosaic::read`] converts nothing.
    pub fn meters_per_height_unit(&self) -> Option<f64> {
        self.meters_per_height_unit
    }

    /// Returns the vertical system, where a tile names it.
    pub fn vertical(&self) -> Option<&VerticalCrs> {
        self.vertical.as_ref()
    }

    /// Returns the meaning of its numbers.
    pub(in crate::formats) fn numbers(&self) -> TileNumbers {
        TileNumbers { band: 0, nodata: self.nodata, scaling: self.scaling }
    }

    /// Returns its content in a few words: `mosaic of 24 tiles, 1200 cells in no tile`.
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

    /// Returns the files of the tiles, or the archives that they lie in, each once, in their order.
    pub fn tile_paths(&self) -> Vec<&Path> {
        let mut paths: Vec<&Path> = Vec::with_capacity(self.tiles.len());
        let mut seen = std::collections::HashSet::new();
        for tile in &self.tiles {
            let own = tile.input.on_disk().as_path();
            paths.extend(std::iter::once(own).chain(tile.parts()).filter(|path| seen.insert(*path)));
        }
        paths
    }

    /// Reads a part as [`crate::formats::RasterFile::read`] does; an error names the tile. Memory
    /// is that of the result and of one band of rows.
    pub fn read<T: bytemuck::Pod>(
        &self,
        window: CellWindow,
        warnings: &mut Vec<Warning>,
        mut convert: impl FnMut(f64) -> T,
    ) -> Result<Raster<T>> {
        let georef = self.georef.part(window);
        let mut cells = reserve_cells(&self.path.display(), &georef)?;
        let mut voids = Voids::new(self.nodata);
        let (scale, offset) = self.scaling;
        let work = Work::new(self);
        let odd = self.for_each_number(window, &work, |row, col, number| {
            cells.push(convert(voids.height(row, col, number) * scale + offset));
        })?;
        self.warn(&odd, warnings);
        voids.report(&self.path.display(), warnings)?;
        Ok(Raster::new(georef, cells))
    }

    /// Calls `visit` with row, column and number of each cell of a part, row by row from the north.
    fn for_each_number(
        &self,
        window: CellWindow,
        work: &Work,
        mut visit: impl FnMut(usize, usize, f64),
    ) -> Result<Oddities> {
        let mut odd = Oddities::default();
        let mut rest = window;
        while rest.n_rows > 0 {
            let band = CellWindow { n_rows: self.rows_at_once(rest), ..rest };
            let numbers = self.put_together(band, work, &mut odd)?;
            for (row, numbers) in (band.row..).zip(numbers.chunks_exact(band.n_cols)) {
                (band.col..).zip(numbers).for_each(|(col, number)| visit(row, col, *number));
            }
            rest = CellWindow { row: rest.row + band.n_rows, n_rows: rest.n_rows - band.n_rows, ..rest };
        }
        Ok(odd)
    }

    /// Returns the number of first rows of a window to assemble. It ends at the edge of a tile if
    /// one is near, so that no tile is opened twice without need.
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

    /// Returns the numbers of a window, row by row.
    fn put_together(&self, window: CellWindow, work: &Work, odd: &mut Oddities) -> Result<Vec<f64>> {
        let mut numbers = reserve_cells(&self.path.display(), &self.georef.part(window))?;
        numbers.resize(window.n_rows * window.n_cols, self.empty);
        for piece in &self.pieces {
            if let Some(area) = overlap(piece.area, window) {
                self.lay(piece, (area, work), (window, &mut numbers), odd)?;
            }
        }
        Ok(numbers)
    }

    /// Lays the part of a piece that covers `area` over earlier numbers.
    fn lay(
        &self,
        piece: &Piece,
        (area, work): (CellWindow, &Work),
        (window, numbers): (CellWindow, &mut [f64]),
        odd: &mut Oddities,
    ) -> Result<()> {
        let tile = &self.tiles[piece.tile];
        // `area` lies inside of the tile, so neither difference is negative.
        let in_tile = |at: usize, origin: i64| usize::try_from(at as i128 - i128::from(origin)).unwrap_or(0);
        let part = CellWindow { row: in_tile(area.row, piece.row), col: in_tile(area.col, piece.col), ..area };
        let is_folder = self.kind == Kind::Folder;
        let laid = tile.for_each_stored((piece.band, work), part, |row, col, stored| {
            let (row, col) = (area.row - window.row + (row - part.row), area.col - window.col + (col - part.col));
            let at = &mut numbers[row * window.n_cols + col];
            match piece.rule.number(tile.numbers, stored) {
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
        warnings.extend(self.of_bands.clone().map(|odd| Oddity::new(&path, odd).into()));
        if odd.n_differing > 0 {
            warnings.push(OddPair::TilesDiffer { folder: path.to_string(), n: odd.n_differing }.into());
        }
        if odd.n_not_finite > 0 {
            warnings.push(OddPair::TilesNotFinite { folder: path.to_string(), n: odd.n_not_finite }.into());
        }
        if self.n_gaps > 0 && self.nodata.is_none() && self.kind != Kind::Folder {
            warnings.push(Oddity::new(&path, OddRaster::Gaps { n: self.n_gaps, empty: self.empty }).into());
        }
        if self.scaling != (1.0, 0.0) {
            warnings.push(Oddity::new(path, OddRaster::Scaled(self.scaling.0, self.scaling.1)).into());
        }
    }
}

/// A raster of a mosaic.
#[derive(Debug, Clone)]
pub(in crate::formats) struct Tile {
    pub(in crate::formats) input: Input,
    pub(in crate::formats) n_rows: usize,
    pub(in crate::formats) n_cols: usize,
    pub(in crate::formats) numbers: TileNumbers,
    pub(in crate::formats) content: Content,
}

/// Kept content of a tile beside its place. The table of a GeoTIFF's blocks can be large, and is
/// read again.
#[derive(Debug, Clone)]
pub(in crate::formats) enum Content {
    GeoTiff,
    AsciiGrid(Box<AsciiGrid>),
    XyzGrid(Box<XyzGrid>),
    Mosaic(Box<Mosaic>),
}

/// Header of a tile, needed while the mosaic is put together.
#[derive(Debug)]
pub(in crate::formats) struct Header {
    pub(in crate::formats) tile: Tile,
    pub(in crate::formats) georef: GeoRef,
    pub(in crate::formats) n_bands: usize,
    pub(in crate::formats) meters_per_height_unit: Option<f64>,
    pub(in crate::formats) vertical: Option<VerticalCrs>,
    pub(in crate::formats) odd: Vec<Oddity>,
}

/// Reads the headers of all tiles, in parallel; the error is that of the first bad one.
///
/// `nesting` is that of the virtual raster that the tiles are in.
pub(super) fn read_headers(tiles: &[Input], nesting: Nesting<'_>) -> Result<Vec<Header>> {
    let headers: Vec<Result<Header>> = tiles.par_iter().map(|tile| (nesting.open)(tile, nesting)).collect();
    headers.into_iter().collect()
}

impl Tile {
    /// Calls `visit` with row, column and content of each cell of a part of one band; rows may come
    /// in any order.
    fn for_each_stored(
        &self,
        (band, work): (usize, &Work),
        window: CellWindow,
        mut visit: impl FnMut(usize, usize, Stored),
    ) -> Result<()> {
        match &self.content {
            Content::GeoTiff => {
                let tiff = work.opened(&self.input)?;
                let (n_rows, n_cols) = (tiff.georef().n_rows(), tiff.georef().n_cols());
                if (n_rows, n_cols, tiff.nodata_of(self.numbers.band).map(f64::to_bits))
                    != (self.n_rows, self.n_cols, self.numbers.nodata.map(f64::to_bits))
                {
                    return Err(Error::truncated(&self.input, "the file has changed since it was opened"));
                }
                work.take(tiff.n_cells_decoded(window), window)?;
                tiff.for_each_stored(band, window, visit)
            }
            Content::AsciiGrid(grid) => {
                work.take((self.n_rows * self.n_cols) as u64, window)?;
                grid.for_each_stored(window, |row, col, number| visit(row, col, Stored::Number(number)))
            }
            Content::XyzGrid(grid) => {
                work.take((self.n_rows * self.n_cols) as u64, window)?;
                grid.for_each_stored(window, |row, col, number| visit(row, col, Stored::Number(number)))
            }
            Content::Mosaic(mosaic) => {
                let visited = mosaic.for_each_number(window, work, |row, col, number| {
                    visit(row, col, Stored::Number(number));
                });
                visited.map(drop)
            }
        }
    }

    /// Returns `true` when a cell holds a number that is neither a height nor declared as nodata.
    fn is_not_finite(&self, stored: Stored) -> bool {
        matches!(stored, Stored::Number(number) if !number.is_finite() && !is_nodata(self.numbers.nodata, number))
    }

    /// Returns the files that the tile is made of, without itself.
    fn parts(&self) -> Vec<&Path> {
        match &self.content {
            Content::Mosaic(mosaic) => mosaic.tile_paths(),
            Content::GeoTiff | Content::AsciiGrid(_) | Content::XyzGrid(_) => Vec::new(),
        }
    }
}

/// Work that one reading of a mosaic may do, so that a tile that many sources name is not decoded
/// without end. A unit is the opening of a file, or the decoding of 8192 cells of which few are used.
#[derive(Debug)]
struct Work {
    left: Cell<u64>,
    /// Last file that was opened: many sources may name one file.
    last: RefCell<Option<(Input, Rc<GeoTiff>)>>,
    /// Name of the mosaic.
    name: PathBuf,
}

impl Work {
    /// Units allowed for any mosaic, in addition to [`Work::READINGS`].
    const MOST: u64 = 10_000;
    /// Times that all pieces may be read.
    const READINGS: u64 = 4;

    fn new(mosaic: &Mosaic) -> Work {
        let left = Cell::new(Work::MOST + Work::READINGS * Work::of_pieces(mosaic));
        Work { left, last: RefCell::default(), name: mosaic.path.clone() }
    }

    /// Opens a tile, unless it is the last one. Oddities of its header were reported when the mosaic
    /// was opened.
    fn opened(&self, input: &Input) -> Result<Rc<GeoTiff>> {
        let mut last = self.last.borrow_mut();
        if let Some((_, tiff)) = last.as_ref().filter(|(known, _)| known == input) {
            return Ok(Rc::clone(tiff));
        }
        let tiff = Rc::new(GeoTiff::open(input, &mut Vec::new())?);
        *last = Some((input.clone(), Rc::clone(&tiff)));
        Ok(tiff)
    }

    /// Returns the units of reading each piece of a mosaic, and of those that it is made of, once.
    fn of_pieces(mosaic: &Mosaic) -> u64 {
        let own = mosaic.pieces.iter().map(|piece| Work::of((piece.area.n_rows * piece.area.n_cols) as u64));
        let nested = mosaic.tiles.iter().map(|tile| match &tile.content {
            Content::Mosaic(mosaic) => Work::of_pieces(mosaic),
            Content::GeoTiff | Content::AsciiGrid(_) | Content::XyzGrid(_) => 0,
        });
        own.chain(nested).sum()
    }

    /// Returns the units of opening a file and decoding some cells.
    fn of(n_cells: u64) -> u64 {
        1 + n_cells / 8192
    }

    /// Takes the work of decoding cells of a tile for a window of it.
    ///
    /// # Errors
    /// E502 if more was done than the mosaic needs.
    fn take(&self, n_decoded: u64, window: CellWindow) -> Result<()> {
        let n_used = (window.n_rows * window.n_cols) as u64;
        let n_idle = n_decoded.saturating_sub(Work::READINGS * n_used);
        match self.left.get().checked_sub(Work::of(n_idle)) {
            Some(left) => {
                self.left.set(left);
                Ok(())
            }
            None => {
                let what = "too many sources name the same tiles, which would be read again and again".into();
                Err(Error::read(self.name.display(), ReadFault::TooMany(what)).because(Cause::ForGdal))
            }
        }
    }
}

/// Returns `true` when a height is laid over a different one; NaN is no height.
#[expect(clippy::float_cmp, reason = "copies of one height are equal to the last digit")]
fn differ(below: f64, above: f64) -> bool {
    !below.is_nan() && below != above
}

/// Returns the cells that lie in both windows, if there are any.
fn overlap(a: CellWindow, b: CellWindow) -> Option<CellWindow> {
    let (row, col) = (a.row.max(b.row), a.col.max(b.col));
    let n_rows = (a.row + a.n_rows).min(b.row + b.n_rows).checked_sub(row)?;
    let n_cols = (a.col + a.n_cols).min(b.col + b.n_cols).checked_sub(col)?;
    (n_rows > 0 && n_cols > 0).then_some(CellWindow { row, col, n_rows, n_cols })
}
