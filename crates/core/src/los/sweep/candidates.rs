//! Step 5 without reading rows again: finds, exactly, the row that obstructs a link most among
//! those that may obstruct a ray of its bin most.
//!
//! A row is a *candidate* of a bin while its own upper bound is not below the bin's `lower`. A row
//! whose lower bound is not below the bin's `upper` replaces all earlier candidates. Later
//! candidates are listed, the newest first. The tops under the edges of the bin are kept with each
//! candidate. A ray of the bin is in no other cell of the row, and its place among these cells is
//! decided in integers.
//!
//! So the steepest obstruction of a link is the steepest one over the candidates of its bin. Each
//! candidate gives the *obstructing point* of the one or two cells that the ray crosses.

use std::ops::Range;

use fearless_simd::prelude::*;

use super::bounds::split;
use super::frame::{BATCH, CELL, CELL_BITS, FIRST_LEVEL, Frame, PAD, as_i64};
use super::least_heights::{Met, one_over_power_of_two};
use super::undecided::{Open, Passed, Recall, RowBounds, Settling};

/// Bins that are listed together: as many as the widest vector has lanes.
pub(super) const LANES: usize = 8;

/// Number of listed rows per vector of bins, on average, from which on rows that are no longer
/// candidates are removed.
const MOST_LISTED: usize = 32;

/// No row.
pub(super) const NONE: u32 = u32::MAX;

/// Below every slope.
const NO_SLOPE: f32 = f32::NEG_INFINITY;

/// A row that is a candidate of some adjacent bins, as many as a vector has lanes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Listed {
    /// For each bin: the place of the candidate before it, the highest upper bound of all before
    /// it, and its own upper bound.
    pub(super) next: [u32; LANES],
    pub(super) before: [f32; LANES],
    pub(super) upper: [f32; LANES],
    /// Tops under the edges of the bins where rays enter the row, and where they leave it \[1/1024
    /// m above the UAV\].
    enters: [i32; LANES + 1],
    leaves: [i32; LANES + 1],
    pub(super) row: u32,
    /// The number of the first bin, among 2^level bins to a side.
    first: i32,
    pub(super) level: u32,
}

impl Listed {
    /// Returns the lane of the bin with a number among 2^level to a side, or of the bin that holds
    /// it.
    #[inline(always)]
    pub(super) fn lane(&self, number: i64, level: u32) -> usize {
        usize::try_from((number >> (level - self.level)) - i64::from(self.first)).unwrap_or(0) % LANES
    }

    /// Returns the tops under the two edges of a bin where rays enter the row, and where they leave
    /// it.
    #[inline(always)]
    pub(super) fn tops(&self, lane: usize) -> [i32; 4] {
        [self.enters[lane], self.enters[lane + 1], self.leaves[lane], self.leaves[lane + 1]]
    }
}

/// The candidate rows of the bins of a wedge: values of bin `i` are at `i + PAD`.
#[derive(Debug)]
pub(super) struct Candidates {
    /// For each bin the newest candidate, and the highest upper bound of all its candidates.
    pub(super) newest: Vec<u32>,
    highest: Vec<f32>,
    pub(super) listed: Vec<Listed>,
    /// Number of listed rows from which on old candidates are removed; and room for the remaining
    /// rows.
    most: usize,
    spare: Vec<Listed>,
    pub(super) met: Box<Met>,
}

impl Candidates {
    pub(super) fn new(len: usize) -> Self {
        Candidates {
            newest: vec![NONE; len + 2 * PAD],
            highest: vec![NO_SLOPE; len + 2 * PAD],
            listed: Vec::new(),
            most: MOST_LISTED,
            spare: Vec::new(),
            met: Met::new(),
        }
    }

    /// Returns the newest candidate of a bin.
    #[inline(always)]
    pub(super) fn newest(&self, bin: usize) -> u32 {
        self.newest[bin + PAD]
    }

    /// Returns `true` if a candidate hides the receiver of a link of slope `slope`.
    #[inline(always)]
    fn is_hidden(&self, frame: &Frame, link: &Link, slope: f32) -> bool {
        let mut next = self.newest(link.bin);
        while let Some(listed) = self.listed.get(next as usize) {
            let lane = listed.lane(link.number, link.level);
            if listed.upper[lane] >= slope && link.is_hidden_by(frame, listed.row as usize, listed.tops(lane)) {
                return true;
            }
            if listed.before[lane] < slope {
                return false;
            }
            next = listed.next[lane];
        }
        false
    }

