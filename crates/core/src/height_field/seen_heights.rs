//! Heights of cells as one UAV sees them: lower by how far a curved earth falls away from it.
//!
//! Drops are sums of a number for the column and one for the row, rounded to the lattice. No height
//! is lowered before it is needed: readers lower the cells that they copy.

use std::ops::Range;

use fearless_simd::{Level, Simd};
use rayon::prelude::*;

use super::curvature::Curvature;
use super::positions::{GridPositions, Place};
use super::tile_maxima::{TILE, TileMaxima};
use crate::dispatch;
use crate::quantity::{BLOCKS_ALL, STEPS_PER_UNIT, VOID, meters};
use crate::raster::{CellWindow, GeoRef, LargeVec};

/// Fall of the earth below a place's horizontal, for each cell of a grid.
#[derive(Debug, Clone)]
pub struct Drops {
    /// Shares of columns and rows \[1/1024 m\]; a cell is lowered by the sum of both, rounded.
    by_col: Vec<f64>,
    by_row: Vec<f64>,
}

/// Heights over a flat earth \[1/1024 m above the datum\].
#[derive(Debug, Clone, Copy)]
pub enum HeightsOf<'a> {
    /// One for all cells.
    One(i32),
    /// One for each cell of a grid, row by row from the north-west.
    Cells(&'a [i32]),
}

/// Heights of the cells of a grid as a UAV sees them.
#[derive(Debug, Clone, Copy)]
pub struct SeenHeights<'a> {
    /// Heights over a flat earth.
    pub heights: HeightsOf<'a>,
    /// Cells to a row.
    pub n_cols: usize,
    /// Drops of the cells; `None` over a flat earth.
    pub drops: Option<&'a Drops>,
}

impl<'a> SeenHeights<'a> {
    /// Returns heights of cells over a flat earth.
    pub fn over_flat_earth(cells: &'a [i32], n_cols: usize) -> Self {
        SeenHeights { heights: HeightsOf::Cells(cells), n_cols, drops: None }
    }

    /// Returns the height of a cell.
    #[inline]
    pub fn at(&self, cell: usize) -> i32 {
        let z = match self.heights {
            HeightsOf::One(z) => z,
            HeightsOf::Cells(cells) => cells[cell],
        };
        self.drops.map_or(z, |drops| drops.lowered(z, (cell / self.n_cols, cell % self.n_cols)))
    }

    /// Copies heights of one row, from cell `first` on.
    pub(crate) fn copy(&self, first: usize, out: &mut [i32]) {
        match self.heights {
            HeightsOf::One(z) => out.fill(z),
            HeightsOf::Cells(cells) => out.copy_from_slice(&cells[first..first + out.len()]),
        }
        if let Some(drops) = self.drops {
            drops.lower_row((first / self.n_cols, first % self.n_cols), out);
        }
    }

    /// Returns all heights, if they are in memory one by one.
    pub(crate) fn in_memory(&self) -> Option<&'a [i32]> {
        match (self.heights, self.drops) {
            (HeightsOf::Cells(cells), None) => Some(cells),
            _ => None,
        }
    }

    /// Returns the highest by tile.
    pub(crate) fn tiles(&self) -> TileMaxima {
        match (self.heights, self.drops) {
            (HeightsOf::Cells(cells), None) => TileMaxima::of(cells, self.n_cols),
            (heights, Some(drops)) => TileMaxima::of(&drops.lowered_all(heights), self.n_cols),
            (HeightsOf::One(_), None) => TileMaxima::of(&[], self.n_cols),
        }
    }

    /// Returns whether both are the same heights in memory, lowered by the same drops.
    pub(crate) fn is(&self, other: &SeenHeights<'_>) -> bool {
        let is_same = |a: Option<&Drops>, b: Option<&Drops>| a.map(std::ptr::from_ref) == b.map(std::ptr::from_ref);
        match (self.heights, other.heights) {
            (HeightsOf::Cells(a), HeightsOf::Cells(b)) => std::ptr::eq(a, b) && is_same(self.drops, other.drops),
            _ => false,
        }
    }
}

impl Drops {
    /// Returns the drops of the cells of a grid, seen from a place.
    pub fn new(positions: &GridPositions, place: &Place, curvature: Curvature, meters_per_unit: f64) -> Self {
        let (n_rows, n_cols) = positions.shape();
        let at = positions.on_range(place);
        let (step_x, step_y) = positions.step_lengths();
        #[expect(clippy::cast_precision_loss, reason = "steps in reach are below 2^53")]
        let along = |steps: i64, length: f64| steps as f64 * length * meters_per_unit;
        Drops::at_distances(
            curvature,
            (0..n_cols).map(|col| along(positions.steps(at, (0, col)).0, step_x)),
            (0..n_rows).map(|row| along(positions.steps(at, (row, 0)).1, step_y)),
        )
    }

    /// Returns the drops of columns and rows at distances \[m\] east and north of a place.
    pub(super) fn at_distances(
        curvature: Curvature,
        cols_m: impl Iterator<Item = f64>,
        rows_m: impl Iterator<Item = f64>,
    ) -> Self {
        let drop = |distance_m: f64| f64::from(STEPS_PER_UNIT) * curvature.drop_m(distance_m);
        Drops { by_col: cols_m.map(drop).collect(), by_row: rows_m.map(drop).collect() }
    }

    /// Returns the drop of a cell \[1/1024 m\].
    #[inline]
    pub fn at(&self, row: usize, col: usize) -> i32 {
        rounded(self.by_col[col], self.by_row[row])
    }

