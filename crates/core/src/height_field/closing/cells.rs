//! The square cells on which the closing is bounded.

use rayon::prelude::*;

use super::vectors::Place;
use crate::raster::BitGrid;

/// Square cells over the footprints, with a margin that a disc fits into. Rows run from the north.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cells {
    /// South-west corner \[lattice steps\].
    pub(super) corner: [i64; 2],
    /// Side of a cell \[lattice steps\].
    pub(super) side: i64,
    pub(super) n_rows: usize,
    pub(super) n_cols: usize,
}

impl Cells {
    /// Returns a position relative to the corner.
    #[expect(clippy::cast_precision_loss, reason = "lattice positions are below 2^27")]
    pub(super) fn place(&self, [x, y]: [i64; 2]) -> Place {
        [(x - self.corner[0]) as f64, (y - self.corner[1]) as f64]
    }

    /// Returns the row and column of the cell that holds a place; `None` beyond the grid.
    pub(super) fn at(&self, [x, y]: Place) -> Option<(usize, usize)> {
        #[expect(clippy::cast_precision_loss, reason = "a side is below 2^26")]
        let side = self.side as f64;
        if x < 0.0 || y < 0.0 {
            return None;
        }
        // PERF: no call of `floor`, which was a tenth of all.
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "saturates, and is beyond the grid then"
        )]
        let [col, from_south] = [x, y].map(|v| (v / side) as u32 as usize);
        let row = self.n_rows.checked_sub(from_south + 1)?;
        (col < self.n_cols).then_some((row, col))
    }

    pub(super) fn center(&self, (row, col): (usize, usize)) -> Place {
        #[expect(clippy::cast_precision_loss, reason = "a grid has fewer than 2^24 cells a side")]
        let [x, y] = [col as f64, (self.n_rows - 1 - row) as f64];
        #[expect(clippy::cast_precision_loss, reason = "a side is below 2^26")]
        let side = self.side as f64;
        [(x + 0.5) * side, (y + 0.5) * side]
    }

    pub(super) fn index(&self, (row, col): (usize, usize)) -> usize {
        row * self.n_cols + col
    }

    pub(super) fn holds(&self, set: &BitGrid, place: Place) -> bool {
        self.at(place).is_some_and(|(row, col)| set.contains(row, col))
    }
}

/// Returns the largest square of a distance between cells that is less than that of a length
/// \[cells\].
pub(super) fn less_than(length: f64) -> u32 {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a radius in cells")]
    let square = (length * length).ceil() as u32;
    square.saturating_sub(1)
}

/// Returns the cells whose centers are near the center of a cell of a set: the square of the
/// distance is at most so much \[cells²\].
pub(super) fn grown(set: &BitGrid, most: u32) -> BitGrid {
    let (n_rows, n_cols) = (set.n_rows(), set.n_cols());
    let radius = u16::try_from(most.isqrt()).unwrap_or(u16::MAX - 1);
    // Rows to the nearest cell of the set in each column: from the north, then from the south as
    // well.
    let far = radius.saturating_add(1);
    let mut rows_to_set = vec![far; n_rows * n_cols];
    let mut pass = |rows: &mut dyn Iterator<Item = usize>| {
        let mut last = vec![far; n_cols];
        for row in rows {
            let of_row = &mut rows_to_set[row * n_cols..(row + 1) * n_cols];
            for (col, (nearest, last)) in of_row.iter_mut().zip(&mut last).enumerate() {
                *last = if set.contains(row, col) { 0 } else { last.saturating_add(1).min(far) };
                *nearest = (*nearest).min(*last);
            }
        }
    };
    pass(&mut (0..n_rows));
    pass(&mut (0..n_rows).rev());
    // Columns that a disc covers so many rows from its middle, to each side.
    let half = |dy: u16| (most - u32::from(dy).pow(2)).isqrt() as usize;
    let halves: Vec<usize> = (0..=radius).map(half).collect();
    let mut grown = BitGrid::new(n_rows, n_cols);
    let per_row = grown.words_per_row();
    grown.words_mut().par_chunks_mut(per_row.max(1)).zip(rows_to_set.par_chunks(n_cols)).for_each(|(words, rows)| {
        // Where intervals of covered columns begin, less where they end.
        let mut ends = vec![0_i32; n_cols + 1];
        for (col, dy) in rows.iter().enumerate().filter(|(_, dy)| **dy <= radius) {
            let half = halves[usize::from(*dy)];
            ends[col.saturating_sub(half)] += 1;
            ends[(col + half + 1).min(n_cols)] -= 1;
        }
        let mut open = 0;
        for (col, change) in ends.iter().take(n_cols).enumerate() {
            open += change;
            words[col / 64] |= u64::from(open > 0) << (col % 64);
        }
    });
    grown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_grows_by_a_disc() {
        let mut set = BitGrid::new(40, 50);
        let seeds = [(3, 4), (20, 30), (20, 33), (39, 49)];
        seeds.iter().for_each(|(row, col)| set.insert(*row, *col));
        let grown = grown(&set, 50);
        for row in 0..40_usize {
            for col in 0..50_usize {
                let is_near = seeds.iter().any(|(r, c)| row.abs_diff(*r).pow(2) + col.abs_diff(*c).pow(2) <= 50);
                assert_eq!(grown.contains(row, col), is_near, "{row} {col}");
            }
        }
    }
}
