//! The oracle proves itself again, on random scenes: against brute-force twins that decide in other ways, and on what
//! must not change or can only change one way.

use num_bigint::BigInt;
use num_rational::Ratio;

use super::oracle::{
    Ceiling, Columns, P3, Prism, columns_ceiling, columns_least_uav_height, columns_los, prisms_ceiling, prisms_cover,
    prisms_least_uav_height, prisms_los,
};
use super::oracle_proof::{M, plan, raised};

// ---------------------------------------------------------------------------------------------------------------------
// Random scenes, crowded with coincidences.

/// SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A whole number from `low` to `high`, both included.
    fn between(&mut self, low: i64, high: i64) -> i64 {
        let span = u64::try_from(high - low + 1).expect("low is not above high");
        low + i64::try_from(self.next() % span).expect("a remainder of a small span")
    }

    fn size(&mut self, most: i64) -> usize {
        usize::try_from(self.between(1, most)).expect("a size is positive")
    }
}

/// A raster of up to 6 × 6 columns of few different heights, some nodata.
fn random_columns(random: &mut Random) -> Columns {
    let (n_cols, n_rows) = (random.size(6), random.size(6));
    let heights = (0..n_cols * n_rows)
        .map(|_| if random.between(0, 9) == 0 { None } else { Some(random.between(0, 1) * random.between(0, 6) * M) })
        .collect();
    Columns { n_cols, n_rows, heights }
}

/// A point in or near the raster: on a corner, an edge, a quarter line, or anywhere.
fn random_end(random: &mut Random, columns: &Columns) -> P3 {
    let grain = [1024, 512, 256, 1][random.size(4) - 1];
    let mut coordinate = |n_cells: usize| {
        let n_steps = (i64::try_from(n_cells).expect("a small raster") + 1) * M / grain;
        random.between(-M / grain, n_steps) * grain
    };
    let (x, y) = (coordinate(columns.n_cols), coordinate(columns.n_rows));
    [x, y, random.between(0, 16) * M / 2]
}

/// Up to 5 prisms with vertices on a lattice of 0..=4: boxes, and rings that may cross themselves.
fn random_prisms(random: &mut Random) -> Vec<Prism> {
    (0..random.size(5))
        .map(|_| {
            let ring = |random: &mut Random| match random.between(0, 2) {
                0 => {
                    let (west, south) = (random.between(0, 3), random.between(0, 3));
                    let (east, north) = (random.between(west + 1, 4), random.between(south + 1, 4));
                    vec![[west, south], [east, south], [east, north], [west, north]]
                }
                kind => (0..2 + random.size(2 * kind)).map(|_| [random.between(0, 4), random.between(0, 4)]).collect(),
            };
            let rings = (0..random.size(3).max(2) - 1).map(|_| ring(random)).collect();
            Prism { rings, top: random.between(1, 5) }
        })
        .collect()
}

/// An end on the lattice in or near the scene of [`random_prisms`].
fn random_prism_end(random: &mut Random) -> P3 {
    [random.between(-1, 5), random.between(-1, 5), random.between(0, 6)]
}

/// Runs `check`, which returns whether a link was LoS, and makes sure that both answers were common.
fn both_answers(n: usize, seed: u64, mut check: impl FnMut(&mut Random) -> bool) {
    let mut random = Random(seed);
    let n_los = (0..n).filter(|_| check(&mut random)).count();
    assert!(n_los * 10 > n && (n - n_los) * 10 > n, "{n_los} of {n} links are LoS");
}

// ---------------------------------------------------------------------------------------------------------------------
// Brute-force twins.

