//! The bins of one wedge of a quadrant, and how a line of cells passes over them.

use fearless_simd::prelude::*;

use super::bins::Bins;
use super::kernels::{
    CELL_BITS, EdgeMap, EdgeSteps, LineSlopes, NOTHING, PAD, PAD_I64, SLACK, end_group, heights_above_uav,
    look_up_edges, raise_bounds,
};
use super::line_order::read_ahead;
use super::quadrants::{CELL, FIRST_LEVEL, NEAR, as_i64};
use super::receivers::{Bounds, Decided, LineReceivers, ReceiverLanes, ReceiverMap, decide_line};
use super::suspects::Suspects;
use crate::height_field::TILE_BITS;

/// One over no distance: so much that any height is too steep for all receivers, and any height's slope finite.
const PER_NOTHING: f32 = 1e25;

/// Bins that sleep or retire together.
const SLEEPERS: usize = 32;

/// Fewer bins than so many between others that are awake do not sleep: it would cost more than it spares.
const SHORTEST_SLEEP: usize = 96;

/// One line of cells across the direction of the sweep, as it is passed over.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line<'a> {
    pub(super) tops: &'a [i32],
    /// Lateral index of the first of them.
    pub(super) first: i64,
    /// Distances from the UAV of its nearer edge (0 if the UAV is beyond it), of its centers, and of its farther edge
    /// \[lattice steps\].
    pub(super) near: i64,
    pub(super) center: i64,
    pub(super) far: i64,
    /// What is read of the line after it, cell by cell as `tops` is, to be in the cache by then; empty to not read ahead.
    pub(super) next: [&'a [i32]; 2],
}

/// The lines that a wedge comes to next, no more than a tile has.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ahead<'a> {
    /// Distances from the UAV of the nearer edge of the first of them, of its centers, and of the farther edge of the last one
    /// \[lattice steps\].
    pub(super) near: i64,
    pub(super) center: i64,
    pub(super) far: i64,
    /// The tiles that they lie in, if they are known.
    pub(super) tiles: Option<TileLine<'a>>,
}

impl Ahead<'_> {
    /// Whether these lines may change bounds of some bins, all of whose lower bounds are at least `lowest`, or hold a receiver
    /// there that is not hidden: they have cells there, and if their tiles are known, a top or a receiver is as steep as that.
    #[inline(always)]
    fn may_matter(
        &self,
        frame: &WedgeFrame,
        (map, per_edges): (&EdgeMap, (f32, f32)),
        (b0, b1): (i64, i64),
        lowest: f32,
    ) -> bool {
        // On a border look-ups may take the cell before it.
        let (low, high) = cells_between(map, (b0 - 1, b1), (self.near, self.far), frame);
        if low >= high {
            return false;
        }
        let Some(tiles) = self.tiles.as_ref().filter(|_| self.near >= NEAR) else { return true };
        #[expect(clippy::cast_precision_loss, reason = "as for each cell, in the same direction")]
        let highest = tiles.highest((low, high), frame.uav_z) as f32;
        (highest * per_edges.0).max(highest * per_edges.1) >= lowest - lowest.abs() * SLACK
    }

    /// One over the distances of their edges, the first of which may be infinite: it is not asked for then.
    #[expect(clippy::cast_precision_loss, reason = "as for each cell, in the same direction")]
    fn per_edges(&self) -> (f32, f32) {
        (1.0 / self.near as f32, 1.0 / self.far as f32)
    }
}

/// A line of tiles across the direction of the sweep.
#[derive(Debug, Clone, Copy)]
pub(super) struct TileLine<'a> {
    /// The highest tops, the first tile of the line foremost, the next one `stride` farther.
    pub(super) tops: &'a [i32],
    pub(super) stride: usize,
    pub(super) receivers: TileReceivers<'a>,
}

/// How high the receivers of tiles are above the UAV \[1/1024 m\].
#[derive(Debug, Clone, Copy)]
pub(super) enum TileReceivers<'a> {
    /// All alike.
    Flat(i32),
    /// So much more than the tops of their cells.
    OnTops(i32),
    /// So much more than the bases of their cells, the highest of which lie as the tops do.
    OnBases(&'a [i32], i32),
}

