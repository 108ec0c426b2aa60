//! The quadrants around the UAV, how many wedges they are cut into, and the cells at its foot that no wedge decides.

use std::ops::Range;

use crate::quantity::{LatticePoint, STEPS_PER_UNIT};
use crate::raster::{BitGrid, CellWindow};

/// Length of a cell \[lattice steps\].
pub(super) const CELL: i64 = STEPS_PER_UNIT as i64;

/// There are `2^level` bins to each side of the axis; this many at least.
pub(super) const FIRST_LEVEL: u32 = 4;

/// The most wedges that one side of a quadrant can be cut into.
pub(super) const MAX_PARTS: i64 = 1 << FIRST_LEVEL;

/// Lines that end within this distance of the UAV \[lattice steps\] are left to `ray`: their bins are many to a cell. As many
/// cells as a vector has lanes, so that those of a vector of receivers lie in two vectors.
pub(super) const NEAR: i64 = 16 * CELL;

/// What a sweep found.
#[derive(Debug, Clone)]
pub struct Swept {
    /// The wanted cells in line of sight.
    pub los: BitGrid,
    /// How many of the wanted cells the bounds left undecided.
    pub undecided: u64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quadrant {
    North,
    South,
    East,
    West,
}

/// Cells across a raster beyond which its quadrants are cut once more.
const LONGEST_LINE: usize = 4096;

/// Wedges to each side of the axis of a quadrant: eight for every thread in all, since some take longer than others, and
/// enough for the bins of a wedge and the lines behind it to stay in a core's cache; no more, since long lines are read
/// faster than short ones.
pub(super) fn parts(n_across: usize) -> i64 {
    let for_threads = rayon::current_num_threads();
    as_i64(for_threads.max(n_across / LONGEST_LINE).next_power_of_two()).clamp(1, MAX_PARTS)
}

/// Rows and columns of the cells near the UAV, which no wedge decides, inside a window of a raster of `n_rows`.
pub(super) fn near_cells(uav: LatticePoint, n_rows: usize, window: CellWindow) -> (Range<usize>, Range<usize>) {
    let reach = NEAR / CELL + 1;
    let clip = |middle: i64, low: usize, n: usize| {
        let at = |v: i64| usize::try_from(v.max(0)).unwrap_or(usize::MAX).clamp(low, low + n);
        at(middle - reach)..at(middle + reach + 1)
    };
    let (east, north) = (uav.x.div_euclid(CELL), uav.y.div_euclid(CELL));
    let row = as_i64(n_rows) - 1 - north;
    (clip(row, window.row, window.n_rows), clip(east, window.col, window.n_cols))
}

pub(super) fn as_i64(n: usize) -> i64 {
    i64::try_from(n).unwrap_or(i64::MAX)
}
