//! Step 6, if least heights are requested: the steepest obstruction of each link, for 64 receivers
//! at a time.
//!
//! This is the search of [`super::candidates`] for one link, in doubles instead of integers. All
//! products are below 2^53, so only the quotients are rounded. Rounding keeps the order of
//! quotients, so the largest quotient rounded is the largest of the rounded quotients. Candidates
//! are left out only if their upper bound is no higher. So least heights are those of `ray` to the
//! last bit.

use fearless_simd::prelude::*;

use super::frame::{BATCH, CELL};

/// One candidate of each of some receivers, and its place: numbers below 2^43 without a fraction.
#[derive(Debug)]
pub(super) struct Met {
    /// Distance of the receiver from the axis \[lattice steps\].
    pub(super) side: [f64; BATCH],
    /// The edge of its bin on the side of the axis, the number of bins to a side, and the inverse
    /// of a cell in these units. Then the distances at which the row begins and ends \[lattice
    /// steps\].
    pub(super) edge: [f64; BATCH],
    pub(super) n_bins: [f64; BATCH],
    pub(super) per_cell: [f64; BATCH],
    pub(super) near: [f64; BATCH],
    pub(super) far: [f64; BATCH],
    /// Tops under that edge and under the next one where rays enter the row, then the same where
    /// they leave it.
    pub(super) tops: [[f64; BATCH]; 4],
    pub(super) least: [f64; BATCH],
}

impl Met {
    /// Makes room for candidates.
    pub(super) fn new() -> Box<Self> {
        let (zeros, ones) = ([0.0; BATCH], [1.0; BATCH]);
        Box::new(Met {
            side: zeros,
            edge: zeros,
            n_bins: ones,
            per_cell: ones,
            near: ones,
            far: ones,
            tops: [zeros; 4],
            least: zeros,
        })
    }

    /// Computes the demand of each of the first `n` rows on its receiver, in as many vectors as
    /// needed.
    #[inline(always)]
    pub(super) fn find<S: Simd>(&mut self, simd: S, (uav, length, blocks_all): (f64, f64, f64), n: usize) {
        let splat = |v: f64| S::f64s::splat(simd, v);
        let (cell, one, zero, uav, length) = (splat(CELL as f64), splat(1.0), splat(0.0), splat(uav), splat(length));
        let (blocks_all, infinity) = (splat(blocks_all), splat(f64::INFINITY));
        for first in (0..n).step_by(S::f64s::LEN) {
            let load = Load { simd, first };
            let (side, near, far) = (load.of(&self.side), load.of(&self.near), load.of(&self.far));
            let [enter, enter_after, leave, leave_after] = &self.tops;
            // The borders after the cells under the edge, from the UAV.
            let (at, edge, per_cell) = (uav * load.of(&self.n_bins), load.of(&self.edge), load.of(&self.per_cell));
            let enter_border = (((at + edge * near) * per_cell).floor() + one) * cell - uav;
            let leave_border = (((at + edge * far) * per_cell).floor() + one) * cell - uav;
            let enters_after = (side * near).simd_ge(enter_border * length);
            let leaves_after = (side * far).simd_gt(leave_border * length);
            let top = enters_after.select(load.of(enter_after), load.of(enter));
            let last_top = leaves_after.select(load.of(leave_after), load.of(leave));
            let enter_border = enters_after.select(enter_border + cell, enter_border);
            let leave_border = leaves_after.select(leave_border + cell, leave_border);
            let crosses = !enter_border.simd_eq(leave_border);
            // Where the ray crosses from one cell into the other: at enter_border / side of the
            // length.
            let (crossed, crossed_at) = (crosses.select(side, length), enter_border);
            let first_far = crosses.select(crossed_at, far);
            let last_near = crosses.select(crossed_at, near);
            let (is_above, is_last_above) = (top.simd_gt(zero), last_top.simd_gt(zero));
            let first_least = top * is_above.select(length, crossed) / is_above.select(near, first_far);
            let last_least = last_top * is_last_above.select(crossed, length) / is_last_above.select(last_near, far);
            let first_least = top.simd_ge(blocks_all).select(infinity, first_least);
            let last_least = last_top.simd_ge(blocks_all).select(infinity, last_least);
            first_least.max(last_least).store_slice(&mut self.least[first..first + S::f64s::LEN]);
        }
    }
}

/// Returns 2^-n.
#[inline(always)]
pub(super) fn one_over_power_of_two(n: u32) -> f64 {
    f64::from_bits((1023 - u64::from(n)) << 52)
}

/// The place of a vector of numbers.
#[derive(Debug, Clone, Copy)]
struct Load<S: Simd> {
    simd: S,
    first: usize,
}

impl<S: Simd> Load<S> {
    #[inline(always)]
    fn of(self, values: &[f64; BATCH]) -> S::f64s {
        S::f64s::from_slice(self.simd, &values[self.first..self.first + S::f64s::LEN])
    }
}
