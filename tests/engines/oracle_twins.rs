//! The oracle proves itself again, on random scenes: against brute-force twins that decide in other ways, at any size of
//! numbers, and at its own ceilings. `invariants` holds it to what must not change or can only change one way.

use num_bigint::BigInt;
use num_rational::Ratio;

use crate::oracle::{
    Ceiling, Columns, P3, Prism, columns_ceiling, columns_least_uav_height, columns_los, prisms_ceiling, prisms_cover,
    prisms_least_uav_height, prisms_los,
};
use crate::referee::both_answers;
use crate::shapes::{
    M, at_height, crossing_prism_end, crossing_prisms, moved, plan, prism, random_columns, random_end, rectangle,
    south_west, without_own_cells,
};

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

/// Decides a link on the small lattice of [`crossing_prisms`] by sampling it so densely that nothing can be missed.
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

/// One prism over each cell that has a height.
fn prisms_over_cells(columns: &Columns) -> Vec<Prism> {
    let prism_over = |(index, height): (usize, &Option<i64>)| {
        let [west, south] = south_west(columns, index);
        height.map(|top| prism(&rectangle(west, south, west + M, south + M), top))
    };
    columns.heights.iter().enumerate().filter_map(prism_over).collect()
}

#[test]
fn rasters_agree_with_prisms_over_their_cells() {
    both_answers(5_000, 2, |random| {
        let columns = random_columns(random);
        let (uav, receiver) = (random_end(random, &columns), random_end(random, &columns));
        let los = columns_los(&columns, uav, receiver);
        let prisms = prisms_over_cells(&without_own_cells(&columns, receiver));
        assert_eq!(los, prisms_los(&prisms, uav, receiver), "{columns:?} {uav:?} {receiver:?}");
        los
    });
}

#[test]
fn prisms_agree_with_dense_sampling() {
    both_answers(1_500, 3, |random| {
        let prisms = crossing_prisms(random);
        let (uav, mut receiver) = (crossing_prism_end(random), crossing_prism_end(random));
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
        let prisms: Vec<Prism> = (0..3).flat_map(|_| crossing_prisms(random)).collect();
        let (p, z) = ([random.within(1, 3), random.within(1, 3)], random.within(0, 2));
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
        let prisms = crossing_prisms(random);
        let (first, step) = (crossing_prism_end(random), [0, 0, 0].map(|_: i64| random.within(-1, 1)));
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

#[test]
fn the_size_of_the_numbers_changes_nothing() {
    // Scaled up, the same scene needs big integers.
    both_answers(2_000, 11, |random| {
        let prisms = crossing_prisms(random);
        let (uav, receiver) = (crossing_prism_end(random), crossing_prism_end(random));
        let los = prisms_los(&prisms, uav, receiver);
        let (plane, up) = (1_i64 << 59, 1_i64 << 58);
        let large = moved(&prisms, |p| p.map(|c| c * plane), |top| top * up);
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
// Ceilings.

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
        let ceiling = columns_ceiling(&columns, uav, plan(receiver));
        let least = columns_least_uav_height(&columns, plan(uav), receiver);
        check_ceiling(&ceiling, |scale, z| {
            columns_los(&stretched(scale), at_height(plan(uav), uav[2] * scale), at_height(plan(receiver), z))
        });
        check_ceiling(&least, |scale, z| {
            columns_los(&stretched(scale), at_height(plan(uav), z), at_height(plan(receiver), receiver[2] * scale))
        });
        let los = columns_los(&columns, uav, receiver);
        assert_eq!([los; 2], [reaches(receiver[2], &ceiling), reaches(uav[2], &least)]);
        los
    });
}

#[test]
fn los_among_prisms_is_at_or_above_the_ceiling() {
    both_answers(5_000, 14, |random| {
        let prisms = crossing_prisms(random);
        let (uav, receiver) = (crossing_prism_end(random), crossing_prism_end(random));
        let stretched = |scale: i64| moved(&prisms, |p| p, |top| top * scale);
        let ceiling = prisms_ceiling(&prisms, uav, plan(receiver));
        let least = prisms_least_uav_height(&prisms, plan(uav), receiver);
        check_ceiling(&ceiling, |scale, z| {
            prisms_los(&stretched(scale), at_height(plan(uav), uav[2] * scale), at_height(plan(receiver), z))
        });
        check_ceiling(&least, |scale, z| {
            prisms_los(&stretched(scale), at_height(plan(uav), z), at_height(plan(receiver), receiver[2] * scale))
        });
        let los = prisms_los(&prisms, uav, receiver);
        if uav != receiver {
            assert_eq!([los; 2], [reaches(receiver[2], &ceiling), reaches(uav[2], &least)]);
        }
        if plan(uav) != plan(receiver) {
            assert_eq!(least, prisms_ceiling(&prisms, receiver, plan(uav)), "swapped");
        }
        los
    });
}

fn reaches(z: i64, ceiling: &Ceiling) -> bool {
    Ceiling::At(Ratio::from(BigInt::from(z))) >= *ceiling
}
