//! Numbers of cells by kind, and ranges of heights.

use super::field::{CellKind, HeightField};
use crate::quantity::VOID;

/// Numbers of cells by kind, and ranges of heights \[1/1024 m above the datum\].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct CellCounts {
    /// Cells of open ground.
    pub open: u64,
    /// Cells of buildings.
    pub building: u64,
    /// Cells without data.
    pub void: u64,
    /// Lowest and highest ground; `None` without any.
    pub ground: Option<(i32, i32)>,
    /// Lowest and highest surface, roofs included; `None` without any.
    pub surface: Option<(i32, i32)>,
}

impl HeightField {
    /// Counts the cells.
    pub fn cell_counts(&self) -> CellCounts {
        let (grid, positions) = (self.grid(), self.positions());
        let mut counts = CellCounts::default();
        let widen = |range: &mut Option<(i32, i32)>, z: i32| {
            if z != VOID {
                let (a, b) = range.unwrap_or((z, z));
                *range = Some((a.min(z), b.max(z)));
            }
        };
        for row in 0..grid.n_rows() {
            for col in 0..grid.n_cols() {
                let center = positions.center(row, col);
                let surface = match self.cell_kind(row * grid.n_cols() + col, &center) {
                    CellKind::Open(z) => {
                        counts.open += 1;
                        z
                    }
                    CellKind::Building(z) => {
                        counts.building += 1;
                        z
                    }
                    CellKind::Void => {
                        counts.void += 1;
                        continue;
                    }
                };
                widen(&mut counts.surface, surface);
                widen(&mut counts.ground, self.ground_at(&center));
            }
        }
        counts
    }

    /// Returns the number of corners of the outlines that the cells of buildings have together.
    pub fn n_corners_of_cells(&self) -> u64 {
        self.cells_of_buildings().n_corners()
    }
}
