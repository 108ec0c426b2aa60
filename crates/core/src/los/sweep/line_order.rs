//! The order in which lines of cells are passed, tile by tile, and columns as lines.

use std::ops::Range;

use fearless_simd::i32x4;
use fearless_simd::prelude::*;
use prefetch_index::prefetch_index;

use crate::height_field::TILE;

/// Lines of one line of tiles, on the way out.
#[derive(Debug, Clone, Copy)]
pub(super) struct TileLines {
    pub(super) tile: usize,
    pub(super) first: usize,
    pub(super) last: usize,
}

impl TileLines {
    /// Calls `line` for each, outward.
    pub(super) fn each(self, mut line: impl FnMut(usize)) {
        if self.first <= self.last {
            (self.first..=self.last).for_each(&mut line);
        } else {
            (self.last..=self.first).rev().for_each(&mut line);
        }
    }
}

/// Calls `each` for the lines of each line of tiles in turn, upward or downward, as long as it says so.
pub(super) fn for_tile_lines(lines: Range<usize>, is_upward: bool, mut each: impl FnMut(TileLines) -> bool) {
    if lines.is_empty() {
        return;
    }
    let mut of_tile = |tile: usize| {
        let (low, high) = ((tile * TILE).max(lines.start), ((tile + 1) * TILE).min(lines.end) - 1);
        each(if is_upward {
            TileLines { tile, first: low, last: high }
        } else {
            TileLines { tile, first: high, last: low }
        })
    };
    let tiles = lines.start / TILE..lines.end.div_ceil(TILE);
    if is_upward {
        tiles.into_iter().all(&mut of_tile);
    } else {
        tiles.rev().all(&mut of_tile);
    }
}

/// Columns that are turned into lines together.
pub(super) const STRIP: usize = 64;

/// Heights of a line of the cache.
const CACHE_LINE: usize = 16;

/// Has some cells brought into the cache, and some after them; those that are not there do no harm.
#[inline(always)]
pub(super) fn read_ahead(values: &[i32], cells: Range<usize>) {
    for cell in (cells.start..cells.end + CACHE_LINE).step_by(CACHE_LINE) {
        prefetch_index(values, cell);
    }
}

/// Copies columns `cols` of rows `rows` into lines, one after another.
pub(super) fn turn<S: Simd>(
    simd: S,
    tops: &[i32],
    n_cols: usize,
    cols: &Range<usize>,
    rows: &Range<usize>,
    lines: &mut Vec<i32>,
) {
    let (width, n_lines) = (rows.len(), cols.len());
    // Grows and never shrinks, so that nothing is cleared which is overwritten anyway.
    if lines.len() < width * n_lines {
        lines.resize(width * n_lines, 0);
    }
    let row = |k: usize| &tops[(rows.start + k) * n_cols..][cols.clone()];
    simd.vectorize(
        #[inline(always)]
        || {
            let (whole_rows, whole_cols) = (width / BLOCK * BLOCK, n_lines / BLOCK * BLOCK);
            for start in (0..whole_rows).step_by(BLOCK) {
                for done in (0..whole_cols).step_by(BLOCK) {
                    for k in (start..start + BLOCK).step_by(SQUARE) {
                        for i in 0..SQUARE {
                            // Past the last row it does no harm.
                            prefetch_index(tops, (rows.start + k + BLOCK + i) * n_cols + cols.start + done);
                        }
                        let sources: [&[i32]; SQUARE] = std::array::from_fn(|i| &row(k + i)[done..][..BLOCK]);
                        for at in (0..BLOCK).step_by(SQUARE) {
                            let square = std::array::from_fn(|i| i32x4::from_slice(simd, &sources[i][at..at + SQUARE]));
                            for (i, column) in transposed(square).into_iter().enumerate() {
                                let place = (done + at + i) * width + k;
                                column.store_slice(&mut lines[place..place + SQUARE]);
                            }
                        }
                    }
                }
            }
            for k in 0..width {
                let from = if k < whole_rows { whole_cols } else { 0 };
                for (i, top) in row(k)[from..].iter().enumerate() {
                    lines[(from + i) * width + k] = *top;
                }
            }
        },
    );
}

/// Rows and columns that are turned together: as many as a line of the cache has heights, so that few are read twice. The rows
/// after them are read ahead.
const BLOCK: usize = CACHE_LINE;

/// Rows and columns that are turned at once, in registers.
const SQUARE: usize = 4;

/// Rows of a square for its columns.
#[inline(always)]
fn transposed<S: Simd>([a, b, c, d]: [i32x4<S>; 4]) -> [i32x4<S>; 4] {
    let (ac, bd) = (a.zip_low(c), b.zip_low(d));
    let (ac_high, bd_high) = (a.zip_high(c), b.zip_high(d));
    [ac.zip_low(bd), ac.zip_high(bd), ac_high.zip_low(bd_high), ac_high.zip_high(bd_high)]
}

#[cfg(test)]
mod tests {
    use crate::dispatch;

    use super::*;
    use crate::simd::simd_levels;

    #[test]
    fn columns_become_lines_whatever_their_shape() {
        let (n_rows, n_cols) = (53, 90);
        let tops: Vec<i32> = (0..n_rows * n_cols).map(|cell| i32::try_from(cell).expect("few")).collect();
        for level in simd_levels() {
            for (cols, rows) in
                [(0..64, 0..53), (64..90, 3..50), (10..26, 5..21), (89..90, 0..17), (5..5, 0..9), (7..40, 8..8)]
            {
                let mut lines = Vec::new();
                dispatch!(level, simd => turn(simd, &tops, n_cols, &cols, &rows, &mut lines));
                let wanted: Vec<i32> = cols
                    .clone()
                    .flat_map(|col| rows.clone().map(move |row| row * n_cols + col))
                    .map(|cell| tops[cell])
                    .collect();
                assert_eq!(lines, wanted, "{cols:?} {rows:?} {level:?}");
            }
        }
    }
}
