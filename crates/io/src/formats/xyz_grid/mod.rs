//! XYZ grid (`.xyz`, `.txt`): a line `x y z` for each cell, as surveys and GDAL write heights.
//!
//! Numbers are separated by blanks, tabs, commas or semicolons, and have a decimal point. Lines
//! before the first point are a heading. Lines come in any order: by rows from the north or the
//! south, or by columns. Cells may be missing.
//!
//! A position is always taken for the center of its cell. Some surveys write corners instead, which
//! no byte of a file shows: such a file lies half a cell off to the south-west. The grid is found
//! from the positions, as [`lattice`] describes. A cell without a line has no height, nor has one
//! with the height -9999, as in an Esri ASCII grid without a declared value. The coordinate
//! reference system is in a file of the same name with the ending `.prj`.
//!
//! The file is read twice as a stream: once for the grid, once for the heights. Rows from north to
//! south take the memory of one row beside the requested cells; other orders that of all of them.

mod lattice;
mod points;

use lattice::{Lattice, Survey};
use points::Points;
pub(crate) use points::begins_with_points;

use super::ascii_grid::{DEFAULT_NODATA, sidecar_crs};
use super::oddity::with_true_lengths;
use super::reserve::{check_cells, reserve_cells};
use super::voids::Voids;
use crate::error::{Cause, Error, OddRaster, Oddity, Place, ReadFault, Result, Warning};
use crate::input::Input;
use crate::raster::{CellWindow, GeoRef, Raster};

/// Number that no text gives: a cell without a line.
const NO_LINE: u64 = 0x7ff8_0000_0000_0001;

/// XYZ grid whose positions have been read and put on a lattice.
#[derive(Debug, Clone)]
pub struct XyzGrid {
    input: Input,
    georef: GeoRef,
    lattice: Lattice,
    n_points: u64,
    /// `true` if the lines come by rows from the north.
    is_from_north: bool,
}

impl XyzGrid {
    /// Opens a file and reads the positions of its points.
    pub(super) fn open_told(input: &Input, odd: &mut Vec<Oddity>) -> Result<XyzGrid> {
        let mut survey = Survey::default();
        let mut points = Points::open(input)?;
        while let Some([x, y, _]) = points.next()? {
            survey.add([x, y], points.line());
        }
        let lattice = survey.lattice(input)?;
        let crs = sidecar_crs(input, odd);
        if crs.is_none() {
            odd.push(Oddity::new(input, OddRaster::NoPrj));
        }
        let georef = lattice.georef().ok_or_else(|| survey.irregular(input, &lattice))?;
        let georef = with_true_lengths(georef.with_crs(crs), &mut |of_grid| odd.push(Oddity::new(input, of_grid)));
        let (n_points, is_from_north) = (survey.n_points(), survey.is_from_north());
        Ok(XyzGrid { input: input.clone(), georef, lattice, n_points, is_from_north })
    }

    /// Returns the grid of the cells.
    pub fn georef(&self) -> &GeoRef {
        &self.georef
    }

    /// Returns the encoding in a few words.
    pub fn description(&self) -> String {
        format!("XYZ grid of {} points", self.n_points)
    }

    /// Returns the memory of reading beyond the requested cells \[bytes\].
    pub(super) fn block_bytes(&self) -> u64 {
        let n_cells = if self.is_from_north { self.georef.n_cols() } else { self.georef.n_cells() };
        (n_cells * size_of::<f64>()) as u64
    }

    /// Returns the value of cells without a height.
    pub(super) fn nodata(&self) -> f64 {
        DEFAULT_NODATA
    }

    /// Reads a part as [`super::RasterFile::read`] does, row by row from the north.
    pub fn read<T: bytemuck::Pod>(
        &self,
        window: CellWindow,
        warnings: &mut Vec<Warning>,
        mut convert: impl FnMut(f64) -> T,
    ) -> Result<Raster<T>> {
        let part = self.georef.part(window);
        let mut cells = reserve_cells(&self.input, &part)?;
        let mut voids = Voids::new(Some(self.nodata()));
        self.for_each_stored(window, |row, col, stored| cells.push(convert(voids.height(row, col, stored))))?;
        voids.report(&self.input, warnings)?;
        Ok(Raster::new(part, cells))
    }

    /// Calls `visit` with row, column and number of each cell of a part, row by row from the north.
    ///
    /// # Errors
    /// E302 for two heights of one cell; E307 for a point that lies on no center.
    pub(super) fn for_each_stored(&self, window: CellWindow, mut visit: impl FnMut(usize, usize, f64)) -> Result<()> {
        let CellWindow { row: first, col: west, n_rows, n_cols } = window;
        let n_held = if self.is_from_north { 1 } else { n_rows };
        check_cells::<f64>(&self.input, &self.georef.part(CellWindow { n_rows: n_held, ..window }))?;
        let mut rows = Rows { held: vec![f64::from_bits(NO_LINE); n_held * n_cols], first, n_cols };
        let mut points = Points::open(&self.input)?;
        while let Some([x, y, z]) = points.next()? {
            let (row, col) = self.lattice.cell([x, y]).map_err(|found| {
                irregular(&self.input, format!("{found}, wanted points on a regular grid"), points.line())
            })?;
            if row < first || !(west..west + n_cols).contains(&col) {
                continue;
            }
            if row >= first + n_rows {
                // No row of the part follows those beyond it.
                if self.is_from_north {
                    break;
                }
                continue;
            }
            while row >= rows.first + n_held {
                rows.pass(west, &mut visit);
            }
            rows.put(row, col - west, z).map_err(|other| {
                let what = format!("height {z} at {x}, {y}, where a line before has {other}; wanted one height a cell");
                Error::malformed(&self.input, what).at(Place::Line(points.line()))
            })?;
        }
        while rows.first < first + n_rows {
            rows.pass(west, &mut visit);
        }
        Ok(())
    }
}

/// Returns E307 for points that are no grid.
fn irregular(input: &Input, what: String, line: u64) -> Error {
    Error::read(input, ReadFault::Irregular(what)).at(Place::Line(line)).because(Cause::PointCloud)
}

/// Rows that are filled while the lines are read.
struct Rows {
    /// Heights row by row; [`NO_LINE`] where no line was read.
    held: Vec<f64>,
    /// First row that is held.
    first: usize,
    n_cols: usize,
}

impl Rows {
    /// Puts a height into a row that is held; the error is another height that the cell has
    /// already.
    fn put(&mut self, row: usize, col: usize, z: f64) -> std::result::Result<(), f64> {
        let cell = row.checked_sub(self.first).and_then(|row| self.held.get_mut(row * self.n_cols + col));
        // Other rows appear only where a file changes while it is read.
        let Some(cell) = cell else { return Ok(()) };
        if cell.to_bits() != NO_LINE && cell.to_bits() != z.to_bits() {
            return Err(*cell);
        }
        *cell = z;
        Ok(())
    }

    /// Visits all rows that are held, and holds as many empty ones behind them.
    fn pass(&mut self, west: usize, visit: &mut impl FnMut(usize, usize, f64)) {
        for (row, cells) in (self.first..).zip(self.held.chunks_exact_mut(self.n_cols)) {
            for (col, cell) in (west..).zip(cells) {
                visit(row, col, if cell.to_bits() == NO_LINE { DEFAULT_NODATA } else { *cell });
                *cell = f64::from_bits(NO_LINE);
            }
        }
        self.first += self.held.len() / self.n_cols;
    }
}
