//! The row loop: passes one row after another over the bins of a wedge.

use fearless_simd::prelude::*;

use super::bounds::{Bins, EdgeMap, NOTHING, RowSlopes};
use super::candidates::level_for;
use super::frame::{BATCH, CELL, CELL_BITS, FIRST_LEVEL, Frame, NEAR, PAD, PAD_I64, as_i64};
use super::output::WedgeOutput;
use super::receivers::{Bounds, ReceiverLanes, ReceiverMap, RowReceivers, decide_row};
use super::row_source::{Rows, Stand, Tiles};
use super::undecided::{Open, Passed, Recall, Settling};
use crate::height_field::TILE;
use crate::quantity::VOID;

/// Bins that sleep or retire together.
const SLEEPERS: usize = 32;

/// Gaps between awake bins shorter than this are processed anyway: skipping them costs more.
const SHORTEST_SLEEP: usize = 96;

/// Relative slack of the slopes that exclude bins and tiles: wider than any doubt.
const SLACK: f32 = 1e-5;

/// Inputs that are the same for all rows of a wedge.
#[derive(Debug, Clone, Copy)]
pub(super) struct Passing<'a> {
    pub(super) frame: &'a Frame,
    pub(super) stand: Stand,
    /// The highest tops and receivers of tiles, if known.
    pub(super) tiles: Option<Tiles<'a>>,
    /// `true` if least heights are requested.
    pub(super) with_heights: bool,
}

/// Bins of the azimuths from `first / 2^level` on, and the row that they passed last.
#[derive(Debug)]
pub(super) struct Wedge<R> {
    level: u32,
    first: i64,
    bins: Bins<R>,
    /// Intervals of bins that may still change.
    active: Vec<(usize, usize)>,
    /// Intervals of bins that the next rows can affect. Short gaps are merged in, which is
    /// harmless: retired bins in them have all later receivers below their `lower`, which only
    /// rises.
    awake: Vec<(usize, usize)>,
    /// Tops above the UAV of the row passed last, and of the row before it; lateral cell `c` is at
    /// `c + PAD`. Only tops under awake bins are from these rows, other tops may be from any
    /// earlier row.
    tops: Vec<i32>,
    tops_before: Vec<i32>,
    /// The row passed last, if it may hide a receiver and has not raised the bounds yet. Rays leave
    /// it where they enter the next row, so cells under the edges of bins there are looked up in
    /// both at once.
    pending: Option<RowSlopes>,
    /// Tops under the edges of bins, edge `i` at `i`: where rays enter the pending row, where they
    /// leave it, and where they enter the next row.
    enters: Vec<i32>,
    leaves: Vec<i32>,
    next_enters: Vec<i32>,
    /// Undecided receivers of a row, and the cells of those that are seen.
    open: Vec<Open>,
    seen: Vec<u32>,
}

impl<R: Recall> Wedge<R> {
    /// Makes part `part` of `parts` (a power of two, at most 2^[`FIRST_LEVEL`]) to one side of the
    /// axis; negative parts are on the other side. Returns `None` if it has no bin of
    /// [`Frame::wanted_bins`].
    pub(super) fn new((part, parts): (i64, i64), wanted: u32, recall: impl FnOnce(usize) -> R) -> Option<Self> {
        let len = (1_i64 << FIRST_LEVEL) / parts;
        let (first, n_bins) = (part * len, usize::try_from(len).unwrap_or(1));
        let mut active = Vec::new();
        for bin in (0..n_bins).filter(|bin| wanted >> (first + (1 << FIRST_LEVEL) + as_i64(*bin)) & 1 == 1) {
            append(&mut active, (bin, bin + 1), 0);
        }
        if active.is_empty() {
            return None;
        }
        let bins = Bins::new(n_bins, recall(n_bins));
        Some(Wedge {
            level: FIRST_LEVEL,
            first,
            awake: active.clone(),
            active,
            bins,
            tops: Vec::new(),
            tops_before: Vec::new(),
            pending: None,
            enters: Vec::new(),
            leaves: Vec::new(),
            next_enters: Vec::new(),
            open: Vec::new(),
            seen: Vec::new(),
        })
    }

    /// Returns `true` if no later row can change a result.
    pub(super) fn is_done(&self, passing: &Passing<'_>) -> bool {
        self.active.is_empty() && !passing.with_heights
    }

