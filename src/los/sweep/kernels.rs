//! The inner loops of the sweep, in vectors of whatever width the machine has.
//!
//! Every lane does the same few IEEE operations in the same order at every width, nothing is fused and nothing is
//! summed across lanes, so all instruction sets give the same bits.

#[cfg(target_arch = "x86_64")]
use std::arch::x86_64::{
    __m256, __m256i, __m512, __m512i, _mm256_blendv_ps, _mm256_castsi256_ps, _mm256_cmpgt_epi32,
    _mm256_permutevar8x32_ps, _mm256_set1_epi32, _mm512_permutex2var_ps, _mm512_permutexvar_ps,
};

use fearless_simd::prelude::*;
#[cfg(target_arch = "x86_64")]
use fearless_simd::{Level, f32x8, f32x16, u32x8, u32x16};

use super::{CELL, as_i64};
use crate::quantity::VOID;

/// A height that blocks nothing, and a slope below every slope: far below −2^27, and finite so that no product with it
/// is undefined.
pub(super) const NOTHING: f32 = -1e30;

/// Room that vectors may read or write before and after the part of a buffer that is in use.
pub(super) const PAD: usize = 128;
/// The same among bins and cells, which are counted with a sign.
pub(super) const PAD_I64: i64 = 128;

/// Bits of an azimuth in fixed point.
pub(super) const AZIMUTH_BITS: u32 = 36;

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

/// A place in a buffer; one before its beginning is far beyond its end.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "wraps around to what no buffer has")]
fn to_index(at: i64) -> usize {
    at as usize
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

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    /// The lanes of a vector that `index` names.
    #[inline(always)]
    fn permute_one_avx512(avx512: Avx512, values: __m512, index: __m512i) -> __m512 {
        _mm512_permutexvar_ps(index, values)
    }
);

#[cfg(target_arch = "x86_64")]
fearless_simd::kernel!(
    /// Of the lanes of two vectors, those of `low` first, the ones that `index` names.
    #[inline(always)]
    fn permute_avx512(avx512: Avx512, low: __m512, high: __m512, index: __m512i) -> __m512 {
        _mm512_permutex2var_ps(low, index, high)
    }
);

/// Values `values[index]`, of as many as there are lanes.
#[inline(always)]
fn permuted<S: Simd>(simd: S, values: &[f32], index: S::u32s) -> S::f32s {
    // PERF: permutations of whole lanes take a third of the instructions that those of bytes do.
    #[cfg(target_arch = "x86_64")]
    match simd.level() {
        Level::Avx2(avx2) => {
            let index = u32x8::from_slice(avx2, index.as_slice());
            let found: f32x8<_> =
                permute_one_avx2(avx2, f32x8::from_slice(avx2, values).into(), index.into()).simd_into(avx2);
            return S::f32s::from_slice(simd, found.as_slice());
        }
        Level::Avx512(avx512) => {
            let index = u32x16::from_slice(avx512, index.as_slice());
            let found: f32x16<_> =
                permute_one_avx512(avx512, f32x16::from_slice(avx512, values).into(), index.into()).simd_into(avx512);
            return S::f32s::from_slice(simd, found.as_slice());
        }
        _ => {}
    }
    S::f32s::from_slice(simd, values).swizzle_dyn(bytes_of::<S>(index))
}

