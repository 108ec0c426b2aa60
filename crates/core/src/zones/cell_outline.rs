//! Outlines of sets of cells simplified to one cell, so that a slanted wall is a line again and not a staircase.

use crate::outlines::traced_around;
use crate::raster::BitGrid;

/// The largest distance of a traced corner from the simplified outline \[cells\].
const TOLERANCE_CELLS: f64 = 1.0;

/// The outlines of a set of cells as rings of cell corners `[x, y]`, counted east and north from the south-west corner of
/// the grid; the set is on the left. Cells that touch only at a corner have outlines of their own.
pub(super) fn rings_around(set: &BitGrid) -> Vec<Vec<[usize; 2]>> {
    traced_around(set).iter().map(|ring| simplified(ring)).collect()
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
