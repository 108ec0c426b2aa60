//! Small scenes for the suites, on coarse lattices, so that shared walls, corners and grazing rays are the rule.

#![expect(clippy::unwrap_used, reason = "a panic is a failed test")]

use std::cmp::Ordering;

use crate::oracle::{Columns, P3, Prism};
use crate::support::Random;

/// Lattice steps to the meter and to the cell.
pub(crate) const M: i64 = 1024;

pub(crate) fn plan([x, y, _]: P3) -> [i64; 2] {
    [x, y]
}

/// A point raised by some lattice units.
pub(crate) fn raised([x, y, z]: P3, units: i64) -> P3 {
    [x, y, z + units]
}

pub(crate) fn at_height([x, y]: [i64; 2], z: i64) -> P3 {
    [x, y, z]
}

/// A prism over one ring.
pub(crate) fn prism(ring: &[[i64; 2]], top: i64) -> Prism {
    Prism { rings: vec![ring.to_vec()], top }
}

/// The corners of a rectangle, counterclockwise.
pub(crate) fn rectangle(west: i64, south: i64, east: i64, north: i64) -> Vec<[i64; 2]> {
    vec![[west, south], [east, south], [east, north], [west, north]]
}

/// A prism over a rectangle.
pub(crate) fn block(west: i64, south: i64, east: i64, north: i64, top: i64) -> Prism {
    prism(&rectangle(west, south, east, north), top)
}

/// Applies a map of the plane to every vertex, and another to every top.
pub(crate) fn moved(prisms: &[Prism], map: impl Fn([i64; 2]) -> [i64; 2], lift: impl Fn(i64) -> i64) -> Vec<Prism> {
    let ring = |ring: &Vec<[i64; 2]>| ring.iter().map(|&vertex| map(vertex)).collect();
    prisms.iter().map(|p| Prism { rings: p.rings.iter().map(ring).collect(), top: lift(p.top) }).collect()
}

// ---------------------------------------------------------------------------------------------------------------------
// A catalogue of footprints on the integers 0..=6, tops 1..=3.

/// Named scenes, each with another way for edges to meet.
pub(crate) fn catalogue() -> Vec<(&'static str, Vec<Prism>)> {
    let with_holes =
        |rings: &[&[[i64; 2]]], top| vec![Prism { rings: rings.iter().map(|r| r.to_vec()).collect(), top }];
    let square = rectangle(0, 0, 6, 6);
    vec![
        ("two blocks share a wall", vec![block(0, 0, 4, 4, 2), block(4, 0, 6, 4, 3)]),
        ("walls shared in part", vec![block(0, 0, 2, 6, 3), block(2, 1, 4, 3, 2), block(2, 4, 5, 6, 1)]),
        ("an L", vec![prism(&[[0, 0], [6, 0], [6, 2], [2, 2], [2, 6], [0, 6]], 2)]),
        ("a U", vec![prism(&[[0, 0], [6, 0], [6, 6], [4, 6], [4, 2], [2, 2], [2, 6], [0, 6]], 2)]),
        (
            "a plus",
            vec![prism(
                &[[2, 0], [4, 0], [4, 2], [6, 2], [6, 4], [4, 4], [4, 6], [2, 6], [2, 4], [0, 4], [0, 2], [2, 2]],
                2,
            )],
        ),
        (
            "a comb",
            vec![prism(
                &[[0, 0], [5, 0], [5, 4], [4, 4], [4, 2], [3, 2], [3, 4], [2, 4], [2, 2], [1, 2], [1, 4], [0, 4]],
                2,
            )],
        ),
        ("a courtyard", with_holes(&[&square, &rectangle(2, 2, 4, 4)], 2)),
        ("a courtyard with a tower", with_holes(&[&square, &rectangle(1, 1, 5, 5), &rectangle(2, 2, 4, 4)], 2)),
        ("a hole that touches the shell", with_holes(&[&square, &[[0, 3], [4, 1], [4, 5]]], 2)),
        ("a hole from the shell's corner", with_holes(&[&square, &[[0, 0], [3, 1], [1, 3]]], 2)),
        (
            "four blocks meet at a point",
            vec![block(0, 0, 3, 3, 1), block(3, 0, 6, 3, 2), block(0, 3, 3, 6, 3), block(3, 3, 6, 6, 2)],
        ),
        (
            "a pinwheel",
            vec![
                prism(&[[3, 3], [6, 2], [6, 4]], 2),
                prism(&[[3, 3], [6, 4], [4, 6]], 1),
                prism(&[[3, 3], [4, 6], [2, 6]], 3),
                prism(&[[3, 3], [0, 4], [0, 2]], 2),
                prism(&[[3, 3], [2, 0], [4, 0]], 2),
            ],
        ),
        ("blocks that overlap", vec![block(0, 0, 4, 4, 2), block(2, 2, 6, 6, 3), block(1, 3, 5, 5, 1)]),
        (
            "slanted walls shared",
            vec![
                prism(&[[3, 0], [6, 3], [3, 6], [0, 3]], 2),
                prism(&[[0, 0], [3, 0], [0, 3]], 1),
                prism(&[[6, 6], [3, 6], [6, 3]], 3),
            ],
        ),
        ("a star", vec![prism(&[[0, 0], [3, 1], [6, 0], [5, 3], [6, 6], [3, 5], [0, 6], [1, 3]], 2)]),
        ("corner to corner", vec![block(0, 0, 3, 3, 2), block(3, 3, 6, 6, 2), block(0, 5, 1, 6, 3)]),
        ("a square in triangles", vec![prism(&[[0, 0], [6, 0], [6, 6]], 2), prism(&[[0, 0], [6, 6], [0, 6]], 2)]),
    ]
}

