//! Cells as runs of equal values: the form of a city's block model on a grid along its walls.

use std::ops::Range;

use bytemuck::Pod;
use rayon::prelude::*;

/// Fewest cells per kept run, in any part of a raster. With more runs, holding it cell by cell
/// costs no more.
pub const CELLS_PER_RUN: usize = 64;

/// Cells that one thread processes at a time.
const PART_CELLS: usize = 1 << 18;

/// The cells of a grid as runs of equal values, row by row. Rows that repeat the row before are
/// kept once.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RowRuns<T> {
    /// For each run, the column after its last.
    ends: Vec<u32>,
    values: Vec<T>,
    /// For each group of equal rows, the row after its last, and the index after its last run.
    groups: Vec<(usize, usize)>,
}

/// Consecutive rows that are equal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RowGroup<'a, T> {
    /// The rows, from the north.
    pub rows: Range<usize>,
    /// For each run, from west to east, the column after its last.
    pub ends: &'a [u32],
    /// The values of the runs.
    pub values: &'a [T],
}

impl<T> RowGroup<'_, T> {
    /// Iterates over the columns of the runs, with their values.
    pub fn runs(&self) -> impl Iterator<Item = (Range<usize>, &T)> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        let cols = starts.zip(self.ends).map(|(start, end)| start as usize..*end as usize);
        cols.zip(self.values)
    }
}

impl<T: Pod + PartialEq + Send + Sync> RowRuns<T> {
    /// Returns the runs of `cells`, rows of `n_cols` each. Returns `None` if some part of them has
    /// fewer than `least` cells per kept run. Threads of the current pool share the work.
    pub fn of(cells: &[T], n_cols: usize, least: usize) -> Option<Self> {
        let cells_at_once = PART_CELLS.div_ceil(n_cols) * n_cols;
        let most = cells_at_once.checked_div(least).unwrap_or(usize::MAX);
        let parts = cells.par_chunks(cells_at_once).map(|cells| RowRuns::of_part(cells, n_cols, most));
        Some(RowRuns::joined(parts.collect::<Option<Vec<_>>>()?))
    }

    /// Returns the runs of a few rows, found by this thread; `None` if more than `most` runs are
    /// kept.
    pub fn of_part(cells: &[T], n_cols: usize, most: usize) -> Option<Self> {
        let mut found = RowRuns { ends: Vec::new(), values: Vec::new(), groups: Vec::new() };
        let mut before: &[T] = &[];
        for (row, of_row) in cells.chunks_exact(n_cols).enumerate() {
            match found.groups.last_mut() {
                // PERF: bytes are compared many at a time.
                Some(group) if bytemuck::cast_slice::<T, u8>(before) == bytemuck::cast_slice::<T, u8>(of_row) => {
                    group.0 = row + 1;
                }
                _ => {
                    found.push_row(of_row);
                    found.groups.push((row + 1, found.ends.len()));
                    if found.ends.len() > most {
                        return None;
                    }
                }
            }
            before = of_row;
        }
        Some(found)
    }

    /// Adds the runs of a row.
    fn push_row(&mut self, row: &[T]) {
        let mut col = 0;
        while let Some(&value) = row.get(col) {
            // PERF: sixteen cells are compared at once.
            let mut chunks = row[col..].chunks_exact(16);
            let is_same = |chunk: &&[T]| chunk.iter().fold(true, |same, cell| same & (*cell == value));
            let n_chunks = chunks.by_ref().take_while(is_same).count();
            let rest = row[col + 16 * n_chunks..].iter().take_while(|cell| **cell == value).count();
            col += (16 * n_chunks + rest).max(1);
            self.ends.push(u32::try_from(col).unwrap_or(u32::MAX));
            self.values.push(value);
        }
    }

    /// Joins the rows of several grids of one width, from the north.
    pub fn joined(parts: Vec<Self>) -> Self {
        let mut all = RowRuns { ends: Vec::new(), values: Vec::new(), groups: Vec::new() };
        for part in parts {
            all.append(&part);
        }
        all
    }