impl TileLine<'_> {
    /// The highest top or receiver above the UAV over the lateral cells from `from` to before `to`, which are not none.
    fn highest(&self, (from, to): (i64, i64), uav_z: i32) -> i32 {
        let tile = |cell: i64| usize::try_from(cell >> TILE_BITS).unwrap_or(0);
        let highest =
            |of: &[i32]| (tile(from)..tile(to - 1) + 1).fold(i32::MIN, |a, tile| a.max(of[tile * self.stride]));
        // EXACT: known heights differ by less than 2^28; a void stays below all of them.
        let top = highest(self.tops);
        let receiver = match self.receivers {
            TileReceivers::Flat(z) => z,
            TileReceivers::OnTops(above) => top.saturating_add(above),
            TileReceivers::OnBases(bases, above) => highest(bases).saturating_add(above),
        };
        let top = top.saturating_sub(uav_z);
        top.max(receiver)
    }
}

/// Who is told of the receivers of a line.
pub(super) trait Verdicts {
    /// Takes what is known of the receivers of a word, which may hold some of another wedge if it is shared; says which of
    /// those that are undecided it asks about.
    fn decided(&mut self, word: usize, decided: Decided, is_shared: bool) -> u64;

    /// Finds out about the receivers of some lateral cells; leaves any of them behind.
    fn ask(&mut self, cells: &mut Vec<u32>, suspects: &Suspects<'_>);
}

/// What is the same for all lines of a wedge.
#[derive(Debug, Clone, Copy)]
pub(super) struct WedgeFrame {
    /// Height of the UAV \[1/1024 m\].
    pub(super) uav_z: i32,
    /// Whether no top is above it.
    pub(super) is_below_uav: bool,
    /// Lateral position of the UAV \[lattice steps\].
    pub(super) uav_lateral: i64,
    /// Lateral indices of the receivers.
    pub(super) window: (i64, i64),
    /// Number of cells along a line.
    pub(super) n_lateral: i64,
    /// The lowest and the highest receiver above the UAV \[1/1024 m\].
    pub(super) lowest_receiver: i64,
    pub(super) highest_receiver: i64,
    /// Distance of the last line's centers \[lattice steps\].
    pub(super) last_center: i64,
}

/// Bins of the azimuths from `first / 2^level` on, and their bounds.
#[derive(Debug)]
pub(super) struct Wedge {
    level: u32,
    first: i64,
    bins: Bins,
    /// Intervals of bins that may still change.
    active: Vec<(usize, usize)>,
    /// Intervals of bins that the next lines may change, or see a receiver of; and all between two of them that are next to each
    /// other, some of which may be active no more: every later receiver is below their `lower`, which only rises.
    awake: Vec<(usize, usize)>,
    /// Heights above the UAV of the line that was passed last, and of the one before it: lateral cell `c` is at `c + PAD`. Only
    /// those under bins that are awake are of these lines, others of any line before.
    heights: Vec<f32>,
    heights_before: Vec<f32>,
    /// The line that was passed last, if it may hide a receiver and bounds are still to be raised by it: it shares its farther
    /// edge with the next line, and cells under the edges of bins there are looked up in both at once.
    pending: Option<LineSlopes>,
    /// Where its farther edge is \[lattice steps from the UAV\].
    far: i64,
    /// Heights of the cells under the edges of bins, of edge `i` at `i`: where rays enter that line, where they exit it, and
    /// where they enter the next one.
    entries: Vec<f32>,
    exits: Vec<f32>,
    next_entries: Vec<f32>,
    /// The lateral cells of the line's receivers that are left to walks.
    open: Vec<u32>,
    n_lines: i32,
    /// The number of the first line of the present group.
    group_start: i32,
}

impl Wedge {
    /// Part `part` of `parts` (a power of two, at most [`super::quadrants::MAX_PARTS`]) to one side of the axis; negative to the other side.
    pub(super) fn new(part: i64, parts: i64) -> Self {
        let len = (1_i64 << FIRST_LEVEL) / parts;
        let bins = Bins::new(usize::try_from(len).unwrap_or(1));
        Wedge {
            level: FIRST_LEVEL,
            first: part * len,
            active: vec![(0, bins.len())],
            awake: vec![(0, bins.len())],
            bins,
            heights: Vec::new(),
            heights_before: Vec::new(),
            pending: None,
            far: 0,
            entries: Vec::new(),
            exits: Vec::new(),
            next_entries: Vec::new(),
            open: Vec::new(),
            n_lines: 0,
            group_start: 1,
        }
    }

    /// Whether every bin is dark for good.
    pub(super) fn is_done(&self) -> bool {
        self.active.is_empty()
    }

    /// Lateral indices of the cells that the active bins can reach between two distances, from the first to after the
    /// last; empty if there are none in the raster.
    pub(super) fn reach(&self, frame: &WedgeFrame, near: i64, far: i64) -> (i64, i64) {
        let (Some(first), Some(last)) = (self.active.first(), self.active.last()) else { return (0, 0) };
        // On a border look-ups may take the cell before it.
        let bins = (self.first + as_i64(first.0) - 1, self.first + as_i64(last.1));
        cells_between(&self.edge_map(frame), bins, (near, far), frame)
    }

