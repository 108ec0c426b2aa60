//! Step 5: how the receivers that bounds leave undecided are settled.
//!
//! Two ways, of one interface. Where all rows are in memory, a bin remembers which rows may hide a receiver, and these are looked at
//! again ([`super::suspects`]). Where they are not, or least heights are asked for, it remembers the tops of these rows under its
//! edges ([`super::candidates`]): that costs more, but no row is ever read again.

use std::ops::Range;

use fearless_simd::prelude::*;

use super::frame::{BATCH, CELL, Frame, as_i64};
use super::receivers::{ReceiverMap, RowReceivers};

/// A row, as it passes over bins from number `first` on among 2^level to a side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passed {
    pub(super) row: usize,
    pub(super) first: i64,
    pub(super) level: u32,
}

/// What a row says of the bins of a vector: its own bounds, below every slope where there is no bin; and those of the bins, `upper`
/// by the rows before it alone.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowBounds<S: Simd> {
    pub(super) upper: S::f32s,
    pub(super) lower: S::f32s,
    pub(super) upper_before: S::f32s,
    pub(super) lower_now: S::f32s,
}

/// What the bins of a wedge remember of rows, to settle the receivers that bounds leave in doubt.
pub(super) trait Recall: Send {
    /// Whether it can tell least heights.
    const WITH_HEIGHTS: bool;

    /// Makes two bins of each of `len`, which both remember the same.
    fn split(&mut self, len: usize);

    /// Adds a row to the bins of a vector, the first of which is `bin` in the wedge; under their edges rays enter it and leave it
    /// at these tops.
    fn add<S: Simd>(&mut self, passed: &Passed, bin: usize, edges: (&[i32], &[i32]), bounds: &RowBounds<S>);

    /// Ends a group of rows for some bins; given `lower` of all, and a slope that no receiver still to come is below.
    fn end_group<S: Simd>(&mut self, simd: S, lower: (&[f32], f32), bins: Range<usize>);

    /// Begins a group of rows, no more than a tile has; given `lower` of the bins from number `first` on among 2^level to a side.
    fn begin_group(&mut self, row: usize, lower: &[f32], first_and_level: (i64, u32));

    /// Finds which receivers in doubt of a row no row before it hides: their cells are the first in `seen` then, so many of them.
    fn settle(&self, of: &Settling<'_>, open: &mut [Open], seen: &mut [u32]) -> usize;

    /// The least height above the UAV of each of some receivers that is in line of sight \[1/1024 m\], if it can tell.
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
    /// The number of the first bin of the wedge among 2^level to a side, and of the last one that a receiver may be given.
    pub(super) bins: (i64, i64),
    pub(super) level: u32,
}

impl Settling<'_> {
    /// The bin of a receiver in the wedge.
    #[inline(always)]
    pub(super) fn bin(&self, cell: usize) -> usize {
        usize::try_from(self.number(cell) - self.bins.0).unwrap_or(0)
    }

    /// The number of that bin among 2^level to a side.
    #[inline(always)]
    pub(super) fn number(&self, cell: usize) -> i64 {
        self.map.bin(as_i64(cell)).min(self.bins.1)
    }

    /// Whether the wedge is to the left of the axis.
    #[inline(always)]
    pub(super) fn is_left(&self) -> bool {
        self.bins.0 < 0
    }

    /// How far a receiver is from the axis \[lattice steps\].
    #[inline(always)]
    pub(super) fn side(&self, cell: usize) -> i64 {
        (as_i64(cell) * CELL + CELL / 2 - self.frame.uav_lateral).abs()
    }

    /// The slope of a receiver so much above the UAV, rounded as where it was compared with bounds.
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
