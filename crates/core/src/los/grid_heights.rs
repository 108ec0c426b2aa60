//! Least heights over the cells of a grid, as an engine finds them all at once.

use rayon::prelude::*;

use crate::raster::{BitGrid, set_bits};

/// Bound on the difference between a rounded height and that of a walk along its link, relative to
/// the height itself and to the heights of both ends.
///
/// With u = 2^-53: a height above the other end is the product of an integer and a quotient of
/// integers, all exact. It errs by less than 4u of itself, and adding the other end's height errs
/// by u of the sum. A walk errs by as much, and so does the order of heights that are as close as
/// that. This constant is four times all of it.
const ROUNDING: f64 = 1.0 / (1_u64 << 47) as f64;

/// The least height of one end, the receiver or the UAV, of each link between a UAV and the
/// receivers of a grid \[1/1024 m above the datum\].
#[derive(Debug, Clone)]
pub struct GridHeights {
    /// Row by row: −∞ if nothing is in the way, +∞ if no height is enough, NaN if unknown.
    heights: Vec<f64>,
    /// Numbers per row; there may be more than columns.
    per_row: usize,
    /// The first row of the grid that they cover.
    first_row: usize,
    /// The largest magnitude of the heights of both ends, if the heights were rounded otherwise
    /// than those of walks; 0 if not.
    rounded: f64,
}

impl GridHeights {
    pub(super) fn exact(heights: Vec<f64>, per_row: usize) -> Self {
        GridHeights { heights, per_row, first_row: 0, rounded: 0.0 }
    }

    /// Makes rounded heights from a row on, with the largest magnitude of the heights of both ends.
    pub(super) fn rounded(heights: Vec<f64>, per_row: usize, first_row: usize, largest: f64) -> Self {
        GridHeights { heights, per_row, first_row, rounded: largest.max(1.0) }
    }

    /// Returns the value of a monotone function at the height of a cell.
    ///
    /// Returns `None` if the height is unknown, or so near to a change of the function that a walk
    /// along the link may give another value.
    #[inline]
    pub fn settled<T: PartialEq>(&self, (row, col): (usize, usize), of: impl Fn(f64) -> T) -> Option<T> {
        let height = self.heights[(row - self.first_row) * self.per_row + col];
        if height.is_nan() {
            return None;
        }
        // PERF: one place for both calls, so that the function is inlined.
        let error = match self.rounded == 0.0 || height.is_infinite() {
            true => 0.0,
            false => ROUNDING * (height.abs() + self.rounded),
        };
        let [low, high] = [height - error, height + error].map(of);
        (low == high).then_some(low)
    }

    /// Raises the known heights at some cells to those of `other`, given the cell and the known
    /// height. NaN changes nothing.
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

    /// Returns the higher height at each cell, for links that must meet both. `other` covers all
    /// rows of these heights, and all its heights are known.
    pub(super) fn or_higher(mut self, other: &GridHeights) -> Self {
        let others = other.heights.chunks_exact(other.per_row.max(1)).skip(self.first_row - other.first_row);
        for (heights, others) in self.heights.chunks_exact_mut(self.per_row.max(1)).zip(others) {
            for (height, other) in heights.iter_mut().zip(others) {
                // Unknown heights stay unknown.
                *height = if *other > *height { *other } else { *height };
            }
        }
        GridHeights { rounded: self.rounded.max(other.rounded), ..self }
    }
}