    /// Returns the lateral indices of the cells that rays of the wedge can reach between two
    /// distances, from the first to after the last. The range is empty if there are none in the
    /// raster.
    pub(super) fn reach(&self, passing: &Passing<'_>, near: i64, far: i64) -> (i64, i64) {
        let whole = [(0, self.bins.len)];
        let of = if passing.with_heights { &whole[..] } else { &self.active };
        let (Some(first), Some(last)) = (of.first(), of.last()) else { return (0, 0) };
        let bins = (self.first + as_i64(first.0), self.first + as_i64(last.1));
        self.edge_map(passing.frame).cells(bins, (near, far), (0, passing.frame.n_lateral))
    }

    fn edge_map(&self, frame: &Frame) -> EdgeMap {
        // Left of the axis a look-up on a border takes the cell before it: see the module.
        EdgeMap::new(frame.uav_lateral, self.level, self.first < 0)
    }

    /// Makes bins as fine as `level`. Both halves of a split bin inherit its values.
    fn refine(&mut self, level: u32) {
        while self.level < level {
            self.bins.split();
            self.level += 1;
            self.first *= 2;
            let finer = self.active.iter_mut().chain(&mut self.awake);
            finer.for_each(|(a, b)| (*a, *b) = (2 * *a, 2 * *b));
        }
    }