/// Decides a raster link piece by piece: the interior of T is the open columns, the open walls between neighbors up to
/// the lower of them, and vertical lines over corners, which a link that is not blocked beside them cannot cross.
fn clipping_los(columns: &Columns, uav: P3, receiver: P3) -> bool {
    let wide = |p: P3| p.map(i128::from);
    let (u, r) = (wide(uav), wide(receiver));
    let (n_cols, n_rows) = (columns.n_cols as i128, columns.n_rows as i128);
    let height = |col: i128, south_row: i128| -> Option<i128> {
        if !(0..n_cols).contains(&col) || !(0..n_rows).contains(&south_row) {
            return None;
        }
        let is_own = (col * 1024..=col * 1024 + 1024).contains(&r[0])
            && (south_row * 1024..=south_row * 1024 + 1024).contains(&r[1]);
        if is_own {
            return None;
        }
        let index = usize::try_from((n_rows - 1 - south_row) * n_cols + col).expect("the cell is in the raster");
        columns.heights[index].map(i128::from)
    };
    // Whether the ray gets below `top` within the open interval of t in which low < p < high on each given axis.
    let is_blocked = |top: i128, limits: &[(usize, i128, i128)]| {
        let (mut enter, mut leave) = ((0, 1), (1, 1));
        for &(axis, low, high) in limits {
            let along = r[axis] - u[axis];
            if along == 0 {
                if u[axis] <= low || high <= u[axis] {
                    return false;
                }
                continue;
            }
            let (first, last) = if along > 0 { (low, high) } else { (high, low) };
            let at = |line: i128| ((line - u[axis]) * along.signum(), along.abs());
            let later = |a: (i128, i128), b: (i128, i128)| a.0 * b.1 > b.0 * a.1;
            if later(at(first), enter) {
                enter = at(first);
            }
            if later(leave, at(last)) {
                leave = at(last);
            }
        }
        enter.0 * leave.1 < leave.0 * enter.1
            && [enter, leave].into_iter().any(|(num, den)| u[2] * den + num * (r[2] - u[2]) < top * den)
    };
    for col in 0..n_cols {
        for row in 0..n_rows {
            let Some(top) = height(col, row) else { continue };
            let (west, south) = (col * 1024, row * 1024);
            if is_blocked(top, &[(0, west, west + 1024), (1, south, south + 1024)]) {
                return false;
            }
            // The wall to the eastern and to the northern neighbor, if the link runs in its plane.
            for (axis, wall, along, start, neighbor) in
                [(0, west + 1024, 1, south, height(col + 1, row)), (1, south + 1024, 0, west, height(col, row + 1))]
            {
                if let Some(other) = neighbor
                    && u[axis] == wall
                    && r[axis] == wall
                    && is_blocked(top.min(other), &[(along, start, start + 1024)])
                {
                    return false;
                }
            }
        }
    }
    true
}

/// The top over a point given in units of 1/scale, by the even-odd rule with a ray to the east.
fn sampled_height(prisms: &[Prism], scale: i128, x: i128, y: i128) -> Option<i64> {
    let is_inside = |prism: &Prism| {
        let mut is_inside = false;
        for ring in &prism.rings {
            for (i, a) in ring.iter().enumerate() {
                let b = ring[(i + 1) % ring.len()];
                let [[ax, ay], [bx, by]] = [*a, b].map(|p| p.map(|c| i128::from(c) * scale));
                if (ay > y) != (by > y) {
                    // x < ax + (y - ay) (bx - ax) / (by - ay)
                    let (left, right) = ((x - ax) * (by - ay), (y - ay) * (bx - ax));
                    is_inside ^= if by > ay { left < right } else { left > right };
                }
            }
        }
        is_inside
    };
    prisms.iter().filter(|prism| is_inside(prism)).map(|prism| prism.top).max()
}

/// Decides a link on the small lattice of [`random_prisms`] by sampling it so densely that nothing can be missed.
///
/// A link advances by at most 6 on each axis and an edge by at most 4, so breakpoints are fractions with denominators
/// up to 2 * 6 * 4 = 48, and the ray is level with a top at fractions with denominators up to 6. So a stretch, or the
/// part of one in which the ray is below the top, is at least 1 / 48² long. With N = 5003 it holds a sample k / N,
/// which is never a breakpoint, N being prime. The scene is looked up about 10⁻¹² to the left and to the right of the
/// sample, too close for any edge that does not go through the sample itself.
fn sampling_los(prisms: &[Prism], uav: P3, receiver: P3) -> bool {
    const N: i128 = 5_003;
    const FINE: i128 = 1_000_000_000;
    let (u, r) = (uav.map(i128::from), receiver.map(i128::from));
    let (dx, dy, dz) = (r[0] - u[0], r[1] - u[1], r[2] - u[2]);
    (1..N).all(|k| {
        let (x, y) = ((u[0] * N + k * dx) * FINE, (u[1] * N + k * dy) * FINE);
        let left = sampled_height(prisms, N * FINE, x - dy, y + dx);
        let right = sampled_height(prisms, N * FINE, x + dy, y - dx);
        left.min(right).is_none_or(|height| u[2] * N + k * dz >= i128::from(height) * N)
    })
}

