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
//! Azimuth is cut into closed *bins* at t = b/2^k, and each bin holds two bounds over all lines passed so far:
//! * `upper`: no ray of the bin is obstructed above this slope. A line raises it to the largest height among the cells under
//!   both edges of the bin at a and at e. Sorted by position these four points are at most a cell apart (|t| ≤ 1 moves a
//!   ray by at most a cell per line, and a bin is narrower than a cell), so no cell that a ray of the bin touches is missed.
//!   A height d = z − h_U obstructs with slope d/e at most if d ≤ 0, with d/a at most if d > 0: the larger of both.
//! * `lower`: every ray of the bin is obstructed at least up to this slope. Each ray leaves the line at e through one of
//!   the two cells under the edges there (or on the border between), so the lower of these two, at e, obstructs it.
//!
//! A receiver is compared with the lines *before* its own: from a cell center, |t| ≤ 1 crosses no other cell of the own
//! line. If its slope is above `upper` it is LoS, below `lower` NLoS, both proven; the few between go to a walk along
//! their ray ([`super::columns_lines`]), in exact integers. So the outcome is that of `ray`, cell for cell.
//!
//! **On the edge of a bin.** A ray exactly on edge t_b is in two closed bins. `upper` holds for it in both. `lower` is the
//! problem: where the ray meets e exactly on a border between cells, look-ups take the cell to the right, and the ray may
//! have come through the left one (t > 0), through both (t = 0, along the border: solid up to the lower one) or through the
//! right one (t < 0). For t ≥ 0 the bin to the left of the edge has both cells; for t < 0 the one to the right has the cell
//! that counts. So receivers on an edge belong to the bin towards the axis, and on the axis to the left one.
//!
//! # Rounding
//!
//! Which cell is under an edge and which bin a receiver is in are decided in integers: an edge is at
//! (u·2^k + b·y)/2^(k+10) cells, a receiver in bin ⌊dx·2^k/y⌋. In a vector of lanes only a remainder below 2^31 is left to
//! add to; nothing is rounded. Slopes are 32-bit floats. A height difference is rounded once (2^-24 of itself), the inverse
//! distance twice, the product once: a slope is off by less than 2^-21 of itself, and maxima and minima round nothing. So
//! two slopes compare as they would exactly wherever they differ by more than 2^-20 of the sum of their sizes, and what is
//! closer is left undecided ([`kernels`]). No distance is below half a lattice cell but a = 0 in the UAV's own line, where
//! 1/a is 10^25: every height above the UAV is then too steep for any receiver, as it must be.
//!
//! # What makes it fast
//!
//! * Bins of a line are looked up with a permutation of two vectors, since neighbors are at most a cell apart; so are the
//!   bounds of receivers. All instruction sets do the same operations in the same order: the bits are the same.
//! * Near lines need few bins: a bin splits in two, which inherit its bounds, when the next line asks for narrower ones.
//!   What is loose stays loose, so bins are kept one level finer than needed (fewer undecided receivers for a quarter more
//!   look-ups).
//! * Bins in which no later receiver can be LoS retire, 64 at a time; in dense cities nearly all do.
//! * An undecided receiver need only be asked about the lines that can matter: each bin remembers the first and the last
//!   line that was as steep as any receiver in doubt could be, that is neither below the lowest possible receiver nor below
//!   `lower`. That is a building or two instead of the whole path. A pyramid of maxima, which lets a walk skip what is
//!   low, was planned for this; the two line numbers cost less memory and make most walks shorter than its blocks.
//! * To the east and west, strips of 64 columns are turned into lines first; memory is read in rows throughout.
//!
//! Cost: about 1.5 look-ups per cell, and a short walk for each undecided receiver (0.02 to 3 % of all).

mod kernels;
mod quadrant_pass;
mod streamed;
mod wedge;

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;

use self::kernels::{Decided, LineReceivers};
pub use self::streamed::{ColumnsReader, StreamLimits, StreamedHeights, StreamedScene, streamed_sweep_los};
use self::wedge::{Line, MAX_PARTS, NEAR, Suspects, Wedge, WedgeFrame};
use super::columns_lines::{Across, columns_los_over_lines};
use super::columns_los;
use crate::height_field::Columns;
use crate::quantity::{LatticePoint, STEPS_PER_UNIT};
use crate::raster::{BitGrid, CellWindow};

const CELL: i64 = STEPS_PER_UNIT as i64;

/// Columns that are turned into lines together.
const STRIP: usize = 64;

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
    /// How many of the wanted cells the bounds left to `ray`.
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
        window,
        rows: SharedBits::new(columns.n_rows(), columns.n_cols()),
        cols: SharedBits::new(columns.n_cols(), columns.n_rows()),
        undecided: AtomicU64::new(0),
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
    Swept { los: sweep.into_los(), undecided }
}

/// Cells across a raster beyond which its quadrants are cut once more.
const LONGEST_LINE: usize = 4096;