    fn edge_map(&self, frame: &WedgeFrame) -> EdgeMap {
        EdgeMap { uav: frame.uav_lateral << self.level, shift: CELL_BITS + self.level }
    }

    /// Makes bins as fine as `level`: a bin that splits in two hands its bounds down to both.
    fn refine(&mut self, level: u32) {
        while self.level < level {
            self.bins.split();
            self.level += 1;
            self.first *= 2;
            let finer = self.active.iter_mut().chain(&mut self.awake);
            finer.for_each(|(a, b)| (*a, *b) = (2 * *a, 2 * *b));
        }
    }

    /// Decides the receivers of a line by what lies before it: enters it, which raises the bounds by the line before. Its own
    /// bounds are raised when the next line is entered.
    ///
    /// Lines lie in the tiles that [`Wedge::look_ahead`] was told of last, if it was told of any.
    ///
    /// PERF: everything below is inlined into one function compiled for the instruction set of `simd`.
    pub(super) fn pass<S: Simd>(
        &mut self,
        simd: S,
        frame: &WedgeFrame,
        line: &Line<'_>,
        receivers: &LineReceivers<'_>,
        verdicts: &mut impl Verdicts,
    ) {
        simd.vectorize(
            #[inline(always)]
            || {
                // The last line hides nobody.
                let is_last = line.center >= frame.last_center;
                let level = level_for(line.far).max(self.level);
                if is_last || level > self.level {
                    self.raise_pending(simd, frame);
                }
                self.n_lines += 1;
                debug_assert!(self.n_lines - self.group_start < 1 << TILE_BITS);
                if !is_last {
                    self.refine(level);
                    self.enter(simd, frame, line);
                }
                if line.far > NEAR {
                    self.decide(simd, frame, line, receivers, verdicts);
                }
            },
        );
    }

    /// How the receivers of a line lie over the bins.
    fn receiver_map(&self, frame: &WedgeFrame, line: &Line<'_>) -> ReceiverMap {
        // A receiver on an edge belongs to the bin on the side of the axis: its ray stays in the closed bin, and comes
        // to each lattice line from inside (see the module).
        // Places are counted from the window on, since a raster may be far wider than any range.
        let first = frame.window.0 & !63;
        let lateral = first * CELL + CELL / 2 - frame.uav_lateral;
        ReceiverMap::new(self.level, (first, lateral), line.center, self.first >= 0)
    }

    #[inline(always)]
    fn decide<S: Simd>(
        &mut self,
        simd: S,
        frame: &WedgeFrame,
        line: &Line<'_>,
        receivers: &LineReceivers<'_>,
        verdicts: &mut impl Verdicts,
    ) {
        let map = self.receiver_map(frame, line);
        let lanes = ReceiverLanes::new(simd, map, receivers);
        let after_axis = ((frame.uav_lateral - CELL / 2) >> CELL_BITS) + 1;
        let end = self.first + as_i64(self.bins.len());
        self.bins.repeat_last();
        let bounds = Bounds { upper: &self.bins.upper, lower: &self.bins.lower, first_bin: self.first };
        let suspects = Suspects {
            bins: &self.bins,
            first_bin: self.first,
            last_bin: end - 1,
            map,
            per_distance: lanes.per_distance(),
            number: self.n_lines,
            group_start: self.group_start,
            ends: (map.first_from(self.first) >> 6, map.first_from(end) >> 6),
        };
        let mut open = std::mem::take(&mut self.open);
        open.clear();
        for &(from, to) in &self.awake {
            let (b0, b1) = (self.first + as_i64(from), self.first + as_i64(to));
            // The axis itself belongs to the last bin of the side before it as well.
            let after = if b1 == 0 { after_axis } else { map.first_from(b1) };
            let cells = (map.first_from(b0).max(frame.window.0), after.min(frame.window.1));
            if cells.0 >= cells.1 {
                continue;
            }
            let as_usize = |cell: i64| usize::try_from(cell).unwrap_or(0);
            let cells = as_usize(cells.0)..as_usize(cells.1);
            decide_line(simd, &bounds, &lanes, receivers, cells, &mut |word, decided| {
                let mut left = verdicts.decided(word, decided, suspects.is_shared(word));
                while left != 0 {
                    #[expect(clippy::cast_possible_truncation, reason = "a side has fewer than 2^32 cells")]
                    open.push(64 * word as u32 + left.trailing_zeros());
                    left &= left - 1;
                }
            });
        }
        if !open.is_empty() {
            verdicts.ask(&mut open, &suspects);
        }
        self.open = open;
    }