    /// Removes rows that are no longer candidates of any bin, once they may be many. Gets the
    /// values of `lower` of all bins from number `first` on.
    fn tidy(&mut self, lower: &[f32], (first, level): (i64, u32)) {
        if self.listed.len() < self.most {
            return;
        }
        // The new place of each row.
        let mut places = vec![NONE; self.listed.len()];
        for (i, lower) in lower.iter().enumerate() {
            let number = first + as_i64(i);
            // The last kept candidate before the next one.
            let mut last: Option<(usize, usize)> = None;
            let mut next = self.newest[PAD + i];
            while let Some(listed) = self.listed.get(next as usize) {
                let lane = listed.lane(number, level);
                let place = next as usize;
                if listed.level != level {
                    // Several bins share it, so it is kept unchanged.
                    places[place] = 0;
                    next = listed.next[lane];
                    continue;
                }
                let is_kept = listed.upper[lane] >= *lower;
                next = if listed.before[lane] >= *lower { listed.next[lane] } else { NONE };
                if is_kept {
                    places[place] = 0;
                    last = Some((place, lane));
                }
                match last {
                    Some((place, lane)) => self.listed[place].next[lane] = next,
                    None => self.newest[PAD + i] = next,
                }
            }
        }
        self.spare.clear();
        for (listed, place) in self.listed.iter().zip(&mut places) {
            if *place == 0 {
                #[expect(clippy::cast_possible_truncation, reason = "far fewer than 2^32")]
                let new = self.spare.len() as u32;
                *place = new;
                self.spare.push(*listed);
            }
        }
        let mut moved = |next: &mut u32| *next = places.get(*next as usize).copied().unwrap_or(NONE);
        self.spare.iter_mut().for_each(|listed| listed.next.iter_mut().for_each(&mut moved));
        self.newest.iter_mut().for_each(moved);
        std::mem::swap(&mut self.spare, &mut self.listed);
        self.most = self.most.max(2 * self.listed.len());
    }
}

impl Recall for Candidates {
    const WITH_HEIGHTS: bool = true;

    fn split(&mut self, len: usize) {
        split(&mut self.newest, len);
        split(&mut self.highest, len);
        self.most = self.most.max(2 * len / LANES * MOST_LISTED);
    }

    #[inline(always)]
    fn add<S: Simd>(&mut self, passed: &Passed, bin: usize, (enters, leaves): (&[i32], &[i32]), bounds: &RowBounds<S>) {
        let RowBounds { upper, lower, upper_before, lower_now } = *bounds;
        let (simd, n) = (upper.token(), S::i32s::LEN);
        let is_one = upper.simd_ge(lower_now);
        // PERF: in the dark nearly no row may obstruct a ray the most.
        if !is_one.any_true() {
            return;
        }
        let is_the_one = lower.simd_ge(upper_before) & is_one;
        let at = bin + PAD..bin + PAD + n;
        let (newest, highest) = (&mut self.newest[at.clone()], &mut self.highest[at]);
        #[expect(clippy::cast_possible_truncation, reason = "bins and rows are fewer than 2^18")]
        let (first, row) = ((passed.first + as_i64(bin)) as i32, passed.row as u32);
        let (old, old_highest) = (S::u32s::from_slice(simd, newest), S::f32s::from_slice(simd, highest));
        let before = is_the_one.select(S::f32s::splat(simd, NO_SLOPE), old_highest);
        // PERF: where rays reach the ground each row replaces the row before it, also in memory.
        let is_in_place = is_the_one.all_true() && old.simd_eq(S::u32s::splat(simd, newest[0])).all_true();
        let place = match self.listed.get(newest[0] as usize) {
            Some(last) if is_in_place && last.level == passed.level => newest[0],
            _ => {
                self.listed.push(EMPTY);
                #[expect(clippy::cast_possible_truncation, reason = "far fewer than 2^32")]
                let last = self.listed.len() as u32 - 1;
                last
            }
        };
        let listed = &mut self.listed[place as usize];
        (listed.row, listed.first, listed.level) = (row, first, passed.level);
        is_the_one.select(S::u32s::splat(simd, NONE), old).store_slice(&mut listed.next[..n]);
        before.store_slice(&mut listed.before[..n]);
        upper.store_slice(&mut listed.upper[..n]);
        listed.enters[..=n].copy_from_slice(&enters[..=n]);
        listed.leaves[..=n].copy_from_slice(&leaves[..=n]);
        is_one.select(S::u32s::splat(simd, place), old).store_slice(newest);
        is_one.select(before.max(upper), old_highest).store_slice(highest);
    }

    #[inline(always)]
    fn end_group<S: Simd>(&mut self, _: S, _: (&[f32], f32), _: Range<usize>) {}

    fn begin_group(&mut self, _: usize, lower: &[f32], bins: (i64, u32)) {
        self.tidy(lower, bins);
    }

    fn settle(&self, of: &Settling<'_>, open: &mut [Open], seen: &mut [u32]) -> usize {
        let mut n_seen = 0;
        for Open { cell } in open {
            let link = Link::to(of, *cell as usize);
            seen[n_seen] = *cell;
            n_seen += usize::from(!self.is_hidden(of.frame, &link, of.slope(link.above_uav)));
        }
        n_seen
    }

    fn least_heights<S: Simd>(&mut self, simd: S, of: &Settling<'_>, cells: &[u32], highest: &mut [f64; BATCH]) {
        self.find_least_heights(simd, of, cells, highest);
    }
}

