//! The order in which lines of cells are passed, tile by tile, and columns as lines.

use std::ops::Range;

use fearless_simd::i32x4;
use fearless_simd::prelude::*;

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

/// Copies columns `cols` of rows `rows` into lines, one after another.
pub(super) fn turn<S: Simd>(
    simd: S,
    tops: &[i32],
    n_cols: usize,
    cols: &Range<usize>,
    rows: &Range<usize>,
    lines: &mut Vec<i32>,
) {
    let width = rows.len();
    // Grows and never shrinks, so that nothing is cleared which is overwritten anyway.
    if lines.len() < width * cols.len() {
        lines.resize(width * cols.len(), 0);
    }
    simd.vectorize(
        #[inline(always)]
        || {
            for start in (0..width).step_by(BLOCK) {
                let height = BLOCK.min(width - start);
                let sources: [&[i32]; BLOCK] = std::array::from_fn(|k| {
                    let row = rows.start + start + k.min(height - 1);
                    &tops[row * n_cols + cols.start..row * n_cols + cols.end]
                });
                let mut done = 0;
                if height == BLOCK {
                    // PERF: squares of four cells a side, in registers.
                    while done + 4 <= cols.len() {
                        for k in (0..BLOCK).step_by(4) {
                            let square =
                                std::array::from_fn(|i| i32x4::from_slice(simd, &sources[k + i][done..done + 4]));
                            for (i, column) in transposed(square).into_iter().enumerate() {
                                let at = (done + i) * width + start + k;
                                column.store_slice(&mut lines[at..at + 4]);
                            }
                        }
                        done += 4;
                    }
                }
                for i in done..cols.len() {
                    for (k, source) in sources.iter().enumerate().take(height) {
                        lines[i * width + start + k] = source[i];
                    }
                }
            }
        },
    );
}

/// Rows that are turned together.
const BLOCK: usize = 16;

/// Rows of a square for its columns.
#[inline(always)]
fn transposed<S: Simd>([a, b, c, d]: [i32x4<S>; 4]) -> [i32x4<S>; 4] {
    let (ac, bd) = (a.zip_low(c), b.zip_low(d));
    let (ac_high, bd_high) = (a.zip_high(c), b.zip_high(d));
    [ac.zip_low(bd), ac.zip_high(bd), ac_high.zip_low(bd_high), ac_high.zip_high(bd_high)]
}
