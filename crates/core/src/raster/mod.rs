//! Rasters in memory: rows of cells on a georeferenced grid, sets of cells, and coordinate
//! reference systems.
//!
//! Rows run north to south and columns west to east, in every file and every array. A cell is an
//! area, and its value holds for all of it.

mod bit_grid;
mod cell_blocks;
mod cell_lattice;
mod crs;
mod georef;
mod hillshade;
mod large_vec;
mod row_runs;

use bytemuck::Pod;

pub(crate) use bit_grid::bits_between;
pub use bit_grid::{BitGrid, n_common, set_bits};
pub use cell_blocks::CellBlocks;
pub use cell_lattice::CellLattice;
pub use crs::{Crs, CrsDefinition, CrsKind};
pub use georef::{CellWindow, GeoRef};
pub use hillshade::Surface;
pub use large_vec::LargeVec;
pub use row_runs::{CELLS_PER_RUN, RowGroup, RowRuns};

/// A grid of values, row by row from the north-west cell: shape `[n_rows, n_cols]`, columns running
/// fastest.
#[derive(Debug, Clone, PartialEq)]
pub struct Raster<T: Pod> {
    georef: GeoRef,
    cells: LargeVec<T>,
}

impl<T: Pod> Raster<T> {
    /// Makes a raster from its cells.
    pub fn new(georef: GeoRef, cells: impl Into<LargeVec<T>>) -> Self {
        let cells = cells.into();
        assert_eq!(cells.len(), georef.n_cells(), "a raster holds one value per cell of its grid");
        Raster { georef, cells }
    }

    /// Returns the grid of the cells.
    pub fn georef(&self) -> &GeoRef {
        &self.georef
    }

    /// Returns all values, row by row from the north-west cell.
    pub fn cells(&self) -> &[T] {
        &self.cells
    }

    /// Returns all values as runs, if they are known as such.
    pub fn runs(&self) -> Option<&RowRuns<T>> {
        self.cells.runs()
    }

    /// Returns one row of values; row 0 is the northernmost.
    pub fn row(&self, row: usize) -> &[T] {
        let n_cols = self.georef.n_cols();
        &self.cells[row * n_cols..(row + 1) * n_cols]
    }

    /// Returns the values without their grid.
    pub fn into_cells(self) -> LargeVec<T> {
        self.cells
    }
}
