//! Step 3: the effect of one row on the bounds of azimuth bins.
//!
//! By the rows passed so far, no ray of a bin is obstructed above `upper`, and every ray of it is
//! obstructed up to `lower`. One row has bounds of its own. They come from the tops of the four
//! cells under the bin's edges, where rays enter the row and where they leave it. The larger bounds
//! count.

use std::ops::Range;

use fearless_simd::prelude::*;

use super::frame::{CELL_BITS, PAD, PAD_I64, as_i64};
use super::simd::{lane_numbers, permuted};
use super::undecided::{Passed, Recall, RowBounds};

/// A top that blocks nothing, above the UAV \[1/1024 m\].
///
/// Heights differ by 2^26 at most. So over the same distance its slope is below that of every
/// receiver and top, and over a shorter one below that of every receiver farther out. It can hide
/// none.
pub(super) const NOTHING: i32 = -(1 << 30);

/// Relative width of the doubt around a bound: both slopes of a comparison are off by less than 2^-21 of themselves.
const DOUBT: f32 = 1.0 / (1 << 19) as f32;

/// Inverse of distance 0. Any height is then too steep for all receivers, and its slope is still
/// finite.
const PER_NOTHING: f32 = 1e25;

/// Position of a row, in the form that the bounds need.
#[derive(Debug, Clone, Copy)]
pub(super) struct RowSlopes {
    /// Number of the row.
    pub(super) row: usize,
    /// Factors of tops above the UAV at the nearer and the farther edge: for `upper`, moved by the
    /// doubt, and for `lower`.
    upper: (f32, f32),
    lower: (f32, f32),
    /// Share by which `lower` is lowered, if its factors do not include the doubt.
    doubt: f32,
    /// A top behind which no height is enough.
    blocks_all: i32,
}

/// The upper bound of a row with a top that blocks everything: above every slope, so that it
/// remains a candidate.
const BLOCKED: f32 = 1e35;

impl RowSlopes {
    /// Makes the slopes of row number `row`, which spans distances from `near` to `far` \[lattice
    /// steps\]. With `is_below`, no top is above the UAV.
    #[expect(clippy::cast_precision_loss, reason = "the rounding is part of the proven error")]
    pub(super) fn new(row: usize, (near, far): (i64, i64), is_below: bool, blocks_all: i32) -> Self {
        let per = |y: i64| if y == 0 { PER_NOTHING } else { 1.0 / y as f32 };
        let (near, far) = (per(near), per(far));
        // A top below the UAV obstructs most at the farther edge, one above it at the nearer edge:
        // the larger product. So the first factor is for tops above it, the second for tops below
        // it, and each is moved upward.
        let upper = (near * (1.0 + DOUBT), far * (1.0 - DOUBT));
        // PERF: if all tops are below the UAV, the doubt of `lower` is part of the factors, not
        // subtracted from each product.
        let (lower, doubt) =
            if is_below { ((near * (1.0 + DOUBT), far * (1.0 + DOUBT)), 0.0) } else { ((near, far), DOUBT) };
        RowSlopes { row, upper, lower, doubt, blocks_all }
    }

    /// Returns the bounds of one bin, from the tops under its two edges where rays enter the row,
    /// and where they leave it. This is the plain twin of the vectors in [`Bins::raise`].
    pub(super) fn bounds(&self, [enters, enters_next, leaves, leaves_next]: [i32; 4]) -> (f32, f32) {
        let max = |a: f32, b: f32| if a > b { a } else { b };
        #[expect(clippy::cast_precision_loss, reason = "the rounding is part of the proven error")]
        let float = |top: i32| top as f32;
        let high = float(enters.max(enters_next).max(leaves.max(leaves_next)));
        let (enters, leaves) = (float(enters.min(enters_next)), float(leaves.min(leaves_next)));
        let proven = max(enters * self.lower.0, leaves * self.lower.1);
        (max(high * self.upper.0, high * self.upper.1), proven - proven.abs() * self.doubt)
    }
}

/// Positions of the edges of bins over the cells of a row: edge `b` is at `(uav + b·y) / 2^shift`
/// cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct EdgeMap {
    /// Lateral position of the UAV, times 2^level \[lattice steps\].
    uav: i64,
    /// Bits below the cell index: those of the lattice and of the level of the bins.
    shift: u32,
    /// `true` if an edge on a border of cells is over the cell before it.
    is_before: bool,
}