// ---------------------------------------------------------------------------------------------------------------------
// Random scenes.

/// Up to 6 × 6 cells with many equal heights and some nodata.
pub(crate) fn random_columns(random: &mut Random) -> Columns {
    let (n_cols, n_rows) = (random.index(1, 6), random.index(1, 6));
    let heights = (0..n_cols * n_rows)
        .map(|_| if random.chance(10) { None } else { Some(random.within(0, 1) * random.within(0, 6) * M) })
        .collect();
    Columns { n_cols, n_rows, heights }
}

/// A point in or near a raster: on a corner, an edge, a quarter line, or anywhere.
pub(crate) fn random_end(random: &mut Random, columns: &Columns) -> P3 {
    let grain = random.choose(&[1024, 512, 256, 1]);
    let mut coordinate = |n_cells: usize| {
        let n_steps = (i64::try_from(n_cells).unwrap() + 1) * M / grain;
        random.within(-M / grain, n_steps) * grain
    };
    let (x, y) = (coordinate(columns.n_cols), coordinate(columns.n_rows));
    [x, y, random.within(0, 16) * M / 2]
}

/// The raster with the receiver's own cells as nodata.
pub(crate) fn without_own_cells(columns: &Columns, receiver: P3) -> Columns {
    let mut open = columns.clone();
    for (index, height) in open.heights.iter_mut().enumerate() {
        let [west, south] = south_west(columns, index);
        if (west..=west + M).contains(&receiver[0]) && (south..=south + M).contains(&receiver[1]) {
            *height = None;
        }
    }
    open
}

/// The south-western corner of a cell.
pub(crate) fn south_west(columns: &Columns, index: usize) -> [i64; 2] {
    let (row, col) = (index / columns.n_cols, index % columns.n_cols);
    [col, columns.n_rows - 1 - row].map(|n| i64::try_from(n).unwrap() * M)
}

/// Moves both ends by up to one step along every axis, `n` times at random.
pub(crate) fn around(uav: P3, receiver: P3, n: usize, random: &mut Random) -> Vec<(P3, P3)> {
    let moved = |p: P3, k: i64| [p[0] + k % 3 - 1, p[1] + k / 3 % 3 - 1, p[2] + k / 9 - 1];
    (0..n).map(|_| (moved(uav, random.within(0, 26)), moved(receiver, random.within(0, 26)))).collect()
}

/// Up to 5 valid polygons on the integers 0..=6, some with a hole, tops 1..=5.
pub(crate) fn random_prisms(random: &mut Random) -> Vec<Prism> {
    (0..random.within(1, 5)).map(|_| random_prism(random)).collect()
}

