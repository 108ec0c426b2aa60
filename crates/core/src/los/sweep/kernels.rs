//! The inner loops of the sweep, in vectors of whatever width the machine has.
//!
//! Every lane does the same few IEEE operations in the same order at every width, nothing is fused and nothing is
//! summed across lanes, so all instruction sets give the same bits.

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::{
    __m256, __m256i, _mm256_blendv_ps, _mm256_castsi256_ps, _mm256_cmpgt_epi32, _mm256_permutevar8x32_ps,
    _mm256_set1_epi32,
};

use fearless_simd::prelude::*;
#[cfg(target_arch = "x86_64")]
use fearless_simd::{Level, f32x8, u32x8};

use super::quadrants::{CELL, as_i64};
use crate::quantity::VOID;

/// A height that blocks nothing, and a slope below every slope: far below −2^27, and finite so that no product with it
/// is undefined.
pub(super) const NOTHING: f32 = -1e30;

/// Room that vectors may read or write before and after the part of a buffer that is in use.
pub(super) const PAD: usize = 128;
/// [`PAD`] among bins and cells, which are counted with a sign.
pub(super) const PAD_I64: i64 = 128;

/// Bits of a lattice position below the cell.
pub(super) const CELL_BITS: u32 = CELL.trailing_zeros();

/// Relative width of the doubt around a bound: both slopes of a comparison are off by less than 2^-21 of themselves.
const DOUBT: f32 = 1.0 / (1 << 19) as f32;

/// Relative slack of slopes that tell which bins and tiles need not be looked at: wider than any doubt.
pub(super) const SLACK: f32 = 1e-5;

/// How the edges of bins lie over the cells of a line: edge `b` is at `(uav + b·y) / 2^shift` cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct EdgeMap {
    /// Lateral position of the UAV, times 2^level \[lattice steps\].
    pub(super) uav: i64,
    /// Bits below the cell index: those of the lattice and of the level of the bins.
    pub(super) shift: u32,
}

impl EdgeMap {
    /// The cell under edge `b` at distance `y`.
    #[inline]
    pub(super) fn cell(&self, b: i64, y: i64) -> i64 {
        (self.uav + b * y) >> self.shift
    }
}

/// Heights of a line above the UAV, as floats: `line` holds them from [`PAD`] on, [`NOTHING`] where `raw` is void. Returns the
/// highest.
#[inline(always)]
pub(super) fn heights_above_uav<S: Simd>(simd: S, raw: &[i32], uav_z: i32, line: &mut [f32]) -> f32 {
    let n = S::f32s::LEN;
    let (void, nothing, uav) = (S::i32s::splat(simd, VOID), S::f32s::splat(simd, NOTHING), S::i32s::splat(simd, uav_z));
    let mut highest = nothing;
    let mut chunks = raw.chunks_exact(n);
    let mut out = line.chunks_exact_mut(n);
    for (tops, line) in (&mut chunks).zip(&mut out) {
        let tops = S::i32s::from_slice(simd, tops);
        // A void wraps around and is replaced.
        let above: S::f32s = tops.simd_eq(void).select(nothing, (tops - uav).to_float());
        above.store_slice(line);
        highest = highest.max(above);
    }
    let mut highest = highest.as_slice().iter().fold(NOTHING, |a, b| if *b > a { *b } else { a });
    let tail = chunks.remainder();
    let done = raw.len() - tail.len();
    for (top, line) in tail.iter().zip(&mut line[done..]) {
        #[expect(clippy::cast_precision_loss, reason = "the rounding is part of the proven error")]
        let above = top.wrapping_sub(uav_z) as f32;
        *line = if *top == VOID { NOTHING } else { above };
        highest = if *line > highest { *line } else { highest };
    }
    highest
}

/// The numbers of the lanes.
#[inline(always)]
fn lane_numbers<S: Simd>(simd: S) -> S::i32s {
    const NUMBERS: [i32; 16] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];
    S::i32s::from_slice(simd, &NUMBERS[..S::i32s::LEN])
}

/// How far the edges of bins are apart at a distance, lane by lane.
#[derive(Debug, Clone, Copy)]
pub(super) struct EdgeSteps<S: Simd> {
    y: i64,
    steps: S::u32s,
}

impl<S: Simd> EdgeSteps<S> {
    /// At distance `y`.
    #[inline(always)]
    pub(super) fn new(simd: S, y: i64) -> Self {
        // EXACT: 0 ≤ y ≤ 2^26, and at most 16 lanes.
        #[expect(clippy::cast_possible_truncation, reason = "at most 2^26")]
        let steps: S::u32s = (lane_numbers(simd) * S::i32s::splat(simd, y as i32)).bitcast();
        EdgeSteps { y, steps }
    }
}

