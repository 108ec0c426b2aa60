//! The highest values of tiles of cells: what lets line of sight pass over much of a city unseen.

use fearless_simd::{Level, Simd};

use crate::dispatch;
use rayon::prelude::*;

/// Rows and columns of a tile, as a power of two.
pub const TILE_BITS: u32 = 3;

/// Rows and columns of a tile.
pub const TILE: usize = 1 << TILE_BITS;

/// Columns whose maxima are found together.
const BLOCK: usize = 64;

/// The highest value of each tile of 8 × 8 cells of a grid; tiles at the south and east edges may
/// hold fewer.
///
/// Rows of tiles run south from the north-west cell, as rows of cells do. 1/64 of the memory of the
/// cells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TileMaxima {
    per_row: usize,
    maxima: Vec<i32>,
    lowest: i32,
    highest: i32,
}

impl TileMaxima {
    /// Returns the maxima of `cells`, rows of `n_cols` each. Threads of the current pool share the
    /// work.
    pub fn of(cells: &[i32], n_cols: usize) -> Self {
        let per_row = n_cols.div_ceil(TILE);
        let mut maxima = vec![i32::MIN; cells.len().div_ceil(TILE * n_cols) * per_row];
        let (lowest, highest) = maxima
            .par_chunks_mut(per_row)
            .zip(cells.par_chunks(TILE * n_cols))
            .map(|(maxima, rows)| dispatch!(Level::new(), simd => row_of_tiles(simd, rows, n_cols, maxima)))
            .reduce(|| (i32::MAX, i32::MIN), |a, b| (a.0.min(b.0), a.1.max(b.1)));
        TileMaxima { per_row, maxima, lowest, highest }
    }

    /// Returns the maxima of so many rows and columns of cells that are all alike.
    pub(crate) fn of_one(value: i32, (n_rows, n_cols): (usize, usize)) -> TileMaxima {
        let per_row = n_cols.div_ceil(TILE);
        TileMaxima { per_row, maxima: vec![value; n_rows.div_ceil(TILE) * per_row], lowest: value, highest: value }
    }

    /// Returns other maxima, given row and column of each tile and its maximum.
    pub(super) fn map(&self, of: impl Fn(usize, usize, i32) -> i32) -> TileMaxima {
        let maxima: Vec<i32> = self
            .maxima
            .iter()
            .enumerate()
            .map(|(k, highest)| of(k / self.per_row, k % self.per_row, *highest))
            .collect();
        let extremes = maxima.iter().fold((self.lowest, i32::MIN), |(low, high), z| (low, high.max(*z)));
        TileMaxima { per_row: self.per_row, maxima, lowest: extremes.0, highest: extremes.1 }
    }

    /// Tiles to a row.
    pub fn per_row(&self) -> usize {
        self.per_row
    }

    /// Returns all maxima, row by row from the north-west tile.
    pub(crate) fn maxima(&self) -> &[i32] {
        &self.maxima
    }

    /// Returns the lowest and the highest value of all cells; `(i32::MAX, i32::MIN)` without cells.
    pub(crate) fn extremes(&self) -> (i32, i32) {
        (self.lowest, self.highest)
    }
}

/// Returns the maxima of one row of tiles, and the extremes of its cells.
#[inline(always)]
fn row_of_tiles<S: Simd>(simd: S, rows: &[i32], n_cols: usize, maxima: &mut [i32]) -> (i32, i32) {
    // PERF: compiled for the instructions of this machine, where the compiler makes vectors of it.
    simd.vectorize(
        #[inline(always)]
        || {
            let mut lowest = [i32::MAX; BLOCK];
            let mut highest = i32::MIN;
            for (block, maxima) in maxima.chunks_mut(BLOCK / TILE).enumerate() {
                let mut high = [i32::MIN; BLOCK];
                for row in rows.chunks_exact(n_cols) {
                    let cells = &row[block * BLOCK..n_cols.min((block + 1) * BLOCK)];
                    if let Ok(cells) = <&[i32; BLOCK]>::try_from(cells) {
                        for k in 0..BLOCK {
                            high[k] = high[k].max(cells[k]);
                            lowest[k] = lowest[k].min(cells[k]);
                        }
                    } else {
                        for (k, cell) in cells.iter().enumerate() {
                            high[k] = high[k].max(*cell);
                            lowest[k] = lowest[k].min(*cell);
                        }
                    }
                }
                for (maximum, tile) in maxima.iter_mut().zip(high.chunks_exact(TILE)) {
                    *maximum = tile.iter().fold(i32::MIN, |a, b| a.max(*b));
                    highest = highest.max(*maximum);
                }
            }
            (lowest.into_iter().fold(i32::MAX, i32::min), highest)
        },
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_tile_has_the_highest_of_its_cells() {
        for (n_rows, n_cols) in [(1, 1), (8, 8), (9, 17), (23, 64), (16, 200), (31, 129)] {
            let cells: Vec<i32> = (0..).map(|i: i32| i.wrapping_mul(0x3d4d_51cb)).take(n_rows * n_cols).collect();
            let found = TileMaxima::of(&cells, n_cols);
            assert_eq!(found.per_row(), n_cols.div_ceil(8));
            assert_eq!(found.maxima().len(), n_rows.div_ceil(8) * found.per_row());
            for (tile, maximum) in found.maxima().iter().enumerate() {
                let (row, col) = (tile / found.per_row(), tile % found.per_row());
                let of_tile = (0..n_rows * n_cols)
                    .filter(|i| i / n_cols / 8 == row && i % n_cols / 8 == col)
                    .map(|i| cells[i])
                    .max();
                assert_eq!(Some(*maximum), of_tile, "{n_rows} × {n_cols}, tile {tile}");
            }
            assert_eq!(Some(found.extremes().0), cells.iter().copied().min());
            assert_eq!(Some(found.extremes().1), cells.iter().copied().max());
        }
    }
}
