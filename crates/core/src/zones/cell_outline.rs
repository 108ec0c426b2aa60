//! Outlines of sets of cells simplified to one cell, so that a slanted wall is a line again and not a staircase.

use crate::outlines::{distance, traced_around};
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
    let at = |k: usize| ring[k % n].map(|v| v as f64);
    let gap = |a: usize, b: usize| (at(a)[0] - at(b)[0]).hypot(at(a)[1] - at(b)[1]);
    let far = |from: usize| (0..n).max_by(|a, b| gap(*a, from).total_cmp(&gap(*b, from)));
    // Two corners that are far apart are kept in any case.
    let Some((first, second)) = far(0).and_then(|a| far(a).map(|b| (a.min(b), a.max(b)))) else { return ring.to_vec() };
    let mut kept = vec![false; n];
    (kept[first], kept[second]) = (true, true);
    let mut open = vec![(first, second), (second, first + n)];
    while let Some((from, to)) = open.pop() {
        let (a, b) = (at(from), at(to));
        let farthest = (from + 1..to)
            .map(|k| (k, distance(at(k), a, b)))
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
