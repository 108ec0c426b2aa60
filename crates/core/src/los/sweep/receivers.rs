//! Step 4: the receivers of a row among its bins, decided by the bins' bounds.

use fearless_simd::prelude::*;

use super::frame::{CELL, CELL_BITS, Frame, PAD_I64, as_i64};
use super::row_source::{Rows, Stand};
use super::simd::tables;

/// Bits of an azimuth in fixed point.
pub(super) const AZIMUTH_BITS: u32 = 36;

/// The bounds of some bins for look-ups by receivers: bin `b` is at `b − first_bin + PAD`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds<'a> {
    pub(super) upper: &'a [f32],
    pub(super) lower: &'a [f32],
    pub(super) first_bin: i64,
}

/// Fraction bits of a receiver's place among the bins.
const PLACE_BITS: u32 = 44;
/// Fraction bits kept in 32 bits, beside a carry.
const LANE_BITS: u32 = 31;

/// Places of the receivers of one row among its bins.
#[derive(Debug, Clone, Copy)]
pub(super) struct ReceiverMap {
    level: u32,
    /// The cell from which places are counted.
    first: i64,
    /// Lateral offset of its center from the UAV, times 2^level \[lattice steps\]; less 1 if a
    /// receiver on an edge belongs to the bin before it.
    offset: i64,
    /// Distance of the row's cell centers from the UAV \[lattice steps\].
    distance: i64,
    /// The place of the first cell, and the distance between the places of neighbors \[2^-44
    /// bins\].
    origin: i64,
    step: i64,
}

impl ReceiverMap {
    /// Makes the map of receivers at `distance` from the UAV among bins of 1 / 2^level, from cell
    /// `first` on. Its center is `lateral` from the UAV \[lattice steps\]. A receiver on an edge
    /// belongs to the bin before it if `is_before`, else to the bin after it.
    pub(super) fn new(level: u32, (first, lateral): (i64, i64), distance: i64, is_before: bool) -> Self {
        debug_assert!((1 << 13..1 << 26).contains(&distance) && lateral.abs() << level < distance << 19);
        // EXACT: the n-th cell is (lateral + 1024·n)·2^level / distance bins from the UAV. So it is
        // on an edge or at least one `distance`-th of a bin from it. Half of that is subtracted
        // from all places or added to them. Then they are 2^-27 of a bin or more from any edge, and
        // stay on their side of it, since they are off by far less. A step is off by 0.51 units, so
        // 2^16 of them are off by 2^-28 of a bin; the origin, which is below 2^19 bins, is off by
        // 2^-32.
        let halves = (lateral << (level + 1)) - if is_before { 1 } else { -1 };
        #[expect(clippy::cast_precision_loss, reason = "all are below 2^53, or powers of two")]
        let (halves, per_distance, half, cell) =
            (halves as f64, 1.0 / distance as f64, (1_i64 << (PLACE_BITS - 1)) as f64, ((2 * CELL) << level) as f64);
        #[expect(clippy::cast_possible_truncation, reason = "below 2^63")]
        let (origin, step) = ((halves * half * per_distance) as i64, (cell * half * per_distance + 0.5) as i64);
        ReceiverMap { level, first, offset: (lateral << level) - i64::from(is_before), distance, origin, step }
    }

    /// Returns the place of the receiver of cell `c` \[2^-44 bins\].
    #[inline(always)]
    fn place(&self, c: i64) -> i64 {
        self.origin + (c - self.first) * self.step
    }

    /// Returns the bin of cell `c`. The caller assigns receivers on the axis to the last bin.
    #[inline(always)]
    pub(super) fn bin(&self, c: i64) -> i64 {
        self.place(c) >> PLACE_BITS
    }

    /// Returns the azimuth of cell `c` \[2^-36\], off by less than a lattice step at its distance.
    #[inline(always)]
    pub(super) fn azimuth(&self, c: i64) -> i64 {
        self.place(c) >> (PLACE_BITS + self.level - AZIMUTH_BITS)
    }

    /// Returns the first cell whose receiver is in bin `b` or after it.
    pub(super) fn first_from(&self, b: i64) -> i64 {
        self.first - ((self.offset - b * self.distance) >> (CELL_BITS + self.level))
    }
}

/// Heights of the receivers of a row above the UAV.
#[derive(Debug, Clone, Copy)]
pub(super) enum RowReceivers<'a> {
    /// All at one height \[1/1024 m\].
    Flat(i32),
    /// `base[c − first] + above`.
    Over { base: &'a [i32], first: i64, above: i32 },
}

impl<'a> RowReceivers<'a> {
    /// Makes the heights of the receivers of a row.
    pub(super) fn new(frame: &Frame, rows: &Rows<'a>, row: usize, stand: Stand) -> Self {
        match stand {
            Stand::Flat(z) => RowReceivers::Flat(z.wrapping_sub(frame.uav_z)),
            Stand::OnTops(above) | Stand::OnBases(above) => RowReceivers::Over {
                base: rows.bases(row, stand),
                first: rows.first(),
                above: above.wrapping_sub(frame.uav_z),
            },
        }
    }