    /// Looks up where rays enter a line, if that may hide a receiver, and raises the bounds by the line before it.
    #[inline(always)]
    fn enter<S: Simd>(&mut self, simd: S, frame: &WedgeFrame, line: &Line<'_>) {
        debug_assert!(self.pending.is_none() || self.far == line.near);
        std::mem::swap(&mut self.heights, &mut self.heights_before);
        // Vectors run over the ends, and all edges of bins have cells.
        let n_edges = self.bins.len() + 2 * PAD;
        if self.entries.len() < n_edges {
            for values in [&mut self.entries, &mut self.exits, &mut self.next_entries] {
                values.resize(n_edges, NOTHING);
            }
        }
        let n_cells = usize::try_from(frame.n_lateral).unwrap_or(0) + 2 * PAD;
        if self.heights.len() < n_cells {
            self.heights.resize(n_cells, NOTHING);
        }
        let (map, steps) = (self.edge_map(frame), EdgeSteps::new(simd, line.near));
        let end = line.first + as_i64(line.tops.len());
        let mut highest = NOTHING;
        for &(from, to) in &self.awake {
            let (b0, b1) = (self.first + as_i64(from), self.first + as_i64(to));
            let low = map.cell(b0 - 1, line.near).min(map.cell(b0 - 1, line.far)).clamp(line.first, end);
            let high = (map.cell(b1, line.near).max(map.cell(b1, line.far)) + 1).clamp(low, end);
            let within = |from: i64| {
                let at = |cell: i64| usize::try_from(cell - from).unwrap_or(0);
                at(low)..at(high)
            };
            let cells = within(line.first);
            for next in line.next.into_iter().filter(|next| !next.is_empty()) {
                read_ahead(next, cells.clone());
            }
            let tops = &line.tops[cells];
            highest = highest.max(heights_above_uav(simd, tops, frame.uav_z, &mut self.heights[within(-PAD_I64)]));
        }
        #[expect(clippy::cast_precision_loss, reason = "the rounding is part of the proven error")]
        let per = |y: i64| if y == 0 { PER_NOTHING } else { 1.0 / y as f32 };
        let slopes = LineSlopes {
            per_near: per(line.near),
            per_far: per(line.far),
            number: self.n_lines,
            is_below: frame.is_below_uav,
        };
        // A line below every receiver beyond it hides none, so no bound, group or steepest line needs to know of it.
        let may_hide = slopes.bounds((highest, highest), (highest, highest)).0 >= self.lowest_slope(frame, line.far);

        let is_before = self.first < 0;
        for &(from, to) in &self.awake {
            let (b0, n_edges) = (self.first + as_i64(from), to + 1 - from);
            match (self.pending.is_some(), may_hide) {
                (true, true) => {
                    let heights = [&self.heights_before[..], &self.heights[..]];
                    let found = [&mut self.exits[from..], &mut self.next_entries[from..]];
                    look_up_edges(simd, map, heights, (b0, n_edges), &steps, is_before, found);
                }
                (true, false) => {
                    let found = [&mut self.exits[from..]];
                    look_up_edges(simd, map, [&self.heights_before[..]], (b0, n_edges), &steps, is_before, found);
                }
                (false, true) => {
                    let found = [&mut self.next_entries[from..]];
                    look_up_edges(simd, map, [&self.heights[..]], (b0, n_edges), &steps, is_before, found);
                }
                (false, false) => {}
            }
        }
        self.raise(simd);
        if may_hide {
            std::mem::swap(&mut self.entries, &mut self.next_entries);
            self.pending = Some(slopes);
            self.far = line.far;
        }
    }

    /// Raises the bounds by the line that was passed last.
    #[inline(always)]
    fn raise_pending<S: Simd>(&mut self, simd: S, frame: &WedgeFrame) {
        if self.pending.is_none() {
            return;
        }
        let (map, steps) = (self.edge_map(frame), EdgeSteps::new(simd, self.far));
        for &(from, to) in &self.awake {
            let b0 = self.first + as_i64(from);
            let found = [&mut self.exits[from..]];
            look_up_edges(simd, map, [&self.heights[..]], (b0, to + 1 - from), &steps, self.first < 0, found);
        }
        self.raise(simd);
    }

