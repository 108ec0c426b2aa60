//! What becomes of the receivers of a line over columns in memory: bits, and walks for those that bounds leave undecided.

use super::line_walk::{LineCells, LineTiles, LinkLength, LinkOverLines};
use super::quadrants::{CELL, as_i64};
use super::receivers::{AZIMUTH_BITS, Decided, LineReceivers};
use super::shared_bits::{SharedBits, StripBits};
use super::suspects::{Suspects, edges_of};
use super::wedge::{Line, Verdicts};
use crate::height_field::Columns;
use crate::quantity::LatticePoint;
use crate::raster::{BitGrid, set_bits};

/// Where the bits of a line go.
pub(super) enum LineBits<'a> {
    /// Of a row: to its words.
    Row(&'a SharedBits),
    /// Of a column: to that of this number in a strip.
    Column(&'a mut StripBits, usize),
}

/// Which way a line of cells lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Across {
    /// A row of cells, met by going north or south.
    Row,
    /// A column of cells, met by going east or west.
    Column,
}

/// Which receivers of columns in memory a sweep is asked for.
pub(super) struct Wanted<'a> {
    pub(super) columns: &'a Columns,
    pub(super) uav: LatticePoint,
    pub(super) cells: &'a BitGrid,
    /// Whether that is every cell.
    pub(super) is_all: bool,
}

/// The receivers of one line.
pub(super) struct LineVerdicts<'a> {
    wanted: &'a Wanted<'a>,
    bits: LineBits<'a>,
    across: Across,
    /// The row or column that the line is, and 1 if rows or columns have rising numbers on the way out, else −1.
    index: usize,
    outward: i64,
    line: &'a Line<'a>,
    receivers: &'a LineReceivers<'a>,
    /// How many receivers were asked about.
    asked: &'a mut u64,
    /// Room for lateral cells.
    seen: &'a mut Vec<u32>,
}

impl<'a> LineVerdicts<'a> {
    pub(super) fn new(
        wanted: &'a Wanted<'a>,
        bits: LineBits<'a>,
        (index, outward): (usize, i64),
        line: &'a Line<'a>,
        receivers: &'a LineReceivers<'a>,
        (asked, seen): (&'a mut u64, &'a mut Vec<u32>),
    ) -> Self {
        let across = match bits {
            LineBits::Row(_) => Across::Row,
            LineBits::Column(..) => Across::Column,
        };
        LineVerdicts { wanted, bits, across, index, outward, line, receivers, asked, seen }
    }

    /// Adds bits to a word of the line, which may hold some of another wedge if it is shared.
    #[inline(always)]
    fn add(&mut self, word: usize, bits: u64, is_shared: bool) {
        match &mut self.bits {
            LineBits::Row(rows) => rows.add(self.index, word, bits, is_shared),
            LineBits::Column(strip, column) => strip.add(*column, word, bits),
        }
    }
}

impl Verdicts for LineVerdicts<'_> {
    #[inline(always)]
    fn decided(&mut self, word: usize, decided: Decided, is_shared: bool) -> u64 {
        self.add(word, decided.los, is_shared);
        match self.across {
            _ if self.wanted.is_all => decided.undecided,
            Across::Row => decided.undecided & self.wanted.cells.row(self.index)[word],
            // PERF: one after another along a column, each bit asked for is in a line of the cache of its own.
            Across::Column => set_bits(&[decided.undecided])
                .filter(|bit| self.wanted.cells.contains(64 * word + bit, self.index))
                .fold(0, |bits, bit| bits | 1 << bit),
        }
    }

    fn ask(&mut self, cells: &mut Vec<u32>, suspects: &Suspects<'_>) {
        *self.asked += cells.len() as u64;
        let lines = RasterLines::new(self);
        // PERF: first, for all and without branches, what the steepest line tells: of four in ten that they are hidden, and
        // of three that they are seen. The others are few enough for branches that nobody can predict.
        self.seen.resize(cells.len().max(self.seen.len()), 0);
        let (mut n_left, mut n_seen) = (0, 0);
        for k in 0..cells.len() {
            let cell = cells[k];
            let above_uav = self.receivers.height(cell as usize);
            let known = suspects.of(i64::from(cell), above_uav);
            let met = lines.meet(known.azimuth(), above_uav, known.steepest_line());
            let is_seen = met.is_clear & known.is_steepest_alone();
            self.seen[n_seen] = cell;
            n_seen += usize::from(is_seen);
            cells[n_left] = cell;
            n_left += usize::from(!met.is_hidden & !is_seen);
        }
        for cell in &cells[..n_left] {
            if lines.is_los(i64::from(*cell), self.receivers.height(*cell as usize), suspects) {
                self.seen[n_seen] = *cell;
                n_seen += 1;
            }
        }
        for k in 0..n_seen {
            let (word, bit) = (self.seen[k] as usize / 64, self.seen[k] % 64);
            self.add(word, 1 << bit, suspects.is_shared(word));
        }
    }
}