    /// Passes some rows, and reports their receivers to `out`.
    ///
    /// PERF: everything below is inlined into one function compiled for the instruction set of
    /// `simd`.
    pub(super) fn pass<S: Simd>(
        &mut self,
        simd: S,
        passing: &Passing<'_>,
        rows: &Rows<'_>,
        out: &mut WedgeOutput<'_, '_>,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                let mut row = rows.numbers.start;
                while row < rows.numbers.end {
                    let end = passing.frame.end_of_strip(row, TILE).min(rows.numbers.end);
                    self.look_ahead(simd, passing, row..end);
                    if self.is_done(passing) {
                        return;
                    }
                    while row < end {
                        self.pass_one(simd, passing, rows, row, out);
                        row += 1;
                    }
                }
            },
        );
    }

    /// Decides the receivers of a row by the rows before it. Entering the row raises the bounds by
    /// the row before; its own bounds are raised when the next row is entered.
    #[inline(always)]
    fn pass_one<S: Simd>(
        &mut self,
        simd: S,
        passing: &Passing<'_>,
        rows: &Rows<'_>,
        row: usize,
        out: &mut WedgeOutput<'_, '_>,
    ) {
        let frame = passing.frame;
        // The last row hides nobody.
        let is_last = frame.center(row) >= frame.last_center;
        let level = if is_last { self.level } else { level_for(frame.far(row)) };
        if is_last || level > self.level {
            self.raise_pending(simd, frame);
        }
        if !is_last {
            self.refine(level);
            self.enter(simd, frame, rows, row);
        }
        if frame.far(row) > NEAR {
            self.decide(simd, passing, rows, row, out);
        }
    }

    /// Returns the map of a row's receivers to the bins.
    fn receiver_map(&self, frame: &Frame, row: usize) -> ReceiverMap {
        // A receiver on an edge belongs to the bin on the side of the axis: its ray stays in the
        // closed bin, and comes to each border of rows from inside (see the module). Places are
        // counted from the window on, since a raster may be far wider than any range.
        let first = frame.window.0 & !63;
        let lateral = first * CELL + CELL / 2 - frame.uav_lateral;
        ReceiverMap::new(self.level, (first, lateral), frame.center(row), self.first >= 0)
    }

    #[inline(always)]
    fn decide<S: Simd>(
        &mut self,
        simd: S,
        passing: &Passing<'_>,
        rows: &Rows<'_>,
        row: usize,
        out: &mut WedgeOutput<'_, '_>,
    ) {
        let frame = passing.frame;
        let receivers = RowReceivers::new(frame, rows, row, passing.stand);
        let map = self.receiver_map(frame, row);
        let lanes = ReceiverLanes::new(simd, map, &receivers);
        let after_axis = ((frame.uav_lateral - CELL / 2) >> CELL_BITS) + 1;
        let end = self.first + as_i64(self.bins.len);
        self.bins.repeat_last();
        let Bins { len: n_bins, upper, lower, recall } = &mut self.bins;
        let bounds = Bounds { upper, lower, first_bin: self.first };
        // The words of the first and of the last receiver of the wedge in the row may hold
        // receivers of another wedge.
        let ends = (map.first_from(self.first) >> 6, map.first_from(end) >> 6);
        let settling = Settling {
            frame,
            row,
            receivers: &receivers,
            map,
            per_distance: lanes.per_distance(),
            bins: (self.first, end - 1),
            level: self.level,
        };
        let mut open = std::mem::take(&mut self.open);
        open.clear();
        let whole = [(0, *n_bins)];
        for &(from, to) in if passing.with_heights { &whole[..] } else { &self.awake } {
            let (b0, b1) = (self.first + as_i64(from), self.first + as_i64(to));
            // A receiver on the axis belongs to the bin before it, so to the side that ends there.
            let after = if b1 == 0 { after_axis } else { map.first_from(b1) };
            let cells = (map.first_from(b0).max(frame.window.0), after.min(frame.window.1));
            if cells.0 >= cells.1 {
                continue;
            }
            let as_usize = |cell: i64| usize::try_from(cell).unwrap_or(0);
            let cells = as_usize(cells.0)..as_usize(cells.1);
            decide_row(simd, &bounds, &lanes, &receivers, cells, &mut |word, decided| {
                let is_shared = as_i64(word) <= ends.0 || as_i64(word) >= ends.1;
                out.add(frame, row, word, decided.los, is_shared);
                let mut left = out.wanted(frame, row, word, decided.undecided);
                while left != 0 {
                    let cell = 64 * word + left.trailing_zeros() as usize;
                    left &= left - 1;
                    #[expect(clippy::cast_possible_truncation, reason = "a side has fewer than 2^32 cells")]
                    open.push(Open { cell: cell as u32 });
                }
                if passing.with_heights {
                    find_heights(simd, recall, &settling, (word, out.wanted(frame, row, word, decided.all)), out);
                }
            });
        }
        if !open.is_empty() {
            out.undecided += open.len() as u64;
            self.seen.resize(open.len().max(self.seen.len()), 0);
            let n_seen = recall.settle(&settling, &mut open, &mut self.seen);
            for cell in &self.seen[..n_seen] {
                let word = (cell / 64) as usize;
                let is_shared = as_i64(word) <= ends.0 || as_i64(word) >= ends.1;
                out.add(frame, row, word, 1 << (cell % 64), is_shared);
            }
        }
        self.open = open;
    }

    /// Looks up the cells at which rays enter a row, if it may hide a receiver. Raises the bounds
    /// by the row before it.
    #[inline(always)]
    fn enter<S: Simd>(&mut self, simd: S, frame: &Frame, rows: &Rows<'_>, row: usize) {
        std::mem::swap(&mut self.tops, &mut self.tops_before);
        let n_cells = usize::try_from(frame.n_lateral).unwrap_or(0) + 2 * PAD;
        if self.tops.len() < n_cells {
            self.tops.resize(n_cells, NOTHING);
        }
        let (near, far) = (frame.near(row), frame.far(row));
        let map = self.edge_map(frame);
        let tops = rows.tops(row);
        let within = (rows.first(), rows.first() + as_i64(tops.len()));
        let mut highest = NOTHING;
        for &(from, to) in &self.awake {
            let bins = (self.first + as_i64(from), self.first + as_i64(to));
            let (low, high) = map.cells(bins, (near, far), within);
            let at = |from: i64| {
                let at = |cell: i64| usize::try_from(cell - from).unwrap_or(0);
                at(low)..at(high)
            };
            highest = highest.max(above_uav(simd, &tops[at(within.0)], frame.uav_z, &mut self.tops[at(-PAD_I64)]));
        }
        let slopes = RowSlopes::new(row, (near, far), frame.is_below_uav, frame.blocks_all);
        // A row below every receiver beyond it hides none, so bounds and candidates can ignore it.
        let may_hide = slopes.bounds([highest; 4]).0 >= lowest_slope(frame, far);

        // Vectors run over the ends, and all edges of bins have cells.
        let n_edges = self.bins.len + 2 * PAD;
        for tops in [&mut self.enters, &mut self.leaves, &mut self.next_enters] {
            tops.resize(n_edges.max(tops.len()), NOTHING);
        }
        for &(from, to) in &self.awake {
            let edges = (self.first + as_i64(from), to + 1 - from);
            let (leaves, next_enters) = (&mut self.leaves[from..], &mut self.next_enters[from..]);
            match (self.pending.is_some(), may_hide) {
                (true, true) => {
                    let rows = [&self.tops_before[..], &self.tops[..]];
                    map.look_up(simd, rows, edges, near, [leaves, next_enters]);
                }
                (true, false) => map.look_up(simd, [&self.tops_before[..]], edges, near, [leaves]),
                (false, true) => map.look_up(simd, [&self.tops[..]], edges, near, [next_enters]),
                (false, false) => {}
            }
        }
        self.raise(simd);
        if may_hide {
            std::mem::swap(&mut self.enters, &mut self.next_enters);
            self.pending = Some(slopes);
        }
    }

    /// Raises the bounds by the row passed last.
    #[inline(always)]
    fn raise_pending<S: Simd>(&mut self, simd: S, frame: &Frame) {
        let Some(slopes) = &self.pending else { return };
        let (map, far) = (self.edge_map(frame), frame.far(slopes.row));
        for &(from, to) in &self.awake {
            let edges = (self.first + as_i64(from), to + 1 - from);
            map.look_up(simd, [&self.tops[..]], edges, far, [&mut self.leaves[from..]]);
        }
        self.raise(simd);
    }

    /// Raises the bounds by the row passed last, all of whose tops have been looked up.
    #[inline(always)]
    fn raise<S: Simd>(&mut self, simd: S) {
        let Some(slopes) = self.pending.take() else { return };
        let passed = Passed { row: slopes.row, first: self.first, level: self.level };
        for &(from, to) in &self.awake {
            self.bins.raise(simd, (&slopes, &passed), (&self.enters, &self.leaves), from..to);
        }
    }

    /// Looks ahead over the next rows, which lie in one row of tiles. Drops the bins that no row
    /// from there on can change, and puts those to sleep that these rows cannot affect.
    #[inline(always)]
    fn look_ahead<S: Simd>(&mut self, simd: S, passing: &Passing<'_>, rows: std::ops::Range<usize>) {
        let frame = passing.frame;
        self.raise_pending(simd, frame);
        let (lower, lowest) = (&self.bins.lower, lowest_slope(frame, frame.center(rows.start)));
        for &(from, to) in &self.awake {
            self.bins.recall.end_group(simd, (lower, lowest), from..to);
        }
        let of_bins = &self.bins.lower[PAD..PAD + self.bins.len];
        self.bins.recall.begin_group(rows.start, of_bins, (self.first, self.level));
        // Slopes of heights below the UAV grow with the distance, and slopes of heights above it
        // fall. Receivers count from their centers on, not positive in the UAV's own row; tops
        // count from where rays enter them.
        let first = if passing.with_heights { frame.near(rows.start) } else { frame.center(rows.start) };
        let at = if frame.highest <= 0 { frame.last_center } else { first }.max(1);
        #[expect(clippy::cast_precision_loss, clippy::cast_possible_truncation, reason = "widened by a margin")]
        let steepest = (frame.highest as f64 / at as f64) as f32;
        // Behind a top that blocks everything no height is enough, which changes least heights even
        // in the dark.
        let is_never_dark = passing.with_heights && frame.highest >= i64::from(frame.blocks_all);
        let dark = if is_never_dark { f32::INFINITY } else { steepest + steepest.abs() * SLACK + f32::MIN_POSITIVE };
        let map = self.edge_map(frame);
        let (near, far) = (frame.near(rows.start), frame.far(rows.end - 1));
        let stand = (!passing.with_heights).then_some(passing.stand);
        let may_matter = |bins: (i64, i64), lowest: f32| {
            let cells = map.cells(bins, (near, far), (0, frame.n_lateral));
            if cells.0 >= cells.1 {
                return false;
            }
            let Some(tiles) = passing.tiles.as_ref().filter(|_| near >= NEAR) else { return true };
            let highest = tiles.highest(frame, frame.tile(rows.start), cells, stand);
            #[expect(clippy::cast_precision_loss, reason = "as for each cell, in the same direction")]
            let (height, near, far) = (highest as f32, near as f32, far as f32);
            (height / near).max(height / far) >= lowest - lowest.abs() * SLACK
                || is_never_dark && highest >= frame.blocks_all
        };
        let active = std::mem::take(&mut self.active);
        self.awake.clear();
        for &(from, to) in &active {
            for start in (from..to).step_by(SLEEPERS) {
                let end = (start + SLEEPERS).min(to);
                let lowest = lowest_of(&self.bins.lower[PAD + start..PAD + end]);
                if lowest > dark {
                    continue;
                }
                append(&mut self.active, (start, end), 0);
                if may_matter((self.first + as_i64(start), self.first + as_i64(end)), lowest) {
                    append(&mut self.awake, (start, end), SHORTEST_SLEEP);
                }
            }
        }
    }
}

