//! The oracle proves itself on prisms small enough to compute by hand.

use crate::oracle::{Ceiling, Prism, prisms_ceiling, prisms_cover, prisms_least_uav_height, prisms_los};
use crate::oracle_proof::{at, block, meters, prism};
use crate::shapes::{M, plan, rectangle};

#[test]
fn the_shadow_of_a_box_ends_on_its_closed_form_length() {
    // UAV 50 high over x = 0, box 20 high to x = 60: the shadow ends at 60 * 50 / (50 - 20) = 100.
    let scene = [block(40, -5, 60, 5, 20)];
    let uav = meters(0, 0, 50);
    assert!(prisms_los(&scene, uav, meters(100, 0, 0)));
    assert!(!prisms_los(&scene, uav, [100 * M - 1, 0, 0]));
    // It starts at the wall that faces the UAV, and includes the inside.
    assert!(prisms_los(&scene, uav, meters(40, 0, 0)));
    assert!(!prisms_los(&scene, uav, [40 * M + 1, 0, 0]));
    // In front of the box all is clear; on the roof as well.
    assert!(prisms_los(&scene, uav, meters(39, 0, 0)));
    assert!(prisms_los(&scene, uav, meters(50, 0, 20)));
}

#[test]
fn the_side_of_a_shadow_is_clear() {
    // The ray over the corner (20, 5) goes on along y = x / 4. The box is below that line, and touched in one point.
    let scene = [block(10, -5, 20, 5, 20)];
    let uav = meters(0, 0, 10);
    assert!(prisms_los(&scene, uav, meters(10, 5, 0)));
    // The corner (10, 5) is the tangent one: the line y = x / 2 only touches there.
    assert!(prisms_los(&scene, uav, meters(40, 20, 0)));
    assert!(!prisms_los(&scene, uav, [40 * M, 20 * M - 1, 0]));
    assert!(prisms_los(&scene, uav, [40 * M, 20 * M + 1, 0]));
}

#[test]
fn above_and_at_and_below_roof_height_a_uav_over_a_house_differs() {
    // Box to x = 10, UAV at x = 5, receiver at x = 25: the edge is a quarter of the way.
    let scene = [block(0, -5, 10, 5, 20)];
    // 8 above the roof: 28 - 8 * 4 = -4.
    assert_eq!(prisms_ceiling(&scene, meters(5, 0, 28), plan(meters(25, 0, 0))), at(-4, 1));
    // At the roof nothing below it is seen.
    assert_eq!(prisms_ceiling(&scene, meters(5, 0, 20), plan(meters(25, 0, 0))), at(20, 1));
    assert!(prisms_los(&scene, meters(5, 0, 20), meters(25, 0, 20)));
    assert!(!prisms_los(&scene, meters(5, 0, 20), [25 * M, 0, 20 * M - 1]));
    // Inside nothing is seen at all.
    assert_eq!(prisms_ceiling(&scene, meters(5, 0, 19), plan(meters(25, 0, 0))), Ceiling::Never);
    // On the roof's edge, looking away, all is seen.
    assert_eq!(prisms_ceiling(&scene, meters(10, 0, 20), plan(meters(25, 0, 0))), Ceiling::Clear);
}

#[test]
fn behind_a_roof_above_the_uav_the_ceiling_rises_from_the_near_wall() {
    // UAV 10 high, roof 20 from x = 10 on: at x = 40, 10 + 10 * 40 / 10 = 50; over the roof at x = 12, 10 + 12 = 22.
    let scene = [block(10, -5, 20, 5, 20)];
    let uav = meters(0, 0, 10);
    assert_eq!(prisms_ceiling(&scene, uav, plan(meters(40, 0, 0))), at(50, 1));
    assert_eq!(prisms_ceiling(&scene, uav, plan(meters(12, 0, 0))), at(22, 1));
    assert_eq!(prisms_ceiling(&scene, uav, plan(meters(10, 0, 0))), Ceiling::Clear);
    // For a receiver at (40, 0, 30) the UAV must be so high that z(10) >= 20 and
    // z(20) >= 20. 30 - 10 * 40 / 30 = 50/3 for the near wall, 30 - 10 * 40 / 20 = 10 for the far one.
    assert_eq!(prisms_least_uav_height(&scene, [0, 0], meters(40, 0, 30)), at(50, 3));
}