/// Values `table[base + index]` of two tables for lanes of `index` below twice the width.
#[inline(always)]
fn tables<S: Simd>(simd: S, tables: [&[f32]; 2], base: usize, index: S::u32s) -> [S::f32s; 2] {
    let n = S::f32s::LEN;
    let windows = tables.map(|table| &table[base..][..2 * n]);
    #[cfg(target_arch = "x86_64")]
    match simd.level() {
        Level::Avx2(avx2) => {
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
        Level::Avx512(avx512) => {
            let index = u32x16::from_slice(avx512, index.as_slice());
            return windows.map(|window| {
                let half = |values| f32x16::from_slice(avx512, values).into();
                let found = permute_avx512(avx512, half(&window[..16]), half(&window[16..]), index.into());
                let found: f32x16<_> = found.simd_into(avx512);
                S::f32s::from_slice(simd, found.as_slice())
            });
        }
        _ => {}
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

    /// The same for the largest slope that `lower` may have where no height is above the UAV.
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

/// The bounds of some bins as receivers look them up: bin `b` is at `b − first_bin + PAD`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds<'a> {
    pub(super) upper: &'a [f32],
    pub(super) lower: &'a [f32],
    pub(super) first_bin: i64,
}

/// Bits of a lattice position below the cell.
pub(super) const CELL_BITS: u32 = CELL.trailing_zeros();

/// Bits of a receiver's place among the bins below the bin.
const PLACE_BITS: u32 = 44;
/// Bits below the bin that are left in 32 bits, beside a carry.
const LANE_BITS: u32 = 31;

/// Where the receivers of one line are among its bins.
#[derive(Debug, Clone, Copy)]
pub(super) struct ReceiverMap {
    level: u32,
    /// The cell that places are counted from.
    first: i64,
    /// Of its center from the UAV, times 2^level \[lattice steps\]; less 1 where a receiver on an edge belongs to the bin
    /// before it.
    offset: i64,
    /// Of the line's cell centers from the UAV \[lattice steps\].
    distance: i64,
    /// The place of the first cell, and how far the places of neighbors are apart \[2^-44 bins\].
    origin: i64,
    step: i64,
}

impl ReceiverMap {
    /// For receivers at `distance` from the UAV among bins of 1 / 2^level, from cell `first` on, whose center is `lateral` from
    /// the UAV \[lattice steps\]; a receiver on an edge belongs to the bin before it if `is_before`, or else to the one after
    /// it.
    pub(super) fn new(level: u32, (first, lateral): (i64, i64), distance: i64, is_before: bool) -> Self {
        debug_assert!((1 << 13..1 << 26).contains(&distance) && lateral.abs() << level < distance << 19);
        // EXACT: the n-th cell is (lateral + 1024·n)·2^level / distance bins from the UAV, so that it is on an edge or at least
        // one `distance`-th of a bin from it. Half of that is taken from all places or added to them: then they are 2^-27 of
        // a bin or more from any edge, and stay on their side of it, since they are off by far less. A step is off by 0.51
        // units and so are 2^16 of them by 2^-28 of a bin, the origin, which is below 2^19 bins, by 2^-32.
        let halves = (lateral << (level + 1)) - if is_before { 1 } else { -1 };
        #[expect(clippy::cast_precision_loss, reason = "all are below 2^53, or powers of two")]
        let (halves, per_distance, half, cell) =
            (halves as f64, 1.0 / distance as f64, (1_i64 << (PLACE_BITS - 1)) as f64, ((2 * CELL) << level) as f64);
        #[expect(clippy::cast_possible_truncation, reason = "below 2^63")]
        let (origin, step) = ((halves * half * per_distance) as i64, (cell * half * per_distance + 0.5) as i64);
        ReceiverMap { level, first, offset: (lateral << level) - i64::from(is_before), distance, origin, step }
    }

    /// Where the receiver of cell `c` is \[2^-44 bins\].
    #[inline(always)]
    fn place(&self, c: i64) -> i64 {
        self.origin + (c - self.first) * self.step
    }

    /// The bin of cell `c`, before the last one is given those on the axis.
    #[inline(always)]
    pub(super) fn bin(&self, c: i64) -> i64 {
        self.place(c) >> PLACE_BITS
    }

    /// The azimuth of cell `c` \[2^-36\], off by less than a lattice step at its distance.
    #[inline(always)]
    pub(super) fn azimuth(&self, c: i64) -> i64 {
        self.place(c) >> (PLACE_BITS + self.level - AZIMUTH_BITS)
    }

    /// The first cell whose receiver is in bin `b` or after it.
    pub(super) fn first_from(&self, b: i64) -> i64 {
        self.first - ((self.offset - b * self.distance) >> (CELL_BITS + self.level))
    }
}

/// How high the receivers of a line are above the UAV.
#[derive(Debug, Clone, Copy)]
pub(super) enum LineReceivers<'a> {
    /// All alike \[1/1024 m\].
    Flat(i32),
    /// `base[c − first] + above`.
    Over { base: &'a [i32], first: i64, above: i32 },
}

impl LineReceivers<'_> {
    /// How high the receiver of lateral cell `c` is above the UAV \[1/1024 m\].
    #[inline]
    pub(super) fn height(&self, c: usize) -> i64 {
        match self {
            LineReceivers::Flat(z) => i64::from(*z),
            LineReceivers::Over { base, first, above } => {
                i64::from(base[c - usize::try_from(*first).unwrap_or(0)]) + i64::from(*above)
            }
        }
    }
}

/// What is known of up to 64 receivers: a bit each.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Decided {
    pub(super) los: u64,
    pub(super) undecided: u64,
}

