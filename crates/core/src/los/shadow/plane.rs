//! The plane of receivers as one UAV sees it: rows and columns around it, and the reach of shadows
//! there.

use super::geometry::as_f64;
use super::grid::ShadowGrid;
use super::reach::{LANES, Reach};
use crate::quantity::LatticePoint;

/// The plane as seen from one UAV, and the part of it that holds wanted cells.
#[derive(Debug, Clone)]
pub(super) struct Plane {
    pub(super) uav: LatticePoint,
    /// North of the UAV, for each row of the grid and eight more \[lattice steps\]; descending,
    /// exact.
    pub(super) q: Vec<f64>,
    /// Rows that hold wanted cells.
    pub(super) rows: (usize, usize),
    /// Columns that hold wanted cells.
    pub(super) cols: (usize, usize),
    /// East of the UAV, for the first and the last of these columns \[lattice steps\].
    pub(super) east: (f64, f64),
    /// Largest distance of a row \[lattice steps\].
    pub(super) q_max: f64,
    /// Column at the UAV's x.
    pub(super) origin: f64,
    /// Columns per lattice step.
    pub(super) per_step: f64,
    /// Lattice steps per column.
    pub(super) step: f64,
    /// Largest number of a column.
    pub(super) last_column: f64,
    /// Rows per lattice step.
    pub(super) rows_per_step: f64,
    /// Fall of the earth at a distance of one lattice step \[1/1024 m\]; 0 on a flat earth.
    pub(super) curve: f64,
    /// Largest distance of a column from its place at even spacing \[columns\].
    pub(super) unevenness: f64,
}

impl Plane {
    /// Makes the plane of rows and columns of a grid as seen from `uav`.
    pub(super) fn new(grid: &ShadowGrid, uav: LatticePoint, rows: (usize, usize), cols: (usize, usize)) -> Plane {
        let mut q: Vec<f64> = grid.ys.iter().map(|y| as_f64(y - uav.y)).collect();
        let q_max = q.iter().fold(0.0_f64, |m, q| m.max(q.abs()));
        q.extend([q[q.len() - 1]; LANES]);
        Plane {
            uav,
            q,
            rows,
            cols,
            east: (as_f64(grid.xs[cols.0] - uav.x), as_f64(grid.xs[cols.1 - 1] - uav.x)),
            q_max,
            origin: as_f64(uav.x - grid.xs[0]) / grid.steps.0,
            per_step: 1.0 / grid.steps.0,
            step: grid.steps.0,
            last_column: as_f64(grid.xs.len()),
            rows_per_step: 1.0 / grid.steps.1,
            curve: 0.0,
            unevenness: grid.unevenness,
        }
    }

    /// At least as far from the UAV as any wanted cell \[lattice steps\].
    pub(super) fn farthest(&self) -> f64 {
        self.east.0.abs().max(self.east.1.abs()).hypot(self.q_max) + 1.0
    }

    /// Returns bounds on the fall of the earth over some rows and columns \[1/1024 m\].
    #[inline(always)]
    pub(super) fn falls(&self, q: (f64, f64), cols: (f64, f64)) -> (f64, f64) {
        if self.curve == 0.0 {
            return (0.0, 0.0);
        }
        let squares = |(a, b): (f64, f64)| {
            let least = if a * b < 0.0 { 0.0 } else { a.abs().min(b.abs()) };
            let most = a.abs().max(b.abs());
            (least * least, most * most)
        };
        let east = |col: f64| (col - self.origin) * self.step;
        let (of_q, of_cols) = (squares(q), squares((east(cols.0), east(cols.1))));
        (self.curve * (of_q.0 + of_cols.0), self.curve * (of_q.1 + of_cols.1))
    }

    /// Returns the plane of these rows and columns as another UAV sees it.
    pub(super) fn seen_from(&self, grid: &ShadowGrid, uav: LatticePoint) -> Plane {
        Plane::new(grid, uav, self.rows, self.cols)
    }

    /// Narrows the plane to some of the wanted rows and columns.
    pub(super) fn narrow_to(&mut self, grid: &ShadowGrid, rows: (usize, usize), cols: (usize, usize)) {
        let east = |col: usize| as_f64(grid.xs[col] - self.uav.x);
        (self.rows, self.cols, self.east) = (rows, cols, (east(cols.0), east(cols.1 - 1)));
    }

    /// Returns `true` if the shadow of a footprint within `bounds` may meet the box of the wanted
    /// cells.
    pub(super) fn meets(&self, bounds: [i32; 4], reach: Option<Reach>) -> bool {
        reach.is_some_and(|reach| self.overlaps(reach.extent(bounds, (self.uav.x, self.uav.y))))
    }

    /// Returns `true` if a box (`west`, `south`, `east` and `north` of the UAV) meets the box of
    /// the wanted cells.
    #[inline(always)]
    pub(super) fn overlaps(&self, [west, south, east, north]: [f64; 4]) -> bool {
        let (first, last) = (self.q[self.rows.0], self.q[self.rows.1 - 1]);
        south <= first && north >= last && west <= self.east.1 && east >= self.east.0
    }

    /// Returns the wanted columns from `west` to `east`, if there are any.
    #[inline(always)]
    pub(super) fn wanted_columns(&self, west: f64, east: f64) -> Option<(usize, usize)> {
        let column = |v: f64| {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates, then clamped")]
            let column = v as usize;
            column.clamp(self.cols.0, self.cols.1)
        };
        let (west, east) = (column(west), column(east + 1.0));
        (west < east).then_some((west, east))
    }

    /// Returns the first row at or south of `q`.
    #[inline(always)]
    pub(super) fn first_row_at_or_below(&self, q: f64) -> usize {
        let (low, high) = self.rows;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a guess, put right below")]
        let guess = ((self.q[0] - q) * self.rows_per_step) as usize;
        let mut row = guess.clamp(low, high);
        while row > low && self.q[row - 1] <= q {
            row -= 1;
        }
        while row < high && self.q[row] > q {
            row += 1;
        }
        row
    }
}
