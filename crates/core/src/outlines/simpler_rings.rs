//! Outlines with fewer corners that stay valid polygons.
//!
//! A corner is removed only if the triangle between it and its two neighbors holds no other corner
//! of any ring of the polygon. Then rings neither cross nor touch anew, holes stay in their shell,
//! and no ring turns inside out.
//!
//! Small triangles go first (Visvalingam & Whyatt 1993). No corner of the outline may end up
//! farther than the tolerance from the line that replaces it. This limit is that of Douglas &
//! Peucker 1973, whose method alone keeps no polygon valid.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

/// Fewest corners of a ring: a cell stays a rectangle.
const FEWEST_CORNERS: usize = 4;
/// Side of the buckets in which corners are looked up \[cells\].
const BUCKET: i64 = 8;

/// Returns the rings of one polygon with fewer corners. No former corner is more than `tolerance_m`
/// from the new outline.
///
/// Corners are `[x, y]` in cells of `cell_m` (width, height) \[m\]. Rings are not closed, meet no
/// corner twice and cross neither themselves nor each other. Their order and winding are kept.
///
/// Cost: O(n log n) for n corners, times the corners between two kept ones.
pub(crate) fn simpler_rings(rings: &[Vec<[usize; 2]>], cell_m: (f64, f64), tolerance_m: f64) -> Vec<Vec<[usize; 2]>> {
    let mut work = Work::new(rings, cell_m, tolerance_m);
    let mut open: BinaryHeap<Reverse<(i64, usize, u32)>> = (0..work.corners.len()).map(|k| work.entry(k)).collect();
    while let Some(Reverse((_, corner, version))) = open.pop() {
        if work.corners[corner].version != version || !work.may_go(corner) {
            continue;
        }
        for neighbor in work.remove(corner) {
            open.push(work.entry(neighbor));
        }
    }
    work.rings()
}

#[derive(Debug)]
struct Corner {
    at: [i64; 2],
    ring: usize,
    before: usize,
    after: usize,
    /// Counts the changes of its neighbors; `u32::MAX` once it is removed.
    version: u32,
}

const GONE: u32 = u32::MAX;

#[derive(Debug)]
struct Work {
    corners: Vec<Corner>,
    /// First corner and number of corners of each ring, in input order.
    spans: Vec<(usize, usize)>,
    /// Number of remaining corners of each ring.
    left: Vec<usize>,
    buckets: HashMap<[i64; 2], Vec<usize>>,
    cell_m: (f64, f64),
    tolerance_m: f64,
}

impl Work {
    fn new(rings: &[Vec<[usize; 2]>], cell_m: (f64, f64), tolerance_m: f64) -> Self {
        let mut corners = Vec::new();
        let mut spans = Vec::new();
        for (ring, points) in rings.iter().enumerate() {
            let (first, n) = (corners.len(), points.len());
            spans.push((first, n));
            corners.extend(points.iter().enumerate().map(|(k, p)| Corner {
                at: p.map(usize::cast_signed).map(|v| v as i64),
                ring,
                before: first + (k + n - 1) % n,
                after: first + (k + 1) % n,
                version: 0,
            }));
        }
        let mut buckets: HashMap<[i64; 2], Vec<usize>> = HashMap::new();
        for (k, corner) in corners.iter().enumerate() {
            buckets.entry(corner.at.map(|v| v.div_euclid(BUCKET))).or_default().push(k);
        }
        let left = spans.iter().map(|span| span.1).collect();
        Work { corners, spans, left, buckets, cell_m, tolerance_m }
    }

    /// Returns a corner's entry in the queue, which is ordered by the area of its triangle.
    fn entry(&self, corner: usize) -> Reverse<(i64, usize, u32)> {
        let [a, b, c] = self.triangle(corner);
        Reverse((turn(a, b, c).abs(), corner, self.corners[corner].version))
    }

    fn triangle(&self, corner: usize) -> [[i64; 2]; 3] {
        let Corner { before, after, at, .. } = self.corners[corner];
        [self.corners[before].at, at, self.corners[after].at]
    }

    fn may_go(&self, corner: usize) -> bool {
        self.left[self.corners[corner].ring] > FEWEST_CORNERS && self.is_near(corner) && self.sweeps_nothing(corner)
    }

    /// Returns `true` if all corners between the two neighbors are within the tolerance of the line
    /// between them.
    fn is_near(&self, corner: usize) -> bool {
        let Corner { before, after, ring, .. } = self.corners[corner];
        let (first, n) = self.spans[ring];
        let meters = |k: usize| {
            let [x, y] = self.corners[k].at;
            [x as f64 * self.cell_m.0, y as f64 * self.cell_m.1]
        };
        let (from, to) = (meters(before), meters(after));
        let mut between = (before - first + 1) % n;
        while between != after - first {
            if distance(meters(first + between), from, to) > self.tolerance_m {
                return false;
            }
            between = (between + 1) % n;
        }
        true
    }

    /// Returns `true` if the closed triangle of a corner and its neighbors holds no other remaining
    /// corner. Corners at the same point as a neighbor are allowed.
    fn sweeps_nothing(&self, corner: usize) -> bool {
        let [a, b, c] = self.triangle(corner);
        let low = [0, 1].map(|k| a[k].min(b[k]).min(c[k]));
        let high = [0, 1].map(|k| a[k].max(b[k]).max(c[k]));
        let is_free = |k: &usize| {
            let other = &self.corners[*k];
            let p = other.at;
            let is_beyond = [0, 1].iter().any(|&k| p[k] < low[k] || p[k] > high[k]);
            *k == corner || other.version == GONE || is_beyond || p == a || p == c || !is_in(p, [a, b, c])
        };
        let buckets = |k: usize| low[k].div_euclid(BUCKET)..=high[k].div_euclid(BUCKET);
        buckets(0)
            .all(|x| buckets(1).all(|y| self.buckets.get(&[x, y]).is_none_or(|bucket| bucket.iter().all(is_free))))
    }

