//! What the cells of the receivers' grid are, as sets, and what receivers stand on there.

use std::borrow::Cow;

use rayon::prelude::*;

use super::{CellKind, HeightField};
use crate::quantity::VOID;
use crate::raster::BitGrid;

/// The cells of open ground and those of buildings; all others are void.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CellSets {
    /// Open ground.
    pub open: BitGrid,
    /// Buildings.
    pub building: BitGrid,
}

impl CellSets {
    /// The sets of a field, by asking for each cell what it is.
    pub(super) fn of(field: &HeightField) -> Self {
        let grid = field.grid();
        let (n_rows, n_cols) = (grid.n_rows(), grid.n_cols());
        let positions = field.positions();
        let (mut open, mut building) = (BitGrid::new(n_rows, n_cols), BitGrid::new(n_rows, n_cols));
        let per_row = open.words_per_row();
        let rows = open.words_mut().par_chunks_mut(per_row).zip(building.words_mut().par_chunks_mut(per_row));
        rows.enumerate().for_each(|(row, (open, building))| {
            for col in 0..n_cols {
                match field.cell_kind(row * n_cols + col, &positions.center(row, col)) {
                    CellKind::Open(_) => open[col / 64] |= 1 << (col % 64),
                    CellKind::Building(_) => building[col / 64] |= 1 << (col % 64),
                    CellKind::Void => {}
                }
            }
        });
        CellSets { open, building }
    }
}

/// Heights of what receivers stand on \[1/1024 m above the datum\].
#[derive(Debug, Clone)]
pub enum StandsOn<'a> {
    /// One height for all cells.
    Flat(i32),
    /// A height for each cell, row by row from the north-west; only those of the cells in question mean anything.
    Cells(Cow<'a, [i32]>),
}

impl HeightField {
    /// The ground under the open cells.
    pub fn ground_of_cells(&self) -> StandsOn<'_> {
        if let Some(z) = self.flat_ground() {
            return StandsOn::Flat(z);
        }
        if let Some(cells) = self.ground_on_grid() {
            return StandsOn::Cells(Cow::Borrowed(cells));
        }
        // A terrain on a grid of its own.
        let n_cols = self.grid().n_cols();
        let positions = self.positions();
        let mut ground = vec![VOID; self.grid().n_cells()];
        ground.par_chunks_mut(n_cols).enumerate().for_each(|(row, ground)| {
            for (col, ground) in ground.iter_mut().enumerate() {
                *ground = self.ground_at(&positions.center(row, col));
            }
        });
        StandsOn::Cells(Cow::Owned(ground))
    }

    /// The roofs of the building cells.
    pub fn roof_of_cells(&self) -> StandsOn<'_> {
        StandsOn::Cells(Cow::Borrowed(self.roofs_on_grid()))
    }
}