impl EdgeMap {
    /// Makes the map of bins of 1 / 2^level.
    pub(super) fn new(uav_lateral: i64, level: u32, is_before: bool) -> Self {
        EdgeMap { uav: uav_lateral << level, shift: CELL_BITS + level, is_before }
    }

    /// Returns the cell under edge `b` at distance `y`.
    #[inline(always)]
    pub(super) fn cell(&self, b: i64, y: i64) -> i64 {
        (self.uav + b * y - i64::from(self.is_before)) >> self.shift
    }

    /// Returns the lateral cells, from the first to after the last, that rays of the bins `b0..b1`
    /// touch between two distances; clamped to `within`.
    pub(super) fn cells(&self, (b0, b1): (i64, i64), (near, far): (i64, i64), within: (i64, i64)) -> (i64, i64) {
        let low = self.cell(b0, near).min(self.cell(b0, far)).clamp(within.0, within.1);
        let high = (self.cell(b1, near).max(self.cell(b1, far)) + 1).clamp(low, within.1);
        (low, high)
    }

    /// Looks up the tops of the cells under `count` edges from `first` on at distance `y` in some
    /// rows. Results begin at index 0. Lateral cell `c` is at `c + PAD` of each row.
    ///
    /// PERF: neighbors are less than a cell apart, so a vector of edges looks into one vector of
    /// cells.
    #[inline(always)]
    pub(super) fn look_up<S: Simd, const N: usize>(
        &self,
        simd: S,
        rows: [&[i32]; N],
        (first, count): (i64, usize),
        y: i64,
        found: [&mut [i32]; N],
    ) {
        let n = S::i32s::LEN;
        let step = as_i64(n) * y;
        let mut at = self.uav + first * y - i64::from(self.is_before) + (PAD_I64 << self.shift);
        // EXACT: 0 ≤ y ≤ 2^26, and at most 16 lanes.
        #[expect(clippy::cast_possible_truncation, reason = "at most 2^26")]
        let steps: S::u32s = (lane_numbers(simd) * S::i32s::splat(simd, y as i32)).bitcast();
        // PERF: of one length, so that little is checked within the loop.
        let (len, n_found) = (rows[0].len(), count.next_multiple_of(n));
        assert!(len >= n);
        let rows = rows.map(|row| &row[..len]);
        let found = found.map(|found| &mut found[..n_found]);
        // Outside the raster all cells are alike.
        let last = len - n;
        for i in (0..n_found).step_by(n) {
            // EXACT: a bin is narrower than a cell, so a step is below 2^shift ≤ 2^27, all lanes
            // stay below 2^31, and as many edges as there are lanes lie over as many cells.
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "masked to at most 27 bits")]
            let within = (at & ((1_i64 << self.shift) - 1)) as u32;
            let index = (S::u32s::splat(simd, within) + steps) >> self.shift;
            let start = usize::try_from(at >> self.shift).unwrap_or(0).min(last);
            for k in 0..N {
                permuted(simd, &rows[k][start..start + n], index).store_slice(&mut found[k][i..i + n]);
            }
            at += step;
        }
    }
}

/// Bounds of the bins of a wedge: values of bin `i` are at `i + PAD`.
#[derive(Debug)]
pub(super) struct Bins<R> {
    pub(super) len: usize,
    /// No ray of the bin is obstructed above this slope.
    pub(super) upper: Vec<f32>,
    /// Every ray of the bin is obstructed up to this slope.
    pub(super) lower: Vec<f32>,
    /// Memory of the rows passed.
    pub(super) recall: R,
}

impl<R: Recall> Bins<R> {
    /// Makes bins that no row has passed yet.
    pub(super) fn new(len: usize, recall: R) -> Self {
        #[expect(clippy::cast_precision_loss, reason = "a power of two")]
        let slopes = || vec![NOTHING as f32; len + 2 * PAD];
        Bins { len, upper: slopes(), lower: slopes(), recall }
    }

