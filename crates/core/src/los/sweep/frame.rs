//! Step 1: the four quadrants around the UAV, and their rows, numbered outward.
//!
//! Everything after this step is written for one quadrant alone, in which rows run across the way
//! out. They are rows of the raster to the north and south, and columns of it to the east and west.

use std::ops::Range;

use crate::height_field::TILE;
use crate::quantity::{BLOCKS_ALL, LatticePoint, STEPS_PER_UNIT};
use crate::raster::{BitGrid, CellWindow};

/// Length of a cell \[lattice steps\].
pub(super) const CELL: i64 = STEPS_PER_UNIT as i64;

/// Bits of a lattice position below the cell.
pub(super) const CELL_BITS: u32 = CELL.trailing_zeros();

/// The least level: there are `2^level` bins to each side of the axis.
pub(super) const FIRST_LEVEL: u32 = 4;

/// The most wedges that one side of a quadrant can be cut into.
const MAX_PARTS: i64 = 1 << FIRST_LEVEL;

/// Distance from the UAV within which rows that end there are left to `ray` \[lattice steps\],
/// since many of their bins are in one cell. It is as many cells as the widest vector has lanes, so
/// that the bins of a vector of receivers lie in two vectors.
pub(super) const NEAR: i64 = 16 * CELL;

/// Room that vectors may read or write before and after the part of a buffer that is in use.
pub(super) const PAD: usize = 128;
/// [`PAD`] among bins and cells, which are counted with a sign.
pub(super) const PAD_I64: i64 = 128;

/// Receivers whose least heights are found together.
pub(super) const BATCH: usize = 64;

/// Cells across a raster beyond which its quadrants are cut once more.
const LONGEST_ROW: usize = 4096;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quadrant {
    North,
    South,
    East,
    West,
}

impl Quadrant {
    pub(super) const ALL: [Quadrant; 4] = [Quadrant::North, Quadrant::South, Quadrant::East, Quadrant::West];

    /// Returns `true` if its rows are rows of the raster, not columns.
    pub(super) fn has_raster_rows(self) -> bool {
        matches!(self, Quadrant::North | Quadrant::South)
    }
}

/// The request of a sweep.
#[derive(Debug, Clone, Copy)]
pub(super) struct Asked {
    /// Rows and columns of the raster.
    pub(super) shape: (usize, usize),
    pub(super) uav: LatticePoint,
    /// The highest top, or an upper bound of it \[1/1024 m\].
    pub(super) max_top: i32,
    /// The range of heights that matter \[1/1024 m\]: heights below the first need not be
    /// distinguished, nor heights above the second.
    pub(super) heights: (i64, i64),
    /// A window that holds all requested receivers, and all cells between them and the UAV.
    pub(super) window: CellWindow,
}

/// One quadrant of a raster.
#[derive(Debug, Clone)]
pub(super) struct Frame {
    pub(super) quadrant: Quadrant,
    pub(super) shape: (usize, usize),
    /// Raster rows or columns that are passed, in the order of the raster.
    lines: Range<usize>,
    /// Distance of the farther edge of row 0 \[lattice steps\].
    far_of_first: i64,
    /// Distance of the last row's centers \[lattice steps\].
    pub(super) last_center: i64,
    /// Height of the UAV \[1/1024 m\].
    pub(super) uav_z: i32,
    /// The top above the UAV behind which no height is enough.
    pub(super) blocks_all: i32,
    /// `true` if no top is above the UAV.
    pub(super) is_below_uav: bool,
    /// Lateral position of the UAV \[lattice steps\]; lateral positions run east, or south as
    /// raster rows do.
    pub(super) uav_lateral: i64,
    /// Number of cells along a row.
    pub(super) n_lateral: i64,
    /// Lateral cells of the window.
    pub(super) window: (i64, i64),
    /// [`Asked::heights`], above the UAV.
    pub(super) lowest: i64,
    pub(super) highest: i64,
}

