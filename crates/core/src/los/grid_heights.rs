//! Least heights over the cells of a grid, as an engine finds them all at once.

use rayon::prelude::*;

use crate::raster::{BitGrid, set_bits};

/// How far a rounded height may be from that of a walk along its link, relative to itself and to the heights of both ends.
///
/// With u = 2^-53: a height above the other end is the product of an integer and a quotient of integers, all exact; it errs by less than
/// 4u of itself, and adding the other end's height by u of the sum. A walk errs by as much, and so does the order of heights that are as
/// close as that. This is four times all of it.
const ROUNDING: f64 = 1.0 / (1_u64 << 47) as f64;

/// The least height of one end, the receiver or the UAV, of each link between a UAV and the receivers of a grid
/// \[1/1024 m above the datum\].
#[derive(Debug, Clone)]
pub struct GridHeights {
    /// Row by row: −∞ where nothing stands in the way, +∞ where no height is enough, NaN where it is not known.
    heights: Vec<f64>,
    /// Numbers to the row, of which there may be more than columns.
    per_row: usize,
    /// The row of the grid that they begin with.
    first_row: usize,
    /// The largest magnitude of the heights of both ends, if the heights were rounded otherwise than those of walks; 0 if not.
    rounded: f64,
}

impl GridHeights {
    pub(super) fn exact(heights: Vec<f64>, per_row: usize) -> Self {
        GridHeights { heights, per_row, first_row: 0, rounded: 0.0 }
    }

    /// Heights from a row on that were rounded, with the largest magnitude of the heights of both ends.
    pub(super) fn rounded(heights: Vec<f64>, per_row: usize, first_row: usize, largest: f64) -> Self {
        GridHeights { heights, per_row, first_row, rounded: largest.max(1.0) }
    }

    /// What a monotone function makes of the height at a cell; `None` if the height is not known, or so near to where the function
    /// changes that a walk along the link may find another value.
    #[inline]
    pub fn settled<T: PartialEq>(&self, (row, col): (usize, usize), of: impl Fn(f64) -> T) -> Option<T> {
        let height = self.heights[(row - self.first_row) * self.per_row + col];
        if height.is_nan() {
            return None;
        }
        if self.rounded == 0.0 || height.is_infinite() {
            return Some(of(height));
        }
        let error = ROUNDING * (height.abs() + self.rounded);
        let (low, high) = (of(height - error), of(height + error));
        (low == high).then_some(low)
    }

    /// Raises the heights that are known at some cells to others, given the cell and what is known; NaN says nothing.
    pub(super) fn raise(&mut self, cells: &BitGrid, other: &(impl Fn((usize, usize), f64) -> f64 + Sync)) {
        let rows = self.heights.par_chunks_exact_mut(self.per_row.max(1)).enumerate();
        rows.for_each(|(k, heights)| {
            let row = self.first_row + k;
            for col in set_bits(cells.row(row)) {
                if !heights[col].is_nan() {
                    heights[col] = heights[col].max(other((row, col), heights[col]));
                }
            }
        });
    }

    /// The higher one at each cell, for links that must meet both. The other ones are of all rows that these are of, and known.
    pub(super) fn or_higher(mut self, other: &GridHeights) -> Self {
        let others = other.heights.chunks_exact(other.per_row.max(1)).skip(self.first_row - other.first_row);
        for (heights, others) in self.heights.chunks_exact_mut(self.per_row.max(1)).zip(others) {
            for (height, other) in heights.iter_mut().zip(others) {
                // What is not known stays so.
                *height = if *other > *height { *other } else { *height };
            }
        }
        GridHeights { rounded: self.rounded.max(other.rounded), ..self }
    }
}
