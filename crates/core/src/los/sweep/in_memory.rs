//! The sweep over columns in memory: a wedge after another, shared by the threads.

use std::borrow::Cow;
use std::sync::atomic::{AtomicU64, Ordering};

use fearless_simd::Level;

use crate::dispatch;
use rayon::prelude::*;

use super::super::columns_los;
use super::line_order::{STRIP, for_tile_lines, turn};
use super::quadrants::{CELL, Quadrant, Swept, as_i64, near_cells, parts};
use super::receivers::LineReceivers;
use super::shared_bits::{SharedBits, StripBits};
use super::verdicts::{LineBits, LineVerdicts, Wanted};
use super::wedge::{Ahead, Line, TileLine, TileReceivers, Wedge, WedgeFrame};
use crate::height_field::{Columns, TileMaxima};
use crate::quantity::LatticePoint;
use crate::raster::{BitGrid, CellWindow};

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

/// Decides which of the `wanted` receivers within `window` are in line of sight of `uav`: equal to
/// [`columns_los`] for each.
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
    let is_all = wanted.count() == as_i64(columns.tops().len()).unsigned_abs();
    let sweep = Sweep {
        wanted: Wanted { columns, uav, cells: wanted, is_all },
        receivers,
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
    let los = sweep.rows.into_grid(columns.n_cols());
    Swept { los: if is_all { los } else { los.and(wanted) }, undecided }
}

struct Sweep<'a> {
    wanted: Wanted<'a>,
    receivers: ReceiverHeights<'a>,
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
            uav_z: i32::try_from(self.wanted.uav.z).unwrap_or(i32::MAX),
            is_below_uav: i64::from(self.wanted.columns.max_top()) <= self.wanted.uav.z,
            uav_lateral,
            window: (as_i64(window.0), as_i64(window.1)),
            n_lateral: as_i64(n_lateral),
            lowest_receiver: self.receivers.lowest() - self.wanted.uav.z,
            highest_receiver: self.receivers.highest() - self.wanted.uav.z,
            last_center,
        }
    }

    fn run_rows<S: fearless_simd::Simd>(&self, simd: S, quadrant: Quadrant, wedge: &mut Wedge) {
        let (n_rows, n_cols) = (self.wanted.columns.n_rows(), self.wanted.columns.n_cols());
        let window = self.window;
        let rows = window.row..window.row + window.n_rows;
        let outward = if quadrant == Quadrant::North { 1 } else { -1 };
        let distances = |row: usize| Self::distances(as_i64(n_rows - 1 - row) * CELL, self.wanted.uav.y, outward);
        let last = if quadrant == Quadrant::North { rows.start } else { rows.end.saturating_sub(1) };
        let frame = self.frame(self.wanted.uav.x, (window.col, window.col + window.n_cols), n_cols, distances(last).1);
        let per_row = self.wanted.columns.tiles().per_row();
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
                let tops = &self.wanted.columns.tops()[cells.clone()];
                let line = Line { tops, first: 0, near, center, far, next: self.row_cells(as_i64(row) - outward) };
                let receivers = match self.receivers {
                    ReceiverHeights::Flat(z) => LineReceivers::Flat(z.wrapping_sub(frame.uav_z)),
                    ReceiverHeights::Over { base, above, .. } => {
                        LineReceivers::Over { base: &base[cells], first: 0, above: above.wrapping_sub(frame.uav_z) }
                    }
                };
                let bits = LineBits::Row(&self.rows);
                let mut verdicts =
                    LineVerdicts::new(&self.wanted, bits, (row, -outward), &line, &receivers, (&mut asked, &mut seen));
                wedge.pass(simd, &frame, &line, &receivers, &mut verdicts);
            });
            !wedge.is_done()
        });
        self.undecided.fetch_add(asked, Ordering::Relaxed);
    }

    fn run_columns<S: fearless_simd::Simd>(&self, simd: S, quadrant: Quadrant, wedge: &mut Wedge) {
        let (n_rows, n_cols) = (self.wanted.columns.n_rows(), self.wanted.columns.n_cols());
        let window = self.window;
        let cols = window.col..window.col + window.n_cols;
        let outward = if quadrant == Quadrant::East { 1 } else { -1 };
        let distances = |col: usize| Self::distances(as_i64(col) * CELL, self.wanted.uav.x, outward);
        let last = if quadrant == Quadrant::East { cols.end.saturating_sub(1) } else { cols.start };
        // Lateral positions run south, as rows do.
        let uav_lateral = as_i64(n_rows) * CELL - self.wanted.uav.y;
        let frame = self.frame(uav_lateral, (window.row, window.row + window.n_rows), n_rows, distances(last).1);
        let per_row = self.wanted.columns.tiles().per_row();
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
                turn(simd, self.wanted.columns.tops(), n_cols, &turned, &rows, &mut tops);
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
                    LineVerdicts::new(&self.wanted, bits, (col, outward), &line, &receivers, (&mut asked, &mut seen));
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
        let n_cols = self.wanted.columns.n_cols();
        let cells = usize::try_from(row).ok().filter(|row| *row < self.wanted.columns.n_rows());
        let cells = cells.map_or(0..0, |row| row * n_cols..(row + 1) * n_cols);
        [&self.wanted.columns.tops()[cells.clone()], self.own_bases().map_or(&[], |bases| &bases[cells])]
    }

    /// The tiles of some rows or columns of cells; tiles have `strides` to the next lines of tiles and along them.
    fn tile_line(&self, number: usize, (across, stride): (usize, usize)) -> TileLine<'_> {
        fn from(tiles: &TileMaxima, first: usize) -> &[i32] {
            &tiles.maxima()[first..]
        }
        let above_uav = |z: i32| z.wrapping_sub(i32::try_from(self.wanted.uav.z).unwrap_or(i32::MAX));
        let first = number * across;
        let receivers = match (self.receivers, self.bases.as_deref()) {
            (ReceiverHeights::Flat(z), _) => TileReceivers::Flat(above_uav(z)),
            (ReceiverHeights::Over { above, .. }, None) => TileReceivers::OnTops(above_uav(above)),
            (ReceiverHeights::Over { above, .. }, Some(bases)) => {
                TileReceivers::OnBases(from(bases, first), above_uav(above))
            }
        };
        TileLine { tops: from(self.wanted.columns.tiles(), first), stride, receivers }
    }

    fn ask(&self, row: usize, col: usize) -> bool {
        let (x, y) = self.wanted.columns.center(row, col);
        let z = self.receivers.at(row * self.wanted.columns.n_cols() + col);
        columns_los(self.wanted.columns, self.wanted.uav, LatticePoint { x, y, z })
    }

    /// Asks `ray` for the cells around the UAV that no wedge decides.
    fn near_box(&self) {
        let (rows, cols) = near_cells(self.wanted.uav, self.wanted.columns.n_rows(), self.window);
        for row in rows {
            for col in cols.clone() {
                if self.wanted.cells.contains(row, col) && self.ask(row, col) {
                    self.rows.add(row, col / 64, 1 << (col % 64), true);
                }
            }
        }
    }
}
