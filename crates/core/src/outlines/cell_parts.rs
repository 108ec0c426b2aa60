//! The connected parts of a set of cells, each with its outline as a polygon with holes.

use std::cmp::Ordering;
use std::collections::HashMap;

use super::cell_outline::traced_around;
use crate::raster::BitGrid;

/// Cells of a set that are connected by their sides.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CellPart {
    /// Number of cells.
    pub n_cells: u64,
    /// Outline along the cell edges: the shell counterclockwise, then holes clockwise. Rings are
    /// cell corners `[x, y]` counted east and north from the south-west corner of the grid. They
    /// are not closed and meet no corner twice.
    pub rings: Vec<Vec<[usize; 2]>>,
}

/// Returns the parts of a set, ordered by their first cells from the south.
///
/// Cost: a few operations per cell of the grid.
pub(crate) fn cell_parts(set: &BitGrid) -> Vec<CellPart> {
    let (labels, sizes) = labelled_parts(set);
    let mut parts: Vec<CellPart> = sizes.iter().map(|n| CellPart { n_cells: *n, rings: Vec::new() }).collect();
    let (shells, holes): (Vec<_>, Vec<_>) =
        traced_around(set).iter().flat_map(|ring| simple_rings(ring)).partition(|ring| is_counterclockwise(ring));
    for ring in shells.into_iter().chain(holes) {
        let [x, y] = cell_on_the_left(ring[0], ring[1]);
        let part = labels[(set.n_rows() - 1 - y) * set.n_cols() + x] as usize;
        parts[part].rings.push(ring);
    }
    parts
}

/// Returns the number of parts of a set.
pub(crate) fn n_cell_parts(set: &BitGrid) -> usize {
    labelled_parts(set).1.len()
}

/// Numbers the parts of a set in the order of their first cells from the south-west, rows first.
/// Returns the part number of each cell, and the sizes.
pub fn labelled_parts(set: &BitGrid) -> (Vec<u32>, Vec<u64>) {
    let (n_rows, n_cols) = (set.n_rows(), set.n_cols());
    let mut labels = vec![u32::MAX; n_rows * n_cols];
    let mut sizes = Vec::new();
    let mut open = Vec::new();
    for row in (0..n_rows).rev() {
        for col in 0..n_cols {
            if !set.contains(row, col) || labels[row * n_cols + col] != u32::MAX {
                continue;
            }
            #[expect(clippy::cast_possible_truncation, reason = "a grid has fewer than 2^32 parts")]
            let label = sizes.len() as u32;
            labels[row * n_cols + col] = label;
            open.push((row, col));
            let mut n_cells = 0;
            while let Some((row, col)) = open.pop() {
                n_cells += 1;
                let neighbors =
                    [(row.wrapping_sub(1), col), (row + 1, col), (row, col.wrapping_sub(1)), (row, col + 1)];
                for (row, col) in neighbors {
                    if row < n_rows && col < n_cols && set.contains(row, col) {
                        let of_cell = &mut labels[row * n_cols + col];
                        if *of_cell == u32::MAX {
                            *of_cell = label;
                            open.push((row, col));
                        }
                    }
                }
            }
            sizes.push(n_cells);
        }
    }
    (labels, sizes)
}

/// Splits a traced ring into rings that meet no corner twice. A traced ring may return to a corner
/// at which cells touch.
fn simple_rings(ring: &[[usize; 2]]) -> Vec<Vec<[usize; 2]>> {
    let mut rings = Vec::new();
    let mut open: Vec<[usize; 2]> = Vec::new();
    let mut place_of = HashMap::new();
    for &corner in ring {
        if let Some(&first) = place_of.get(&corner) {
            let closed = open.split_off(first);
            for corner in &closed {
                place_of.remove(corner);
            }
            rings.push(closed);
        }
        place_of.insert(corner, open.len());
        open.push(corner);
    }
    rings.push(open);
    rings
}

fn is_counterclockwise(ring: &[[usize; 2]]) -> bool {
    doubled_cells(ring) > 0
}

/// Returns twice the signed area within a ring of cell corners \[cells\].
pub(crate) fn doubled_cells(ring: &[[usize; 2]]) -> i64 {
    let signed = |p: &[usize; 2]| p.map(|v| v.cast_signed() as i64);
    let edges = ring.iter().zip(ring.iter().cycle().skip(1)).map(|(a, b)| (signed(a), signed(b)));
    edges.map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum()
}

/// Returns the cell to the left of the first step along an edge, as columns from the west and rows
/// from the south.
fn cell_on_the_left(from: [usize; 2], to: [usize; 2]) -> [usize; 2] {
    let [x, y] = from;
    match (to[0].cmp(&x), to[1].cmp(&y)) {
        (Ordering::Greater, _) => [x, y],
        (Ordering::Less, _) => [x - 1, y - 1],
        (_, Ordering::Greater) => [x - 1, y],
        _ => [x, y - 1],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the rings of the cells drawn `#`, north row first.
    fn rings(rows: &[&str]) -> Vec<Vec<[usize; 2]>> {
        let mut set = BitGrid::new(rows.len(), rows[0].len());
        for (row, letters) in rows.iter().enumerate() {
            letters.bytes().enumerate().filter(|(_, b)| *b == b'#').for_each(|(col, _)| set.insert(row, col));
        }
        traced_around(&set).iter().flat_map(|ring| simple_rings(ring)).collect()
    }

    #[test]
    fn rings_that_touch_themselves_are_cut() {
        // The ground inside touches the ground outside at the corner (2, 2).
        let found = rings(&["###", "#.#", "##."]);
        assert_eq!(found.len(), 2);
        assert_eq!(found.iter().filter(|ring| is_counterclockwise(ring)).count(), 1);
        for ring in &found {
            let mut corners = ring.clone();
            corners.sort_unstable();
            corners.dedup();
            assert_eq!(corners.len(), ring.len());
        }
        // Two cells that touch at a corner are two shells.
        assert_eq!(rings(&["#.", ".#"]).iter().filter(|ring| is_counterclockwise(ring)).count(), 2);
    }
}