/// The height around a lattice point, by looking in every direction with terms up to 13.
///
/// Directions of edges at the point have terms up to 4, so each sector between two of them contains a direction with
/// terms up to 8. Looking along an edge gives the height on one of its sides.
fn sampled_height_around(prisms: &[Prism], p: [i64; 2]) -> Option<i64> {
    let directions = (-13..=13).flat_map(|dx| (-13..=13).map(move |dy| (dx, dy))).filter(|&d| d != (0, 0));
    directions
        .map(|(dx, dy)| sampled_height(prisms, 1000, i128::from(p[0]) * 1000 + dx, i128::from(p[1]) * 1000 + dy))
        .min()
        .flatten()
}

#[test]
fn rasters_agree_with_clipping_each_column_and_each_wall() {
    both_answers(60_000, 1, |random| {
        let columns = random_columns(random);
        let (uav, receiver) = (random_end(random, &columns), random_end(random, &columns));
        let los = columns_los(&columns, uav, receiver);
        assert_eq!(los, clipping_los(&columns, uav, receiver), "{columns:?} {uav:?} {receiver:?}");
        los
    });
}

#[test]
fn rasters_agree_with_prisms_over_their_cells() {
    both_answers(5_000, 2, |random| {
        let columns = random_columns(random);
        let (uav, receiver) = (random_end(random, &columns), random_end(random, &columns));
        let los = columns_los(&columns, uav, receiver);
        let prisms = prisms_of(&without_own_cells(&columns, receiver));
        assert_eq!(los, prisms_los(&prisms, uav, receiver), "{columns:?} {uav:?} {receiver:?}");
        los
    });
}

#[test]
fn prisms_agree_with_dense_sampling() {
    both_answers(1_500, 3, |random| {
        let prisms = random_prisms(random);
        let (uav, mut receiver) = (random_prism_end(random), random_prism_end(random));
        if plan(uav) == plan(receiver) {
            receiver[0] += 1;
        }
        let los = prisms_los(&prisms, uav, receiver);
        assert_eq!(los, sampling_los(&prisms, uav, receiver), "{prisms:?} {uav:?} {receiver:?}");
        los
    });
}

#[test]
fn the_height_around_a_point_agrees_with_looking_in_all_directions() {
    both_answers(4_000, 4, |random| {
        // Three scenes in one, so that many points are surrounded.
        let prisms: Vec<Prism> = (0..3).flat_map(|_| random_prisms(random)).collect();
        let (p, z) = ([random.between(1, 3), random.between(1, 3)], random.between(0, 2));
        let covers = prisms_cover(&prisms, p, z);
        assert_eq!(covers, sampled_height_around(&prisms, p).is_some_and(|height| z < height), "{prisms:?} {p:?} {z}");
        // The link straight up to the sky starts at this point.
        assert_eq!(covers, !prisms_los(&prisms, [p[0], p[1], 9], [p[0], p[1], z]));
        covers
    });
}

#[test]
fn no_point_of_a_clear_link_is_covered() {
    // Horizontal distances are multiples of 6, so the five points between are on the lattice.
    both_answers(3_000, 5, |random| {
        let prisms = random_prisms(random);
        let (first, step) = (random_prism_end(random), [0, 0, 0].map(|_: i64| random.between(-1, 1)));
        let along = |k: i64| [0, 1, 2].map(|axis| first[axis] + k * step[axis]);
        let los = prisms_los(&prisms, first, along(6));
        if los && step != [0, 0, 0] {
            for [x, y, z] in (1..6).map(along) {
                assert!(!prisms_cover(&prisms, [x, y], z), "{prisms:?} {first:?} {step:?}");
            }
        }
        los
    });
}

