//! Cells that a tile covers, and the number of cells in at least one of many rectangles: Klee's
//! measure in the plane.

use crate::raster::CellWindow;

/// Returns the cells of a grid of `n_rows` × `n_cols` that a tile covers; `None` if it lies
/// outside. The tile begins at row and column `origin`, and is cut to `bounds`: first and end row,
/// first and end column.
pub(super) fn covered_area(
    (n_rows, n_cols): (usize, usize),
    (tile_rows, tile_cols): (usize, usize),
    origin: (i64, i64),
    bounds: Option<[i64; 4]>,
) -> Option<CellWindow> {
    let range = |n: usize, origin: i64, n_tile: usize, bounds: Option<(i64, i64)>| {
        let (least, most) = bounds.unwrap_or((i64::MIN, i64::MAX));
        let start = i128::from(origin).max(i128::from(least)).max(0);
        let end = (i128::from(origin) + n_tile as i128).min(i128::from(most)).min(n as i128);
        let (start, length) = (usize::try_from(start).ok()?, usize::try_from(end - start).ok()?);
        (length > 0).then_some((start, length))
    };
    let (row, rows) = range(n_rows, origin.0, tile_rows, bounds.map(|[first, end, ..]| (first, end)))?;
    let (col, cols) = range(n_cols, origin.1, tile_cols, bounds.map(|[_, _, first, end]| (first, end)))?;
    Some(CellWindow { row, col, n_rows: rows, n_cols: cols })
}

/// Returns the number of cells that at least one window covers.
///
/// A line sweeps from row to row over a tree of column ranges.
///
/// Cost: O(n log n).
pub(super) fn n_covered_cells(windows: &[CellWindow]) -> u64 {
    let mut edges: Vec<usize> = windows.iter().flat_map(|w| [w.col, w.col + w.n_cols]).collect();
    edges.sort_unstable();
    edges.dedup();
    // Row, `true` if a window begins there, and the edges of its columns.
    let mut events: Vec<(usize, bool, usize, usize)> = Vec::with_capacity(2 * windows.len());
    for window in windows {
        let edge = |col: usize| edges.partition_point(|edge| *edge < col);
        let (from, to) = (edge(window.col), edge(window.col + window.n_cols));
        events.push((window.row, true, from, to));
        events.push((window.row + window.n_rows, false, from, to));
    }
    events.sort_unstable();
    let mut columns = Columns::new(edges);
    let (mut covered, mut row) = (0, 0);
    for (at, begins, from, to) in events {
        covered += columns.n_covered() * (at - row) as u64;
        row = at;
        columns.change(Node { at: 1, from: 0, to: columns.edges.len() - 1 }, (from, to), begins);
    }
    covered
}

/// Ranges of columns between neighboring edges, as the leaves of a binary tree.
struct Columns {
    edges: Vec<usize>,
    /// Windows that cover all of a node, but not all of its parent.
    counts: Vec<u32>,
    /// Number of columns of a node that are covered within it.
    covered: Vec<u64>,
}

/// Node of the tree, and the edges between which it lies.
#[derive(Clone, Copy)]
struct Node {
    at: usize,
    from: usize,
    to: usize,
}

impl Columns {
    fn new(edges: Vec<usize>) -> Columns {
        let n_nodes = 4 * edges.len().max(1);
        Columns { edges, counts: vec![0; n_nodes], covered: vec![0; n_nodes] }
    }

    fn n_covered(&self) -> u64 {
        self.covered[1]
    }

    /// Adds or removes a window over the ranges `from..to`.
    fn change(&mut self, node: Node, (from, to): (usize, usize), begins: bool) {
        let Node { at, from: low, to: high } = node;
        if to <= low || high <= from {
            return;
        }
        if from <= low && high <= to {
            // A window ends after it began, because rows are sorted.
            self.counts[at] = if begins { self.counts[at] + 1 } else { self.counts[at].saturating_sub(1) };
        } else {
            let middle = usize::midpoint(low, high);
            self.change(Node { at: 2 * at, from: low, to: middle }, (from, to), begins);
            self.change(Node { at: 2 * at + 1, from: middle, to: high }, (from, to), begins);
        }
        self.covered[at] = if self.counts[at] > 0 {
            (self.edges[high] - self.edges[low]) as u64
        } else if high - low > 1 {
            self.covered[2 * at] + self.covered[2 * at + 1]
        } else {
            0
        };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn window(row: usize, col: usize, n_rows: usize, n_cols: usize) -> CellWindow {
        CellWindow { row, col, n_rows, n_cols }
    }

    #[test]
    fn counts_are_those_of_a_grid_of_marks() {
        // A linear congruential generator: any windows will do.
        let mut state = 1_u64;
        let mut below = |n: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            usize::try_from(state >> 33).unwrap() % n
        };
        for n in 1..40 {
            let windows: Vec<CellWindow> =
                (0..n).map(|_| window(below(20), below(20), 1 + below(9), 1 + below(9))).collect();
            let is_in = |w: &CellWindow, row: usize, col: usize| {
                (w.row..w.row + w.n_rows).contains(&row) && (w.col..w.col + w.n_cols).contains(&col)
            };
            let marked = (0..30 * 30).filter(|cell| windows.iter().any(|w| is_in(w, cell / 30, cell % 30))).count();
            assert_eq!(n_covered_cells(&windows), marked as u64, "{windows:?}");
        }
    }
}
