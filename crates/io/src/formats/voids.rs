//! Cells without a height, distinguished and counted while a raster is read.
//!
//! A declared nodata value is expected and gives no warning. NaN, infinities and numbers that look
//! like an undeclared nodata value are reported with the rectangle that they lie in. Cells of
//! missing blocks are reported by their number.

use std::fmt::Display;

use crate::error::{Cause, CellsFound, Error, OddRaster, Oddity, ReadFault, Result, Warning};

/// Heights at or below this, or at or above [`HIGHEST_LIKELY`], occur nowhere on Earth \[m or ft\].
pub(super) const LOWEST_LIKELY: f64 = -9000.0;
pub(super) const HIGHEST_LIKELY: f64 = 32_000.0;

/// Content of a file for one cell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Stored {
    /// A number, which may mean nodata.
    Number(f64),
    /// A number that a mask hides.
    Hidden(f64),
    /// Nothing: a sparse file leaves out the block of the cell.
    Nothing,
}

/// Returns `true` when a stored number means no height; NaN equals NaN.
#[inline]
#[expect(clippy::float_cmp, reason = "a nodata value is a pattern to recognize, not a quantity")]
pub(super) fn is_nodata(nodata: Option<f64>, number: f64) -> bool {
    nodata.is_some_and(|nodata| number == nodata || (number.is_nan() && nodata.is_nan()))
}

impl CellsFound {
    const NONE: CellsFound = CellsFound { count: 0, rows: (usize::MAX, 0), cols: (usize::MAX, 0) };

    #[cold]
    fn add(&mut self, row: usize, col: usize) {
        self.count += 1;
        self.rows = (self.rows.0.min(row), self.rows.1.max(row));
        self.cols = (self.cols.0.min(col), self.cols.1.max(col));
    }
}

/// Tally of one read.
#[derive(Debug)]
pub(super) struct Voids {
    nodata: Option<f64>,
    /// Number of cells with a height.
    pub(super) n_heights: u64,
    /// Number of cells with the declared nodata value, or hidden by a mask.
    pub(super) n_nodata: u64,
    /// Number of cells of blocks that the file leaves out.
    pub(super) n_missing: u64,
    nan: CellsFound,
    infinite: CellsFound,
    unlikely: CellsFound,
}

impl Voids {
    /// Creates an empty tally; cells equal to `nodata` (NaN equals NaN) are void.
    pub(super) fn new(nodata: Option<f64>) -> Self {
        Voids {
            nodata,
            n_heights: 0,
            n_nodata: 0,
            n_missing: 0,
            nan: CellsFound::NONE,
            infinite: CellsFound::NONE,
            unlikely: CellsFound::NONE,
        }
    }

    /// Counts a cell and returns its height, NaN where it has none.
    #[inline]
    pub(super) fn height_of(&mut self, row: usize, col: usize, stored: Stored) -> f64 {
        match stored {
            Stored::Number(number) => return self.height(row, col, number),
            Stored::Hidden(_) => self.n_nodata += 1,
            Stored::Nothing => self.n_missing += 1,
        }
        f64::NAN
    }

    /// Counts a cell that holds a number and returns its height, NaN where the number is none.
    #[inline]
    pub(super) fn height(&mut self, row: usize, col: usize, stored: f64) -> f64 {
        if is_nodata(self.nodata, stored) {
            self.n_nodata += 1;
            return f64::NAN;
        }
        if !stored.is_finite() {
            if stored.is_nan() { &mut self.nan } else { &mut self.infinite }.add(row, col);
            return f64::NAN;
        }
        self.n_heights += 1;
        if stored <= LOWEST_LIKELY || stored >= HIGHEST_LIKELY {
            self.unlikely.add(row, col);
        }
        stored
    }

    /// Warns of oddities; fails if no cell has a height.
    pub(super) fn report(&self, name: &dyn Display, warnings: &mut Vec<Warning>) -> Result<()> {
        let n_voids = self.n_nodata + self.n_missing + self.nan.count + self.infinite.count;
        if self.n_heights == 0 {
            let read = ReadFault::AllVoid(n_voids, "read holds".into());
            let are_marked = self.n_nodata > 0 && self.nodata.is_some_and(|number| !number.is_nan());
            return Err(Error::read(name, read).because(if are_marked { Cause::Nodata } else { Cause::AsSaid }));
        }
        let found = |cells: CellsFound| (cells.count > 0).then_some(cells);
        let odd = [
            found(self.nan).map(OddRaster::NotNumbers),
            found(self.infinite).map(OddRaster::Infinite),
            found(self.unlikely).map(OddRaster::Unlikely),
            (self.n_missing > 0).then_some(OddRaster::Sparse(self.n_missing)),
        ];
        warnings.extend(odd.into_iter().flatten().map(|odd| Oddity::new(name, odd).into()));
        Ok(())
    }
}
