//! Step 6, if least heights are requested: the steepest obstruction of each link, for 64 receivers
//! at a time.
//!
//! This is the search of [`super::candidates`] for one link, in doubles instead of integers. All
//! products are below 2^53, so only the quotients are rounded. Rounding keeps the order of
//! quotients, so the largest quotient rounded is the largest of the rounded quotients. Candidates
//! are left out only if their upper bound is no higher. So least heights are those of `ray` to the
//! last bit.

use fearless_simd::prelude::*;

use super::bounds::PAD;
use super::candidates::{Candidates, NONE};
use super::frame::{CELL, CELL_BITS};
use super::undecided::Settling;

/// Receivers that are processed together.
pub(super) const BATCH: usize = 64;

/// One candidate of each of some receivers, and its place: numbers below 2^43 without a fraction.
#[derive(Debug)]
pub(super) struct Met {
    /// Distance of the receiver from the axis \[lattice steps\].
    side: [f64; BATCH],
    /// The edge of its bin on the side of the axis, the number of bins to a side, and the inverse
    /// of a cell in these units. Then the distances at which the row begins and ends \[lattice
    /// steps\].
    edge: [f64; BATCH],
    n_bins: [f64; BATCH],
    per_cell: [f64; BATCH],
    near: [f64; BATCH],
    far: [f64; BATCH],
    /// Tops under that edge and under the next one where rays enter the row, then the same where
    /// they leave it.
    tops: [[f64; BATCH]; 4],
    least: [f64; BATCH],
}

impl Candidates {
    /// Returns the least height above the UAV at which each of some receivers of a row is in line
    /// of sight \[1/1024 m\]. It is +∞ if no height is enough, and below all heights if nothing
    /// obstructs.
    #[inline(always)]
    pub(super) fn find_least_heights<S: Simd>(
        &mut self,
        simd: S,
        of: &Settling<'_>,
        cells: &[u32],
        highest: &mut [f64; BATCH],
    ) {
        let length = of.frame.center(of.row) as f64;
        let uav = (if of.is_left() { -of.frame.uav_lateral } else { of.frame.uav_lateral }) as f64;
        let Candidates { newest, listed: all, met, .. } = self;
        // The unfinished receivers: their place in `cells`, and the next candidate to look at.
        let (mut which, mut next, mut before) = ([0_u8; BATCH], [NONE; BATCH], [0.0_f64; BATCH]);
        let mut n = 0;
        for (k, cell) in cells.iter().enumerate() {
            highest[k] = f64::NEG_INFINITY;
            #[expect(clippy::cast_possible_truncation, reason = "below 64")]
            let number = k as u8;
            which[n] = number;
            next[n] = newest[of.bin(*cell as usize) + PAD];
            n += usize::from(next[n] != NONE);
        }
        while n > 0 {
            for k in 0..n {
                let cell = cells[usize::from(which[k])] as usize;
                let (listed, number) = (&all[next[k] as usize], of.number(cell));
                let lane = listed.lane(number, of.level);
                let (near, far) = (of.frame.near(listed.row as usize), of.frame.far(listed.row as usize));
                let [a, b, c, d] = listed.tops(lane).map(f64::from);
                let number = number >> (of.level - listed.level);
                let (edge, tops) = if of.is_left() { (-(number + 1), [b, a, d, c]) } else { (number, [a, b, c, d]) };
                met.side[k] = of.side(cell) as f64;
                met.edge[k] = edge as f64;
                let n_bins = f64::from(1_u32 << listed.level);
                (met.n_bins[k], met.per_cell[k]) = (n_bins, one_over_power_of_two(CELL_BITS + listed.level));
                (met.near[k], met.far[k]) = (near as f64, far as f64);
                for (of_all, top) in met.tops.iter_mut().zip(tops) {
                    of_all[k] = top;
                }
                before[k] = f64::from(listed.before[lane]) * length;
                next[k] = listed.next[lane];
            }
            simd.vectorize(
                #[inline(always)]
                || met.find(simd, (uav, length, f64::from(of.frame.blocks_all)), n),
            );
            let mut n_left = 0;
            for k in 0..n {
                let cell = usize::from(which[k]);
                highest[cell] = if met.least[k] > highest[cell] { met.least[k] } else { highest[cell] };
                // Upper bounds leave more slack than the error of a product of doubles.
                let (mut rest, mut place) = (before[k], next[k]);
                while rest > highest[cell] {
                    let listed = &all[place as usize];
                    let lane = listed.lane(of.number(cells[cell] as usize), of.level);
                    if f64::from(listed.upper[lane]) * length > highest[cell] {
                        (which[n_left], next[n_left]) = (which[k], place);
                        n_left += 1;
                        break;
                    }
                    (rest, place) = (f64::from(listed.before[lane]) * length, listed.next[lane]);
                }
            }
            n = n_left;
        }
    }
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
    fn find<S: Simd>(&mut self, simd: S, (uav, length, blocks_all): (f64, f64, f64), n: usize) {
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
fn one_over_power_of_two(n: u32) -> f64 {
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
