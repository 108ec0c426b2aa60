//! `sweep` over columns: bounds on what hides a receiver, carried outward from the UAV line by line.
//!
//! # Method
//!
//! The plane around the UAV is cut into four quadrants: in the one to the north all cells with |dx| ≤ dy, and so on. Within
//! a quadrant the sweep goes outward over *lines* of cells (rows to the north and south, columns to the east and west).
//! Positions are (lateral, distance): distance y > 0 across the lines, t = lateral/y the azimuth, |t| ≤ 1. Slopes are
//! (z − h_U)/y, so that one slope holds along a whole ray.
//!
//! ```text
//!   distance e ──┬─────┬──x──┬─────┬──   a line spans distances a to e; a bin is what lies
//!                │     │ / \ │     │     between two azimuths, closed, and narrower than a
//!   distance a ──┴─────┴x───x┴─────┴──   cell at e
//!                      /     \           UAV at distance 0, below
//! ```
//!
//! Azimuth is cut into closed *bins* at t = b/2^k, and each bin holds two bounds over the lines passed so far that may hide
//! a receiver:
//! * `upper`: none of these lines obstructs a ray of the bin above this slope. A line raises it to the largest height among
//!   the cells under both edges of the bin at a and at e. Sorted by position these four points are at most a cell apart
//!   (|t| ≤ 1 moves a ray by at most a cell per line, and a bin is narrower than a cell), so no cell that a ray of the bin
//!   touches is missed.
//!   A height d = z − h_U obstructs with slope d/e at most if d ≤ 0, with d/a at most if d > 0: the larger of both.
//! * `lower`: every ray of the bin is obstructed at least up to this slope. Each ray leaves the line at e through one of
//!   the two cells under the edges there (or on the border between), so the lower of these two, at e, obstructs it. It enters
//!   the line through one of the two cells under the edges at a, so the lower of those, at a, obstructs it as well: on rough
//!   surfaces this proves a fifth of what would be in doubt, since half of all cells that rays touch are left sideways.
//!
//! A receiver is compared with the lines *before* its own: from a cell center, |t| ≤ 1 crosses no other cell of the own
//! line. If its slope is above `upper` it is LoS, below `lower` NLoS, both proven; the few between are settled by the lines
//! that may hide them, the last of them by a walk along their ray ([`line_walk`]), in exact integers. So the
//! outcome is that of `ray`, cell for cell.
//!
//! **On the edge of a bin.** A ray exactly on edge t_b is in two closed bins. `upper` holds for it in both. `lower` is the
//! problem: where the ray meets a or e exactly on a border between cells, a look-up takes one of them, and the ray is in the
//! other one before or after. For t > 0 the ray comes out of the left cell and goes on into the right one, and look-ups take
//! the right one: the bin to the left of the edge has both, since its other edge is less than a cell away. For t < 0 all is
//! mirrored: look-ups take the left cell, and the bin to the right of the edge has both. So receivers on an edge belong to
//! the bin towards the axis, and on the axis to the left one: a ray with t = 0 leads to the center of a cell, so that it is
//! never on a border. All other rays of either bin are to one side of the edge, where the bin has the cell.
//!
//! # Rounding
//!
//! Which cell is under an edge is decided in integers: an edge is at (u·2^k + b·y)/2^(k+10) cells. Which bin a receiver is in
//! is decided in fixed point: where it is among the bins, dx·2^k/y, is a multiple of 1/y, so half of that is room enough for
//! rounding once none of them is on an edge any more ([`receivers`]). In a vector of lanes only a remainder below 2^31 is left to
//! add to: of edges it is exact, of receivers it is rounded down by less than 2^-31 of a bin, for which there is room as well.
//! Slopes are 32-bit floats. A height difference is rounded once (2^-24 of itself), the inverse distance twice, its product
//! with what puts a bound off once, the product once: a slope is off by less than 2^-21 of itself, and maxima and minima round nothing. So
//! two slopes compare as they would exactly wherever they differ by more than 2^-20 of either. Both bounds are put off by
//! 2^-19 of themselves, `upper` up and `lower` down, and what lies between is left undecided ([`kernels`]). No distance is
//! below half a lattice cell but a = 0 in the UAV's own line, where 1/a is 10^25: every height above the UAV is then too
//! steep for any receiver, as it must be.
//!
//! # What makes it fast
//!
//! * Cells under edges are looked up with a permutation of one vector, since neighbors are less than a cell apart, and the
//!   bounds of receivers with one of two. All instruction sets do the same operations in the same order: the bits are the
//!   same.
//! * Rays exit a line where they enter the next one, so a line raises the bounds when the next one is entered, and cells are
//!   looked up in both by one reckoning of places.
//! * A line that is below every receiver still to come, wherever it may be, can hide none and raises nothing: so do the streets
//!   between blocks on flat ground (two of five lines of an urban city).
//! * Near lines need few bins: a bin splits in two, which inherit its bounds, when the next line asks for narrower ones.
//!   Bins twice as fine leave fewer receivers undecided, by a sixth to a quarter, but cost as much as these walks do.
//! * Bins in which no later receiver can be LoS retire, 32 at a time; in dense cities nearly all do.
//! * Bins sleep through what lies in the dark. The highest top and receiver of each tile of 8 × 8 cells are known
//!   ([`TileMaxima`]). Where those of all tiles that 32 bins pass in the next eight lines are less steep than the least
//!   `lower` of these bins, nothing there can raise a bound, be suspected or be seen: not `lower`; not `upper`, which is never
//!   below it; nor is a receiver LoS. So neither cells nor receivers are looked at. This comparison leaves more slack than
//!   any bound is put off by. About half of all bins sleep in an urban city of 4096² cells, fewer in suburbs, more among
//!   high-rises. Gaps of less than 96 bins between others stay awake, which is harmless and costs less than to leave them out.
//! * An undecided receiver need only be asked about the lines that can matter ([`suspects`]). Each bin knows its steepest line
//!   and how steep the second is. Looked at where the ray, in fixed point, enters and leaves it, the steepest line hides four
//!   of ten, and three of ten are seen because no other is as steep as they are. For the rest each bin knows the steepest of
//!   the present group of up to eight lines, the two steepest groups before it, and the first and the last of all other groups
//!   that are as steep as any receiver in doubt can be, that is neither below the lowest possible receiver nor below `lower`.
//!   Over laser scans a half to three quarters of the rest need one group, and one in forty needs other groups; over
//!   these a walk skips eight lines at a time where the tiles are below it.
//! * To the east and west, strips of 64 columns are turned into lines first; memory is read in rows throughout. Rows of rasters
//!   in memory are asked for while those before them are turned or passed: what a wedge reads of a row is too short for a core to
//!   read ahead by itself.
//!
//! Cost: two to three look-ups per cell that is not in the dark, and a look at one line or a walk for each undecided receiver
//! (0.02 to 3 % of all).