#[test]
fn equal_houses_that_share_a_wall_block_along_it_up_to_the_roof() {
    let scene = [block(10, -5, 20, 0, 12), block(10, 0, 20, 5, 12)];
    assert!(!prisms_los(&scene, meters(0, 0, 5), meters(30, 0, 5)));
    assert!(!prisms_los(&scene, [0, 0, 12 * M - 1], [30 * M, 0, 12 * M - 1]));
    assert!(prisms_los(&scene, meters(0, 0, 12), meters(30, 0, 12)));
}

#[test]
fn unequal_houses_that_share_a_wall_block_along_it_up_to_the_lower_roof() {
    let scene = [block(10, -5, 20, 0, 12), block(10, 0, 20, 5, 7)];
    assert!(prisms_los(&scene, meters(0, 0, 7), meters(30, 0, 7)));
    assert!(!prisms_los(&scene, [0, 0, 7 * M - 1], [30 * M, 0, 7 * M - 1]));
    // One unit to the side of the higher house its roof counts, to the other side 7.
    assert!(!prisms_los(&scene, [0, -1, 7 * M], [30 * M, -1, 7 * M]));
    assert!(prisms_los(&scene, [0, 1, 7 * M], [30 * M, 1, 7 * M]));
}

#[test]
fn a_ray_along_a_wall_that_is_not_shared_is_free() {
    let scene = [block(10, -5, 20, 5, 12)];
    for y in [-5, 5] {
        assert!(prisms_los(&scene, meters(0, y, 1), meters(30, y, 1)));
        assert_eq!(prisms_ceiling(&scene, meters(0, y, 1), plan(meters(30, y, 0))), Ceiling::Clear);
    }
    // Ends on the wall itself, and in its corners.
    assert!(prisms_los(&scene, meters(10, 5, 1), meters(20, 5, 1)));
    assert!(prisms_los(&scene, meters(12, 5, 1), meters(18, 5, 1)));
}

#[test]
fn walls_that_meet_in_a_t_junction_are_shared_where_they_overlap() {
    // South: x = 0..30. North: x = 0..14 and x = 16..30. Along y = 0 only 14..16 is free.
    let scene = [block(0, -10, 30, 0, 9), block(0, 0, 14, 10, 9), block(16, 0, 30, 10, 9)];
    assert!(prisms_los(&scene, meters(14, 0, 1), meters(16, 0, 1)));
    assert!(!prisms_los(&scene, meters(13, 0, 1), meters(15, 0, 1)));
    assert!(!prisms_los(&scene, meters(15, 0, 1), meters(17, 0, 1)));
    assert!(!prisms_los(&scene, meters(-5, 0, 1), meters(35, 0, 1)));
    // Through the alley x = 15 to the southern wall, seen from the north, and no further.
    assert!(prisms_los(&scene, meters(15, 20, 1), meters(15, 0, 1)));
    assert!(!prisms_los(&scene, meters(15, 20, 1), [15 * M, -1, M]));
    // If the two northern houses touch at x = 15, the T is closed: all of y = 0 is inside.
    let closed = [block(0, -10, 30, 0, 9), block(0, 0, 15, 10, 9), block(15, 0, 30, 10, 9)];
    assert!(!prisms_los(&closed, meters(14, 0, 1), meters(16, 0, 1)));
    assert!(prisms_cover(&closed, [15 * M, 0], 9 * M - 1));
    assert!(!prisms_cover(&closed, [15 * M, 0], 9 * M));
}

#[test]
fn the_two_triangles_of_a_square_are_one_solid() {
    let halves_of_square = |south_east: i64, north_west: i64| {
        [prism(&[[0, 0], [10, 0], [10, 10]], south_east), prism(&[[0, 0], [10, 10], [0, 10]], north_west)]
    };
    // Along the diagonal and across it.
    assert!(!prisms_los(&halves_of_square(8, 8), meters(-5, -5, 7), meters(15, 15, 7)));
    assert!(prisms_los(&halves_of_square(8, 8), meters(-5, -5, 8), meters(15, 15, 8)));
    assert!(!prisms_los(&halves_of_square(8, 8), meters(-5, 15, 7), meters(15, -5, 7)));
    // With roofs of 8 and 6 the diagonal is free from 6 on, the way across from 8 on.
    assert!(prisms_los(&halves_of_square(8, 6), meters(-5, -5, 6), meters(15, 15, 6)));
    assert!(!prisms_los(&halves_of_square(8, 6), [-5 * M, -5 * M, 6 * M - 1], [15 * M, 15 * M, 6 * M - 1]));
    assert!(!prisms_los(&halves_of_square(8, 6), meters(-5, 15, 6), meters(15, -5, 6)));
}

