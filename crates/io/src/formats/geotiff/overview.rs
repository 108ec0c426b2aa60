//! Overviews: smaller pictures of a raster, each cell standing for a square of them.

use rayon::prelude::*;

/// A rectangle of cells that one cell of an overview stands for: first and end row, first and end column.
#[derive(Clone, Copy)]
pub(super) struct Block {
    pub(super) rows: (usize, usize),
    pub(super) cols: (usize, usize),
}

/// The value of an overview cell, from all cells of the full resolution, the number of columns and the block.
pub(super) type Reduce<T> = fn(&[T], usize, Block) -> T;

/// A smaller picture: each cell stands for `reduction` × `reduction` cells.
pub(super) fn overview<T: Copy + Send + Sync>(
    cells: &[T],
    (n_rows, n_cols): (usize, usize),
    reduction: usize,
    reduce: Reduce<T>,
) -> Vec<T> {
    let width = n_cols.div_ceil(reduction);
    let row_of = |row: usize| {
        let rows = (row * reduction, ((row + 1) * reduction).min(n_rows));
        (0..width).map(move |col| {
            let cols = (col * reduction, ((col + 1) * reduction).min(n_cols));
            reduce(cells, n_cols, Block { rows, cols })
        })
    };
    (0..n_rows.div_ceil(reduction)).into_par_iter().flat_map_iter(row_of).collect()
}

/// The north-west cell of a block.
pub(super) fn first_of<T: Copy>(cells: &[T], n_cols: usize, block: Block) -> T {
    cells[block.rows.0 * n_cols + block.cols.0]
}

/// The most frequent class of a block, the smallest one on a tie.
///
/// PERF: in most blocks the first class has the majority; else the few classes that occur are counted in a list.
pub(super) fn most_frequent(cells: &[u8], n_cols: usize, block: Block) -> u8 {
    let rows = || {
        let cols = block.cols.0..block.cols.1;
        (block.rows.0..block.rows.1).map(move |row| &cells[row * n_cols + cols.start..row * n_cols + cols.end])
    };
    let first = cells[block.rows.0 * n_cols + block.cols.0];
    let n_first: usize = rows().map(|row| row.iter().filter(|class| **class == first).count()).sum();
    if 2 * n_first > (block.rows.1 - block.rows.0) * (block.cols.1 - block.cols.0) {
        return first;
    }
    let mut counts: Vec<(u8, usize)> = Vec::with_capacity(8);
    for &class in rows().flatten() {
        match counts.iter_mut().find(|(known, _)| *known == class) {
            Some((_, count)) => *count += 1,
            None => counts.push((class, 1)),
        }
    }
    let most = counts.iter().map(|c| c.1).max().unwrap_or(0);
    counts.iter().filter(|c| c.1 == most).map(|c| c.0).min().unwrap_or(first)
}
