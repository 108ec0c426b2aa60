//! Step 5 with all rows in memory: the few rows that may hide a receiver in doubt are looked up, or
//! walked over.
//!
//! Rows come in *groups*: the rows of one row of tiles. Each bin knows its steepest row and the
//! slope of the second steepest. It also knows which groups hold other rows that may hide a
//! receiver: the present one, the steepest one before it, and the first and the last of the rest.
//!
//! The steepest row, looked at where the ray enters and leaves it, hides four of ten receivers in
//! doubt. Three of ten are seen because no other row is as steep as they are. Over laser scans a
//! half to three quarters of the rest need one group.

use std::ops::Range;

use fearless_simd::prelude::*;

use super::bounds::split;
use super::frame::{CELL, PAD, as_i64};
use super::receivers::AZIMUTH_BITS;
use super::row_walk::{LinkLength, LinkOverRows, RowCells, RowTiles, SeenTops};
use super::undecided::{Open, Passed, Recall, RowBounds, Settling};
use crate::height_field::{Columns, TILE};

/// Below every slope that counts.
const NO_SLOPE: f32 = f32::NEG_INFINITY;

/// Knowledge of a wedge's bins about the rows that may hide a receiver: values of bin `i` are at
/// `i + PAD`.
#[derive(Debug)]
pub(super) struct Suspects<'a> {
    columns: &'a Columns,
    /// The steepest row, and the upper bound by all other rows.
    steepest_row: Vec<i32>,
    second: Vec<f32>,
    /// The upper bound by the rows of the present group, and its first row.
    present: Vec<f32>,
    present_start: i32,
    /// The upper bound by the steepest group before it, and its first row.
    steepest: Vec<f32>,
    steepest_start: Vec<i32>,
    /// The upper bound by all other groups. Then the first rows of the first and of the last of
    /// these groups that may still hide a receiver.
    others: Vec<f32>,
    first_other: Vec<i32>,
    last_other: Vec<i32>,
}

impl<'a> Suspects<'a> {
    /// Makes the knowledge of no rows.
    pub(super) fn new(columns: &'a Columns, len: usize) -> Self {
        let slopes = || vec![NO_SLOPE; len + 2 * PAD];
        let rows = || vec![0; len + 2 * PAD];
        Suspects {
            columns,
            steepest_row: rows(),
            second: slopes(),
            present: slopes(),
            present_start: 0,
            steepest: slopes(),
            steepest_start: rows(),
            others: slopes(),
            first_other: rows(),
            last_other: rows(),
        }
    }

    /// Returns the rows that may hide a receiver of slope `slope`: up to two groups, the steeper
    /// one first, and the span of all other groups.
    #[inline(always)]
    fn rows(&self, i: usize, slope: f32) -> ([Option<Rows>; 2], Option<Rows>) {
        let group = |steepest: f32, start: i32| (steepest >= slope).then_some((start, start));
        let present = group(self.present[i], self.present_start);
        let before = group(self.steepest[i], self.steepest_start[i]);
        let groups = if self.present[i] > self.steepest[i] { [present, before] } else { [before, present] };
        (groups, (self.others[i] >= slope).then(|| (self.first_other[i], self.last_other[i])))
    }
}

/// The first rows of the first and of the last of some groups.
type Rows = (i32, i32);