impl Frame {
    /// Makes the frame of a quadrant; `None` if no row of the window lies in it.
    pub(super) fn new(asked: &Asked, quadrant: Quadrant) -> Option<Self> {
        let Asked { shape: (n_rows, n_cols), uav, window, heights, .. } = *asked;
        let (rows, cols) = (window.row..window.row + window.n_rows, window.col..window.col + window.n_cols);
        let is_rows = quadrant.has_raster_rows();
        let (across, along, n_lateral) = if is_rows { (rows, cols, n_cols) } else { (cols, rows, n_rows) };
        let far = |line: usize| match quadrant {
            Quadrant::North => (as_i64(n_rows) - as_i64(line)) * CELL - uav.y,
            Quadrant::South => uav.y - (as_i64(n_rows) - 1 - as_i64(line)) * CELL,
            Quadrant::East => (as_i64(line) + 1) * CELL - uav.x,
            Quadrant::West => uav.x - as_i64(line) * CELL,
        };
        let mut frame = Frame {
            quadrant,
            shape: (n_rows, n_cols),
            lines: across.clone(),
            far_of_first: 0,
            last_center: 0,
            uav_z: i32::try_from(uav.z).unwrap_or(i32::MAX),
            blocks_all: i32::try_from(i64::from(BLOCKS_ALL) - uav.z).unwrap_or(i32::MAX),
            is_below_uav: i64::from(asked.max_top) <= uav.z,
            uav_lateral: if is_rows { uav.x } else { as_i64(n_rows) * CELL - uav.y },
            n_lateral: as_i64(n_lateral),
            window: (as_i64(along.start), as_i64(along.end)),
            lowest: heights.0 - uav.z,
            highest: heights.1 - uav.z,
        };
        // Rows behind the UAV belong to another quadrant.
        frame.lines = if frame.counts_up() {
            across.clone().find(|line| far(*line) > 0)?..across.end
        } else {
            across.start..across.clone().rev().find(|line| far(*line) > 0)? + 1
        };
        frame.far_of_first = far(frame.line(0));
        frame.last_center = frame.center(frame.n_rows() - 1);
        Some(frame)
    }

    /// Returns `true` if raster rows or columns have rising numbers on the way out.
    pub(super) fn counts_up(&self) -> bool {
        matches!(self.quadrant, Quadrant::South | Quadrant::East)
    }

    /// Returns the number of rows.
    pub(super) fn n_rows(&self) -> usize {
        self.lines.len()
    }

    /// Returns the raster row or column of a row.
    #[inline(always)]
    pub(super) fn line(&self, row: usize) -> usize {
        if self.counts_up() { self.lines.start + row } else { self.lines.end - 1 - row }
    }

    /// Returns the raster rows or columns of some rows, of which there is at least one.
    pub(super) fn lines_of(&self, rows: &Range<usize>) -> Range<usize> {
        let (a, b) = (self.line(rows.start), self.line(rows.end - 1));
        a.min(b)..a.max(b) + 1
    }

    /// Returns row and column in the raster of lateral cell `lateral` of a row.
    #[inline(always)]
    pub(super) fn cell(&self, row: usize, lateral: usize) -> (usize, usize) {
        let line = self.line(row);
        if self.quadrant.has_raster_rows() { (line, lateral) } else { (lateral, line) }
    }

    /// Returns the distance of the farther edge of a row \[lattice steps\].
    #[inline(always)]
    pub(super) fn far(&self, row: usize) -> i64 {
        self.far_of_first + as_i64(row) * CELL
    }

    /// Returns the distance of its nearer edge; 0 if the UAV is beyond it.
    #[inline(always)]
    pub(super) fn near(&self, row: usize) -> i64 {
        (self.far(row) - CELL).max(0)
    }

    /// Returns the distance of its centers; not positive if the UAV is beyond them.
    #[inline(always)]
    pub(super) fn center(&self, row: usize) -> i64 {
        self.far(row) - CELL / 2
    }

    /// Returns the end of the rows from `row` on that lie between the same two multiples of `n` in
    /// the raster.
    pub(super) fn end_of_strip(&self, row: usize, n: usize) -> usize {
        let line = self.line(row);
        let left = if self.counts_up() { n - line % n } else { line % n + 1 };
        (row + left).min(self.n_rows())
    }

