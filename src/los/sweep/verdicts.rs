//! What becomes of the receivers of a line over columns in memory: bits, and walks for those that bounds leave undecided.

use super::super::columns_lines::columns_los_over_lines;
use super::kernels::{Decided, LineReceivers};
use super::shared_bits::SharedBits;
use super::wedge::{Line, SuspectLines, Suspects, Verdicts};
use super::{Across, CELL, Sweep, as_i64};
use crate::quantity::LatticePoint;

/// The receivers of one line.
pub(super) struct LineVerdicts<'a> {
    sweep: &'a Sweep<'a>,
    across: Across,
    /// The row or column that the line is, and 1 if rows or columns have rising numbers on the way out, else −1.
    index: usize,
    outward: i64,
    line: &'a Line<'a>,
    receivers: &'a LineReceivers<'a>,
    /// How many receivers were asked about.
    asked: &'a mut u64,
}

impl<'a> LineVerdicts<'a> {
    pub(super) fn new(
        sweep: &'a Sweep<'a>,
        (across, index, outward): (Across, usize, i64),
        line: &'a Line<'a>,
        receivers: &'a LineReceivers<'a>,
        asked: &'a mut u64,
    ) -> Self {
        LineVerdicts { sweep, across, index, outward, line, receivers, asked }
    }

    /// The bits of lines of this kind.
    #[inline(always)]
    fn bits(&self) -> &SharedBits {
        match self.across {
            Across::Row => &self.sweep.rows,
            Across::Column => &self.sweep.cols,
        }
    }

    /// Row and column of a lateral cell.
    #[inline(always)]
    fn cell(&self, lateral: usize) -> (usize, usize) {
        match self.across {
            Across::Row => (self.index, lateral),
            Across::Column => (lateral, self.index),
        }
    }
}

impl Verdicts for LineVerdicts<'_> {
    #[inline(always)]
    fn decided(&mut self, word: usize, decided: Decided, is_shared: bool) -> u64 {
        self.bits().add(self.index, word, decided.los, is_shared);
        match self.across {
            _ if self.sweep.is_all_wanted => decided.undecided,
            Across::Row => decided.undecided & self.sweep.wanted.row(self.index)[word],
            Across::Column => crate::raster::set_bits(&[decided.undecided])
                .filter(|bit| self.sweep.wanted.contains(64 * word + bit, self.index))
                .fold(0, |bits, bit| bits | 1 << bit),
        }
    }

    fn ask(&mut self, cells: &mut Vec<u32>, suspects: &Suspects<'_>) {
        *self.asked += cells.len() as u64;
        self.drop_hidden(cells, suspects);
        let Sweep { columns, uav, .. } = *self.sweep;
        for cell in cells.iter().map(|cell| *cell as usize) {
            let (row, col) = self.cell(cell);
            let (x, y) = columns.center(row, col);
            let own = row * columns.n_cols() + col;
            let above_uav = self.receivers.height(cell);
            let receiver = LatticePoint { x, y, z: above_uav + uav.z };
            let SuspectLines { groups, others } = suspects.of(as_i64(cell), above_uav);
            if columns_los_over_lines(columns, uav, (own, receiver), self.across, (groups, others)) {
                let (word, bits) = (cell / 64, 1 << (cell % 64));
                self.bits().add(self.index, word, bits, suspects.is_shared(word));
            }
        }
    }
}

/// Bits of a fraction of a distance.
const FRACTION: u32 = 36;

impl LineVerdicts<'_> {
    /// Leaves out receivers that the steepest line surely hides: half of all. A ray is looked at where it enters and where it
    /// exits the line, unless that is next to a border of cells.
    fn drop_hidden(&self, cells: &mut Vec<u32>, suspects: &Suspects<'_>) {
        let Sweep { columns, uav, .. } = *self.sweep;
        let (n_rows, n_cols) = (as_i64(columns.n_rows()), as_i64(columns.n_cols()));
        let own = as_i64(self.index);
        // Steps from cell to cell of the raster: to the next line outward and along a line.
        let (uav_lateral, n_lateral, start, outward, sideways) = match self.across {
            Across::Row => (uav.x, n_cols, own * n_cols, self.outward * n_cols, 1),
            Across::Column => (n_rows * CELL - uav.y, n_rows, own, self.outward, n_cols),
        };
        let tops = columns.tops();
        let far_of_own = self.line.far;
        let per_distance = 1.0 / self.line.center as f64;
        let scale = per_distance * (1_i64 << FRACTION) as f64;
        let mut n_left = 0;
        for k in 0..cells.len() {
            let lateral = i64::from(cells[k]);
            let above_uav = self.receivers.height(cells[k] as usize);
            let back = suspects.lines_to_steepest(lateral);
            let far = far_of_own - back * CELL;
            // EXACT: rounded to 2^-36 of the distance, which is at most 2^26, so no place is off by a lattice step.
            let side = ((lateral * CELL + CELL / 2 - uav_lateral) as f64 * scale) as i64;
            let slope = above_uav as f64 * per_distance;
            let start = start - back * outward;
            let is_hidden_at = |distance: i64| {
                let at = uav_lateral + (side * distance >> FRACTION);
                let (cell, within) = (at.div_euclid(CELL), at.rem_euclid(CELL));
                let is_inside = (0..n_lateral).contains(&cell) & (2..CELL - 2).contains(&within);
                let top = if is_inside { start + cell * sideways } else { 0 };
                let above = i64::from(tops[top as usize]) - uav.z;
                is_inside & (above as f64 > slope * distance as f64 + 1e-3)
            };
            let is_hidden = is_hidden_at((far - CELL).max(0)) | is_hidden_at(far);
            cells[n_left] = cells[k];
            n_left += usize::from(!is_hidden);
        }
        cells.truncate(n_left);
    }
}