/// Returns a lower limit of the slopes of all requested heights at distance `from` or beyond.
fn lowest_slope(frame: &Frame, from: i64) -> f32 {
    // Slopes of receivers below the UAV grow with the distance, those of other receivers fall.
    let at = if frame.lowest <= 0 { from } else { frame.last_center.max(from) };
    #[expect(clippy::cast_precision_loss, clippy::cast_possible_truncation, reason = "widened by a margin")]
    let lowest = (frame.lowest as f64 / at.max(1) as f64) as f32;
    lowest - lowest.abs() * SLACK - f32::MIN_POSITIVE
}

/// Writes the tops of a row above the UAV, [`NOTHING`] where there is none. Returns the highest.
#[inline(always)]
fn above_uav<S: Simd>(simd: S, tops: &[i32], uav_z: i32, out: &mut [i32]) -> i32 {
    let n = S::i32s::LEN;
    let (void, nothing, uav) = (S::i32s::splat(simd, VOID), S::i32s::splat(simd, NOTHING), S::i32s::splat(simd, uav_z));
    let mut highest = nothing;
    let mut chunks = tops.chunks_exact(n);
    let mut outs = out.chunks_exact_mut(n);
    for (tops, out) in (&mut chunks).zip(&mut outs) {
        let tops = S::i32s::from_slice(simd, tops);
        // A void wraps around and is replaced.
        let above = tops.simd_eq(void).select(nothing, tops - uav);
        above.store_slice(out);
        highest = highest.max(above);
    }
    let mut highest = highest.as_slice().iter().fold(NOTHING, |a, b| a.max(*b));
    for (top, out) in chunks.remainder().iter().zip(outs.into_remainder()) {
        *out = if *top == VOID { NOTHING } else { top - uav_z };
        highest = highest.max(*out);
    }
    highest
}