impl Recall for Suspects<'_> {
    const WITH_HEIGHTS: bool = false;

    fn split(&mut self, len: usize) {
        for slopes in [&mut self.second, &mut self.present, &mut self.steepest, &mut self.others] {
            split(slopes, len);
        }
        for rows in [&mut self.steepest_row, &mut self.steepest_start, &mut self.first_other, &mut self.last_other] {
            split(rows, len);
        }
    }

    #[inline(always)]
    fn add<S: Simd>(&mut self, passed: &Passed, bin: usize, _: (&[i32], &[i32]), bounds: &RowBounds<S>) {
        let (simd, n) = (bounds.upper.token(), S::f32s::LEN);
        let at = bin + PAD..bin + PAD + n;
        #[expect(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "fewer than 2^17 rows")]
        let row = S::i32s::splat(simd, passed.row as i32);
        let (upper, before) = (bounds.upper, bounds.upper_before);
        let (second, steepest) = (&mut self.second[at.clone()], &mut self.steepest_row[at.clone()]);
        S::f32s::from_slice(simd, second).max(before.min(upper)).store_slice(second);
        upper.simd_gt(before).select(row, S::i32s::from_slice(simd, steepest)).store_slice(steepest);
        let present = &mut self.present[at];
        S::f32s::from_slice(simd, present).max(upper).store_slice(present);
    }

    #[inline(always)]
    fn end_group<S: Simd>(&mut self, simd: S, (lower, lowest): (&[f32], f32), bins: Range<usize>) {
        // Vectors run over the end.
        let at = bins.start + PAD..bins.end + 2 * PAD;
        let n_bins = bins.len();
        let lower = &lower[at.clone()];
        let [present, steepest, others] =
            [&mut self.present, &mut self.steepest, &mut self.others].map(|slopes| &mut slopes[at.clone()]);
        let [steepest_start, first_other, last_other] =
            [&mut self.steepest_start, &mut self.first_other, &mut self.last_other].map(|rows| &mut rows[at.clone()]);
        let start = self.present_start;
        let n = S::f32s::LEN;
        let (start, lowest) = (S::i32s::splat(simd, start), S::f32s::splat(simd, lowest));
        for i in (0..n_bins).step_by(n) {
            let load = |values: &[f32]| S::f32s::from_slice(simd, &values[i..i + n]);
            let load_start = |values: &[i32]| S::i32s::from_slice(simd, &values[i..i + n]);
            let (new, before, before_start) = (load(present), load(steepest), load_start(steepest_start));
            S::f32s::splat(simd, NO_SLOPE).store_slice(&mut present[i..i + n]);
            let is_steepest = new.simd_gt(before);
            is_steepest.select(new, before).store_slice(&mut steepest[i..i + n]);
            is_steepest.select(start, before_start).store_slice(&mut steepest_start[i..i + n]);
            let (other, other_start) = (is_steepest.select(before, new), is_steepest.select(before_start, start));
            // A receiver in doubt is neither below the lowest slope nor below the proven `lower`.
            // So the group may hide it only if it is as steep as both. If no earlier group was, no
            // other group can hide it any more.
            let bar = lowest.max(load(lower));
            let (may_hide, is_first) = (other.simd_ge(bar), load(others).simd_lt(bar));
            let (first, last) = (load_start(first_other), load_start(last_other));
            let earlier = is_first.select(other_start, first.min(other_start));
            let later = is_first.select(other_start, last.max(other_start));
            may_hide.select(earlier, first).store_slice(&mut first_other[i..i + n]);
            may_hide.select(later, last).store_slice(&mut last_other[i..i + n]);
            load(others).max(other).store_slice(&mut others[i..i + n]);
        }
    }

    fn begin_group(&mut self, row: usize, _: &[f32], _: (i64, u32)) {
        self.present_start = i32::try_from(row).unwrap_or(i32::MAX);
    }

    fn settle(&self, of: &Settling<'_>, open: &mut [Open], seen: &mut [u32]) -> usize {
        let rows = RasterRows::new(self.columns, of);
        // PERF: the steepest row first, for all receivers and without branches. The remaining
        // receivers are few enough for unpredictable branches.
        let (mut n_left, mut n_seen) = (0, 0);
        for k in 0..open.len() {
            let Open { cell } = open[k];
            let above_uav = of.receivers.height(cell as usize);
            let i = of.bin(cell as usize) + PAD;
            let back = rows.row - i64::from(self.steepest_row[i]);
            let met = rows.meet(of.map.azimuth(i64::from(cell)), above_uav, back);
            let is_seen = met.is_clear & (of.slope(above_uav) > self.second[i]);
            seen[n_seen] = cell;
            n_seen += usize::from(is_seen);
            open[n_left] = Open { cell };
            n_left += usize::from(!met.is_hidden & !is_seen);
        }
        for Open { cell } in &open[..n_left] {
            let above_uav = of.receivers.height(*cell as usize);
            let suspects = self.rows(of.bin(*cell as usize) + PAD, of.slope(above_uav));
            if rows.is_los(i64::from(*cell), above_uav, suspects) {
                seen[n_seen] = *cell;
                n_seen += 1;
            }
        }
        n_seen
    }
}

/// The rows of the raster before the row of some receivers.
struct RasterRows<'a> {
    columns: &'a Columns,
    seen: SeenTops<'a>,
    uav_z: i64,
    uav_lateral: i64,
    n_lateral: i64,
    /// The number of the receivers' row, also in the raster, and the change of numbers there on the
    /// way out, by 1.
    row: i64,
    line: i64,
    outward: i64,
    /// The first cell of the receivers' row, and the strides to the next row outward and along a
    /// row.
    start: i64,
    strides: (i64, i64),
    /// Strides to the tile of the next rows, and to the next tile of the same rows, as numbers in
    /// the raster rise.
    tile_strides: (i64, i64),
    /// Distance of the farther edge of the receivers' row, and of its centers \[lattice steps\].
    far: i64,
    length: LinkLength,
}

/// The certain effects of a row on a link.
struct Met {
    is_hidden: bool,
    is_clear: bool,
}

