//! The receivers on which shadows are cast, and the cells that shadows can meet.

use fearless_simd::Level;
use rayon::prelude::*;

use super::grid::ShadowGrid;
use super::plane::Plane;
use super::words::for_each_bit;
use crate::height_field::{Casters, Prisms};
use crate::quantity::LatticePoint;
use crate::raster::BitGrid;

/// Data of shadows that are the same for many UAVs.
#[derive(Debug, Clone, Copy)]
pub struct ShadowScene<'a> {
    /// The prisms that hide receivers.
    pub prisms: &'a Prisms,
    /// The casters of shadows: all casters of the prisms, or those that matter.
    pub casters: &'a Casters,
    /// Positions of the receivers.
    pub grid: &'a ShadowGrid,
    /// The cells to decide, of the same shape as the grid.
    pub wanted: &'a BitGrid,
    /// Vector instructions to use; the result is the same at all levels.
    pub level: Level,
    /// Bands of rows that are processed in parallel in the current pool; the result is the same for
    /// any number.
    pub n_bands: usize,
}

/// The cells in line of sight of a UAV.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ShadowLos {
    /// The wanted cells that are in line of sight.
    pub los: BitGrid,
    /// The number of wanted cells in line of sight.
    pub count: u64,
    /// The number of receivers on the boundary of a shadow, decided by `ray`.
    pub asked: u64,
}

/// Heights of the receivers \[1/1024 m above the datum\].
pub(super) enum Receivers {
    Level(i64),
    /// By cell, `width` to the row, whole words of cells; 0 for cells that are not wanted.
    Relief {
        heights: Vec<f64>,
        width: usize,
    },
}

impl Receivers {
    /// Makes receivers from a function that returns the height of each wanted cell \[1/1024 m above
    /// the datum\]. Also returns the lowest and the highest height; without receivers the first
    /// exceeds the second.
    pub(super) fn relief(wanted: &BitGrid, height: &(impl Fn(usize, usize) -> i32 + Sync)) -> (Receivers, (i32, i32)) {
        let width = wanted.words_per_row() * 64;
        let mut heights = vec![0.0; wanted.n_rows() * width];
        let of_row = |(row, heights): (usize, &mut [f64])| {
            let mut range = (i32::MAX, i32::MIN);
            for_each_bit(wanted.row(row), 0, wanted.n_cols(), |col| {
                let z = height(row, col);
                range = (range.0.min(z), range.1.max(z));
                heights[col] = f64::from(z);
            });
            range
        };
        let ranges = heights.par_chunks_mut(width.max(1)).enumerate().map(of_row);
        let range = ranges.reduce(|| (i32::MAX, i32::MIN), |a, b| (a.0.min(b.0), a.1.max(b.1)));
        (Receivers::Relief { heights, width }, range)
    }

    #[inline(always)]
    pub(super) fn at(&self, row: usize, col: usize) -> i64 {
        match self {
            Receivers::Level(z) => *z,
            Receivers::Relief { heights, width } => {
                #[expect(clippy::cast_possible_truncation, reason = "came from an i32")]
                let z = heights[row * width + col] as i64;
                z
            }
        }
    }
}

/// Returns the rows and the columns that enclose all cells of a set within given rows and columns;
/// `None` without any.
pub(super) fn extent_of(cells: &BitGrid, rows: (usize, usize), cols: (usize, usize)) -> Option<(Span, Span)> {
    let (first_word, end_word) = (cols.0 / 64, cols.1.div_ceil(64));
    let is_used = |row: &usize| cells.row(*row)[first_word..end_word].iter().any(|w| *w != 0);
    let first = (rows.0..rows.1).find(is_used)?;
    let last = (first..rows.1).rev().find(is_used)?;
    // PERF: row by row, in memory order.
    let mut used = cells.row(first)[first_word..end_word].to_vec();
    for row in first + 1..=last {
        used.iter_mut().zip(&cells.row(row)[first_word..end_word]).for_each(|(used, word)| *used |= word);
    }
    let west = used.iter().position(|w| *w != 0)?;
    let east = used.iter().rposition(|w| *w != 0)?;
    let first_col = (first_word + west) * 64 + used[west].trailing_zeros() as usize;
    let end_col = (first_word + east) * 64 + 64 - used[east].leading_zeros() as usize;
    Some(((first, last + 1), (first_col, end_col)))
}

/// The first of some rows or columns, and the one after the last.
type Span = (usize, usize);

impl ShadowScene<'_> {
    /// Returns the plane as a UAV sees it, for `cells` in place of the wanted ones; `None` if there
    /// are none.
    pub(super) fn plane(&self, cells: &BitGrid, uav: LatticePoint) -> Option<Plane> {
        let curve = self.prisms.earth().map_or(0.0, |earth| earth.bulge.coefficient());
        Some(Plane { curve, ..flat_plane_of(self.grid, cells, uav)? })
    }
}

/// Returns the plane on a flat earth as seen from a UAV; `None` if no cell is wanted.
pub(super) fn flat_plane_of(grid: &ShadowGrid, wanted: &BitGrid, uav: LatticePoint) -> Option<Plane> {
    let (rows, cols) = extent_of(wanted, (0, wanted.n_rows()), (0, wanted.n_cols()))?;
    Some(Plane::new(grid, uav, rows, cols))
}

/// Returns the wanted cells right below or above the UAV, which no shadow decides.
pub(super) fn cells_at_uav(grid: &ShadowGrid, plane: &Plane, wanted: &BitGrid) -> Vec<(usize, usize)> {
    let (x, y) = (plane.uav.x, plane.uav.y);
    let cols = grid.xs.partition_point(|at| *at < x)..grid.xs.partition_point(|at| *at <= x);
    let rows = grid.ys.partition_point(|at| *at > y)..grid.ys.partition_point(|at| *at >= y);
    let within = |cells: std::ops::Range<usize>, (first, end): Span| cells.start.max(first)..cells.end.min(end);
    within(rows, plane.rows)
        .flat_map(|row| within(cols.clone(), plane.cols).map(move |col| (row, col)))
        .filter(|(row, col)| wanted.contains(*row, *col))
        .collect()
}
