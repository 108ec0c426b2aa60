//! The inner loops of [`super`]: columns between the bounds of an outline, eight rows at a time,
//! and heights against a ceiling, eight receivers at a time.
//!
//! No multiplication is fused with an addition and all rounding is to integers, so every SIMD level
//! computes the same bits.

use std::ops::Range;

use fearless_simd::prelude::*;
use fearless_simd::{f64x8, u64x8};

use super::ceiling::{Ceiling, Slope};
use super::geometry::as_f64;
use super::outline::{BentLine, Line, Outline};
use super::plane::Plane;
use super::reach::LANES;

/// Cells `.0[k]...1[k]` of eight rows.
pub(super) type Lanes = ([u64; LANES], [u64; LANES]);

/// The cells of eight rows that are surely between the bounds of a shadow.
pub(super) struct Spans {
    pub(super) sure: Lanes,
    /// `true` if no other cell may be.
    pub(super) is_all_sure: bool,
}

/// The western and the eastern bounds of an outline \[columns\] in the eight rows from `row` on,
/// for cells surely inside and for cells possibly inside. Without a bound it is half a column
/// beyond the wanted ones.
struct Bounds<S: Simd> {
    sure: (f64x8<S>, f64x8<S>),
    maybe: (f64x8<S>, f64x8<S>),
}

#[inline(always)]
fn bounds<S: Simd>(simd: S, plane: &Plane, outline: &Outline, row: usize) -> Bounds<S> {
    let splat = |v: f64| f64x8::splat(simd, v);
    let q = f64x8::from_slice(simd, &plane.q[row..row + LANES]);
    let bound = |line: &Line| splat(line.at) + splat(line.per_q) * q;
    let mut west = splat(as_f64(plane.cols.0) - 0.5);
    for line in &outline.west {
        west = west.max(bound(line));
    }
    let mut east = splat(as_f64(plane.cols.1) - 0.5);
    for line in &outline.east {
        east = east.min(bound(line));
    }
    let margin = splat(outline.margin);
    let mut bounds = Bounds { sure: (west + margin, east - margin), maybe: (west - margin, east + margin) };
    let bent = |line: &BentLine| splat(line.at) + splat(line.per_q) * q;
    for line in &outline.bent_west {
        let at = bent(line);
        bounds.sure.0 = bounds.sure.0.max(at + splat(line.inward));
        bounds.maybe.0 = bounds.maybe.0.max(at - splat(line.outward));
    }
    for line in &outline.bent_east {
        let at = bent(line);
        bounds.sure.1 = bounds.sure.1.min(at - splat(line.inward));
        bounds.maybe.1 = bounds.maybe.1.min(at + splat(line.outward));
    }
    bounds
}

/// Rounds to integer columns, clamped to the wanted ones.
#[inline(always)]
fn to_columns<S: Simd>(simd: S, plane: &Plane, v: f64x8<S>) -> [u64; LANES] {
    let splat = |v: f64| f64x8::splat(simd, v);
    let within = v.max(splat(as_f64(plane.cols.0))).min(splat(as_f64(plane.cols.1)));
    // Adding 2^52 leaves an integer below 2^52 in the lowest bits of the double.
    let bits: u64x8<S> = (within + splat((1_u64 << 52) as f64)).bitcast();
    (bits & u64x8::splat(simd, (1 << 52) - 1)).into()
}

/// Returns the columns, with their rows, that may be inside an outline but are not surely inside,
/// in `n` rows from `first` on. The `sure_rows` are those between its horizontal lines.
pub(super) fn doubtful(
    sure: &Lanes,
    maybe: &Lanes,
    sure_rows: (usize, usize),
    (first, n): (usize, usize),
) -> impl Iterator<Item = (usize, Range<usize>)> {
    (0..n).flat_map(move |k| {
        let (row, maybe) = (first + k, [maybe.0[k], maybe.1[k]].map(as_column));
        let mut sure = [sure.0[k], sure.1[k]].map(as_column);
        if row < sure_rows.0 || row >= sure_rows.1 || sure[0] >= sure[1] {
            sure = [maybe[1]; 2];
        }
        [(row, maybe[0]..sure[0]), (row, sure[1]..maybe[1])]
    })
}

/// Converts a column number to an index.
pub(super) fn as_column(v: u64) -> usize {
    usize::try_from(v).unwrap_or(usize::MAX)
}

/// Returns the cells that are surely inside an outline in the eight rows from `row` on.
#[inline(always)]
pub(super) fn spans<S: Simd>(simd: S, plane: &Plane, outline: &Outline, row: usize) -> Spans {
    let Bounds { sure: (west, east), maybe: (maybe_west, maybe_east) } = bounds(simd, plane, outline, row);
    let one = f64x8::splat(simd, 1.0);
    // The last column that may be outside in the west, and the first in the east.
    let (outside_west, outside_east) = (west.floor(), east.ceil());
    let in_doubt = outside_west.simd_ge(maybe_west) | outside_east.simd_le(maybe_east);
    Spans {
        sure: (to_columns(simd, plane, outside_west + one), to_columns(simd, plane, outside_east)),
        is_all_sure: !in_doubt.any_true(),
    }
}

/// Returns the cells that may be inside an outline in the eight rows from `row` on.
#[inline(always)]
pub(super) fn maybe_spans<S: Simd>(simd: S, plane: &Plane, outline: &Outline, row: usize) -> Lanes {
    let Bounds { maybe: (west, east), .. } = bounds(simd, plane, outline, row);
    let end = east.floor() + f64x8::splat(simd, 1.0);
    (to_columns(simd, plane, west.ceil()), to_columns(simd, plane, end))
}

/// Returns, among the 64 receivers from column `first` on of a row, those surely below a ceiling
/// and those too near to decide.
#[inline(always)]
pub(super) fn below_ceiling<S: Simd>(
    simd: S,
    plane: &Plane,
    ceiling: &Ceiling,
    q: f64,
    first: f64,
    heights: &[f64],
) -> (u64, u64) {
    let splat = |v: f64| f64x8::splat(simd, v);
    let (cap, cap_maybe, margin) = (splat(ceiling.cap), splat(ceiling.cap_maybe), splat(ceiling.margin));
    let lane = f64x8::from_slice(simd, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
    let (mut below, mut near) = (0, 0);
    for (k, heights) in heights.chunks_exact(LANES).enumerate() {
        let z = f64x8::from_slice(simd, heights);
        let col = splat(first + as_f64(k * LANES)) + lane;
        let mut bound = splat(f64::INFINITY);
        for Slope { at, per_col, per_q } in &ceiling.slopes {
            bound = bound.min(splat(at + per_q * q) + splat(*per_col) * col);
        }
        if plane.curve != 0.0 {
            // The receivers are lower as seen from the UAV.
            let east = (col - splat(plane.origin)) * splat(plane.step);
            bound = bound + splat(plane.curve * (q * q)) + splat(plane.curve) * (east * east);
        }
        let is_below = z.simd_lt(bound - margin) & z.simd_lt(cap);
        let may_be = z.simd_le(bound + margin) & z.simd_lt(cap_maybe);
        below |= is_below.to_bitmask() << (k * LANES);
        near |= may_be.to_bitmask() << (k * LANES);
    }
    (below, near & !below)
}
