//! The order in which lines of cells are passed, tile by tile, and columns as lines.

use std::ops::Range;

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
pub(super) fn turn(tops: &[i32], n_cols: usize, cols: &Range<usize>, rows: &Range<usize>, lines: &mut Vec<i32>) {
    let width = rows.len();
    // Grows and never shrinks, so that nothing is cleared which is overwritten anyway.
    if lines.len() < width * cols.len() {
        lines.resize(width * cols.len(), 0);
    }
    const BLOCK: usize = 16;
    for start in (0..width).step_by(BLOCK) {
        let height = BLOCK.min(width - start);
        let sources: [&[i32]; BLOCK] = std::array::from_fn(|k| {
            let row = rows.start + start + k.min(height - 1);
            &tops[row * n_cols + cols.start..row * n_cols + cols.end]
        });
        for i in 0..cols.len() {
            let line = &mut lines[i * width + start..i * width + start + height];
            // PERF: of known length, the copy is unrolled.
            if let Ok(line) = <&mut [i32; BLOCK]>::try_from(&mut *line) {
                for (k, top) in line.iter_mut().enumerate() {
                    *top = sources[k][i];
                }
            } else {
                for (k, top) in line.iter_mut().enumerate() {
                    *top = sources[k][i];
                }
            }
        }
    }
}