mod bins;
mod kernels;
mod line_order;
mod line_walk;
mod quadrant_pass;
mod receivers;
mod shared_bits;
mod streamed;
mod suspects;
mod verdicts;
mod wedge;

use std::borrow::Cow;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

use self::line_order::{STRIP, for_tile_lines, turn};
use self::receivers::LineReceivers;
use self::shared_bits::{SharedBits, StripBits};
pub use self::streamed::{ColumnsReader, StreamLimits, StreamedHeights, StreamedScene, streamed_sweep_los};
use self::verdicts::{LineBits, LineVerdicts};
use self::wedge::{Ahead, Line, MAX_PARTS, NEAR, TileLine, TileReceivers, Wedge, WedgeFrame};
use super::columns_los;
use crate::height_field::{Columns, TileMaxima};
use crate::quantity::{LatticePoint, STEPS_PER_UNIT};
use crate::raster::{BitGrid, CellWindow};

const CELL: i64 = STEPS_PER_UNIT as i64;

/// Heights of the receivers at the cell centers of the columns.
#[derive(Debug, Clone, Copy)]
pub enum ReceiverHeights<'a> {
    /// All at one height \[1/1024 m above the datum\].
    Flat(i32),
    /// Above a base for each cell, row by row from the north-west \[1/1024 m\].
    Over {
        /// What receivers stand on.
        base: &'a [i32],
        /// How high they are above it.
        above: i32,
        /// The lowest of `base`, or anything lower.
        lowest: i32,
        /// The highest of `base`, or anything higher.
        highest: i32,
        /// The highest of `base` by tile, where that is not the tops; found anew if it is not given.
        tiles: Option<&'a TileMaxima>,
    },
}