const EMPTY: Listed = Listed {
    next: [NONE; LANES],
    before: [NO_SLOPE; LANES],
    upper: [NO_SLOPE; LANES],
    enters: [0; LANES + 1],
    leaves: [0; LANES + 1],
    row: 0,
    first: 0,
    level: 0,
};

impl Candidates {
    /// The least height above the UAV of each of some receivers of a row that is in line of sight \[1/1024 m\]: +∞ if there is none.
    /// Where nothing obstructs, it is below all heights.
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
        // The receivers that are not done with: which of `cells`, and the candidate to look at next.
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
                // Upper bounds leave more slack than a product of doubles is off.
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

/// The link to a receiver, as the rows of its quadrant see it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Link {
    /// The receiver's bin, and its number: that of its lower edge among bins of 1 / 2^level.
    pub(super) bin: usize,
    pub(super) number: i64,
    pub(super) level: u32,
    /// Distance of the receiver from the axis, and along it \[lattice steps\]. The flag is `true`
    /// to the left of the axis, seen from the UAV outward with lateral numbers rising to the right.
    pub(super) side: i64,
    pub(super) length: i64,
    pub(super) is_left: bool,
    /// The receiver's height above the UAV \[1/1024 m\].
    pub(super) above_uav: i64,
}

impl Link {
    /// Makes the link to a receiver of a row.
    #[inline(always)]
    fn to(of: &Settling<'_>, cell: usize) -> Self {
        Link {
            bin: of.bin(cell),
            number: of.number(cell),
            level: of.level,
            side: of.side(cell),
            length: of.frame.center(of.row),
            is_left: of.is_left(),
            above_uav: of.receivers.height(cell),
        }
    }

    /// Returns `true` if a row hides the receiver.
    #[inline(always)]
    fn is_hidden_by(&self, frame: &Frame, row: usize, tops: [i32; 4]) -> bool {
        // EXACT: heights are below 2^27 and distances at most 2^26.
        let [a, b] = self.obstructions(frame, row, tops).map(|(num, den)| self.above_uav * den < num);
        a | b
    }

    /// Returns the demands of the one or two cells of a row that the ray crosses on the receiver's
    /// height above the UAV. A demand is the first number over the second. One cell gives its
    /// demand twice. The `tops` are those of [`Candidates`].
    ///
    /// Left of the axis everything is mirrored, so that rays continue towards higher cells. The ray
    /// is compared with the borders of cells in products of distances. At a border it enters the
    /// cell after it, and leaves the cell before it.
    #[inline(always)]
    fn obstructions(&self, frame: &Frame, row: usize, tops: [i32; 4]) -> [(i64, i64); 2] {
        let Link { side, length, .. } = *self;
        let (near, far) = (frame.near(row), frame.far(row));
        // The edge of the bin on the side of the axis, when the row was passed.
        let level = level_for(far);
        let number = self.number >> (self.level - level);
        let (edge, uav, tops) = if self.is_left {
            (-(number + 1), -frame.uav_lateral, [tops[1], tops[0], tops[3], tops[2]])
        } else {
            (number, frame.uav_lateral, tops)
        };
        // The border after the cell under that edge, from the UAV.
        let border = |y: i64| ((((uav << level) + edge * y) >> (CELL_BITS + level)) + 1) * CELL - uav;
        let (enter_border, leave_border) = (border(near), border(far));
        // EXACT: distances are at most 2^26, so products are at most 2^52.
        let enters_after = side * near >= enter_border * length;
        let leaves_after = side * far > leave_border * length;
        let first = i64::from(if enters_after { tops[1] } else { tops[0] });
        let last = i64::from(if leaves_after { tops[3] } else { tops[2] });
        let enter_border = enter_border + if enters_after { CELL } else { 0 };
        let leave_border = leave_border + if leaves_after { CELL } else { 0 };
        // Where the ray crosses from one cell into the other: at enter_border / side of the length.
        let crosses = enter_border != leave_border;
        // A cell below the UAV obstructs at its end towards the receiver, a cell above it at the
        // end towards the UAV.
        let whole = |y: i64| (length, y);
        let crossing = if crosses { Some((side, enter_border)) } else { None };
        let demand = |top: i64, (num, den): (i64, i64)| {
            if top < i64::from(frame.blocks_all) { (top * num, den) } else { (1, 0) }
        };
        [
            demand(first, if first > 0 { whole(near) } else { crossing.unwrap_or(whole(far)) }),
            demand(last, if last > 0 { crossing.unwrap_or(whole(near)) } else { whole(far) }),
        ]
    }
}

/// Returns the level of the bins for a row whose farther edge is at distance `far` \[lattice
/// steps\]. It is the least level at which bins are narrower than a cell there.
#[inline(always)]
pub(super) fn level_for(far: i64) -> u32 {
    (far / CELL).checked_ilog2().map_or(0, |bits| bits + 1).max(FIRST_LEVEL)
}