// ---------------------------------------------------------------------------------------------------------------------
// What must not change.

/// The raster with the receiver's own cells as nodata.
fn without_own_cells(columns: &Columns, receiver: P3) -> Columns {
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
fn south_west(columns: &Columns, index: usize) -> [i64; 2] {
    let (row, col) = (index / columns.n_cols, index % columns.n_cols);
    [col, columns.n_rows - 1 - row].map(|n| i64::try_from(n).expect("a small raster") * M)
}

/// One prism over each cell that has a height.
fn prisms_of(columns: &Columns) -> Vec<Prism> {
    let mut prisms = Vec::new();
    for (index, height) in columns.heights.iter().enumerate() {
        if let Some(top) = *height {
            let [west, south] = south_west(columns, index);
            let ring = vec![[west, south], [west + M, south], [west + M, south + M], [west, south + M]];
            prisms.push(Prism { rings: vec![ring], top });
        }
    }
    prisms
}

/// Applies a map of the plane to every vertex.
fn moved(prisms: &[Prism], map: impl Fn([i64; 2]) -> [i64; 2]) -> Vec<Prism> {
    let ring = |ring: &Vec<[i64; 2]>| ring.iter().map(|&vertex| map(vertex)).collect();
    prisms.iter().map(|prism| Prism { rings: prism.rings.iter().map(ring).collect(), top: prism.top }).collect()
}

#[test]
fn swapping_the_ends_changes_nothing_among_prisms() {
    both_answers(5_000, 6, |random| {
        let prisms = random_prisms(random);
        let (uav, receiver) = (random_prism_end(random), random_prism_end(random));
        let los = prisms_los(&prisms, uav, receiver);
        assert_eq!(los, prisms_los(&prisms, receiver, uav), "{prisms:?} {uav:?} {receiver:?}");
        if plan(uav) != plan(receiver) {
            let swapped = prisms_ceiling(&prisms, receiver, plan(uav));
            assert_eq!(swapped, prisms_least_uav_height(&prisms, plan(uav), receiver));
        }
        los
    });
}

#[test]
fn mirrors_and_quarter_turns_change_nothing_among_prisms() {
    both_answers(3_000, 7, |random| {
        let prisms = random_prisms(random);
        let (uav, receiver) = (random_prism_end(random), random_prism_end(random));
        let los = prisms_los(&prisms, uav, receiver);
        let maps: [fn([i64; 2]) -> [i64; 2]; 4] =
            [|[x, y]| [-x, y], |[x, y]| [-y, x], |[x, y]| [y + 7, x - 3], |[x, y]| [2 * x + y, y - x]];
        for map in maps {
            let end = |p: P3| {
                let [x, y] = map(plan(p));
                [x, y, p[2]]
            };
            assert_eq!(
                los,
                prisms_los(&moved(&prisms, map), end(uav), end(receiver)),
                "{prisms:?} {uav:?} {receiver:?}"
            );
        }
        los
    });
}

#[test]
fn mirrors_and_quarter_turns_change_nothing_in_a_raster() {
    both_answers(5_000, 8, |random| {
        let columns = random_columns(random);
        let (uav, receiver) = (random_end(random, &columns), random_end(random, &columns));
        let los = columns_los(&columns, uav, receiver);
        let Columns { n_cols, n_rows, ref heights } = columns;
        let (width, depth) = [n_cols, n_rows].map(|n| i64::try_from(n).expect("a small raster") * M).into();

        let mirrored = heights.chunks(n_cols).flat_map(|row| row.iter().rev().copied()).collect();
        let mirrored = Columns { n_cols, n_rows, heights: mirrored };
        let end = |[x, y, z]: P3| [width - x, y, z];
        assert_eq!(los, columns_los(&mirrored, end(uav), end(receiver)), "mirror: {columns:?} {uav:?} {receiver:?}");

        // Counterclockwise: the eastern column becomes the northern row, its northern end first.
        let turned =
            (0..n_cols).rev().flat_map(|col| (0..n_rows).map(move |row| heights[row * n_cols + col])).collect();
        let turned = Columns { n_cols: n_rows, n_rows: n_cols, heights: turned };
        let end = |[x, y, z]: P3| [depth - y, x, z];
        assert_eq!(los, columns_los(&turned, end(uav), end(receiver)), "turn: {columns:?} {uav:?} {receiver:?}");
        los
    });
}

#[test]
fn splitting_each_cell_in_four_changes_nothing() {
    both_answers(5_000, 9, |random| {
        let columns = random_columns(random);
        let (uav, receiver) = (random_end(random, &columns), random_end(random, &columns));
        // The own cell would shrink with the cells, so it is opened beforehand.
        let coarse = without_own_cells(&columns, receiver);
        let (n_cols, n_rows) = (2 * coarse.n_cols, 2 * coarse.n_rows);
        let fine = |index: usize| coarse.heights[index / n_cols / 2 * coarse.n_cols + index % n_cols / 2];
        let fine = Columns { n_cols, n_rows, heights: (0..n_cols * n_rows).map(fine).collect() };
        let end = |[x, y, z]: P3| [2 * x, 2 * y, z];
        let los = columns_los(&coarse, uav, receiver);
        assert_eq!(los, columns_los(&columns, uav, receiver));
        assert_eq!(los, columns_los(&fine, end(uav), end(receiver)), "{columns:?} {uav:?} {receiver:?}");
        los
    });
}

#[test]
fn cutting_a_prism_in_two_changes_nothing() {
    // A convex quadrilateral is cut along a diagonal; each half is a prism of its own.
    both_answers(5_000, 10, |random| {
        let mut whole = random_prisms(random);
        let (a, b) = (random.between(1, 3), random.between(1, 3));
        let ring = [[0, a], [b, 0], [4, 4 - a], [4 - b, 4]];
        let top = random.between(1, 5);
        let mut cut = whole.clone();
        whole.push(Prism { rings: vec![ring.to_vec()], top });
        cut.push(Prism { rings: vec![vec![ring[0], ring[1], ring[2]]], top });
        cut.push(Prism { rings: vec![vec![ring[2], ring[0], ring[3]]], top });
        let (uav, receiver) = (random_prism_end(random), random_prism_end(random));
        let los = prisms_los(&whole, uav, receiver);
        assert_eq!(los, prisms_los(&cut, uav, receiver), "{whole:?} {uav:?} {receiver:?}");
        los
    });
}

#[test]
fn the_size_of_the_numbers_changes_nothing() {
    // Scaled up, the same scene needs big integers.
    both_answers(2_000, 11, |random| {
        let prisms = random_prisms(random);
        let (uav, receiver) = (random_prism_end(random), random_prism_end(random));
        let los = prisms_los(&prisms, uav, receiver);
        let (plane, up) = (1_i64 << 59, 1_i64 << 58);
        let mut large = moved(&prisms, |p| p.map(|c| c * plane));
        large.iter_mut().for_each(|prism| prism.top *= up);
        let end = |[x, y, z]: P3| [x * plane, y * plane, z * up];
        assert_eq!(los, prisms_los(&large, end(uav), end(receiver)), "{prisms:?} {uav:?} {receiver:?}");
        assert_eq!(
            prisms_cover(&prisms, plan(uav), uav[2]),
            prisms_cover(&large, plan(end(uav)), end(uav)[2]),
            "{prisms:?} {uav:?}"
        );
        los
    });
}

// ---------------------------------------------------------------------------------------------------------------------
// What can change only one way.

#[test]
fn raising_a_column_never_clears_and_raising_an_end_never_blocks() {
    both_answers(5_000, 12, |random| {
        let mut columns = random_columns(random);
        let (uav, receiver) = (random_end(random, &columns), random_end(random, &columns));
        let los = columns_los(&columns, uav, receiver);
        if los {
            assert!(columns_los(&columns, raised(uav, random.between(1, 5000)), receiver));
            assert!(columns_los(&columns, uav, raised(receiver, random.between(1, 5000))));
        } else {
            let index = random.size(i64::try_from(columns.heights.len()).expect("a small raster")) - 1;
            columns.heights[index] = Some(columns.heights[index].unwrap_or(0) + random.between(1, 5000));
            assert!(!columns_los(&columns, uav, receiver), "{columns:?} {uav:?} {receiver:?}");
        }
        los
    });
}

/// Checks a ceiling: `los_at(scale, z)` decides the link with all heights but the asked one multiplied by `scale`.
///
/// At the ceiling itself, an integer in a scene stretched by its denominator, the link must be LoS; just below, NLoS.
fn check_ceiling(ceiling: &Ceiling, los_at: impl Fn(i64, i64) -> bool) {
    match ceiling {
        Ceiling::Clear => assert!(los_at(1, -1_000_000)),
        Ceiling::Never => assert!(!los_at(1, 1_000_000_000)),
        Ceiling::At(height) => {
            let [z, scale] = [height.numer(), height.denom()].map(|n| i64::try_from(n.clone()).expect("a small scene"));
            assert!(los_at(scale, z), "at the ceiling {height}");
            assert!(!los_at(scale, z - 1), "below the ceiling {height}");
        }
    }
}

#[test]
fn los_in_a_raster_is_at_or_above_the_ceiling() {
    both_answers(5_000, 13, |random| {
        let columns = random_columns(random);
        let (uav, mut receiver) = (random_end(random, &columns), random_end(random, &columns));
        if plan(uav) == plan(receiver) {
            receiver[0] += 1;
        }
        let stretched = |scale: i64| {
            let heights = columns.heights.iter().map(|height| height.map(|height| height * scale)).collect();
            Columns { heights, ..columns.clone() }
        };
        let with_z = |p: P3, z: i64| [p[0], p[1], z];
        check_ceiling(&columns_ceiling(&columns, uav, plan(receiver)), |scale, z| {
            columns_los(&stretched(scale), with_z(uav, uav[2] * scale), with_z(receiver, z))
        });
        check_ceiling(&columns_least_uav_height(&columns, plan(uav), receiver), |scale, z| {
            columns_los(&stretched(scale), with_z(uav, z), with_z(receiver, receiver[2] * scale))
        });
        let los = columns_los(&columns, uav, receiver);
        assert_eq!(los, reaches(receiver[2], &columns_ceiling(&columns, uav, plan(receiver))));
        assert_eq!(los, reaches(uav[2], &columns_least_uav_height(&columns, plan(uav), receiver)));
        los
    });
}

#[test]
fn los_among_prisms_is_at_or_above_the_ceiling() {
    both_answers(5_000, 14, |random| {
        let prisms = random_prisms(random);
        let (uav, receiver) = (random_prism_end(random), random_prism_end(random));
        let stretched = |scale: i64| -> Vec<Prism> {
            prisms.iter().map(|prism| Prism { top: prism.top * scale, ..prism.clone() }).collect()
        };
        let with_z = |p: P3, z: i64| [p[0], p[1], z];
        check_ceiling(&prisms_ceiling(&prisms, uav, plan(receiver)), |scale, z| {
            prisms_los(&stretched(scale), with_z(uav, uav[2] * scale), with_z(receiver, z))
        });
        check_ceiling(&prisms_least_uav_height(&prisms, plan(uav), receiver), |scale, z| {
            prisms_los(&stretched(scale), with_z(uav, z), with_z(receiver, receiver[2] * scale))
        });
        let los = prisms_los(&prisms, uav, receiver);
        if uav != receiver {
            assert_eq!(los, reaches(receiver[2], &prisms_ceiling(&prisms, uav, plan(receiver))));
            assert_eq!(los, reaches(uav[2], &prisms_least_uav_height(&prisms, plan(uav), receiver)));
        }
        los
    });
}

fn reaches(z: i64, ceiling: &Ceiling) -> bool {
    match ceiling {
        Ceiling::Clear => true,
        Ceiling::At(height) => Ratio::from(BigInt::from(z)) >= *height,
        Ceiling::Never => false,
    }
}