    /// Splits each bin into two with the same values.
    pub(super) fn split(&mut self) {
        split(&mut self.upper, self.len);
        split(&mut self.lower, self.len);
        self.recall.split(self.len);
        self.len *= 2;
    }

    /// Copies the bounds of the last bin to the place after it, for receivers on its farther edge.
    pub(super) fn repeat_last(&mut self) {
        let end = PAD + self.len;
        for bounds in [&mut self.upper, &mut self.lower] {
            bounds[end] = bounds[end - 1];
        }
    }

    /// Raises the bounds of some bins by a row. Rays under edge number `i` enter and leave it at
    /// tops `enters[i]` and `leaves[i]` \[1/1024 m above the UAV\].
    #[inline(always)]
    pub(super) fn raise<S: Simd>(
        &mut self,
        simd: S,
        (slopes, passed): (&RowSlopes, &Passed),
        (enters, leaves): (&[i32], &[i32]),
        bins: Range<usize>,
    ) {
        let n = S::f32s::LEN;
        let splat = |v: f32| S::f32s::splat(simd, v);
        let (upper_near, upper_far) = (splat(slopes.upper.0), splat(slopes.upper.1));
        let (lower_near, lower_far, doubt) = (splat(slopes.lower.0), splat(slopes.lower.1), splat(slopes.doubt));
        let (blocks_all, no_slope) = (S::i32s::splat(simd, slopes.blocks_all), splat(f32::NEG_INFINITY));
        // PERF: of known lengths, so that nothing is checked within the loop.
        let count = bins.len().next_multiple_of(n);
        let edges = bins.start..bins.start + count + n;
        let (enters, leaves) = (&enters[edges.clone()], &leaves[edges]);
        let at = bins.start + PAD..bins.start + PAD + count;
        let (upper, lower) = (&mut self.upper[at.clone()], &mut self.lower[at]);
        for i in (0..count).step_by(n) {
            let (enter, next_enter) = (tops_from::<S>(simd, enters, i), tops_from::<S>(simd, enters, i + 1));
            let (leave, next_leave) = (tops_from::<S>(simd, leaves, i), tops_from::<S>(simd, leaves, i + 1));
            let highest = enter.max(next_enter).max(leave.max(next_leave));
            let high: S::f32s = highest.to_float();
            let (enter, leave): (S::f32s, S::f32s) =
                (enter.min(next_enter).to_float(), leave.min(next_leave).to_float());
            let mut slope = (high * upper_near).max(high * upper_far);
            if R::WITH_HEIGHTS {
                slope = highest.simd_ge(blocks_all).select(splat(BLOCKED), slope);
            }
            let proven = (enter * lower_near).max(leave * lower_far);
            let mut proven = proven - proven.abs() * doubt;
            if bins.len() - i < n {
                // Bins past the last may sleep, and must ignore this row.
                let within = S::mask32s::from_bitmask(simd, (1 << (bins.len() - i)) - 1);
                (slope, proven) = (within.select(slope, no_slope), within.select(proven, no_slope));
            }
            let old_upper = S::f32s::from_slice(simd, &upper[i..i + n]);
            let new_lower = S::f32s::from_slice(simd, &lower[i..i + n]).max(proven);
            old_upper.max(slope).store_slice(&mut upper[i..i + n]);
            new_lower.store_slice(&mut lower[i..i + n]);
            let bounds = RowBounds::<S> { upper: slope, lower: proven, upper_before: old_upper, lower_now: new_lower };
            self.recall.add(passed, bins.start + i, (&enters[i..], &leaves[i..]), &bounds);
        }
    }
}

/// Loads a vector of tops.
#[inline(always)]
fn tops_from<S: Simd>(simd: S, tops: &[i32], at: usize) -> S::i32s {
    S::i32s::from_slice(simd, &tops[at..at + S::i32s::LEN])
}

/// Copies values of bins to bins of half their width.
pub(super) fn split<T: Copy>(values: &mut Vec<T>, len: usize) {
    let padding = values[0];
    values.resize(2 * len + 2 * PAD, padding);
    for i in (0..len).rev() {
        let value = values[PAD + i];
        values[PAD + 2 * i] = value;
        values[PAD + 2 * i + 1] = value;
    }
    values[PAD + 2 * len..].fill(padding);
}