    /// Raises the bounds by the line that was passed last, all of whose heights have been looked up.
    #[inline(always)]
    fn raise<S: Simd>(&mut self, simd: S) {
        let Some(slopes) = self.pending.take() else { return };
        for &(from, to) in &self.awake {
            // Whole vectors first, then one by one: bins past the last may sleep, and must not remember this line.
            let vectors = (to - from) / S::f32s::LEN * S::f32s::LEN;
            let edges = (&self.entries[from..], &self.exits[from..]);
            raise_bounds(simd, edges, slopes, &mut self.bins.slopes_of(from..from + vectors));
            for i in from + vectors..to {
                let at_edges = |values: &[f32]| (values[i], values[i + 1]);
                let (slope, proven) = slopes.bounds(at_edges(&self.entries), at_edges(&self.exits));
                let (bin, bins) = (PAD + i, &mut self.bins);
                bins.second[bin] = bins.second[bin].max(bins.upper[bin].min(slope));
                if slope > bins.upper[bin] {
                    bins.steepest_line[bin] = slopes.number;
                    bins.upper[bin] = slope;
                }
                bins.present[bin] = bins.present[bin].max(slope);
                bins.lower[bin] = bins.lower[bin].max(proven);
            }
        }
    }

    /// A slope that no receiver at distance `from` or beyond is below.
    fn lowest_slope(&self, frame: &WedgeFrame, from: i64) -> f32 {
        // Slopes of receivers below the UAV grow with the distance, those of others fall.
        let at = if frame.lowest_receiver <= 0 { from } else { frame.last_center.max(from) };
        if at <= 0 {
            return NOTHING;
        }
        #[expect(clippy::cast_precision_loss, clippy::cast_possible_truncation, reason = "widened by a margin")]
        let lowest = (frame.lowest_receiver as f64 / at as f64) as f32;
        lowest - lowest.abs() * SLACK - f32::MIN_POSITIVE
    }

    /// Looks ahead: drops the bins in which no receiver from there on can be in line of sight, and finds those that need not
    /// be looked at in the next lines. Begins a group of lines: call it before the first of any tiles, and never after more
    /// lines than a tile has.
    pub(super) fn look_ahead<S: Simd>(&mut self, simd: S, frame: &WedgeFrame, ahead: &Ahead<'_>) {
        simd.vectorize(
            #[inline(always)]
            || {
                self.raise_pending(simd, frame);
                // The receivers' slopes grow with the distance where they are below the UAV, and fall where above.
                // Beside the UAV centers may be behind it.
                let at = if frame.highest_receiver <= 0 { frame.last_center } else { ahead.center }.max(1);
                #[expect(clippy::cast_precision_loss, clippy::cast_possible_truncation, reason = "widened by a margin")]
                let steepest = (frame.highest_receiver as f64 / at as f64) as f32;
                let dark = steepest + steepest.abs() * SLACK + f32::MIN_POSITIVE;
                let (map, per_edges) = (self.edge_map(frame), ahead.per_edges());
                let lowest_slope = self.lowest_slope(frame, ahead.center);
                for &(from, to) in &self.awake {
                    end_group(simd, self.group_start, lowest_slope, &mut self.bins.groups_of(from..to));
                }
                self.group_start = self.n_lines + 1;
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
                        let bins = (self.first + as_i64(start), self.first + as_i64(end));
                        if ahead.may_matter(frame, (&map, per_edges), bins, lowest) {
                            append(&mut self.awake, (start, end), SHORTEST_SLEEP);
                        }
                    }
                }
            },
        );
    }
}

/// Adds an interval to others before it; with all between if that is less than `gap`.
#[inline(always)]
fn append(intervals: &mut Vec<(usize, usize)>, (start, end): (usize, usize), gap: usize) {
    match intervals.last_mut() {
        Some(last) if start - last.1 < gap.max(1) => last.1 = end,
        _ => intervals.push((start, end)),
    }
}

/// The lowest of some slopes.
#[inline(always)]
fn lowest_of(slopes: &[f32]) -> f32 {
    let lower = |a: f32, b: f32| if b < a { b } else { a };
    // PERF: as many at once as a vector has lanes; one after another, each would wait for the one before.
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

/// Lateral cells of the raster under the bins `b0..b1` between two distances, from the first to after the last; none of them
/// is outside the raster where there are none either.
fn cells_between(map: &EdgeMap, (b0, b1): (i64, i64), (near, far): (i64, i64), frame: &WedgeFrame) -> (i64, i64) {
    let low = map.cell(b0, near).min(map.cell(b0, far)).clamp(0, frame.n_lateral);
    let high = (map.cell(b1, near).max(map.cell(b1, far)) + 1).clamp(low, frame.n_lateral);
    (low, high)
}

/// The least level at which bins are narrower than a cell at distance `far`.
fn level_for(far: i64) -> u32 {
    (far.max(0) / CELL).checked_ilog2().map_or(0, |bits| bits + 1)
}
