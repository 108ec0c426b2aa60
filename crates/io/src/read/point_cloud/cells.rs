//! Cells of a grid, and the points that fall into them.
//!
//! A point lies in the cell that holds it; on an edge, to within a millionth of a cell, in the one
//! to its north-east. Sums are integers, so that no order of points changes a height.
//!
//! A cell takes 20 bytes, and none where no point is: pages of zeros stay untouched.

use super::file::RecordForm;
use crate::quantity::{VOID, height_steps};
use crate::raster::{Crs, GeoRef, LargeVec};

/// Steps of a meter that heights of the ground are summed in.
const SUMMED_PER_M: f64 = 1_048_576.0;
/// Most points of the ground that a cell averages, so that no sum overflows.
const MOST_AVERAGED: u32 = 1 << 27;
/// Top of a cell that holds points, but no roof; 0 stands for a cell without points.
const SEEN: i32 = 1;
/// Added to heights, so that all are above [`SEEN`].
const RAISED: i32 = 1 << 26;

/// Role of a point, by its class.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Role {
    /// Ground, key points of it, water, rails and roads.
    Ground,
    /// Roof of a building.
    Roof,
    /// Unknown: roof, tree, car.
    Other,
    /// Vegetation, wires, bridges: neither ground nor wall.
    Apart,
    /// Noise, low or high.
    Noise,
}

/// Returns the role of a class of LAS 1.4, table 17. Class 12 of older versions is that of overlaps
/// of flight lines, which can be anything.
fn role_of(class: u8) -> Role {
    match class {
        2 | 8..=11 => Role::Ground,
        6 => Role::Roof,
        3..=5 | 13..=17 => Role::Apart,
        7 | 18 => Role::Noise,
        _ => Role::Other,
    }
}

/// Returns the role of a point, and `true` for the last return of a pulse; `None` for a point that
/// counts nowhere.
fn role_and_return(record: &[u8], is_extended: bool) -> Option<(Role, bool)> {
    let (class, is_withheld, number, of) = match is_extended {
        true => (record[16], record[15] & 4 != 0, record[14] & 15, record[14] >> 4),
        false => (record[15] & 31, record[15] & 128 != 0, record[14] & 7, (record[14] >> 3) & 7),
    };
    let role = role_of(class);
    (!is_withheld && role != Role::Noise).then_some((role, number >= of))
}

/// Square cells. They are multiples of their edge away from an anchor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grid {
    /// Place that corners of cells are counted from \[CRS units\].
    pub(super) anchor: [f64; 2],
    /// Column and row of the south-west cell, counted from the anchor.
    pub(super) first: [i64; 2],
    /// Edge of a cell \[CRS units\].
    pub(super) cell: f64,
    pub(super) n_cols: usize,
    pub(super) n_rows: usize,
}

/// Points by cell, rows from the north.
pub(super) struct Cells {
    grid: Grid,
    /// Sum of the heights of the ground \[1/1048576 m\].
    sums: LargeVec<i64>,
    /// Number of points of the ground.
    counts: LargeVec<u32>,
    /// Highest roof \[1/1024 m\] and [`RAISED`]; [`SEEN`], or 0.
    tops: LargeVec<i32>,
    /// Highest last return of unknown role \[1/1024 m\] and [`RAISED`], or 0; dropped once a roof is
    /// there.
    lasts: Option<LargeVec<i32>>,
    has_ground: bool,
    /// A height beyond the lattice \[m\] of a last return of unknown role.
    beyond: Option<f64>,
    /// Number of points outside of the grid.
    pub(super) n_outside: u64,
}

impl Grid {
    /// Returns the grid with its system; `None` for one that no numbers can place.
    pub(super) fn georef(&self, crs: Option<&Crs>) -> Option<GeoRef> {
        let [x_min, y_min] = self.corner();
        let corner = (x_min, y_min + self.cell * count(self.n_rows));
        GeoRef::new(corner, (self.cell, self.cell), (self.n_rows, self.n_cols), crs.cloned())
    }

    /// Returns the south-west corner.
    fn corner(&self) -> [f64; 2] {
        #[expect(clippy::cast_precision_loss, reason = "indices of cells are far below 2^53")]
        let corner = [0, 1].map(|axis| self.anchor[axis] + self.first[axis] as f64 * self.cell);
        corner
    }

    /// Returns the grid of cells twice as large that covers all of it.
    fn coarser(&self) -> Grid {
        let halved = |first: i64, n: usize| {
            let low = first.div_euclid(2);
            let high = (first + i64::try_from(n).unwrap_or(i64::MAX / 2) - 1).div_euclid(2);
            (low, usize::try_from(high - low + 1).unwrap_or(1))
        };
        let ((col, n_cols), (row, n_rows)) = (halved(self.first[0], self.n_cols), halved(self.first[1], self.n_rows));
        Grid { first: [col, row], cell: 2.0 * self.cell, n_cols, n_rows, ..*self }
    }
}

