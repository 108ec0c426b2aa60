//! Outlines of sets of cells: traced along cell edges, and on request simplified to one cell, so that a slanted wall is a
//! line again and not a staircase.

use crate::raster::BitGrid;

/// The largest distance of a traced corner from the simplified outline \[cells\].
const TOLERANCE_CELLS: f64 = 1.0;

/// Directions along cell edges, counterclockwise from east, as steps of (x, y).
const STEPS: [[isize; 2]; 4] = [[1, 0], [0, 1], [-1, 0], [0, -1]];

/// The outlines of a set of cells as rings of cell corners `[x, y]`, counted east and north from the south-west corner of
/// the grid; the set is on the left. Cells that touch only at a corner have outlines of their own.
pub(super) fn rings_around(set: &BitGrid) -> Vec<Vec<[usize; 2]>> {
    traced_around(set).iter().map(|ring| simplified(ring)).collect()
}

/// The same along the very edges of the cells, each ring from its first corner from the south-west on.
pub(super) fn traced_around(set: &BitGrid) -> Vec<Vec<[usize; 2]>> {
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

/// Follows an outline from a corner back to it, keeping the corners where it turns.
fn trace(leaving: &mut [u8], width: usize, start: usize) -> Vec<[usize; 2]> {
    let mut ring = Vec::new();
    let first = leaving[start].trailing_zeros() as usize;
    let (mut corner, mut heading) = (start, first);
    ring.push([corner % width, corner / width]);
    loop {
        let [dx, dy] = STEPS[heading];
        corner = corner.wrapping_add_signed(dx).wrapping_add_signed(dy * width.cast_signed());
        // Left first: that stays with the same cell where two cells touch at a corner.
        let order = [(heading + 1) % 4, heading, (heading + 3) % 4];
        let next = order.into_iter().find(|d| leaving[corner] >> d & 1 == 1);
        if let Some(next) = next {
            leaving[corner] &= !(1 << next);
            if next != heading && corner != start {
                ring.push([corner % width, corner / width]);
            }
            heading = next;
        }
        // Every edge has one successor, so an outline closes with the edge that it began with.
        if next.is_none() || (corner == start && next == Some(first)) {
            return ring;
        }
    }
}

/// A ring with fewer corners, none of the former farther than [`TOLERANCE_CELLS`] from it (Douglas & Peucker 1973), or
/// the ring itself where nothing would be left.
fn simplified(ring: &[[usize; 2]]) -> Vec<[usize; 2]> {
    let n = ring.len();
    let far = |from: usize| (0..n).max_by(|a, b| gap(ring[*a], ring[from]).total_cmp(&gap(ring[*b], ring[from])));
    // Two corners that are far apart are kept in any case.
    let Some((first, second)) = far(0).and_then(|a| far(a).map(|b| (a.min(b), a.max(b)))) else { return ring.to_vec() };
    let mut kept = vec![false; n];
    (kept[first], kept[second]) = (true, true);
    let mut open = vec![(first, second), (second, first + n)];
    while let Some((from, to)) = open.pop() {
        let (a, b) = (ring[from % n], ring[to % n]);
        let farthest = (from + 1..to)
            .map(|k| (k, distance_to_segment(ring[k % n], a, b)))
            .max_by(|p, q| p.1.total_cmp(&q.1))
            .filter(|(_, d)| *d > TOLERANCE_CELLS);
        if let Some((k, _)) = farthest {
            kept[k % n] = true;
            open.extend([(from, k), (k, to)]);
        }
    }
    let few: Vec<[usize; 2]> = (0..n).filter(|k| kept[*k]).map(|k| ring[k]).collect();
    if few.len() >= 3 { few } else { ring.to_vec() }
}

fn vector(from: [usize; 2], to: [usize; 2]) -> [f64; 2] {
    [to[0] as f64 - from[0] as f64, to[1] as f64 - from[1] as f64]
}

fn gap(a: [usize; 2], b: [usize; 2]) -> f64 {
    let [x, y] = vector(a, b);
    x.hypot(y)
}

fn distance_to_segment(p: [usize; 2], a: [usize; 2], b: [usize; 2]) -> f64 {
    let (ab, ap) = (vector(a, b), vector(a, p));
    let squared = ab[0] * ab[0] + ab[1] * ab[1];
    let along = if squared > 0.0 { ((ab[0] * ap[0] + ab[1] * ap[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (ap[0] - along * ab[0]).hypot(ap[1] - along * ab[1])
}