impl ReceiverHeights<'_> {
    fn lowest(&self) -> i64 {
        match self {
            ReceiverHeights::Flat(z) => i64::from(*z),
            ReceiverHeights::Over { lowest, above, .. } => i64::from(*lowest) + i64::from(*above),
        }
    }

    fn highest(&self) -> i64 {
        match self {
            ReceiverHeights::Flat(z) => i64::from(*z),
            ReceiverHeights::Over { highest, above, .. } => i64::from(*highest) + i64::from(*above),
        }
    }

    #[inline]
    fn at(&self, cell: usize) -> i64 {
        match self {
            ReceiverHeights::Flat(z) => i64::from(*z),
            ReceiverHeights::Over { base, above, .. } => i64::from(base[cell]) + i64::from(*above),
        }
    }
}

/// What a sweep found.
#[derive(Debug, Clone)]
pub struct Swept {
    /// The wanted cells in line of sight.
    pub los: BitGrid,
    /// How many of the wanted cells the bounds left undecided.
    pub undecided: u64,
}

/// Decides which of the `wanted` receivers within `window` are in line of sight of `uav`: equal to
/// [`columns_los`](super::columns_los) for each.
///
/// `wanted` has the shape of the columns. Threads of the current pool share the work; neither their number nor `level`
/// changes the result.
pub fn sweep_los(
    columns: &Columns,
    uav: LatticePoint,
    receivers: ReceiverHeights<'_>,
    wanted: &BitGrid,
    window: CellWindow,
    level: Level,
) -> Swept {
    if i64::from(columns.max_top()) <= uav.z.min(receivers.lowest()) {
        // Nothing rises above both ends of any link.
        return Swept { los: wanted.clone(), undecided: 0 };
    }
    let sweep = Sweep {
        columns,
        uav,
        receivers,
        wanted,
        is_all_wanted: wanted.count() == as_i64(columns.tops().len()).unsigned_abs(),
        window,
        rows: SharedBits::new(columns.n_rows(), columns.n_cols()),
        undecided: AtomicU64::new(0),
        bases: match receivers {
            ReceiverHeights::Over { base, tiles, .. } if !std::ptr::eq(base, columns.tops()) => {
                Some(tiles.map_or_else(|| Cow::Owned(TileMaxima::of(base, columns.n_cols())), Cow::Borrowed))
            }
            _ => None,
        },
    };
    let quadrants = [Quadrant::North, Quadrant::South, Quadrant::East, Quadrant::West];
    let parts = parts(columns.n_rows().max(columns.n_cols()));
    let wedges: Vec<(Quadrant, i64)> =
        quadrants.iter().flat_map(|q| (-parts..parts).map(move |part| (*q, part))).collect();
    wedges.into_par_iter().for_each(|(quadrant, part)| {
        dispatch!(level, simd => sweep.run(simd, quadrant, Wedge::new(part, parts)));
    });
    sweep.near_box();
    let undecided = sweep.undecided.load(Ordering::Relaxed);
    let is_all_wanted = sweep.is_all_wanted;
    let los = sweep.rows.into_grid(columns.n_cols());
    Swept { los: if is_all_wanted { los } else { los.and(wanted) }, undecided }
}

/// Cells across a raster beyond which its quadrants are cut once more.
const LONGEST_LINE: usize = 4096;