#[expect(clippy::cast_precision_loss, reason = "numbers of cells are far below 2^53")]
fn count(n: usize) -> f64 {
    n as f64
}

impl std::fmt::Debug for Cells {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Cells").field("grid", &self.grid).finish_non_exhaustive()
    }
}

impl Cells {
    /// Makes empty cells.
    pub(super) fn new(grid: Grid) -> Cells {
        let n = grid.n_cols * grid.n_rows;
        Cells {
            grid,
            sums: LargeVec::zeroed(n),
            counts: LargeVec::zeroed(n),
            tops: LargeVec::zeroed(n),
            lasts: Some(LargeVec::zeroed(n)),
            has_ground: false,
            beyond: None,
            n_outside: 0,
        }
    }

    pub(super) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Returns `true` if a point of the ground is there.
    pub(super) fn has_ground(&self) -> bool {
        self.has_ground
    }

    /// Returns `true` if no point is there.
    pub(super) fn is_empty(&self) -> bool {
        self.tops.iter().all(|top| *top == 0)
    }

    /// Returns a height beyond the lattice \[m\] of a return that counts as a roof, if one is there.
    pub(super) fn beyond(&self) -> Option<f64> {
        self.beyond.filter(|_| !self.has_roofs())
    }

    /// Returns `true` if a roof is there.
    pub(super) fn has_roofs(&self) -> bool {
        self.lasts.is_none()
    }