impl<'a> RasterRows<'a> {
    fn new(columns: &'a Columns, of: &Settling<'_>) -> Self {
        let frame = of.frame;
        let (n_cols, line) = (as_i64(columns.n_cols()), as_i64(frame.line(of.row)));
        let per_row = as_i64(columns.tiles().per_row());
        let outward = if frame.counts_up() { 1 } else { -1 };
        let (start, strides, tile_strides) = if frame.quadrant.has_raster_rows() {
            (line * n_cols, (outward * n_cols, 1), (per_row, 1))
        } else {
            (line, (outward, n_cols), (1, per_row))
        };
        RasterRows {
            columns,
            seen: SeenTops::of(columns, frame.quadrant.has_raster_rows()),
            uav_z: i64::from(frame.uav_z),
            uav_lateral: frame.uav_lateral,
            n_lateral: frame.n_lateral,
            row: as_i64(of.row),
            line,
            outward,
            start,
            strides,
            tile_strides,
            far: frame.far(of.row),
            length: LinkLength::new(frame.center(of.row)),
        }
    }

    /// Returns `true` if no suspected row hides the receiver of a lateral cell, `above_uav` above
    /// the UAV \[1/1024 m\].
    fn is_los(&self, lateral: i64, above_uav: i64, (groups, others): ([Option<Rows>; 2], Option<Rows>)) -> bool {
        let RasterRows { columns, strides, .. } = *self;
        let heights = (self.uav_z + above_uav, -above_uav);
        let link = LinkOverRows::new(self.length, (lateral, self.n_lateral), self.uav_lateral, heights);
        let own = usize::try_from(self.start + lateral * strides.1).unwrap_or(0);
        let (at, step, seen) = ((self.line, lateral), -self.outward, self.seen);
        let cells = RowCells { seen, at, step, own, strides: (-strides.0, strides.1), tiles: None };
        // A group has too few rows for tiles to save any.
        let tiles = || RowTiles { tiles: columns.tiles(), strides: self.tile_strides };
        groups.iter().flatten().all(|rows| link.is_clear(&cells, self.edges_of(*rows)))
            && others.is_none_or(|rows| link.is_clear(&RowCells { tiles: Some(tiles()), ..cells }, self.edges_of(rows)))
    }

    /// Returns the distances of some groups, from the first rows of the first and of the last one.
    #[inline(always)]
    fn edges_of(&self, (first, last): Rows) -> (i64, i64) {
        // A group has no more rows than a tile, all of them before the receivers' own.
        let last = (self.row - i64::from(last) - as_i64(TILE) + 1).max(1);
        self.edges(self.row - i64::from(first), last)
    }

    /// Returns the distances of two edges: the nearer edge of the row `first` before the
    /// receivers', and the farther edge of the row `last` before it.
    #[inline(always)]
    fn edges(&self, first: i64, last: i64) -> (i64, i64) {
        ((self.far - (first + 1) * CELL).max(0), self.far - last * CELL)
    }

    /// Returns the effect of the row `back` before the receivers' on the link to a receiver. The
    /// ray is looked at where it enters and where it leaves the row, unless that is next to a
    /// border of cells.
    #[inline(always)]
    fn meet(&self, azimuth: i64, above_uav: i64, back: i64) -> Met {
        let (near, far) = self.edges(back, back);
        // Heights are compared times the distance of the receiver. The result holds the height of
        // the cell's top above the UAV, the height of the ray, and whether the cell is certain.
        let look = |distance: i64| {
            // EXACT: an azimuth is off by less than a lattice step at the receiver, the product
            // rounded down by one at most.
            let at = self.uav_lateral + ((azimuth * distance) >> AZIMUTH_BITS);
            let (cell, within) = (at.div_euclid(CELL), at.rem_euclid(CELL));
            let is_certain = (0..self.n_lateral).contains(&cell) & (2..CELL - 2).contains(&within);
            let index = if is_certain { self.start - back * self.strides.0 + cell * self.strides.1 } else { 0 };
            let place = (self.line - back * self.outward, if is_certain { cell } else { 0 });
            let top = usize::try_from(index).map_or(0, |index| i64::from(self.seen.top(index, place)) - self.uav_z);
            // EXACT: heights are below 2^31, distances at most 2^26.
            (top * self.length.steps(), above_uav * distance, is_certain)
        };
        let ((top, height, is_certain), (far_top, far_height, is_far_certain)) = (look(near), look(far));
        Met {
            is_hidden: is_certain & (top > height) | is_far_certain & (far_top > far_height),
            // Between both points the ray is in these two cells alone.
            is_clear: is_certain & is_far_certain & (top.max(far_top) <= height.min(far_height)),
        }
    }
}