/// Wedges to each side of the axis of a quadrant: eight for every thread in all, since some take longer than others, and
/// enough for the bins of a wedge and the lines behind it to stay in a core's cache; no more, since long lines are read
/// faster than short ones.
fn parts(n_across: usize) -> i64 {
    let for_threads = rayon::current_num_threads();
    as_i64(for_threads.max(n_across / LONGEST_LINE).next_power_of_two()).clamp(1, MAX_PARTS)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Quadrant {
    North,
    South,
    East,
    West,
}

struct Sweep<'a> {
    columns: &'a Columns,
    uav: LatticePoint,
    receivers: ReceiverHeights<'a>,
    wanted: &'a BitGrid,
    /// Whether that is every cell.
    is_all_wanted: bool,
    window: CellWindow,
    /// Line of sight by row.
    rows: SharedBits,
    undecided: AtomicU64,
    /// The highest of what receivers stand on, tile by tile, where that is not the tops.
    bases: Option<Cow<'a, TileMaxima>>,
}

impl Sweep<'_> {
    fn run<S: fearless_simd::Simd>(&self, simd: S, quadrant: Quadrant, mut wedge: Wedge) {
        match quadrant {
            Quadrant::North | Quadrant::South => self.run_rows(simd, quadrant, &mut wedge),
            Quadrant::East | Quadrant::West => self.run_columns(simd, quadrant, &mut wedge),
        }
    }

    /// Distances of a line from the UAV along the sweep: of its nearer edge, its centers and its farther edge.
    fn distances(low: i64, uav: i64, outward: i64) -> (i64, i64, i64) {
        let ends = ((low - uav) * outward, (low + CELL - uav) * outward);
        let (near, far) = (ends.0.min(ends.1), ends.0.max(ends.1));
        (near.max(0), near + CELL / 2, far)
    }

    fn frame(&self, uav_lateral: i64, window: (usize, usize), n_lateral: usize, last_center: i64) -> WedgeFrame {
        WedgeFrame {
            uav_z: i32::try_from(self.uav.z).unwrap_or(i32::MAX),
            is_below_uav: i64::from(self.columns.max_top()) <= self.uav.z,
            uav_lateral,
            window: (as_i64(window.0), as_i64(window.1)),
            n_lateral: as_i64(n_lateral),
            lowest_receiver: self.receivers.lowest() - self.uav.z,
            highest_receiver: self.receivers.highest() - self.uav.z,
            last_center,
        }
    }

    fn run_rows<S: fearless_simd::Simd>(&self, simd: S, quadrant: Quadrant, wedge: &mut Wedge) {
        let (n_rows, n_cols) = (self.columns.n_rows(), self.columns.n_cols());
        let window = self.window;
        let rows = window.row..window.row + window.n_rows;
        let outward = if quadrant == Quadrant::North { 1 } else { -1 };
        let distances = |row: usize| Self::distances(as_i64(n_rows - 1 - row) * CELL, self.uav.y, outward);
        let last = if quadrant == Quadrant::North { rows.start } else { rows.end.saturating_sub(1) };
        let frame = self.frame(self.uav.x, (window.col, window.col + window.n_cols), n_cols, distances(last).1);
        let per_row = self.columns.tiles().per_row();
        let (mut asked, mut seen) = (0, Vec::new());
        for_tile_lines(rows, outward < 0, |rows| {
            let (first, last) = (distances(rows.first), distances(rows.last));
            if last.2 <= 0 {
                return true;
            }
            let tiles = Some(self.tile_line(rows.tile, (per_row, 1)));
            wedge.look_ahead(simd, &frame, &Ahead { near: first.0, center: first.1, far: last.2, tiles });
            rows.each(|row| {
                let (near, center, far) = distances(row);
                if far <= 0 {
                    return;
                }
                let cells = row * n_cols..(row + 1) * n_cols;
                let tops = &self.columns.tops()[cells.clone()];
                let line = Line { tops, first: 0, near, center, far, next: self.row_cells(as_i64(row) - outward) };
                let receivers = match self.receivers {
                    ReceiverHeights::Flat(z) => LineReceivers::Flat(z.wrapping_sub(frame.uav_z)),
                    ReceiverHeights::Over { base, above, .. } => {
                        LineReceivers::Over { base: &base[cells], first: 0, above: above.wrapping_sub(frame.uav_z) }
                    }
                };
                let bits = LineBits::Row(&self.rows);
                let mut verdicts =
                    LineVerdicts::new(self, bits, (row, -outward), &line, &receivers, (&mut asked, &mut seen));
                wedge.pass(simd, &frame, &line, &receivers, &mut verdicts);
            });
            !wedge.is_done()
        });
        self.undecided.fetch_add(asked, Ordering::Relaxed);
    }

    fn run_columns<S: fearless_simd::Simd>(&self, simd: S, quadrant: Quadrant, wedge: &mut Wedge) {
        let (n_rows, n_cols) = (self.columns.n_rows(), self.columns.n_cols());
        let window = self.window;
        let cols = window.col..window.col + window.n_cols;
        let outward = if quadrant == Quadrant::East { 1 } else { -1 };
        let distances = |col: usize| Self::distances(as_i64(col) * CELL, self.uav.x, outward);
        let last = if quadrant == Quadrant::East { cols.end.saturating_sub(1) } else { cols.start };
        // Lateral positions run south, as rows do.
        let uav_lateral = as_i64(n_rows) * CELL - self.uav.y;
        let frame = self.frame(uav_lateral, (window.row, window.row + window.n_rows), n_rows, distances(last).1);
        let per_row = self.columns.tiles().per_row();
        // Columns of tops and bases as lines, of which those cells are there that can be looked at.
        let (mut tops, mut bases) = (Vec::new(), Vec::new());
        let (mut strip, mut low, mut width) = (0..0, 0, 0);
        // Line of sight in that strip.
        let mut found = StripBits::new(n_rows);
        let own_bases = self.own_bases();
        let (mut asked, mut seen) = (0, Vec::new());
        for_tile_lines(cols.clone(), outward > 0, |of_tile| {
            let (first, last) = (distances(of_tile.first), distances(of_tile.last));
            if last.2 <= 0 {
                return true;
            }
            let tiles = Some(self.tile_line(of_tile.tile, (1, per_row)));
            wedge.look_ahead(simd, &frame, &Ahead { near: first.0, center: first.1, far: last.2, tiles });
            let turned = of_tile.first / STRIP * STRIP..((of_tile.first / STRIP + 1) * STRIP).min(n_cols);
            if strip != turned {
                found.move_to(&self.rows, strip.start / STRIP);
                strip = turned.clone();
                let (a, b) = (distances(turned.start), distances(turned.end - 1));
                let reach = wedge.reach(&frame, a.0.min(b.0), a.2.max(b.2));
                let rows = usize::try_from(reach.0).unwrap_or(0)..usize::try_from(reach.1).unwrap_or(0);
                (low, width) = (reach.0, rows.len());
                found.begin(&rows);
                turn(simd, self.columns.tops(), n_cols, &turned, &rows, &mut tops);
                if let Some(own) = own_bases {
                    turn(simd, own, n_cols, &turned, &rows, &mut bases);
                }
            }
            of_tile.each(|col| {
                let (near, center, far) = distances(col);
                if far <= 0 {
                    return;
                }
                let cells = (col - turned.start) * width..(col - turned.start + 1) * width;
                let line = Line { tops: &tops[cells.clone()], first: low, near, center, far, next: [&[]; 2] };
                let receivers = match self.receivers {
                    ReceiverHeights::Flat(z) => LineReceivers::Flat(z.wrapping_sub(frame.uav_z)),
                    ReceiverHeights::Over { above, .. } => {
                        let base = if own_bases.is_some() { &bases[cells] } else { &tops[cells] };
                        LineReceivers::Over { base, first: low, above: above.wrapping_sub(frame.uav_z) }
                    }
                };
                let bits = LineBits::Column(&mut found, col % STRIP);
                let mut verdicts =
                    LineVerdicts::new(self, bits, (col, outward), &line, &receivers, (&mut asked, &mut seen));
                wedge.pass(simd, &frame, &line, &receivers, &mut verdicts);
            });
            !wedge.is_done()
        });
        found.move_to(&self.rows, strip.start / STRIP);
        self.undecided.fetch_add(asked, Ordering::Relaxed);
    }

    /// What receivers stand on, where that is not the tops.
    fn own_bases(&self) -> Option<&[i32]> {
        match self.receivers {
            ReceiverHeights::Over { base, .. } if self.bases.is_some() => Some(base),
            _ => None,
        }
    }

    /// Tops of a row of cells, and what receivers stand on there, where that is not the tops; nothing outside the raster.
    fn row_cells(&self, row: i64) -> [&[i32]; 2] {
        let n_cols = self.columns.n_cols();
        let cells = usize::try_from(row).ok().filter(|row| *row < self.columns.n_rows());
        let cells = cells.map_or(0..0, |row| row * n_cols..(row + 1) * n_cols);
        [&self.columns.tops()[cells.clone()], self.own_bases().map_or(&[], |bases| &bases[cells])]
    }

    /// The tiles of some rows or columns of cells; tiles have `strides` to the next lines of tiles and along them.
    fn tile_line(&self, number: usize, (across, stride): (usize, usize)) -> TileLine<'_> {
        fn from(tiles: &TileMaxima, first: usize) -> &[i32] {
            &tiles.maxima()[first..]
        }
        let above_uav = |z: i32| z.wrapping_sub(i32::try_from(self.uav.z).unwrap_or(i32::MAX));
        let first = number * across;
        let receivers = match (self.receivers, self.bases.as_deref()) {
            (ReceiverHeights::Flat(z), _) => TileReceivers::Flat(above_uav(z)),
            (ReceiverHeights::Over { above, .. }, None) => TileReceivers::OnTops(above_uav(above)),
            (ReceiverHeights::Over { above, .. }, Some(bases)) => {
                TileReceivers::OnBases(from(bases, first), above_uav(above))
            }
        };
        TileLine { tops: from(self.columns.tiles(), first), stride, receivers }
    }

    fn ask(&self, row: usize, col: usize) -> bool {
        let (x, y) = self.columns.center(row, col);
        let z = self.receivers.at(row * self.columns.n_cols() + col);
        columns_los(self.columns, self.uav, LatticePoint { x, y, z })
    }

    /// Asks `ray` for the cells around the UAV that no wedge decides.
    fn near_box(&self) {
        let (rows, cols) = near_cells(self.uav, self.columns.n_rows(), self.window);
        for row in rows {
            for col in cols.clone() {
                if self.wanted.contains(row, col) && self.ask(row, col) {
                    self.rows.add(row, col / 64, 1 << (col % 64), true);
                }
            }
        }
    }
}

/// Rows and columns of the cells near the UAV, which no wedge decides, inside a window of a raster of `n_rows`.
fn near_cells(uav: LatticePoint, n_rows: usize, window: CellWindow) -> (Range<usize>, Range<usize>) {
    let reach = NEAR / CELL + 1;
    let clip = |middle: i64, low: usize, n: usize| {
        let at = |v: i64| usize::try_from(v.max(0)).unwrap_or(usize::MAX).clamp(low, low + n);
        at(middle - reach)..at(middle + reach + 1)
    };
    let (east, north) = (uav.x.div_euclid(CELL), uav.y.div_euclid(CELL));
    let row = as_i64(n_rows) - 1 - north;
    (clip(row, window.row, window.n_rows), clip(east, window.col, window.n_cols))
}

fn as_i64(n: usize) -> i64 {
    i64::try_from(n).unwrap_or(i64::MAX)
}
