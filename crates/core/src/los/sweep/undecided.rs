//! Step 5: settles the receivers that bounds leave undecided.
//!
//! Two ways share one interface. If all rows are in memory, a bin remembers which rows may hide a
//! receiver, and these are looked at again ([`super::suspects`]). If they are not, or least heights
//! are requested, it remembers the tops of these rows under its edges ([`super::candidates`]). That
//! costs more, but no row is ever read again.

use std::ops::Range;

use fearless_simd::prelude::*;

use super::frame::{BATCH, CELL, Frame, as_i64};
use super::receivers::{ReceiverMap, RowReceivers};

/// A row that passes over bins from number `first` on among 2^level to a side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passed {
    pub(super) row: usize,
    pub(super) first: i64,
    pub(super) level: u32,
}

/// Bounds of a row and of the bins of a vector. The row's bounds are below every slope where there
/// is no bin. Of the bins, `upper_before` is by the earlier rows alone, `lower_now` includes this
/// row.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowBounds<S: Simd> {
    pub(super) upper: S::f32s,
    pub(super) lower: S::f32s,
    pub(super) upper_before: S::f32s,
    pub(super) lower_now: S::f32s,
}

/// Memory of a wedge's bins about rows, to settle the receivers that bounds leave in doubt.
pub(super) trait Recall: Send {
    /// `true` if it can find least heights.
    const WITH_HEIGHTS: bool;

    /// Splits each of `len` bins into two with the same memory.
    fn split(&mut self, len: usize);

    /// Adds a row to the bins of a vector; the first of them is `bin` in the wedge. Rays under
    /// their edges enter and leave the row at these tops.
    fn add<S: Simd>(&mut self, passed: &Passed, bin: usize, edges: (&[i32], &[i32]), bounds: &RowBounds<S>);

    /// Ends a group of rows for some bins. Gets `lower` of all bins, and a lower limit of the
    /// slopes of all later receivers.
    fn end_group<S: Simd>(&mut self, simd: S, lower: (&[f32], f32), bins: Range<usize>);

    /// Begins a group of rows, at most those of a tile. Gets `lower` of the bins from number
    /// `first` on among 2^level to a side.
    fn begin_group(&mut self, row: usize, lower: &[f32], first_and_level: (i64, u32));

    /// Finds the receivers in doubt of a row that no earlier row hides. Writes their cells to the
    /// beginning of `seen` and returns their number.
    fn settle(&self, of: &Settling<'_>, open: &mut [Open], seen: &mut [u32]) -> usize;

    /// Finds the least height above the UAV at which each of some receivers is in line of sight
    /// \[1/1024 m\], if supported.
    fn least_heights<S: Simd>(&mut self, _: S, _: &Settling<'_>, _cells: &[u32], _highest: &mut [f64; BATCH]) {}
}

/// The receivers of one row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Settling<'a> {
    pub(super) frame: &'a Frame,
    pub(super) row: usize,
    pub(super) receivers: &'a RowReceivers<'a>,
    pub(super) map: ReceiverMap,
    pub(super) per_distance: f32,
    /// The number of the first bin of the wedge among 2^level to a side, and of the last one that a
    /// receiver may belong to.
    pub(super) bins: (i64, i64),
    pub(super) level: u32,
}

impl Settling<'_> {
    /// Returns the bin of a receiver in the wedge.
    #[inline(always)]
    pub(super) fn bin(&self, cell: usize) -> usize {
        usize::try_from(self.number(cell) - self.bins.0).unwrap_or(0)
    }

    /// Returns the number of that bin among 2^level to a side.
    #[inline(always)]
    pub(super) fn number(&self, cell: usize) -> i64 {
        self.map.bin(as_i64(cell)).min(self.bins.1)
    }

    /// Returns `true` if the wedge is to the left of the axis.
    #[inline(always)]
    pub(super) fn is_left(&self) -> bool {
        self.bins.0 < 0
    }

    /// Returns the distance of a receiver from the axis \[lattice steps\].
    #[inline(always)]
    pub(super) fn side(&self, cell: usize) -> i64 {
        (as_i64(cell) * CELL + CELL / 2 - self.frame.uav_lateral).abs()
    }

    /// Returns the slope of a receiver at this height above the UAV, rounded as in the comparison
    /// with bounds.
    #[inline(always)]
    #[expect(clippy::cast_precision_loss, reason = "see above")]
    pub(super) fn slope(&self, above_uav: i64) -> f32 {
        above_uav as f32 * self.per_distance
    }
}

/// A receiver in doubt: its lateral cell.
#[derive(Debug, Clone, Copy)]
pub(super) struct Open {
    pub(super) cell: u32,
}
