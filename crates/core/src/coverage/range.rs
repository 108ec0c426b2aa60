//! The cells in range of a place, mostly that of a UAV: a disc, row by row.

use crate::height_field::{GridPositions, Place};
use crate::quantity::whole;
use crate::raster::{BitGrid, CellWindow, bits_between};

/// Which columns of each row are in range.
#[derive(Debug, Clone)]
pub(super) struct Range {
    shape: (usize, usize),
    /// The rows of the disc and their columns; `None` if every cell is in range.
    disc: Option<Disc>,
}

#[derive(Debug, Clone)]
struct Disc {
    first_row: usize,
    /// First column in range and the one after the last, row by row.
    cols: Vec<(usize, usize)>,
}

impl Range {
    /// The cells whose centers are at most `radius` \[CRS units\] from a place; those at just this distance are in.
    ///
    /// Distances come from whole lattice steps and their squares are compared, so a scene and its mirror image agree.
    pub(super) fn of(positions: &GridPositions, place: &Place, radius: Option<f64>) -> Self {
        let shape = positions.shape();
        let Some(radius) = radius else { return Range { shape, disc: None } };
        let (step_x, step_y) = positions.step_lengths();
        // In steps along x: whole where the radius is a whole number of them but for rounding.
        let (limit, ratio) = (whole(radius / step_x), step_y / step_x);
        let steps_to = positions.steps_from(place);
        let squared = |row: usize, col: usize| {
            let (dx, dy) = steps_to(row, col);
            let (dx, dy) = (dx as f64, dy as f64 * ratio);
            dx * dx + dy * dy
        };
        let is_in = |row: usize, col: usize| squared(row, col) <= limit * limit;
        // The column nearest to the UAV, and away from it both ways the distance only grows.
        let nearest = (0..shape.1).min_by(|a, b| squared(0, *a).total_cmp(&squared(0, *b))).unwrap_or(0);
        let of_row = |row: usize| {
            if !is_in(row, nearest) {
                return (0, 0);
            }
            let to_the_east = partition(nearest..shape.1, |col| is_in(row, col));
            let to_the_west = partition(0..nearest, |col| !is_in(row, col));
            (to_the_west, to_the_east)
        };
        let nearest_row =
            (0..shape.0).min_by(|a, b| squared(*a, nearest).total_cmp(&squared(*b, nearest))).unwrap_or(0);
        if !is_in(nearest_row, nearest) {
            return Range { shape, disc: Some(Disc { first_row: 0, cols: Vec::new() }) };
        }
        let first_row = partition(0..nearest_row, |row| !is_in(row, nearest));
        let end_row = partition(nearest_row..shape.0, |row| is_in(row, nearest));
        Range { shape, disc: Some(Disc { first_row, cols: (first_row..end_row).map(of_row).collect() }) }
    }

    /// Whether no cell is out of range for want of a radius.
    pub(super) fn is_everywhere(&self) -> bool {
        self.disc.is_none()
    }

    /// First column in range of a row and the one after the last.
    pub(super) fn cols(&self, row: usize) -> (usize, usize) {
        match &self.disc {
            None => (0, self.shape.1),
            Some(disc) => row.checked_sub(disc.first_row).and_then(|k| disc.cols.get(k)).copied().unwrap_or((0, 0)),
        }
    }

    /// Whether a cell, row and column, is in range.
    pub(super) fn contains(&self, (row, col): (usize, usize)) -> bool {
        let (first, end) = self.cols(row);
        (first..end).contains(&col)
    }

    /// The smallest window that holds all cells in range, and so all cells between them and the UAV.
    pub(super) fn window(&self) -> CellWindow {
        match &self.disc {
            None => CellWindow { row: 0, col: 0, n_rows: self.shape.0, n_cols: self.shape.1 },
            Some(disc) => {
                let west = disc.cols.iter().map(|c| c.0).min().unwrap_or(0);
                let east = disc.cols.iter().map(|c| c.1).max().unwrap_or(0);
                CellWindow { row: disc.first_row, col: west, n_rows: disc.cols.len(), n_cols: east - west }
            }
        }
    }

    /// The smallest window that holds those of two ranges.
    pub(super) fn window_with(&self, other: &Range) -> CellWindow {
        let (a, b) = (self.window(), other.window());
        let (row, col) = (a.row.min(b.row), a.col.min(b.col));
        let (end_row, end_col) = ((a.row + a.n_rows).max(b.row + b.n_rows), (a.col + a.n_cols).max(b.col + b.n_cols));
        CellWindow { row, col, n_rows: end_row - row, n_cols: end_col - col }
    }

    /// The cells of a set that are in range.
    pub(super) fn cut(&self, cells: &BitGrid) -> BitGrid {
        match &self.disc {
            None => cells.clone(),
            Some(disc) => self.cut_rows(cells, disc.first_row..disc.first_row + disc.cols.len()),
        }
    }

    /// The cells of a set in some rows that are in range.
    fn cut_rows(&self, cells: &BitGrid, rows: std::ops::Range<usize>) -> BitGrid {
        let mut kept = BitGrid::new(self.shape.0, self.shape.1);
        let per_row = kept.words_per_row();
        for row in rows {
            let (from, to) = self.cols(row);
            for word in from / 64..to.div_ceil(64) {
                kept.words_mut()[row * per_row + word] = cells.row(row)[word] & bits_between(from, to, word);
            }
        }
        kept
    }
}

/// Whether a set holds a cell whose center is at most `radius` \[CRS units\] from a place.
pub fn any_in_range(positions: &GridPositions, place: &Place, radius: f64, cells: &BitGrid) -> bool {
    let range = Range::of(positions, place, Some(radius));
    let CellWindow { row, n_rows, .. } = range.window();
    (row..row + n_rows).any(|row| {
        let (from, to) = range.cols(row);
        let words = from / 64..to.div_ceil(64);
        words.into_iter().any(|word| cells.row(row)[word] & bits_between(from, to, word) != 0)
    })
}

/// The first index of a range for which `holds` is false; it holds for all before and for none after.
fn partition(range: std::ops::Range<usize>, holds: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (range.start, range.end);
    while low < high {
        let middle = low + (high - low) / 2;
        if holds(middle) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}