/// Looks up the heights of the cells under the edges `first..first + count` in some lines, the first of them at index 0: of
/// lateral cell `c` they are at `c + PAD` of each line. On a border between cells that is the cell before it if `is_before`.
#[inline(always)]
pub(super) fn look_up_edges<S: Simd, const N: usize>(
    simd: S,
    map: EdgeMap,
    lines: [&[f32]; N],
    (first, count): (i64, usize),
    edges: &EdgeSteps<S>,
    is_before: bool,
    found: [&mut [f32]; N],
) {
    let n = S::f32s::LEN;
    let EdgeSteps { y, steps } = *edges;
    let step = as_i64(n) * y;
    let mut at = map.uav + first * y - i64::from(is_before) + (PAD_I64 << map.shift);
    // PERF: of one length, so that little is checked within the loop.
    let (len, n_found) = (lines[0].len(), count.next_multiple_of(n));
    assert!(len >= n);
    let lines = lines.map(|line| &line[..len]);
    let found = found.map(|found| &mut found[..n_found]);
    // Beside the raster all cells are alike.
    let last = len - n;
    for i in (0..n_found).step_by(n) {
        // EXACT: a bin is narrower than a cell, so a step is below 2^shift ≤ 2^27, all lanes stay below 2^31, and as many edges
        // as there are lanes lie over as many cells.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "masked to at most 27 bits")]
        let within = (at & ((1_i64 << map.shift) - 1)) as u32;
        let index = (S::u32s::splat(simd, within) + steps) >> map.shift;
        let start = usize::try_from(at >> map.shift).unwrap_or(0).min(last);
        for k in 0..N {
            permuted(simd, &lines[k][start..start + n], index).store_slice(&mut found[k][i..i + n]);
        }
        at += step;
    }
}

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    /// Of the lanes of two vectors, those of the first foremost, the ones that `index` names: of two such pairs.
    #[inline(always)]
    fn permute_pairs_avx2(avx2: Avx2, a: (__m256, __m256), b: (__m256, __m256), index: __m256i) -> (__m256, __m256) {
        let is_high = _mm256_castsi256_ps(_mm256_cmpgt_epi32(index, _mm256_set1_epi32(7)));
        let of = |(low, high)| {
            _mm256_blendv_ps(_mm256_permutevar8x32_ps(low, index), _mm256_permutevar8x32_ps(high, index), is_high)
        };
        (of(a), of(b))
    }
);

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    /// The lanes of a vector that `index` names.
    #[inline(always)]
    fn permute_one_avx2(avx2: Avx2, values: __m256, index: __m256i) -> __m256 {
        _mm256_permutevar8x32_ps(values, index)
    }
);

/// Values `values[index]`, of as many as there are lanes.
#[inline(always)]
fn permuted<S: Simd>(simd: S, values: &[f32], index: S::u32s) -> S::f32s {
    // PERF: permutations of whole lanes take a third of the instructions that those of bytes do.
    #[cfg(target_arch = "x86_64")]
    if let Level::Avx2(avx2) = simd.level() {
        let index = u32x8::from_slice(avx2, index.as_slice());
        let found: f32x8<_> =
            permute_one_avx2(avx2, f32x8::from_slice(avx2, values).into(), index.into()).simd_into(avx2);
        return S::f32s::from_slice(simd, found.as_slice());
    }
    S::f32s::from_slice(simd, values).swizzle_dyn(bytes_of::<S>(index))
}

/// Values `table[base + index]` of two tables for lanes of `index` below twice the width.
#[inline(always)]
pub(super) fn tables<S: Simd>(simd: S, tables: [&[f32]; 2], base: usize, index: S::u32s) -> [S::f32s; 2] {
    let n = S::f32s::LEN;
    let windows = tables.map(|table| &table[base..][..2 * n]);
    #[cfg(target_arch = "x86_64")]
    if let Level::Avx2(avx2) = simd.level() {
        let index = u32x8::from_slice(avx2, index.as_slice());
        let [a, b] = windows.map(|window| {
            let half = |values| f32x8::from_slice(avx2, values).into();
            (half(&window[..8]), half(&window[8..]))
        });
        let found = permute_pairs_avx2(avx2, a, b, index.into());
        return [found.0, found.1].map(|found| {
            let found: f32x8<_> = found.simd_into(avx2);
            S::f32s::from_slice(simd, found.as_slice())
        });
    }
    windows.map(|window| {
        let (low, high) = (S::f32s::from_slice(simd, &window[..n]), S::f32s::from_slice(simd, &window[n..]));
        low.concat_swizzle_dyn(high, bytes_of::<S>(index))
    })
}