/// Wedges to each side of the axis of a quadrant: enough for every thread, and for the bins of a wedge and the lines behind
/// it to stay in a core's cache; no more, since long lines are read faster than short ones.
fn parts(n_across: usize) -> i64 {
    let for_threads = rayon::current_num_threads() / 2;
    as_i64(for_threads.max(n_across / LONGEST_LINE).next_power_of_two()).clamp(1, MAX_PARTS)
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Quadrant {
    North,
    South,
    East,
    West,
}

/// Bits that several threads write, one line after another.
struct SharedBits {
    words: Vec<AtomicU64>,
    per_line: usize,
}

impl SharedBits {
    fn new(n_lines: usize, n_cells: usize) -> Self {
        let per_line = n_cells.div_ceil(64);
        let mut words = Vec::with_capacity(n_lines * per_line);
        words.resize_with(n_lines * per_line, || AtomicU64::new(0));
        SharedBits { words, per_line }
    }

    /// The words of a line.
    fn line(&self, line: usize) -> &[AtomicU64] {
        &self.words[line * self.per_line..(line + 1) * self.per_line]
    }

    #[inline]
    fn add(&self, line: usize, word: usize, bits: u64) {
        self.words[line * self.per_line + word].fetch_or(bits, Ordering::Relaxed);
    }
}

struct Sweep<'a> {
    columns: &'a Columns,
    uav: LatticePoint,
    receivers: ReceiverHeights<'a>,
    wanted: &'a BitGrid,
    window: CellWindow,
    /// Line of sight by row, from the quadrants north and south.
    rows: SharedBits,
    /// Line of sight by column, from the quadrants east and west.
    cols: SharedBits,
    undecided: AtomicU64,
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
        let mut pass = |row: usize| -> bool {
            let (near, center, far) = distances(row);
            if far <= 0 {
                return true;
            }
            let cells = row * n_cols..(row + 1) * n_cols;
            let line = Line { tops: &self.columns.tops()[cells.clone()], first: 0, near, center, far };
            let receivers = match self.receivers {
                ReceiverHeights::Flat(z) => LineReceivers::Flat(z.wrapping_sub(frame.uav_z)),
                ReceiverHeights::Over { base, above, .. } => {
                    LineReceivers::Over { base: &base[cells], first: 0, above: above.wrapping_sub(frame.uav_z) }
                }
            };
            let wanted = self.wanted.row(row);
            wedge.pass(simd, &frame, &line, &receivers, &mut |word, decided: Decided, suspects: &Suspects<'_>| {
                let open = decided.undecided & wanted[word];
                let los = decided.los | self.ask_each(open, 64 * word, suspects, Across::Row, |lateral| (row, lateral));
                if los != 0 {
                    self.rows.add(row, word, los);
                }
            });
            !wedge.is_done()
        };
        match quadrant {
            Quadrant::North => rows.rev().all(&mut pass),
            _ => rows.into_iter().all(&mut pass),
        };
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
        let (mut tops, mut bases) = (Vec::new(), Vec::new());
        let first_strip = cols.start / STRIP;
        let strips = first_strip..cols.end.div_ceil(STRIP);
        let mut pass = |strip: usize| -> bool {
            let cols = (strip * STRIP).max(cols.start)..((strip + 1) * STRIP).min(cols.end);
            let (a, b) = (distances(cols.start), distances(cols.end - 1));
            let (near, far) = (a.0.min(b.0), a.2.max(b.2));
            if far <= 0 {
                return true;
            }
            let (low, high) = wedge.reach(&frame, near, far);
            let span = usize::try_from(low).unwrap_or(0)..usize::try_from(high).unwrap_or(0);
            let width = span.len();
            turn(self.columns.tops(), n_cols, &cols, &span, &mut tops);
            let own_base = match self.receivers {
                ReceiverHeights::Over { base, .. } if !std::ptr::eq(base, self.columns.tops()) => {
                    turn(base, n_cols, &cols, &span, &mut bases);
                    true
                }
                _ => false,
            };
            let mut each = |col: usize| -> bool {
                let (near, center, far) = distances(col);
                if far <= 0 {
                    return true;
                }
                let cells = (col - cols.start) * width..(col - cols.start + 1) * width;
                let line = Line { tops: &tops[cells.clone()], first: low, near, center, far };
                let receivers = match self.receivers {
                    ReceiverHeights::Flat(z) => LineReceivers::Flat(z.wrapping_sub(frame.uav_z)),
                    ReceiverHeights::Over { above, .. } => {
                        let base = if own_base { &bases[cells] } else { &tops[cells] };
                        LineReceivers::Over { base, first: low, above: above.wrapping_sub(frame.uav_z) }
                    }
                };
                wedge.pass(simd, &frame, &line, &receivers, &mut |word, decided: Decided, suspects: &Suspects<'_>| {
                    let los = decided.los
                        | self
                            .ask_each(decided.undecided, 64 * word, suspects, Across::Column, |lateral| (lateral, col));
                    if los != 0 {
                        self.cols.add(col, word, los);
                    }
                });
                !wedge.is_done()
            };
            match quadrant {
                Quadrant::East => cols.clone().all(&mut each),
                _ => cols.clone().rev().all(&mut each),
            }
        };
        match quadrant {
            Quadrant::East => strips.into_iter().all(&mut pass),
            _ => strips.rev().all(&mut pass),
        };
    }

    /// Of the undecided receivers from lateral cell `first` on, those that `ray` finds in line of sight.
    fn ask_each(
        &self,
        undecided: u64,
        first: usize,
        suspects: &Suspects<'_>,
        across: Across,
        cell: impl Fn(usize) -> (usize, usize),
    ) -> u64 {
        let mut los = 0;
        let mut left = undecided;
        let mut asked = 0;
        while left != 0 {
            let bit = left.trailing_zeros() as usize;
            left &= left - 1;
            let (row, col) = cell(first + bit);
            if !self.wanted.contains(row, col) {
                continue;
            }
            asked += 1;
            let (x, y) = self.columns.center(row, col);
            let own = row * self.columns.n_cols() + col;
            let receiver = LatticePoint { x, y, z: self.receivers.at(own) };
            let lines = suspects.of(as_i64(first + bit));
            let is_los = columns_los_over_lines(self.columns, self.uav, (own, receiver), across, lines);
            los |= u64::from(is_los) << bit;
        }
        if asked > 0 {
            self.undecided.fetch_add(asked, Ordering::Relaxed);
        }
        los
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
                    self.rows.add(row, col / 64, 1 << (col % 64));
                }
            }
        }
    }

    /// Both halves together, cut to what is wanted.
    fn into_los(self) -> BitGrid {
        let (n_rows, n_cols) = (self.columns.n_rows(), self.columns.n_cols());
        let mut los = BitGrid::new(n_rows, n_cols);
        let per_row = los.words_per_row();
        let per_col = self.cols.per_line;
        let (rows, cols, wanted) = (&self.rows.words, &self.cols.words, self.wanted);
        los.words_mut().par_chunks_mut(64 * per_row).enumerate().for_each(|(band, out)| {
            let n_band = out.len() / per_row;
            for word in 0..per_row {
                let mut block = [0_u64; 64];
                let n_here = (n_cols - 64 * word).min(64);
                let mut any = 0;
                for (k, bits) in block.iter_mut().enumerate().take(n_here) {
                    *bits = cols[(64 * word + k) * per_col + band].load(Ordering::Relaxed);
                    any |= *bits;
                }
                if any != 0 {
                    transpose(&mut block);
                }
                for k in 0..n_band {
                    let own = rows[(64 * band + k) * per_row + word].load(Ordering::Relaxed);
                    out[k * per_row + word] = (own | block[k]) & wanted.row(64 * band + k)[word];
                }
            }
        });
        los
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

/// Copies columns `cols` of rows `rows` into lines, one after another.
fn turn(tops: &[i32], n_cols: usize, cols: &Range<usize>, rows: &Range<usize>, lines: &mut Vec<i32>) {
    let width = rows.len();
    // Grows and never shrinks, so that nothing is cleared which is overwritten anyway.
    if lines.len() < width * cols.len() {
        lines.resize(width * cols.len(), 0);
    }
    const BLOCK: usize = 16;
    for start in (0..width).step_by(BLOCK) {
        let height = BLOCK.min(width - start);
        let sources: [&[i32]; BLOCK] = std::array::from_fn(|k| {
            let row = rows.start + start + k.min(height - 1);
            &tops[row * n_cols + cols.start..row * n_cols + cols.end]
        });
        for i in 0..cols.len() {
            let line = &mut lines[i * width + start..i * width + start + height];
            // PERF: of known length, the copy is unrolled.
            if let Ok(line) = <&mut [i32; BLOCK]>::try_from(&mut *line) {
                for (k, top) in line.iter_mut().enumerate() {
                    *top = sources[k][i];
                }
            } else {
                for (k, top) in line.iter_mut().enumerate() {
                    *top = sources[k][i];
                }
            }
        }
    }
}

/// Turns a block of bits over: bit `c` of word `r` becomes bit `r` of word `c` (Warren, Hacker's Delight, 7-3).
fn transpose(block: &mut [u64; 64]) {
    let mut width = 32;
    let mut mask = 0x0000_0000_ffff_ffff_u64;
    while width != 0 {
        let mut k = 0;
        while k < 64 {
            let swapped = ((block[k] >> width) ^ block[k + width]) & mask;
            block[k] ^= swapped << width;
            block[k + width] ^= swapped;
            k = (k + width + 1) & !width;
        }
        width >>= 1;
        mask ^= mask << width;
    }
}

fn as_i64(n: usize) -> i64 {
    i64::try_from(n).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transposed_block_has_rows_for_columns() {
        let mut block: [u64; 64] =
            std::array::from_fn(|r| (r as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(7));
        let before = block;
        transpose(&mut block);
        for (r, row) in before.iter().enumerate() {
            for (c, column) in block.iter().enumerate() {
                assert_eq!(row >> c & 1, column >> r & 1);
            }
        }
    }
}