/// Appends an interval to earlier ones; merges it into the last one if the gap is less than `gap`.
#[inline(always)]
fn append(intervals: &mut Vec<(usize, usize)>, (start, end): (usize, usize), gap: usize) {
    match intervals.last_mut() {
        Some(last) if start - last.1 < gap.max(1) => last.1 = end,
        _ => intervals.push((start, end)),
    }
}

/// Finds the least heights over some cells of a word of a row.
#[inline(always)]
fn find_heights<S: Simd, R: Recall>(
    simd: S,
    recall: &mut R,
    of: &Settling<'_>,
    (word, mut wanted): (usize, u64),
    out: &WedgeOutput<'_, '_>,
) {
    let (mut cells, mut n_cells) = ([0; BATCH], 0);
    while wanted != 0 {
        #[expect(clippy::cast_possible_truncation, reason = "a side has fewer than 2^32 cells")]
        let first = 64 * word as u32;
        cells[n_cells] = first + wanted.trailing_zeros();
        n_cells += 1;
        wanted &= wanted - 1;
    }
    let mut least = [0.0; BATCH];
    recall.least_heights(simd, of, &cells[..n_cells], &mut least);
    for (cell, least) in cells[..n_cells].iter().zip(least) {
        let (row, col) = of.frame.cell(of.row, *cell as usize);
        out.output.set_height(row, col, f64::from(of.frame.uav_z) + least);
    }
}

/// Returns the lowest of some slopes.
#[inline(always)]
fn lowest_of(slopes: &[f32]) -> f32 {
    let lower = |a: f32, b: f32| if b < a { b } else { a };
    // PERF: as many at once as a vector has lanes; one after another, each would wait for the one
    // before.
    let mut lowest = [f32::INFINITY; 16];
    let mut chunks = slopes.chunks_exact(16);
    for chunk in &mut chunks {
        for (lowest, slope) in lowest.iter_mut().zip(chunk) {
            *lowest = lower(*lowest, *slope);
        }
    }
    for (lowest, slope) in lowest.iter_mut().zip(chunks.remainder()) {
        *lowest = lower(*lowest, *slope);
    }
    for half in [8, 4, 2, 1] {
        for k in 0..half {
            lowest[k] = lower(lowest[k], lowest[k + half]);
        }
    }
    lowest[0]
}