    /// Returns the height of the receiver of lateral cell `c` above the UAV \[1/1024 m\].
    #[inline]
    pub(super) fn height(&self, c: usize) -> i64 {
        match self {
            RowReceivers::Flat(z) => i64::from(*z),
            RowReceivers::Over { base, first, above } => {
                i64::from(base[c - usize::try_from(*first).unwrap_or(0)]) + i64::from(*above)
            }
        }
    }
}

/// Decisions about up to 64 receivers: a bit each.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Decided {
    pub(super) los: u64,
    pub(super) undecided: u64,
    /// Receivers that were compared with bounds.
    pub(super) all: u64,
}

/// Places of a row's receivers among its bins, and their heights, lane by lane.
#[derive(Debug, Clone, Copy)]
pub(super) struct ReceiverLanes<S: Simd> {
    map: ReceiverMap,
    /// Distance of each lane's place from that of the first lane: whole bins, and the rest \[2^-31
    /// bins\].
    wholes: S::u32s,
    rests: S::u32s,
    per_distance: S::f32s,
    /// The slope of receivers that all have one height.
    flat: S::f32s,
}

impl<S: Simd> ReceiverLanes<S> {
    /// Prepares the receivers of one row.
    #[inline(always)]
    pub(super) fn new(simd: S, map: ReceiverMap, receivers: &RowReceivers<'_>) -> Self {
        // At most 2^level = 2·far bins lie over the distance of a row's centers, which is half a
        // cell less. So from as many cells on as a vector has lanes, a vector of receivers lies
        // over two vectors of bins.
        debug_assert!((map.step * (as_i64(S::f32s::LEN) - 1)) >> PLACE_BITS < 2 * as_i64(S::f32s::LEN) - 1);
        let of_lanes = |part: fn(i64) -> u32| {
            let values: [u32; 16] = std::array::from_fn(|lane| part(as_i64(lane) * map.step));
            S::u32s::from_slice(simd, &values[..S::u32s::LEN])
        };
        #[expect(clippy::cast_precision_loss, reason = "the rounding is part of the proven error")]
        let per_distance = S::f32s::splat(simd, 1.0 / map.distance as f32);
        #[expect(clippy::cast_precision_loss, reason = "the rounding is part of the proven error")]
        let flat = match receivers {
            RowReceivers::Flat(above_uav) => S::f32s::splat(simd, *above_uav as f32) * per_distance,
            RowReceivers::Over { .. } => S::f32s::splat(simd, 0.0),
        };
        ReceiverLanes { map, wholes: of_lanes(whole), rests: of_lanes(rest), per_distance, flat }
    }
}

/// Returns the whole bins of a place difference; they are few.
#[inline(always)]
#[expect(clippy::cast_sign_loss, reason = "at most 31 from lane to lane")]
fn whole(place: i64) -> u32 {
    (place >> PLACE_BITS) as u32
}

/// Returns the rest of a place beside whole bins \[2^-31 bins\].
#[inline(always)]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "masked to 31 bits")]
fn rest(place: i64) -> u32 {
    (place >> (PLACE_BITS - LANE_BITS)) as u32 & ((1 << LANE_BITS) - 1)
}

impl<S: Simd> ReceiverLanes<S> {
    /// Returns one over the distance of the receivers.
    #[inline(always)]
    pub(super) fn per_distance(&self) -> f32 {
        self.per_distance[0]
    }
}

/// Decides the receivers `cells` of a row. Calls `word(index, decided)` for each run of 64 that
/// holds one.
#[inline(always)]
pub(super) fn decide_row<S: Simd>(
    simd: S,
    bounds: &Bounds<'_>,
    lanes_of: &ReceiverLanes<S>,
    receivers: &RowReceivers<'_>,
    cells: std::ops::Range<usize>,
    word: &mut impl FnMut(usize, Decided),
) {
    // PERF: a loop for each, not a choice in every vector.
    match receivers {
        RowReceivers::Flat(_) => decide_words::<S, true>(simd, bounds, lanes_of, (&[], 0, 0), cells, word),
        RowReceivers::Over { base, first, above } => {
            decide_words::<S, false>(simd, bounds, lanes_of, (base, *first, *above), cells, word);
        }
    }
}

/// Decides receivers of one height, or those of [`RowReceivers::Over`].
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
            // EXACT: both rests are below 2^31, and each is rounded down by less than 2^-31 of a
            // bin.
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
        word(index, Decided { los: los & within, undecided: within & !los & !nlos, all: within });
    }
}

/// Converts a place in a buffer to an index; a place before its beginning becomes one far beyond
/// its end.
#[inline(always)]
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "wraps around to what no buffer has")]
fn to_index(at: i64) -> usize {
    at as usize
}

/// Returns the 64 values from `at` on. If some of them lie outside, they are 0 and the result is in
/// `padded`.
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