    fn append(&mut self, other: &Self) {
        let (n_rows, n_runs) = (self.n_rows(), self.ends.len());
        let first = other.groups().next();
        let is_same = |last: RowGroup<'_, T>| {
            first.as_ref().is_some_and(|first| (last.ends, last.values) == (first.ends, first.values))
        };
        let is_repeated = self.groups().next_back().is_some_and(is_same);
        let (n_repeated_rows, repeated) =
            first.filter(|_| is_repeated).map_or((0, 0), |first| (first.rows.len(), first.ends.len()));
        if let Some(group) = self.groups.last_mut() {
            group.0 += n_repeated_rows;
        }
        self.ends.extend(&other.ends[repeated..]);
        self.values.extend(&other.values[repeated..]);
        let rest = other.groups.iter().skip(usize::from(is_repeated));
        self.groups.extend(rest.map(|(row, run)| (n_rows + row, n_runs + run - repeated)));
    }
}

impl<T: Pod> RowRuns<T> {
    /// Returns the number of rows.
    pub fn n_rows(&self) -> usize {
        self.groups.last().map_or(0, |(row, _)| *row)
    }

    /// Returns the number of columns.
    pub fn n_cols(&self) -> usize {
        self.ends.last().map_or(0, |end| *end as usize)
    }

    /// Returns the values of all runs, for writing.
    pub fn values_mut(&mut self) -> &mut [T] {
        &mut self.values
    }

    /// Iterates over groups of equal rows, from the north.
    pub fn groups(&self) -> impl DoubleEndedIterator<Item = RowGroup<'_, T>> + ExactSizeIterator {
        (0..self.groups.len()).map(|k| self.group(k))
    }

    fn group(&self, k: usize) -> RowGroup<'_, T> {
        let from = if k == 0 { (0, 0) } else { self.groups[k - 1] };
        let to = self.groups[k];
        RowGroup { rows: from.0..to.0, ends: &self.ends[from.1..to.1], values: &self.values[from.1..to.1] }
    }

    /// Copies the cells of a row from column `col` on.
    pub(crate) fn copy_row(&self, row: usize, col: usize, out: &mut [T]) {
        let group = self.group(self.groups.partition_point(|(end, _)| *end <= row));
        let mut run = group.ends.partition_point(|end| *end as usize <= col);
        let mut done = 0;
        while done < out.len() {
            let n = (group.ends[run] as usize - col - done).min(out.len() - done);
            out[done..done + n].fill(group.values[run]);
            done += n;
            run += 1;
        }
    }

    /// Writes all cells, row by row from the north-west.
    pub(super) fn write(&self, out: &mut [T]) {
        let n_cols = self.n_cols();
        assert_eq!(out.len(), self.n_rows() * n_cols, "one value per cell");
        for group in self.groups() {
            let rows = &mut out[group.rows.start * n_cols..group.rows.end * n_cols];
            let (first, others) = rows.split_at_mut(n_cols);
            group.runs().for_each(|(cols, value)| first[cols].fill(*value));
            others.chunks_exact_mut(n_cols).for_each(|row| row.copy_from_slice(first));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(runs: &RowRuns<i32>) -> Vec<i32> {
        let mut cells = vec![-1; runs.n_rows() * runs.n_cols()];
        runs.write(&mut cells);
        cells
    }

    /// Returns rows that repeat within a part and from one part to the next, with runs of all
    /// lengths around sixteen.
    fn stripes(n_rows: usize, n_cols: usize) -> Vec<i32> {
        let mut cells = vec![0; n_rows * n_cols];
        for (row, cells) in cells.chunks_exact_mut(n_cols).enumerate() {
            let group = row / 83;
            let mut end = 0;
            for (k, len) in (1..60).enumerate() {
                let next = (end + len + group).min(n_cols);
                cells[end..next].fill(i32::try_from(k % 5).unwrap());
                end = next;
            }
        }
        cells
    }

    #[test]
    fn runs_are_the_cells() {
        let n_cols = 3000;
        let cells = stripes(300, n_cols);
        let runs = RowRuns::of(&cells, n_cols, 64).expect("few runs");
        assert_eq!((runs.n_rows(), runs.n_cols(), runs.groups().len()), (300, n_cols, 4));
        assert!(written(&runs) == cells);
        for (row, col, n) in [(0, 0, n_cols), (82, 100, 64), (83, 2999, 1), (299, 1700, 900), (5, 7, 0)] {
            let mut found = vec![-1; n];
            runs.copy_row(row, col, &mut found);
            assert_eq!(found, cells[row * n_cols + col..][..n], "row {row}, column {col}");
        }
    }
}