/// The lines before that of some receivers, in the raster.
struct RasterLines<'a> {
    columns: &'a Columns,
    uav_z: i64,
    uav_lateral: i64,
    n_lateral: i64,
    /// The number of the receivers' row or column, and how numbers change on the way out, by 1.
    index: i64,
    outward: i64,
    /// The first cell of the receivers' line, and the steps to that of the next line outward and along a line.
    start: i64,
    strides: (i64, i64),
    /// Steps to the tile of the next lines, and to the next tile of the same lines, as numbers rise.
    tile_strides: (i64, i64),
    /// Distances of the farther edge of the receivers' line and of its centers \[lattice steps\].
    far: i64,
    length: LinkLength,
}

/// What a line does to a link, where that is sure.
struct Met {
    is_hidden: bool,
    is_clear: bool,
}

impl<'a> RasterLines<'a> {
    fn new(of: &LineVerdicts<'a>) -> Self {
        let Wanted { columns, uav, .. } = *of.wanted;
        let LineVerdicts { outward, .. } = *of;
        let (n_rows, n_cols, index) = (as_i64(columns.n_rows()), as_i64(columns.n_cols()), as_i64(of.index));
        let per_row = as_i64(columns.tiles().per_row());
        let (uav_lateral, n_lateral, start, strides, tile_strides) = match of.across {
            Across::Row => (uav.x, n_cols, index * n_cols, (outward * n_cols, 1), (per_row, 1)),
            Across::Column => (n_rows * CELL - uav.y, n_rows, index, (outward, n_cols), (1, per_row)),
        };
        let (far, length) = (of.line.far, LinkLength::new(of.line.center));
        let uav_z = uav.z;
        RasterLines {
            columns,
            uav_z,
            uav_lateral,
            n_lateral,
            index,
            outward,
            start,
            strides,
            tile_strides,
            far,
            length,
        }
    }

    /// Whether none of the suspected lines hides the receiver of a lateral cell, `above_uav` above the UAV \[1/1024 m\].
    fn is_los(&self, lateral: i64, above_uav: i64, suspects: &Suspects<'_>) -> bool {
        let RasterLines { columns, strides, .. } = *self;
        let heights = (self.uav_z + above_uav, -above_uav);
        let link = LinkOverLines::new(self.length, (lateral, self.n_lateral), self.uav_lateral, heights);
        let own = usize::try_from(self.start + lateral * strides.1).unwrap_or(0);
        let cells = LineCells { tops: columns.tops(), own, strides: (-strides.0, strides.1), tiles: None };
        let (groups, others) = suspects.of(lateral, above_uav).lines();
        // A group is too few lines for tiles to spare any.
        let tiles = || LineTiles {
            tiles: columns.tiles(),
            line: self.index,
            lateral,
            step: -self.outward,
            strides: self.tile_strides,
        };
        groups.iter().flatten().all(|lines| link.is_clear(&cells, edges_of(self.far, *lines)))
            && others.is_none_or(|lines| {
                link.is_clear(&LineCells { tiles: Some(tiles()), ..cells }, edges_of(self.far, lines))
            })
    }

    /// What line `back`, counted back, does to the link to a receiver: the ray is looked at where it enters and where it exits
    /// the line, unless that is next to a border of cells.
    #[inline(always)]
    fn meet(&self, azimuth: i64, above_uav: i64, back: i64) -> Met {
        let tops = self.columns.tops();
        let (near, far) = edges_of(self.far, (back, back));
        // Heights are compared times the distance of the receiver: how far the top of the cell that the ray is in is above
        // the UAV, the same of the ray, and whether the cell is certain.
        let look = |distance: i64| {
            // EXACT: an azimuth is off by less than a lattice step at the receiver, the product rounded down by one at most.
            let at = self.uav_lateral + ((azimuth * distance) >> AZIMUTH_BITS);
            let (cell, within) = (at.div_euclid(CELL), at.rem_euclid(CELL));
            let is_certain = (0..self.n_lateral).contains(&cell) & (2..CELL - 2).contains(&within);
            let index = if is_certain { self.start - back * self.strides.0 + cell * self.strides.1 } else { 0 };
            let top = usize::try_from(index).map_or(0, |index| i64::from(tops[index]) - self.uav_z);
            // EXACT: heights are below 2^31, distances at most 2^26.
            (top * self.length.steps(), above_uav * distance, is_certain)
        };
        let ((top, height, is_certain), (far_top, far_height, is_far_certain)) = (look(near), look(far));
        Met {
            is_hidden: is_certain & (top > height) | is_far_certain & (far_top > far_height),
            // Between both the ray is in these two cells alone.
            is_clear: is_certain & is_far_certain & (top.max(far_top) <= height.min(far_height)),
        }
    }
}