/// How receivers of a line lie over its bins, and how high they are, lane by lane.
#[derive(Debug, Clone, Copy)]
pub(super) struct ReceiverLanes<S: Simd> {
    map: ReceiverMap,
    /// How far the place of each lane is from that of the first: whole bins, and the rest \[2^-31 bins\].
    wholes: S::u32s,
    rests: S::u32s,
    per_distance: S::f32s,
    /// The slope of receivers that are all alike.
    flat: S::f32s,
}

impl<S: Simd> ReceiverLanes<S> {
    /// For the receivers of one line.
    #[inline(always)]
    pub(super) fn new(simd: S, map: ReceiverMap, receivers: &LineReceivers<'_>) -> Self {
        // At most 2^level = 2·far bins lie over the distance of a line's centers, which is half a cell less, so from as many
        // cells on as a vector has lanes, a vector of receivers lies over two vectors of bins.
        debug_assert!((map.step * (as_i64(S::f32s::LEN) - 1)) >> PLACE_BITS < 2 * as_i64(S::f32s::LEN) - 1);
        let of_lanes = |part: fn(i64) -> u32| {
            let values: [u32; 16] = std::array::from_fn(|lane| part(as_i64(lane) * map.step));
            S::u32s::from_slice(simd, &values[..S::u32s::LEN])
        };
        #[expect(clippy::cast_precision_loss, reason = "the rounding is part of the proven error")]
        let per_distance = S::f32s::splat(simd, 1.0 / map.distance as f32);
        #[expect(clippy::cast_precision_loss, reason = "the rounding is part of the proven error")]
        let flat = match receivers {
            LineReceivers::Flat(above_uav) => S::f32s::splat(simd, *above_uav as f32) * per_distance,
            LineReceivers::Over { .. } => S::f32s::splat(simd, 0.0),
        };
        ReceiverLanes { map, wholes: of_lanes(whole), rests: of_lanes(rest), per_distance, flat }
    }
}

/// The whole bins of a place, of which there are few.
#[inline(always)]
#[expect(clippy::cast_sign_loss, reason = "at most 31 from lane to lane")]
fn whole(place: i64) -> u32 {
    (place >> PLACE_BITS) as u32
}

/// What is left over of a place beside whole bins \[2^-31 bins\].
#[inline(always)]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "masked to 31 bits")]
fn rest(place: i64) -> u32 {
    (place >> (PLACE_BITS - LANE_BITS)) as u32 & ((1 << LANE_BITS) - 1)
}

impl<S: Simd> ReceiverLanes<S> {
    /// One over the distance of the receivers.
    #[inline(always)]
    pub(super) fn per_distance(&self) -> f32 {
        self.per_distance[0]
    }
}