/// A square ring, in meters.
fn square(low: i64, high: i64) -> Vec<[i64; 2]> {
    rectangle(low * M, low * M, high * M, high * M)
}

#[test]
fn a_courtyard_is_open_and_its_walls_are_not() {
    let scene = [Prism { rings: vec![square(0, 30), square(10, 20)], top: 10 * M }];
    // Within the yard, along its walls, and across it from corner to corner.
    assert!(prisms_los(&scene, meters(11, 11, 1), meters(19, 15, 1)));
    assert!(prisms_los(&scene, meters(10, 10, 1), meters(20, 10, 1)));
    assert!(prisms_los(&scene, meters(10, 10, 1), meters(20, 20, 1)));
    // From the yard through the house, and along the line of the yard's wall into the house.
    assert!(!prisms_los(&scene, meters(15, 15, 1), meters(40, 15, 1)));
    assert!(!prisms_los(&scene, meters(10, 10, 1), meters(21, 10, 1)));
    // From outside: the roof is left at x = 10, z_u = 40 at x = -20, so at x = 15 40 - 30 * 35 / 30 = 5.
    assert_eq!(prisms_ceiling(&scene, meters(-20, 15, 40), plan(meters(15, 15, 0))), at(5, 1));
}

#[test]
fn winding_and_order_of_rings_do_not_matter() {
    // The square ring runs counterclockwise; the hole either way, and before or after the shell.
    let (shell, hole) = (square(0, 30), square(10, 20));
    let turned = |ring: &[[i64; 2]]| ring.iter().rev().copied().collect::<Vec<_>>();
    for rings in [
        vec![shell.clone(), hole.clone()],
        vec![shell.clone(), turned(&hole)],
        vec![turned(&shell), hole.clone()],
        vec![hole, shell],
    ] {
        let scene = [Prism { rings, top: 10 * M }];
        assert!(prisms_los(&scene, meters(11, 11, 1), meters(19, 15, 1)));
        assert!(!prisms_los(&scene, meters(15, 15, 1), meters(40, 15, 1)));
    }
}

#[test]
fn a_ring_walked_through_a_slit_is_a_house_with_a_yard() {
    // In to the yard and back along y = 15, x = 0..10: both sides are solid, so the slit is inside.
    let shell = [[0, 15], [0, 0], [30, 0], [30, 30], [0, 30], [0, 15]];
    let yard = [[10, 15], [10, 20], [20, 20], [20, 10], [10, 10], [10, 15]];
    let scene = [prism(&[shell, yard].concat(), 10)];
    assert!(!prisms_los(&scene, meters(-5, 15, 1), meters(15, 15, 1)));
    assert!(!prisms_los(&scene, meters(2, 15, 1), meters(8, 15, 1)));
    assert!(prisms_cover(&scene, [5 * M, 15 * M], 9 * M));
    assert!(prisms_los(&scene, meters(10, 15, 1), meters(20, 15, 1)));
}

#[test]
fn a_bow_tie_is_two_triangles_that_touch() {
    let scene = [prism(&[[0, 0], [10, 10], [10, 0], [0, 10]], 10)];
    // Its wings are west and east of (5, 5): through the knot from south to north is free, from west to east is not.
    assert!(prisms_los(&scene, meters(5, -5, 1), meters(5, 15, 1)));
    assert!(!prisms_los(&scene, meters(-5, 5, 1), meters(15, 5, 1)));
    // Along its diagonals one side is open all the way.
    assert!(prisms_los(&scene, meters(-5, -5, 1), meters(15, 15, 1)));
    assert!(prisms_los(&scene, meters(-5, 15, 1), meters(15, -5, 1)));
    // Beside the knot, at x = 5 + 1 unit, the eastern wing is cut.
    assert!(!prisms_los(&scene, [5 * M + 1, -5 * M, M], [5 * M + 1, 15 * M, M]));
    assert!(!prisms_cover(&scene, [5 * M, 5 * M], -99 * M));
    assert!(prisms_cover(&scene, [4 * M, 5 * M], 9 * M));
}