/// The indices of the four bytes of each lane that is named.
#[inline(always)]
fn bytes_of<S: Simd>(index: S::u32s) -> <S::u32s as Bytes>::Bytes {
    (index * 0x0404_0404 + 0x0302_0100).to_bytes()
}

/// One line as its bins see it.
#[derive(Debug, Clone, Copy)]
pub(super) struct LineSlopes {
    /// One over the distances of its nearer and its farther edge.
    pub(super) per_near: f32,
    pub(super) per_far: f32,
    pub(super) number: i32,
    /// Whether no height is above the UAV.
    pub(super) is_below: bool,
}

impl LineSlopes {
    /// What a height above the UAV is multiplied by at the nearer and at the farther edge for the least slope that `upper` may
    /// have, put off by the doubt. The larger product counts: below the UAV a height binds at the farther edge, above it at
    /// the nearer one.
    fn upper_factors(self) -> (f32, f32) {
        (self.per_near * (1.0 + DOUBT), self.per_far * (1.0 - DOUBT))
    }

    /// What a height is multiplied by at either edge for the largest slope that `lower` may have where no height is above the UAV.
    fn lower_factors(self) -> (f32, f32) {
        (self.per_near * (1.0 + DOUBT), self.per_far * (1.0 + DOUBT))
    }

    /// The bounds that a line puts on a bin, whose edges have the heights `entries` and `exits`: its own `upper` and `lower`.
    #[inline(always)]
    pub(super) fn bounds(self, entries: (f32, f32), exits: (f32, f32)) -> (f32, f32) {
        let max = |a: f32, b: f32| if a > b { a } else { b };
        let min = |a: f32, b: f32| if a < b { a } else { b };
        let (upper_near, upper_far) = self.upper_factors();
        let high = max(max(entries.0, entries.1), max(exits.0, exits.1));
        let (entry, exit) = (min(entries.0, entries.1), min(exits.0, exits.1));
        if self.is_below {
            let (lower_near, lower_far) = self.lower_factors();
            (high * upper_far, max(entry * lower_near, exit * lower_far))
        } else {
            let proven = max(entry * self.per_near, exit * self.per_far);
            (max(high * upper_near, high * upper_far), proven - proven.abs() * DOUBT)
        }
    }
}

/// What a line changes of some bins, a value each.
#[derive(Debug)]
pub(super) struct SlopeRows<'a> {
    pub(super) upper: &'a mut [f32],
    pub(super) lower: &'a mut [f32],
    pub(super) second: &'a mut [f32],
    pub(super) steepest_line: &'a mut [i32],
    pub(super) present: &'a mut [f32],
}

/// What the end of a group changes of `n_bins` bins, a value each and a vector more.
#[derive(Debug)]
pub(super) struct GroupRows<'a> {
    pub(super) n_bins: usize,
    pub(super) lower: &'a [f32],
    pub(super) present: &'a mut [f32],
    pub(super) steepest: &'a mut [f32],
    pub(super) steepest_start: &'a mut [i32],
    pub(super) next_steepest: &'a mut [f32],
    pub(super) next_start: &'a mut [i32],
    pub(super) others: &'a mut [f32],
    pub(super) first_other: &'a mut [i32],
    pub(super) last_other: &'a mut [i32],
}

/// Raises the bounds of bins by one line: `entries[i]`, `entries[i + 1]` belong to the edges of bin `i`, and so do exits. The
/// number of bins is a multiple of the width.
#[inline(always)]
pub(super) fn raise_bounds<S: Simd>(simd: S, edges: (&[f32], &[f32]), line: LineSlopes, bins: &mut SlopeRows<'_>) {
    let splat = |(near, far): (f32, f32)| (S::f32s::splat(simd, near), S::f32s::splat(simd, far));
    let (upper_near, upper_far) = splat(line.upper_factors());
    // PERF: where nothing is above the UAV, and that is most often, a quarter of the operations can be left out.
    if line.is_below {
        let (lower_near, lower_far) = splat(line.lower_factors());
        raise_each(simd, edges, line.number, bins, |high, entry, exit| {
            (high * upper_far, (entry * lower_near).max(exit * lower_far))
        });
    } else {
        let (per_near, per_far) = splat((line.per_near, line.per_far));
        let doubt = S::f32s::splat(simd, DOUBT);
        raise_each(simd, edges, line.number, bins, |high, entry, exit| {
            let proven = (entry * per_near).max(exit * per_far);
            ((high * upper_near).max(high * upper_far), proven - proven.abs() * doubt)
        });
    }
}