    /// Removes a corner and returns its neighbors, whose triangles change.
    fn remove(&mut self, corner: usize) -> [usize; 2] {
        let Corner { before, after, ring, .. } = self.corners[corner];
        self.corners[corner].version = GONE;
        self.corners[before].after = after;
        self.corners[after].before = before;
        self.corners[before].version += 1;
        self.corners[after].version += 1;
        self.left[ring] -= 1;
        [before, after]
    }

    fn rings(&self) -> Vec<Vec<[usize; 2]>> {
        let ring = |&(first, n): &(usize, usize)| {
            let left = self.corners[first..first + n].iter().filter(|corner| corner.version != GONE);
            left.map(|corner| corner.at.map(|v| usize::try_from(v).unwrap_or_default())).collect()
        };
        self.spans.iter().map(ring).collect()
    }
}

/// Returns twice the signed area of a triangle, exact: coordinates are below 2^31.
fn turn(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Returns `true` if a point within the bounds of a triangle lies in it or on its border.
fn is_in(p: [i64; 2], [a, b, c]: [[i64; 2]; 3]) -> bool {
    let sides = [turn(a, b, p), turn(b, c, p), turn(c, a, p)];
    sides.iter().all(|s| *s >= 0) || sides.iter().all(|s| *s <= 0)
}

/// Returns the distance of a point from a segment.
fn distance(p: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (ab, ap) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
    let squared = ab[0] * ab[0] + ab[1] * ab[1];
    let along = if squared > 0.0 { ((ab[0] * ap[0] + ab[1] * ap[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (ap[0] - along * ab[0]).hypot(ap[1] - along * ab[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::outlines::cell_parts;
    use crate::raster::BitGrid;

    fn edges(rings: &[Vec<[usize; 2]>]) -> Vec<[[i64; 2]; 2]> {
        let signed = |p: [usize; 2]| p.map(|v| v.cast_signed() as i64);
        let of = |ring: &Vec<[usize; 2]>| -> Vec<[[i64; 2]; 2]> {
            (0..ring.len()).map(|k| [signed(ring[k]), signed(ring[(k + 1) % ring.len()])]).collect()
        };
        rings.iter().flat_map(of).collect()
    }

    /// Returns `true` if two edges share more than a common end.
    fn cross(e: [[i64; 2]; 2], f: [[i64; 2]; 2]) -> bool {
        let on = |p: [i64; 2], [a, b]: [[i64; 2]; 2]| {
            let within = |k: usize| p[k] >= a[k].min(b[k]) && p[k] <= a[k].max(b[k]);
            turn(a, b, p) == 0 && within(0) && within(1) && p != a && p != b
        };
        let side = |a, b, p| turn(a, b, p).signum();
        let proper =
            side(e[0], e[1], f[0]) * side(e[0], e[1], f[1]) < 0 && side(f[0], f[1], e[0]) * side(f[0], f[1], e[1]) < 0;
        proper || f.iter().any(|p| on(*p, e)) || e.iter().any(|p| on(*p, f)) || (e[0] == f[1] && e[1] == f[0])
    }

    fn doubled(ring: &[[usize; 2]]) -> i64 {
        edges(&[ring.to_vec()]).iter().map(|[a, b]| a[0] * b[1] - a[1] * b[0]).sum()
    }

    #[test]
    fn a_staircase_becomes_a_slope_and_a_cell_stays_a_cell() {
        // Cells below the diagonal of 20 × 20: 20 steps.
        let mut set = BitGrid::new(20, 20);
        (0..20).for_each(|row| (0..=row).for_each(|col| set.insert(row, col)));
        let part = &cell_parts(&set)[0];
        assert_eq!(part.rings[0].len(), 2 + 2 * 20);
        let few = simpler_rings(&part.rings, (1.0, 1.0), 1.0);
        assert!(few[0].len() <= 5, "{few:?}");
        assert_eq!(simpler_rings(&part.rings, (1.0, 1.0), 0.4), part.rings, "a step is 0.7 m from its slope");
        let mut cell = BitGrid::new(3, 3);
        cell.insert(1, 1);
        let part = &cell_parts(&cell)[0];
        assert_eq!(simpler_rings(&part.rings, (1.0, 1.0), 50.0), part.rings);
    }

    #[test]
    fn whatever_the_tolerance_rings_do_not_cross_and_keep_their_winding() {
        let mut state = 7_u64;
        for density in [30, 50, 70] {
            let mut set = BitGrid::new(40, 50);
            for cell in 0..2000 {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                if state >> 33 & 127 < density + density / 4 {
                    set.insert(cell / 50, cell % 50);
                }
            }
            for part in cell_parts(&set) {
                for tolerance in [0.8, 2.0, 100.0] {
                    let few = simpler_rings(&part.rings, (1.0, 0.5), tolerance);
                    let all = edges(&few);
                    for (k, e) in all.iter().enumerate() {
                        assert!(all[..k].iter().all(|f| !cross(*e, *f)), "{tolerance}: {few:?}");
                    }
                    let windings = |rings: &[Vec<[usize; 2]>]| -> Vec<i64> {
                        rings.iter().map(|ring| doubled(ring).signum()).collect()
                    };
                    assert_eq!(windings(&few), windings(&part.rings));
                }
            }
        }
    }
}