#[test]
fn overlapping_prisms_count_with_the_higher_roof() {
    // Tops 10 over x = 0..10, 20 over x = 5..15: 20 counts from x = 5 on.
    let scene = [block(0, -5, 10, 5, 10), block(5, -5, 15, 5, 20)];
    assert!(prisms_los(&scene, meters(-5, 0, 10), meters(5, 0, 10)));
    assert!(!prisms_los(&scene, meters(-5, 0, 19), meters(20, 0, 19)));
    assert!(prisms_los(&scene, meters(-5, 0, 20), meters(20, 0, 20)));
    // x = 5 has 10 on its western side and 20 on the other: a ray along it is free from 10 on.
    assert!(prisms_los(&scene, meters(5, -9, 10), meters(5, 9, 10)));
    assert!(!prisms_los(&scene, [5 * M, -9 * M, 10 * M - 1], [5 * M, 9 * M, 10 * M - 1]));
    // The same prism twice is the prism.
    let twice = [block(0, -5, 10, 5, 10), block(0, -5, 10, 5, 10)];
    assert!(!prisms_los(&twice, meters(-5, 0, 9), meters(20, 0, 9)));
    assert!(prisms_los(&twice, meters(-5, 5, 9), meters(20, 5, 9)));
}

#[test]
fn three_prisms_that_meet_in_a_point_are_open_between_them() {
    // Sectors around the origin, open between them: east (y between x/5 and -x/5), north-west, south-west.
    let scene = [
        prism(&[[0, 0], [10, -2], [10, 2]], 10),
        prism(&[[0, 0], [-2, 10], [-10, 8]], 10),
        prism(&[[0, 0], [-10, -8], [-2, -10]], 10),
    ];
    // From the north-north-east to the south-south-west passes between east and north-west, and in the south-west.
    assert!(!prisms_los(&scene, meters(3, 4, 1), meters(-3, -4, 1)));
    // From the west to the north-east: (-10, -2) to (10, 2) ends on the eastern prism's edge and runs along it.
    assert!(prisms_los(&scene, meters(-10, -2, 1), meters(10, 2, 1)));
    // From the south to the north.
    assert!(prisms_los(&scene, meters(0, -9, 1), meters(0, 9, 1)));
    // The origin itself is not inside, and a vertical link there is clear.
    assert!(!prisms_cover(&scene, [0, 0], -M));
    assert!(prisms_los(&scene, meters(0, 0, 20), meters(0, 0, 0)));
    // With the gaps filled by prisms of 4 it is inside up to 4.
    let gaps = [[[0, 0], [10, 2], [-2, 10]], [[0, 0], [-10, 8], [-10, -8]], [[0, 0], [-2, -10], [10, -2]]];
    let filled = [scene, gaps.map(|gap| prism(&gap, 4))].concat();
    assert!(prisms_cover(&filled, [0, 0], 4 * M - 1));
    assert!(!prisms_cover(&filled, [0, 0], 4 * M));
    assert_eq!(prisms_ceiling(&filled, meters(0, 0, 20), [0, 0]), at(4, 1));
}

#[test]
fn a_link_straight_down_asks_for_the_open_side_of_a_wall() {
    let scene = [block(10, -5, 20, 0, 12), block(10, 0, 20, 5, 7)];
    // Inside either house; on their shared wall; on a free wall; in a corner; on the end of the shared wall; outside.
    for (x, y, ceiling) in [
        (15, -2, at(12, 1)),
        (15, 2, at(7, 1)),
        (15, 0, at(7, 1)),
        (15, 5, Ceiling::Clear),
        (20, 5, Ceiling::Clear),
        (20, 0, Ceiling::Clear),
        (25, 0, Ceiling::Clear),
    ] {
        assert_eq!(prisms_ceiling(&scene, meters(x, y, 50), plan(meters(x, y, 0))), ceiling, "at {x}, {y}");
        let is_clear = ceiling == Ceiling::Clear;
        assert_eq!(prisms_los(&scene, meters(x, y, 50), meters(x, y, 0)), is_clear, "at {x}, {y}");
    }
    // Upward, from 7 on the shared wall; from below 7 the link starts inside.
    assert!(prisms_los(&scene, meters(15, 0, 7), meters(15, 0, 50)));
    assert!(!prisms_los(&scene, [15 * M, 0, 7 * M - 1], meters(15, 0, 50)));
    assert_eq!(prisms_ceiling(&scene, meters(15, 0, 6), [15 * M, 0]), Ceiling::Never);
}