    /// Adds the points of some records; heights are in units of `meters`.
    ///
    /// # Errors
    /// A height beyond the lattice \[m\].
    pub(super) fn add(&mut self, records: &[u8], form: &RecordForm, meters: f64) -> Result<(), f64> {
        let [(x_scale, x_offset), (y_scale, y_offset), (z_scale, z_offset)] = form.scaling;
        let ([west, south], per_cell) = (self.grid.corner(), 1.0 / self.grid.cell);
        let (n_cols, n_rows) = (self.grid.n_cols, self.grid.n_rows);
        let (sums, counts, tops): (&mut [i64], &mut [u32], &mut [i32]) =
            (&mut self.sums, &mut self.counts, &mut self.tops);
        for record in records.chunks_exact(form.length) {
            let Some((role, is_last)) = role_and_return(record, form.format >= 6) else { continue };
            let word = |at: usize| f64::from(i32::from_le_bytes(std::array::from_fn(|k| record[at + k])));
            let col = ((word(0) * x_scale + x_offset - west) * per_cell + 1e-6).floor();
            let row = ((word(4) * y_scale + y_offset - south) * per_cell + 1e-6).floor();
            if !(col >= 0.0 && col < count(n_cols) && row >= 0.0 && row < count(n_rows)) {
                self.n_outside += 1;
                continue;
            }
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "inside of the grid")]
            let index = (n_rows - 1 - row as usize) * n_cols + col as usize;
            tops[index] = tops[index].max(SEEN);
            if role == Role::Apart || (role == Role::Other && (!is_last || self.lasts.is_none())) {
                continue;
            }
            let z = (word(8) * z_scale + z_offset) * meters;
            let Some(steps) = height_steps(z).map(|steps| RAISED + steps) else {
                if role == Role::Other {
                    self.beyond.get_or_insert(z);
                    continue;
                }
                return Err(z);
            };
            match (role, &mut self.lasts) {
                (Role::Ground, _) => {
                    self.has_ground = true;
                    if counts[index] < MOST_AVERAGED {
                        counts[index] += 1;
                        #[expect(clippy::cast_possible_truncation, reason = "below 2^36")]
                        let summed = (z * SUMMED_PER_M).round() as i64;
                        sums[index] += summed;
                    }
                }
                (Role::Roof, _) => {
                    self.lasts = None;
                    tops[index] = tops[index].max(steps);
                }
                (_, Some(lasts)) => lasts[index] = lasts[index].max(steps),
                (_, None) => {}
            }
        }
        Ok(())
    }

    /// Returns the share of the open cells with points that hold ground.
    ///
    /// Cells under roofs are not open: no pulse reaches the ground there. In a dense cloud without
    /// roofs of their own class, cells with last returns and no ground are taken as such.
    pub(super) fn ground_share(&self) -> f64 {
        let lasts = self.lasts.as_deref().filter(|_| self.is_dense());
        let (mut n_open, mut n_ground) = (0, 0);
        for (index, (top, n)) in self.tops.iter().zip(self.counts.iter()).enumerate() {
            let is_under_roof = *top > SEEN || lasts.is_some_and(|lasts| lasts[index] > 0);
            if *n > 0 && *top != 0 {
                n_ground += 1;
            }
            n_open += usize::from(*top != 0 && (*n > 0 || !is_under_roof));
        }
        if n_open == 0 { 1.0 } else { count(n_ground) / count(n_open) }
    }

    /// Returns `true` if points fill at least half of the cells of squares of four that hold any.
    fn is_dense(&self) -> bool {
        let Grid { n_cols, .. } = self.grid;
        let (mut n_cells, mut n_squares) = (0, 0);
        for rows in self.tops.chunks(2 * n_cols) {
            let (upper, lower) = rows.split_at(n_cols);
            for col in (0..n_cols).step_by(2) {
                let end = (col + 2).min(n_cols);
                let below = lower.get(col..end).unwrap_or_default();
                let n = upper[col..end].iter().chain(below).filter(|top| **top != 0).count();
                n_cells += n;
                n_squares += usize::from(n > 0);
            }
        }
        n_cells >= 2 * n_squares
    }

    /// Returns the cells that hold points, and what lies between them; `None` without any point.
    pub(super) fn trimmed(self) -> Option<Cells> {
        let Grid { n_cols, n_rows, first, .. } = self.grid;
        let has_points = |row: &usize| self.tops[row * n_cols..][..n_cols].iter().any(|top| *top != 0);
        let (top, bottom) = ((0..n_rows).find(has_points)?, (0..n_rows).rev().find(has_points)?);
        let (mut left, mut right) = (n_cols - 1, 0);
        for row in self.tops[top * n_cols..(bottom + 1) * n_cols].chunks_exact(n_cols) {
            left = row[..left].iter().position(|top| *top != 0).unwrap_or(left);
            right = row[right..].iter().rposition(|top| *top != 0).map_or(right, |col| right + col);
        }
        if (top, left, bottom + 1, right + 1) == (0, 0, n_rows, n_cols) {
            return Some(self);
        }
        let from = |col: usize| i64::try_from(col).unwrap_or(0);
        let first = [first[0] + from(left), first[1] + from(n_rows - 1 - bottom)];
        let grid = Grid { first, n_cols: right + 1 - left, n_rows: bottom + 1 - top, ..self.grid };
        Some(self.moved_to(grid, |row, col| {
            let is_inside = (top..=bottom).contains(&row) && (left..=right).contains(&col);
            is_inside.then(|| (row - top, col - left))
        }))
    }

    /// Returns cells twice as large.
    pub(super) fn coarser(self) -> Cells {
        let (from, to) = (self.grid, self.grid.coarser());
        // Cells of even indices from the anchor begin a larger one.
        let half = |index: usize, first: i64| (index + usize::from(first.rem_euclid(2) == 1)) / 2;
        self.moved_to(to, |row, col| {
            let from_south = half(from.n_rows - 1 - row, from.first[1]);
            Some((to.n_rows - 1 - from_south, half(col, from.first[0])))
        })
    }

    /// Returns the cells of another grid, joined from those of this one by their rows and columns.
    fn moved_to(self, grid: Grid, place: impl Fn(usize, usize) -> Option<(usize, usize)>) -> Cells {
        let mut moved =
            Cells { has_ground: self.has_ground, beyond: self.beyond, n_outside: self.n_outside, ..Cells::new(grid) };
        if self.lasts.is_none() {
            moved.lasts = None;
        }
        for index in (0..self.tops.len()).filter(|index| self.tops[*index] != 0) {
            let Some((row, col)) = place(index / self.grid.n_cols, index % self.grid.n_cols) else { continue };
            let at = row * grid.n_cols + col;
            moved.sums[at] = moved.sums[at].saturating_add(self.sums[index]);
            moved.counts[at] = moved.counts[at].saturating_add(self.counts[index]);
            moved.tops[at] = moved.tops[at].max(self.tops[index]);
            if let (Some(to), Some(from)) = (&mut moved.lasts, &self.lasts) {
                to[at] = to[at].max(from[index]);
            }
        }
        moved
    }

    /// Returns the mean height of the ground in each cell \[1/1024 m\], [`VOID`] where none is.
    pub(super) fn terrain(&self) -> impl Iterator<Item = i32> {
        self.sums.iter().zip(self.counts.iter()).map(|(sum, n)| {
            #[expect(clippy::cast_precision_loss, reason = "far below a step of the lattice")]
            let mean = *sum as f64 / f64::from(*n) / SUMMED_PER_M;
            height_steps(mean).unwrap_or(VOID)
        })
    }

    /// Returns the highest roof in each cell \[1/1024 m\], [`VOID`] where none is. In a cloud
    /// without any, all last returns that are no ground are roofs.
    pub(super) fn roofs(&self) -> impl Iterator<Item = i32> {
        let tops = self.lasts.as_ref().unwrap_or(&self.tops);
        tops.iter().map(|top| if *top > SEEN { top - RAISED } else { VOID })
    }
}