/// Decides the receivers `cells` of a line, calling `word(index, decided)` for each run of 64 that holds one.
#[inline(always)]
pub(super) fn decide_line<S: Simd>(
    simd: S,
    bounds: &Bounds<'_>,
    lanes_of: &ReceiverLanes<S>,
    receivers: &LineReceivers<'_>,
    cells: std::ops::Range<usize>,
    word: &mut impl FnMut(usize, Decided),
) {
    // PERF: a loop for each, not a choice in every vector.
    match receivers {
        LineReceivers::Flat(_) => decide_words::<S, true>(simd, bounds, lanes_of, (&[], 0, 0), cells, word),
        LineReceivers::Over { base, first, above } => {
            decide_words::<S, false>(simd, bounds, lanes_of, (base, *first, *above), cells, word);
        }
    }
}

/// Decides receivers that are all alike, or those of [`LineReceivers::Over`].
#[inline(always)]
fn decide_words<S: Simd, const IS_FLAT: bool>(
    simd: S,
    bounds: &Bounds<'_>,
    lanes_of: &ReceiverLanes<S>,
    (base, first, above): (&[i32], i64, i32),
    cells: std::ops::Range<usize>,
    word: &mut impl FnMut(usize, Decided),
) {
    let ReceiverLanes { map, wholes, rests, per_distance, flat } = *lanes_of;
    let lanes = S::f32s::LEN;
    let above = S::i32s::splat(simd, above);
    let start = cells.start / lanes * lanes;
    let mut place = map.place(as_i64(start)) + ((PAD_I64 - bounds.first_bin) << PLACE_BITS);
    let step = as_i64(lanes) * map.step;
    let bounds = [bounds.upper, &bounds.lower[..bounds.upper.len()]];
    let mut padded = [0; 64];
    for index in cells.start / 64..cells.end.div_ceil(64) {
        let (from, to) = (cells.start.max(64 * index) - 64 * index, cells.end.min(64 * index + 64) - 64 * index);
        let heights = if IS_FLAT { &padded } else { word_of(base, as_i64(64 * index) - first, &mut padded) };
        let vectors = from / lanes * lanes..to.next_multiple_of(lanes);
        let (mut los, mut nlos) = (0, 0);
        for (bit, heights) in vectors.clone().step_by(lanes).zip(heights[vectors].chunks_exact(lanes)) {
            // EXACT: both rests are below 2^31, and each is rounded down by less than 2^-31 of a bin.
            let carries: S::u32s = (S::u32s::splat(simd, rest(place)) + rests) >> LANE_BITS;
            let [upper, lower] = tables(simd, bounds, to_index(place >> PLACE_BITS), wholes + carries);
            let slope = if IS_FLAT {
                flat
            } else {
                (S::i32s::from_slice(simd, heights) + above).to_float::<S::f32s>() * per_distance
            };
            los |= slope.simd_gt(upper).to_bitmask() << bit;
            nlos |= slope.simd_lt(lower).to_bitmask() << bit;
            place += step;
        }
        let within = (u64::MAX << from) & (u64::MAX >> (64 - to));
        word(index, Decided { los: los & within, undecided: within & !los & !nlos });
    }
}

/// The 64 values from `at` on, in `padded` if some of them lie outside; these are 0.
#[inline(always)]
fn word_of<'a>(values: &'a [i32], at: i64, padded: &'a mut [i32; 64]) -> &'a [i32; 64] {
    let whole = usize::try_from(at).ok().and_then(|at| values.get(at..)?.first_chunk());
    whole.unwrap_or_else(|| {
        *padded = [0; 64];
        let place = |at: i64| usize::try_from(at).unwrap_or(0);
        let (from, to) = ((-at).clamp(0, 64), (as_i64(values.len()) - at).clamp(0, 64));
        if from < to {
            padded[place(from)..place(to)].copy_from_slice(&values[place(at + from)..place(at + to)]);
        }
        padded
    })
}