    /// Returns the drop of the cell that holds a place, the nearest one outside \[1/1024 m\].
    pub(crate) fn at_place(&self, grid: &GeoRef, place: &Place) -> i32 {
        let x = place.x.clamp(grid.x_min(), grid.x_max() - 0.5 * grid.cell_width());
        let y = place.y.clamp(grid.y_min() + 0.5 * grid.cell_height(), grid.y_max());
        grid.cell_at(x, y).map_or(0, |(row, col)| self.at(row, col))
    }

    /// Returns the drops of some rows alone.
    pub(crate) fn of_rows(&self, rows: Range<usize>) -> Drops {
        Drops { by_col: self.by_col.clone(), by_row: self.by_row[rows].to_vec() }
    }

    /// Returns a lowered height over a cell as a height above the datum \[m\]; infinite ones stay.
    pub(crate) fn raised(&self, lowered: f32, (row, col): (usize, usize)) -> f32 {
        #[expect(clippy::cast_possible_truncation, reason = "layers are stored as f32")]
        let raised = (f64::from(lowered) + meters(self.at(row, col))) as f32;
        raised
    }

    /// Lowers the cells of a window, row by row.
    pub(crate) fn lower(&self, cells: &mut [i32], window: CellWindow) {
        let by_col = &self.by_col[window.col..window.col + window.n_cols];
        let by_row = &self.by_row[window.row..window.row + window.n_rows];
        cells.chunks_mut(window.n_cols.max(1)).zip(by_row).for_each(|(row, of_row)| lower(row, by_col, *of_row));
    }

    /// Returns the largest drop in a window that is not empty \[1/1024 m\].
    pub(crate) fn most(&self, window: CellWindow) -> i64 {
        let most = |of: &[f64]| of.iter().fold(0.0, |a: f64, b| a.max(*b));
        let cols = most(&self.by_col[window.col..window.col + window.n_cols]);
        let rows = most(&self.by_row[window.row..window.row + window.n_rows]);
        #[expect(clippy::cast_possible_truncation, reason = "saturates")]
        let most = (cols + rows + 0.5) as i64;
        most
    }

    /// Returns a height over a cell, lowered.
    #[inline]
    pub(crate) fn lowered(&self, z: i32, (row, col): (usize, usize)) -> i32 {
        lower_known(z, self.at(row, col))
    }

    /// Lowers cells of a row, from a column on.
    pub(crate) fn lower_row(&self, (row, first): (usize, usize), cells: &mut [i32]) {
        lower(cells, &self.by_col[first..], self.by_row[row]);
    }

    /// Lowers cells of a column, from a row on.
    pub(crate) fn lower_col(&self, (first, col): (usize, usize), cells: &mut [i32]) {
        lower(cells, &self.by_row[first..], self.by_col[col]);
    }

    /// Returns all cells lowered by their drops. Threads of the current pool share the work.
    pub(super) fn lowered_all(&self, heights: HeightsOf<'_>) -> LargeVec<i32> {
        let n_cols = self.by_col.len();
        let seen = SeenHeights { heights, n_cols, drops: Some(self) };
        let mut lowered = LargeVec::<i32>::zeroed(self.by_row.len() * n_cols);
        lowered.par_chunks_mut(n_cols).enumerate().for_each(|(row, cells)| seen.copy(row * n_cols, cells));
        lowered
    }

    /// Returns upper bounds on the highest lowered cells of tiles.
    pub(crate) fn of_tiles(&self, tiles: &TileMaxima) -> TileMaxima {
        let least = |of: &[f64]| -> Vec<f64> {
            of.chunks(TILE).map(|tile| tile.iter().fold(f64::INFINITY, |a, b| a.min(*b))).collect()
        };
        let (by_col, by_row) = (least(&self.by_col), least(&self.by_row));
        tiles.map(|row, col, highest| match highest {
            VOID | BLOCKS_ALL => highest,
            _ => highest - rounded(by_col[col], by_row[row]),
        })
    }
}

/// Lowers known heights of a line.
fn lower(cells: &mut [i32], by_cell: &[f64], of_line: f64) {
    dispatch!(Level::new(), simd => lower_with(simd, cells, by_cell, of_line));
}

/// Lowers known heights of a line.
///
/// PERF: compiled for the instructions of this machine, so that the compiler makes vectors of it.
#[inline(always)]
fn lower_with<S: Simd>(simd: S, cells: &mut [i32], by_cell: &[f64], of_line: f64) {
    simd.vectorize(
        #[inline(always)]
        || {
            for (z, of_cell) in cells.iter_mut().zip(by_cell) {
                *z = lower_known(*z, rounded(*of_cell, of_line));
            }
        },
    );
}

/// Lowers a height by a drop, if it is known.
#[inline(always)]
fn lower_known(z: i32, drop: i32) -> i32 {
    // PERF: lowered whatever it is, so that a vector chooses.
    let low = z.wrapping_sub(drop);
    if z == VOID || z == BLOCKS_ALL { z } else { low }
}

/// Rounds the sum of two numbers that are not negative, below 2^31, to the nearest whole number.
///
/// PERF: adding 2^52 leaves it in the lowest bits of the double, which the compiler does for a
/// vector at once.
#[inline(always)]
fn rounded(a: f64, b: f64) -> i32 {
    const ONE_PER_STEP: f64 = (1_u64 << 52) as f64;
    #[expect(clippy::cast_possible_truncation, reason = "the lowest bits alone")]
    let steps = (a + b + ONE_PER_STEP).to_bits() as i32;
    steps
}