/// Raises the bounds of bins by those of one line: `bounds` finds them, given the highest cell under the edges of a bin, the
/// lower one of those where rays enter the line, and the lower one of those where they exit it.
#[inline(always)]
fn raise_each<S: Simd>(
    simd: S,
    (entries, exits): (&[f32], &[f32]),
    number: i32,
    bins: &mut SlopeRows<'_>,
    bounds: impl Fn(S::f32s, S::f32s, S::f32s) -> (S::f32s, S::f32s),
) {
    let n = S::f32s::LEN;
    let number = S::i32s::splat(simd, number);
    let SlopeRows { upper, lower, second, steepest_line, present } = bins;
    // PERF: of known lengths, so that nothing is checked within the loop.
    let vectors = |values| <[f32]>::chunks_exact(values, n);
    let edges = vectors(entries).zip(vectors(&entries[1..])).zip(vectors(exits).zip(vectors(&exits[1..])));
    let rows = upper.chunks_exact_mut(n).zip(lower.chunks_exact_mut(n).zip(second.chunks_exact_mut(n)));
    let lines = steepest_line.chunks_exact_mut(n).zip(present.chunks_exact_mut(n));
    for ((((entry, next_entry), (exit, next_exit)), (upper, (lower, second))), (steepest_line, present)) in
        edges.zip(rows).zip(lines)
    {
        let load = |values: &[f32]| S::f32s::from_slice(simd, values);
        let (entry, next_entry, exit, next_exit) = (load(entry), load(next_entry), load(exit), load(next_exit));
        let high = entry.max(next_entry).max(exit.max(next_exit));
        let (slope, proven) = bounds(high, entry.min(next_entry), exit.min(next_exit));
        let before = load(upper);
        before.max(slope).store_slice(upper);
        load(second).max(before.min(slope)).store_slice(second);
        let line_before = S::i32s::from_slice(simd, steepest_line);
        slope.simd_gt(before).select(number, line_before).store_slice(steepest_line);
        load(present).max(slope).store_slice(present);
        load(lower).max(proven).store_slice(lower);
    }
}

/// Ends a group of lines, the first of which is number `start`: it is the steepest one from now on, or one of the others. No
/// receiver that is still to come has a slope below `lowest`.
#[inline(always)]
pub(super) fn end_group<S: Simd>(simd: S, start: i32, lowest: f32, bins: &mut GroupRows<'_>) {
    let n = S::f32s::LEN;
    let (start, lowest) = (S::i32s::splat(simd, start), S::f32s::splat(simd, lowest));
    let GroupRows { n_bins, lower, present, steepest, steepest_start, next_steepest, next_start, others, .. } = bins;
    let (first_other, last_other) = (&mut bins.first_other, &mut bins.last_other);
    for i in (0..*n_bins).step_by(n) {
        let load = |values: &[f32]| S::f32s::from_slice(simd, &values[i..i + n]);
        let load_start = |values: &[i32]| S::i32s::from_slice(simd, &values[i..i + n]);
        let (new, before, before_start) = (load(present), load(steepest), load_start(steepest_start));
        S::f32s::splat(simd, NOTHING).store_slice(&mut present[i..i + n]);
        let is_steepest = new.simd_gt(before);
        is_steepest.select(new, before).store_slice(&mut steepest[i..i + n]);
        is_steepest.select(start, before_start).store_slice(&mut steepest_start[i..i + n]);
        let (rest, rest_start) = (is_steepest.select(before, new), is_steepest.select(before_start, start));
        let (next, next_group) = (load(next_steepest), load_start(next_start));
        let is_next = rest.simd_gt(next);
        is_next.select(rest, next).store_slice(&mut next_steepest[i..i + n]);
        is_next.select(rest_start, next_group).store_slice(&mut next_start[i..i + n]);
        let (other, other_start) = (is_next.select(next, rest), is_next.select(next_group, rest_start));
        // A receiver in doubt is neither below the lowest slope nor below what is proven hidden, so the group may hide it only
        // if it is as steep as both, and no other group can any more if none was.
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
