//! Outlines of sets of cells simplified to one cell, so that a slanted wall is a line again and not
//! a staircase.
//!
//! A turned or mirrored set has the turned or mirrored outline. Distances are compared in integers,
//! and all corners that are equally far are kept.

use crate::outlines::traced_around;
use crate::raster::BitGrid;

/// Largest distance of a traced corner from the simplified outline, squared \[cells²\].
const TOLERANCE_CELLS2: i128 = 1;

/// Returns the outlines of a set of cells as rings of cell corners `[x, y]`, counted east and north
/// from the south-west corner of the grid. The set is on the left of each ring. Cells that touch
/// only at a corner have separate outlines.
pub(super) fn rings_around(set: &BitGrid) -> Vec<Vec<[usize; 2]>> {
    traced_around(set).iter().map(|ring| simplified(ring)).collect()
}

/// Returns a ring with fewer corners; no former corner is farther from it than the tolerance
/// (Douglas & Peucker 1973). A ring that would vanish is returned unchanged.
fn simplified(ring: &[[usize; 2]]) -> Vec<[usize; 2]> {
    let n = ring.len();
    let points: Vec<[i64; 2]> = ring.iter().map(|p| p.map(|v| v.cast_signed() as i64)).collect();
    // Corners far from one another are always kept.
    let ends = ends(&points);
    let mut kept = vec![false; n];
    ends.iter().for_each(|k| kept[*k] = true);
    let mut open: Vec<(usize, usize)> = ends.windows(2).map(|pair| (pair[0], pair[1])).collect();
    open.extend(ends.first().zip(ends.last()).map(|(first, last)| (*last, first + n)));
    let mut distances: Vec<(i128, i128)> = Vec::new();
    while let Some((from, to)) = open.pop() {
        let (a, b) = (points[from % n], points[to % n]);
        distances.clear();
        distances.extend((from + 1..to).map(|k| {
            (scaled_distance(points[k % n], a, b), -(squared(a, points[k % n]) - squared(b, points[k % n])).abs())
        }));
        let farthest = distances.iter().copied().max().unwrap_or((0, 0));
        if farthest.0 <= TOLERANCE_CELLS2 * squared(a, b) {
            continue;
        }
        let mut last = from;
        for k in (from + 1..to).filter(|k| distances[k - from - 1] == farthest) {
            kept[k % n] = true;
            open.push((last, k));
            last = k;
        }
        open.push((last, to));
    }
    let few: Vec<[usize; 2]> = (0..n).filter(|k| kept[*k]).map(|k| ring[k]).collect();
    if few.len() >= 3 { few } else { ring.to_vec() }
}

/// Returns the corners farthest from the middle of a ring's bounds. If there is only one, adds the
/// corners farthest from it.
fn ends(points: &[[i64; 2]]) -> Vec<usize> {
    let bounds = |k: usize| (points.iter().map(|p| p[k]).min(), points.iter().map(|p| p[k]).max());
    let farthest_from = |doubled: [i64; 2]| -> Vec<usize> {
        let distances: Vec<i128> = points.iter().map(|p| squared(p.map(|v| 2 * v), doubled)).collect();
        let most = distances.iter().max();
        (0..points.len()).filter(|k| Some(&distances[*k]) == most).collect()
    };
    let mut ends = farthest_from([0, 1].map(bounds).map(|(low, high)| low.unwrap_or(0) + high.unwrap_or(0)));
    if let [only] = ends[..] {
        ends.extend(farthest_from(points[only].map(|v| 2 * v)));
        ends.sort_unstable();
    }
    ends
}

/// Returns the squared distance of a point from a segment, times its squared length. EXACT: below
/// 2^80 for 2^19 cells.
fn scaled_distance(p: [i64; 2], a: [i64; 2], b: [i64; 2]) -> i128 {
    let along = (b[0] - a[0]) * (p[0] - a[0]) + (b[1] - a[1]) * (p[1] - a[1]);
    let length = squared(a, b);
    match i128::from(along) {
        ..0 => squared(a, p) * length,
        along if along > length => squared(b, p) * length,
        _ => i128::from(turn(a, b, p)).pow(2),
    }
}

fn squared(a: [i64; 2], b: [i64; 2]) -> i128 {
    i128::from((b[0] - a[0]).pow(2) + (b[1] - a[1]).pow(2))
}

fn turn(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}
