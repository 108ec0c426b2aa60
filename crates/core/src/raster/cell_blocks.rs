//! Square blocks of cells, which are drawn together when a map is resampled.

use super::GeoRef;

/// A grid cut into square blocks of cells, row by row from the north-west. Blocks at the south and
/// east border may be smaller.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellBlocks {
    /// Rows and columns of a block.
    block: (usize, usize),
    n_per_row: usize,
    n_blocks: usize,
}

impl CellBlocks {
    /// Makes blocks whose edge is the whole number of cells nearest to `side_m` \[m\], at least
    /// one.
    pub fn new(grid: &GeoRef, meters_per_unit: f64, side_m: f64) -> Self {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at least 1, and saturating")]
        let cells = |cell: f64| (side_m / (cell * meters_per_unit)).round().max(1.0) as usize;
        let block = (cells(grid.cell_height()), cells(grid.cell_width()));
        let n_per_row = grid.n_cols().div_ceil(block.1);
        CellBlocks { block, n_per_row, n_blocks: n_per_row * grid.n_rows().div_ceil(block.0) }
    }

    /// Returns the number of blocks.
    #[inline]
    pub fn count(&self) -> usize {
        self.n_blocks
    }

    /// Returns the westernmost block of a row of cells.
    #[inline]
    pub fn first_of_row(&self, row: usize) -> usize {
        row / self.block.0 * self.n_per_row
    }

    /// Returns the number of columns of cells in a block.
    #[inline]
    pub fn n_cols(&self) -> usize {
        self.block.1
    }
}