    /// Returns the number in the raster of the tiles that a row lies in.
    pub(super) fn tile(&self, row: usize) -> usize {
        self.line(row) / TILE
    }
}

impl Frame {
    /// Returns the bins of the first level, from the leftmost on, that may hold a wanted receiver:
    /// a bit each.
    pub(super) fn wanted_bins(&self, wanted: &BitGrid) -> u32 {
        let as_usize = |v: i64| usize::try_from(v.max(0)).unwrap_or(0);
        let window = as_usize(self.window.0)..as_usize(self.window.1);
        let is_rows = self.quadrant.has_raster_rows();
        let (rows, cols) = if is_rows { (&self.lines, &window) } else { (&window, &self.lines) };
        let side = |lateral: usize| as_i64(lateral) * CELL + CELL / 2 - self.uav_lateral;
        let mut bins = 0;
        // Raster rows, in raster order for every quadrant.
        for row in rows.clone() {
            // Only cells in the quadrant: no farther to the side than away.
            if is_rows && self.center_of(row) <= 0 {
                continue;
            }
            let within = if is_rows {
                let (middle, reach) = (self.uav_lateral - CELL / 2, self.center_of(row));
                let first = as_usize((middle - reach + CELL - 1).div_euclid(CELL));
                first.max(cols.start)..as_usize((middle + reach).div_euclid(CELL) + 1).min(cols.end)
            } else {
                let away = side(row).abs().max(1);
                let n_near =
                    as_usize((away - self.far_of_first + CELL / 2 + CELL - 1).div_euclid(CELL)).min(cols.len());
                if self.counts_up() { cols.start + n_near..cols.end } else { cols.start..cols.end - n_near }
            };
            let Some((first, last)) = wanted.ends_of_row(row, within) else { continue };
            let bins_of = |col: usize| {
                let (side, away) =
                    if is_rows { (side(col), self.center_of(row)) } else { (side(row), self.center_of(col)) };
                // A receiver on an edge may belong to either bin.
                [((side << FIRST_LEVEL) - 1).div_euclid(away), (side << FIRST_LEVEL).div_euclid(away)]
            };
            let ([a, b], [c, d]) = (bins_of(first), bins_of(last));
            let (low, high) = (a.min(c).max(-MAX_PARTS), b.max(d).min(MAX_PARTS - 1));
            (low..=high).for_each(|bin| bins |= 1_u32 << (bin + MAX_PARTS));
        }
        bins
    }

    /// Returns the distance of the centers of a raster row or column.
    fn center_of(&self, line: usize) -> i64 {
        let row = if self.counts_up() {
            as_i64(line) - as_i64(self.lines.start)
        } else {
            as_i64(self.lines.end) - 1 - as_i64(line)
        };
        self.far_of_first + row * CELL - CELL / 2
    }
}

/// Returns the number of wedges to each side of the axis of a quadrant.
///
/// There are eight for every thread in all, since some take longer than others. They are enough for
/// the bins of a wedge and the rows behind it to stay in a core's cache. More would not pay, since
/// long rows are read faster than short ones.
pub(super) fn parts(n_across: usize) -> i64 {
    let for_threads = rayon::current_num_threads();
    as_i64(for_threads.max(n_across / LONGEST_ROW).next_power_of_two()).clamp(1, MAX_PARTS)
}

/// Returns raster rows and columns of the cells near the UAV inside the window, which no wedge
/// decides.
pub(super) fn near_cells(asked: &Asked) -> (Range<usize>, Range<usize>) {
    let reach = NEAR / CELL + 1;
    let clip = |middle: i64, low: usize, n: usize| {
        let at = |v: i64| usize::try_from(v.max(0)).unwrap_or(usize::MAX).clamp(low, low + n);
        at(middle - reach)..at(middle + reach + 1)
    };
    let (east, north) = (asked.uav.x.div_euclid(CELL), asked.uav.y.div_euclid(CELL));
    let row = as_i64(asked.shape.0) - 1 - north;
    (clip(row, asked.window.row, asked.window.n_rows), clip(east, asked.window.col, asked.window.n_cols))
}

pub(super) fn as_i64(n: usize) -> i64 {
    i64::try_from(n).unwrap_or(i64::MAX)
}