fn random_prism(random: &mut Random) -> Prism {
    let top = random.within(1, 5);
    match random.within(0, 3) {
        0 => {
            let (west, south) = (random.within(0, 4), random.within(0, 4));
            block(west, south, random.within(west + 1, 6), random.within(south + 1, 6), top)
        }
        1 => {
            let (west, south) = (random.within(0, 2), random.within(0, 2));
            let hole = rectangle(west + 1, south + 1, west + 2, south + 3);
            Prism { rings: vec![rectangle(west, south, west + 4, south + 4), hole], top }
        }
        _ => prism(&star(random, 6), top),
    }
}

/// An end among such prisms: integers, also below and around them, or half-way between.
pub(crate) fn random_prism_end(random: &mut Random) -> P3 {
    [random.within(-1, 7), random.within(-1, 7), random.within(0, 6)]
}

/// Up to 5 prisms with vertices on the integers 0..=4, tops 1..=5: boxes, and rings that may cross themselves. The
/// oracle takes them as they are; for the engines the crossings are rounded.
pub(crate) fn crossing_prisms(random: &mut Random) -> Vec<Prism> {
    let ring = |random: &mut Random| match random.within(0, 2) {
        0 => {
            let (west, south) = (random.within(0, 3), random.within(0, 3));
            rectangle(west, south, random.within(west + 1, 4), random.within(south + 1, 4))
        }
        kind => (0..random.within(3, 2 + 2 * kind)).map(|_| [random.within(0, 4), random.within(0, 4)]).collect(),
    };
    let prism = |random: &mut Random| {
        let n_rings = random.index(1, 3).max(2) - 1;
        Prism { rings: (0..n_rings).map(|_| ring(random)).collect(), top: random.within(1, 5) }
    };
    (0..random.index(1, 5)).map(|_| prism(random)).collect()
}

/// An end in or near such prisms.
pub(crate) fn crossing_prism_end(random: &mut Random) -> P3 {
    [random.within(-1, 5), random.within(-1, 5), random.within(0, 6)]
}

/// A polygon seen whole from one point: lattice points of `0..=largest` in order of their direction, no gap between
/// neighbors as wide as half a turn. Many of its vertices are collinear.
pub(crate) fn star(random: &mut Random, largest: i64) -> Vec<[i64; 2]> {
    loop {
        let center = [random.within(1, largest - 1), random.within(1, largest - 1)];
        let n_points = random.within(3, 14);
        let mut rays: Vec<[i64; 2]> = (0..n_points)
            .map(|_| [random.within(0, largest) - center[0], random.within(0, largest) - center[1]])
            .filter(|d| *d != [0, 0])
            .collect();
        rays.sort_by(|a, b| by_direction(*a, *b));
        rays.dedup_by(|a, b| by_direction(*a, *b) == Ordering::Equal);
        let n = rays.len();
        if n >= 3 && (0..n).all(|i| cross(rays[i], rays[(i + 1) % n]) > 0) {
            return rays.iter().map(|d| [d[0] + center[0], d[1] + center[1]]).collect();
        }
    }
}

/// Order of directions, counterclockwise from east.
fn by_direction(a: [i64; 2], b: [i64; 2]) -> Ordering {
    let is_lower = |d: [i64; 2]| d[1] < 0 || (d[1] == 0 && d[0] < 0);
    is_lower(a).cmp(&is_lower(b)).then(0.cmp(&cross(a, b)))
}

/// Positive if `b` is to the left of `a`.
pub(crate) fn cross(a: [i64; 2], b: [i64; 2]) -> i64 {
    a[0] * b[1] - a[1] * b[0]
}

/// Positive if `c` is to the left of the way from `a` to `b`.
pub(crate) fn turn(a: [i64; 2], b: [i64; 2], c: [i64; 2]) -> i64 {
    cross([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]])
}

/// Twice the signed area of a ring.
pub(crate) fn doubled_area(ring: &[[i64; 2]]) -> i64 {
    (0..ring.len()).map(|i| cross(ring[i], ring[(i + 1) % ring.len()])).sum()
}