#[test]
fn no_prism_is_exempt() {
    let scene = [block(0, 0, 10, 10, 8)];
    // Receiver inside: the end of the ray is below the roof.
    assert!(!prisms_los(&scene, meters(5, -50, 60), meters(5, 5, 0)));
    // Receiver on the roof; and on the outer wall at the UAV's side.
    assert!(prisms_los(&scene, meters(5, -50, 60), meters(5, 5, 8)));
    assert!(prisms_los(&scene, meters(5, -50, 60), meters(5, 0, 0)));
    // UAV inside, receiver inside the same prism.
    assert!(!prisms_los(&scene, meters(5, 5, 5), meters(6, 6, 0)));
}

#[test]
fn a_ray_through_a_vertex_counts_it_once() {
    // A diamond: the ray along y = 0 passes its western and eastern vertex and its inside.
    let diamond = [prism(&[[0, 0], [10, -10], [20, 0], [10, 10]], 8)];
    assert!(!prisms_los(&diamond, meters(-10, 0, 1), meters(30, 0, 1)));
    // It touches the northern vertex along y = 10.
    assert!(prisms_los(&diamond, meters(-10, 10, 1), meters(30, 10, 1)));
    // A notch: along y = 5 the ray is inside from x = 0 to 10 but for the touching tip of the notch at (5, 5).
    let notched = [prism(&[[0, 0], [10, 0], [10, 10], [5, 5], [0, 10]], 8)];
    assert!(!prisms_los(&notched, meters(-10, 5, 1), meters(20, 5, 1)));
    // It leaves the notch by its tip along x = 5 from the north; south of it the ray is inside.
    assert!(prisms_los(&notched, meters(5, 20, 1), meters(5, 5, 1)));
    assert!(!prisms_los(&notched, meters(5, 20, 1), [5 * M, 5 * M - 1, M]));
}

#[test]
fn rings_without_area_block_nothing() {
    // A segment walked to and fro, a point, an empty ring, a ring walked twice.
    for rings in [
        vec![vec![[0, 0], [10 * M, 0]]],
        vec![vec![[5 * M, 0]]],
        vec![vec![]],
        vec![],
        vec![vec![[0, -M], [10 * M, -M], [5 * M, M], [0, -M], [10 * M, -M], [5 * M, M]]],
    ] {
        let scene = [Prism { rings, top: 10 * M }];
        assert!(prisms_los(&scene, meters(-5, 0, 1), meters(15, 0, 1)));
        assert!(prisms_los(&scene, meters(5, -5, 1), meters(5, 5, 1)));
        assert!(prisms_los(&scene, meters(5, 0, 20), meters(5, 0, 0)));
    }
}

#[test]
fn a_house_of_one_lattice_unit_throws_its_shadow_from_20_km() {
    // The house is 1/1024 m wide at x = 1 m and 10 m high; the UAV is 100 m west of it, at x = -99 m. Behind its far
    // wall, at x = 1025 units, the shadow ends at distance d from the UAV with 20480000 (d - 102401) / d = 10240, so
    // d = 102401 * 20480000 / 20469760 = 102401 * 2000 / 1999 = 102452.2...
    let house = [Prism { rings: vec![vec![[1024, -9], [1025, -9], [1025, 9], [1024, 9]]], top: 10 * M }];
    let uav = [-99 * M, 0, 20_480_000];
    assert!(!prisms_los(&house, uav, [-99 * M + 102_452, 0, 0]));
    assert!(prisms_los(&house, uav, [-99 * M + 102_453, 0, 0]));
}

#[test]
fn inputs_too_large_for_machine_integers_are_decided_exactly() {
    // A box of side s and height s, s = 2^60, UAV 2 s high at x = -s: its far edge is two
    // thirds of the way to x = 2 s, so z(s) = 2 s / 3; the receiver must be 2 s - s * 3 / 2 = s / 2 high.
    let s = 1_i64 << 60;
    let scene = [Prism { rings: vec![vec![[0, -s], [s, -s], [s, s], [0, s]]], top: s }];
    let uav = [-s, 1, 2 * s];
    assert!(prisms_los(&scene, uav, [2 * s, 1, s / 2]));
    assert!(!prisms_los(&scene, uav, [2 * s, 1, s / 2 - 1]));
}
