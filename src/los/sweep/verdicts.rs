//! What becomes of the receivers of a line over columns in memory: bits, and walks for those that bounds leave undecided.

use super::super::columns_lines::columns_los_over_lines;
use super::kernels::{Decided, LineReceivers};
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
        match self.across {
            Across::Row => self.sweep.rows.add(self.index, word, decided.los, is_shared),
            Across::Column => self.sweep.cols.add(self.index, word, decided.los, is_shared),
        }
        match self.across {
            _ if self.sweep.is_all_wanted => decided.undecided,
            Across::Row => decided.undecided & self.sweep.wanted.row(self.index)[word],
            Across::Column => crate::raster::set_bits(&[decided.undecided])
                .filter(|bit| self.sweep.wanted.contains(64 * word + bit, self.index))
                .fold(0, |bits, bit| bits | 1 << bit),
        }
    }

    fn ask(&mut self, cells: &[u32], suspects: &Suspects<'_>) {
        let Sweep { columns, uav, .. } = *self.sweep;
        *self.asked += cells.len() as u64;
        let n_cols = as_i64(columns.n_cols());
        let (uav_lateral, n_lateral) = match self.across {
            Across::Row => (uav.x, n_cols),
            Across::Column => (as_i64(columns.n_rows()) * CELL - uav.y, as_i64(columns.n_rows())),
        };
        // Steps to the next line inward and to the next lateral cell.
        let (inward, sideways) = match self.across {
            Across::Row => (-self.outward * n_cols, 1),
            Across::Column => (-self.outward, n_cols),
        };
        let start = match self.across {
            Across::Row => as_i64(self.index) * n_cols,
            Across::Column => as_i64(self.index),
        };
        let tops = columns.tops();
        let per_distance = 1.0 / self.line.center as f64;
        for &cell in cells {
            let lateral = i64::from(cell);
            let above_uav = self.receivers.height(cell as usize);
            let back = suspects.steepest(lateral);
            let far = self.line.far - back * CELL;
            let near = (far - CELL).max(0);
            let along = (lateral * CELL + CELL / 2 - uav_lateral) as f64 * per_distance;
            let slope = above_uav as f64 * per_distance;
            // Whether the ray is below the top of the cell it is in at a distance.
            let is_below = |distance: i64| -> bool {
                let at = uav_lateral as f64 + along * distance as f64;
                let whole = at as i64;
                let cell = whole >> 10;
                let within = at - (cell * CELL) as f64;
                let inside = at >= 0.0 && cell < n_lateral;
                let index = if inside { start + back * inward + cell * sideways } else { 0 };
                let above = i64::from(tops[index as usize]) - uav.z;
                inside & (within > 1e-3) & (within < 1024.0 - 1e-3) & (above as f64 > slope * distance as f64 + 1e-3)
            };
            if is_below(near) | is_below(far) {
                continue;
            }
            let (row, col) = self.cell(cell as usize);
            let (x, y) = columns.center(row, col);
            let own = row * columns.n_cols() + col;
            let receiver = LatticePoint { x, y, z: above_uav + uav.z };
            let SuspectLines { groups, others } = suspects.of(lateral, above_uav);
            if columns_los_over_lines(columns, uav, (own, receiver), self.across, (groups, others)) {
                let word = cell as usize / 64;
                let bits = 1 << (cell % 64);
                match self.across {
                    Across::Row => self.sweep.rows.add(self.index, word, bits, suspects.is_shared(word)),
                    Across::Column => self.sweep.cols.add(self.index, word, bits, suspects.is_shared(word)),
                }
            }
        }
    }
}
