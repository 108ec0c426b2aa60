//! The zones of any scene, from the shape of the ground between its buildings.

use std::cmp::Ordering;
use std::ops::Range;

use super::crossings::zones_of;
use super::mesh::Mesh;
use super::outline::Outlines;
use super::zone::{NONE, Zone};
use crate::height_field::HeightField;
use crate::overlay::Tangle;

/// Returns the zone codes of the cells, row by row from the north-west.
///
/// # Errors
/// Outlines that cross too often.
pub(super) fn codes(field: &HeightField) -> Result<Vec<u8>, Tangle> {
    let ground = Outlines::of(field).open_ground()?;
    let [xs, ys] = ground.centers.clone();
    let mesh = Mesh::of(ground);
    let zones = zones_of(&mesh);
    let (n_rows, n_cols) = (field.grid().n_rows(), field.grid().n_cols());
    let mut codes = vec![NONE; n_rows * n_cols];
    let mut centers = Centers::new(&xs, &ys);
    for (cell, zone) in zones.iter().enumerate() {
        centers.inside(mesh.sides(cell).map(|side| mesh.ends(side)), |y, cols| {
            let row = (n_rows - 1 - y) * n_cols;
            codes[row + cols.start..row + cols.end].iter_mut().for_each(|code| *code = zone.code().max(*code));
        });
    }
    let cells = field.cells();
    let mut left_over = Vec::new();
    for row in 0..n_rows {
        for col in 0..n_cols {
            let code = &mut codes[row * n_cols + col];
            if cells.building.contains(row, col) {
                *code = Zone::Rooftop.code();
            } else if !cells.open.contains(row, col) {
                *code = NONE;
            } else if *code == NONE {
                left_over.push((row, col));
            }
        }
    }
    spread(&mut codes, left_over, (n_rows, n_cols));
    Ok(codes)
}

/// Compares a point with the line through two others, the second farther north: `Greater` is east
/// of it. EXACT.
fn side_of([low, high]: [[i64; 2]; 2], p: [i64; 2]) -> Ordering {
    let [dx, dy, px, py] = [high[0] - low[0], high[1] - low[1], p[0] - low[0], p[1] - low[1]].map(i128::from);
    (px * dy).cmp(&(py * dx))
}

/// Centers of the cells of a grid.
struct Centers<'a> {
    /// Centers of columns from west to east, and of rows from south to north.
    xs: &'a [i64],
    ys: &'a [i64],
    /// Columns for each step along x.
    cols_per_step: f64,
    /// Columns inside a polygon in each of its rows.
    cols: Vec<Range<usize>>,
}

impl<'a> Centers<'a> {
    fn new(xs: &'a [i64], ys: &'a [i64]) -> Self {
        let cols_per_step = match xs {
            [first, .., last] => (xs.len() - 1) as f64 / (last - first).max(1) as f64,
            _ => 0.0,
        };
        Centers { xs, ys, cols_per_step, cols: Vec::new() }
    }

    /// Calls `visit` with a row, counted from the south, and the columns whose centers in it are
    /// inside a convex polygon or on a side of it. Its sides are given counterclockwise. EXACT.
    fn inside(
        &mut self,
        sides: impl Iterator<Item = [[i64; 2]; 2]> + Clone,
        mut visit: impl FnMut(usize, Range<usize>),
    ) {
        let rows = |south: i64, north: i64| {
            self.ys.partition_point(|center| *center < south)..self.ys.partition_point(|center| *center <= north)
        };
        let ys = sides.clone().map(|[a, _]| a[1]);
        let (Some(south), Some(north)) = (ys.clone().min(), ys.max()) else { return };
        let rows_inside = rows(south, north);
        self.cols.clear();
        self.cols.resize(rows_inside.len(), 0..0);
        for [a, b] in sides {
            // Sides going down are west of the polygon, sides going up are east of it.
            let (low, high, beyond) = match a[1].cmp(&b[1]) {
                Ordering::Greater => (b, a, Ordering::Less),
                Ordering::Less => (a, b, Ordering::Equal),
                Ordering::Equal => continue,
            };
            for row in rows(low[1], high[1]) {
                let col = self.first_beyond([low, high], self.ys[row], beyond);
                let cols = &mut self.cols[row - rows_inside.start];
                *(if beyond == Ordering::Less { &mut cols.start } else { &mut cols.end }) = col;
            }
        }
        for (row, cols) in rows_inside.zip(&self.cols) {
            if !cols.is_empty() {
                visit(row, cols.clone());
            }
        }
    }

    /// Returns the first column whose center at y compares greater with a line than `last`.
    fn first_beyond(&self, line: [[i64; 2]; 2], y: i64, last: Ordering) -> usize {
        let [low, high] = line;
        let x = low[0] as f64 + (y - low[1]) as f64 / (high[1] - low[1]) as f64 * (high[0] - low[0]) as f64;
        // A guess, corrected by exact comparisons.
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the columns")]
        let mut col = (((x - self.xs[0] as f64) * self.cols_per_step).ceil().max(0.0) as usize).min(self.xs.len());
        let is_before = |col: usize| side_of(line, [self.xs[col], y]) <= last;
        while col > 0 && !is_before(col - 1) {
            col -= 1;
        }
        while col < self.xs.len() && is_before(col) {
            col += 1;
        }
        col
    }
}

/// Gives the zone of a neighbor, ring by ring, to open cells outside the mesh: on a wall, or at a
/// block too small to count. Cells without such a neighbor are street.
fn spread(codes: &mut [u8], mut left_over: Vec<(usize, usize)>, (n_rows, n_cols): (usize, usize)) {
    while !left_over.is_empty() {
        let zone_beside = |codes: &[u8], row: usize, col: usize| {
            let beside = [
                (row.checked_sub(1), Some(col)),
                (Some(row), col.checked_sub(1)),
                (Some(row), Some(col + 1).filter(|c| *c < n_cols)),
                (Some(row + 1).filter(|r| *r < n_rows), Some(col)),
            ];
            let codes = beside.into_iter().filter_map(|(r, c)| Some(codes[r? * n_cols + c?]));
            codes.filter(|code| *code != NONE && *code != Zone::Rooftop.code()).max()
        };
        let found: Vec<Option<u8>> = left_over.iter().map(|(row, col)| zone_beside(codes, *row, *col)).collect();
        let is_stuck = found.iter().all(Option::is_none);
        let mut rest = Vec::new();
        for ((row, col), code) in left_over.into_iter().zip(found) {
            match code.or(is_stuck.then(|| Zone::Street.code())) {
                Some(code) => codes[row * n_cols + col] = code,
                None => rest.push((row, col)),
            }
        }
        left_over = rest;
    }
}
