//! Outlines of sets of cells, traced along the cell edges.

use crate::raster::BitGrid;

/// Directions along cell edges, counterclockwise from east, as steps of (x, y).
const STEPS: [[isize; 2]; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];

/// Returns the outlines of a set of cells as rings of cell corners `[x, y]`, counted east and north
/// from the south-west corner of the grid. The set is on the left of each ring. Each ring begins at
/// its first corner from the south-west. Cells that touch only at a corner have separate outlines.
pub(crate) fn traced_around(set: &BitGrid) -> Vec<Vec<[usize; 2]>> {
    let (n_rows, n_cols) = (set.n_rows(), set.n_cols());
    let width = n_cols + 1;
    // One bit per direction in which an outline leaves a corner.
    let mut leaving = vec![0_u8; width * (n_rows + 1)];
    let holds = |x: Option<usize>, y: Option<usize>| match (x, y) {
        (Some(x), Some(y)) if x < n_cols && y < n_rows => set.contains(n_rows - 1 - y, x),
        _ => false,
    };
    for y in 0..n_rows {
        for x in 0..n_cols {
            if !holds(Some(x), Some(y)) {
                continue;
            }
            if !holds(Some(x), y.checked_sub(1)) {
                leaving[y * width + x] |= 1;
            }
            if !holds(Some(x + 1), Some(y)) {
                leaving[y * width + x + 1] |= 2;
            }
            if !holds(Some(x), Some(y + 1)) {
                leaving[(y + 1) * width + x + 1] |= 4;
            }
            if !holds(x.checked_sub(1), Some(y)) {
                leaving[(y + 1) * width + x] |= 8;
            }
        }
    }
    let mut rings = Vec::new();
    for start in 0..leaving.len() {
        while leaving[start] != 0 {
            rings.push(trace(&mut leaving, width, start));
        }
    }
    rings
}

/// Follows an outline from a corner back to it. Returns the corners at which it turns.
fn trace(leaving: &mut [u8], width: usize, start: usize) -> Vec<[usize; 2]> {
    let mut ring = Vec::new();
    let first = leaving[start].trailing_zeros() as usize;
    let (mut corner, mut heading) = (start, first);
    ring.push([corner % width, corner / width]);
    loop {
        let [dx, dy] = STEPS[heading];
        corner = corner.wrapping_add_signed(dx).wrapping_add_signed(dy * width.cast_signed());
        // Left first: this stays with the same cell if two cells touch at a corner.
        let order = [(heading + 1) % 4, heading, (heading + 3) % 4];
        let next = order.into_iter().find(|d| leaving[corner] >> d & 1 == 1);
        if let Some(next) = next {
            leaving[corner] &= !(1 << next);
            if next != heading && corner != start {
                ring.push([corner % width, corner / width]);
            }
            heading = next;
        }
        // Every edge has one successor, so an outline closes with its first edge.
        if next.is_none() || (corner == start && next == Some(first)) {
            return ring;
        }
    }
}
