//! The cells around a UAV in four quadrants, each line by line outward.

use rayon::prelude::*;

use crate::height_field::Columns;
use crate::quantity::{LatticePoint, STEPS_PER_UNIT, VOID};
use crate::raster::{BitGrid, CellWindow};

/// The slope of a void cell, which blocks nothing: below that of every height, and still finite for
/// interpolation.
pub(super) const NOTHING: f64 = -1e30;

/// The cells with |lateral| ≤ ring on one side of the UAV. To the north and south its lines are
/// rows, to the east and west columns. Ring 0 is the UAV's own cell, which belongs to no quadrant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quadrant<'a> {
    columns: &'a Columns,
    window: Window,
    along_rows: bool,
    /// Direction of lines away from the UAV: +1 if their numbers grow, −1 if they fall.
    outward: i64,
    /// Position of the UAV across and along the lines \[cells from the first\].
    uav: (f64, f64),
    /// The UAV's cell across and along the lines.
    cell: (i64, i64),
    uav_z: i64,
}

/// Lines and lateral cells in the window, each as first and end.
#[derive(Debug, Clone, Copy)]
struct Window {
    lines: (i64, i64),
    lateral: (i64, i64),
}

/// A line of a quadrant.
#[derive(Debug, Clone, Copy)]
pub(super) struct Line {
    /// Row or column of the line.
    number: i64,
    /// First lateral cell in the window and the one after the last.
    pub(super) first: i64,
    pub(super) end: i64,
    /// Distance of its centers from the UAV across the lines \[cells\]: at least 1/2.
    pub(super) distance: f64,
    /// The ring around the UAV's cell that it belongs to.
    pub(super) ring: i64,
}

/// Returns the cells that all four quadrants of a window see together. Adds the receiver in the
/// UAV's own cell, which no line holds.
pub(super) fn by_quadrants(
    columns: &Columns,
    uav: LatticePoint,
    (wanted, window): (&BitGrid, CellWindow),
    seen: impl Fn(&Quadrant<'_>) -> BitGrid + Sync,
) -> BitGrid {
    let parts: Vec<BitGrid> = Quadrant::all(columns, uav, window).par_iter().map(&seen).collect();
    let mut los = parts.iter().fold(BitGrid::new(wanted.n_rows(), wanted.n_cols()), BitGrid::or);
    if let Some(own) = columns.cell_at(uav.x, uav.y) {
        let (row, col) = (own / columns.n_cols(), own % columns.n_cols());
        if wanted.contains(row, col) {
            los.insert(row, col);
        }
    }
    los
}

impl<'a> Quadrant<'a> {
    pub(super) fn all(columns: &'a Columns, uav: LatticePoint, window: CellWindow) -> [Quadrant<'a>; 4] {
        #[expect(clippy::cast_precision_loss, reason = "positions are below 2^27")]
        let cells = |v: i64| v as f64 / f64::from(STEPS_PER_UNIT);
        #[expect(clippy::cast_possible_wrap, reason = "a raster in memory has far fewer than 2^63 cells")]
        let range = |first: usize, n: usize| (first as i64, (first + n) as i64);
        #[expect(clippy::cast_possible_wrap, reason = "a raster in memory has far fewer than 2^63 cells")]
        let from_north = columns.n_rows() as i64 * i64::from(STEPS_PER_UNIT) - uav.y;
        let (rows, cols) = (range(window.row, window.n_rows), range(window.col, window.n_cols));
        let cell = |v: i64| v.div_euclid(i64::from(STEPS_PER_UNIT));
        [(true, -1), (true, 1), (false, -1), (false, 1)].map(|(along_rows, outward)| {
            let (across, along, lines, lateral) =
                if along_rows { (from_north, uav.x, rows, cols) } else { (uav.x, from_north, cols, rows) };
            Quadrant {
                columns,
                window: Window { lines, lateral },
                along_rows,
                outward,
                uav: (cells(across), cells(along)),
                cell: (cell(across), cell(along)),
                uav_z: uav.z,
            }
        })
    }

    /// Returns the lines in the window, outward.
    pub(super) fn lines(&self) -> impl Iterator<Item = Line> {
        let (first, end) = self.window.lines;
        let (near, n) = if self.outward > 0 {
            let near = (self.cell.0 + 1).max(first);
            (near, end - near)
        } else {
            let near = (self.cell.0 - 1).min(end - 1);
            (near, near + 1 - first)
        };
        (0..n.max(0)).map(move |k| {
            let number = near + k * self.outward;
            let ring = (number - self.cell.0).abs();
            let (first, end) = self.window.lateral;
            #[expect(clippy::cast_precision_loss, reason = "line numbers are below 2^17")]
            let distance = (number as f64 + 0.5 - self.uav.0).abs();
            Line { number, first: first.max(self.cell.1 - ring), end: end.min(self.cell.1 + ring + 1), distance, ring }
        })
    }

    /// Returns `true` if the quadrant decides a cell of a line: diagonal ones belong to the north
    /// and south.
    pub(super) fn decides(&self, line: &Line, lateral: i64) -> bool {
        self.along_rows || (lateral - self.cell.1).abs() < line.ring
    }

    /// Returns row and column of a cell of a line.
    #[inline]
    pub(super) fn cell(&self, line: &Line, lateral: i64) -> (usize, usize) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "inside the window")]
        let (number, lateral) = (line.number as usize, lateral as usize);
        if self.along_rows { (number, lateral) } else { (lateral, number) }
    }

    /// Returns the position of the center of a lateral cell along its line, from the UAV \[cells\].
    #[inline]
    pub(super) fn offset(&self, lateral: i64) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "cell numbers are below 2^17")]
        let center = lateral as f64 + 0.5;
        center - self.uav.1
    }

    /// Returns the position of the center of the UAV's own cell along the lines, from the UAV
    /// \[cells\].
    pub(super) fn offset_of_own_cell(&self) -> f64 {
        self.offset(self.cell.1)
    }

    /// Returns the cell of a line nearest to an offset along it; `None` if that is outside the
    /// line.
    #[inline]
    pub(super) fn nearest(&self, line: &Line, offset: f64) -> Option<i64> {
        #[expect(clippy::cast_possible_truncation, reason = "offsets are below 2^18")]
        let lateral = (offset + self.uav.1).floor() as i64;
        (line.first..line.end).contains(&lateral).then_some(lateral)
    }

    /// Returns the slope from the UAV to the top of a cell \[steps of height per cell\];
    /// [`NOTHING`] if it is void.
    #[inline]
    pub(super) fn slope(&self, line: &Line, lateral: i64) -> f64 {
        let (row, col) = self.cell(line, lateral);
        match self.columns.tops()[row * self.columns.n_cols() + col] {
            VOID => NOTHING,
            top => self.slope_of(line, i64::from(top)),
        }
    }

    /// Returns the slope from the UAV to a height on a line.
    #[inline]
    pub(super) fn slope_of(&self, line: &Line, z: i64) -> f64 {
        #[expect(clippy::cast_precision_loss, reason = "heights are at most 2^27")]
        let above = (z - self.uav_z) as f64;
        above / line.distance
    }
}
