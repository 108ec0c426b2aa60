//! The oracle proves itself: first on scenes small enough to compute by hand, then against two brute-force twins
//! that decide in other ways, then on what must not change or can only change one way.

use num_bigint::BigInt;
use num_rational::Ratio;

use super::oracle::{
    Ceiling, Columns, P3, Prism, columns_ceiling, columns_least_uav_height, columns_los, prisms_ceiling, prisms_cover,
    prisms_least_uav_height, prisms_los,
};

// ---------------------------------------------------------------------------------------------------------------------
// Scenes in meters and cells.

/// Meters or cells in lattice units.
const M: i64 = 1024;

/// Marks nodata in a grid of heights.
const NODATA: i64 = i64::MIN;

/// A raster from heights in meters, the northern row first.
fn grid(rows: &[&[i64]]) -> Columns {
    let cell = |&height: &i64| if height == NODATA { None } else { Some(height * M) };
    let heights = rows.iter().flat_map(|row| row.iter().map(cell)).collect();
    Columns { n_cols: rows[0].len(), n_rows: rows.len(), heights }
}

/// A point from half meters or half cells east and north, and meters up.
fn halves(x: i64, y: i64, z: i64) -> P3 {
    [x * M / 2, y * M / 2, z * M]
}

/// A point in meters.
fn meters(x: i64, y: i64, z: i64) -> P3 {
    [x * M, y * M, z * M]
}

/// The same point some lattice units higher.
fn raised([x, y, z]: P3, units: i64) -> P3 {
    [x, y, z + units]
}

fn plan([x, y, _]: P3) -> [i64; 2] {
    [x, y]
}

/// A prism over one ring in meters.
fn prism(ring: &[[i64; 2]], top: i64) -> Prism {
    Prism { rings: vec![ring.iter().map(|vertex| vertex.map(|c| c * M)).collect()], top: top * M }
}

/// A prism over a rectangle in meters.
fn block(west: i64, south: i64, east: i64, north: i64, top: i64) -> Prism {
    prism(&[[west, south], [east, south], [east, north], [west, north]], top)
}

/// A ceiling of num/den meters.
fn at(num: i64, den: i64) -> Ceiling {
    Ceiling::At(Ratio::new(BigInt::from(num * M), BigInt::from(den)))
}

// ---------------------------------------------------------------------------------------------------------------------
// By hand: rasters.

#[test]
fn an_empty_street_is_clear() {
    // Both ends at 0 over columns of 0: the ray grazes the ground everywhere, and touching is LoS.
    let street = grid(&[&[0, 0, 0, 0]]);
    assert!(columns_los(&street, halves(1, 1, 0), halves(7, 1, 0)));
    assert!(columns_los(&street, halves(1, 1, 9), halves(7, 1, 0)));
}

#[test]
fn a_ray_under_the_ground_is_blocked() {
    // From 2 m down to -2 m over columns of 0: below 0 from half way on, and the second cell is not exempt.
    assert!(!columns_los(&grid(&[&[0, 0, 0, 0]]), halves(1, 1, 2), halves(7, 1, -2)));
    // Over nodata there is no ground.
    assert!(columns_los(&grid(&[&[0, NODATA, NODATA, NODATA]]), halves(1, 1, 2), halves(7, 1, -2)));
}

#[test]
fn the_shadow_of_a_wall_has_the_length_of_similar_triangles() {
    // UAV 30 high over x = 0.5, wall 10 high to x = 3. The ray over the far edge loses 20 in 2.5 cells, 8 to the cell,
    // and reaches the ground after 30 / 8 = 3.75 cells, at x = 4.25 = 4352 / 1024.
    let street = grid(&[&[0, 0, 10, 0, 0, 0]]);
    let uav = halves(1, 1, 30);
    assert!(columns_los(&street, uav, [4352, 512, 0]));
    assert!(!columns_los(&street, uav, [4351, 512, 0]));
    assert!(columns_los(&street, uav, [4353, 512, 0]));
}

#[test]
fn grazing_a_roof_edge_is_clear_and_one_unit_lower_is_not() {
    // z(3) = 20 - (20 - z) * 2.5 / 4 = 10 for z = 4.
    let street = grid(&[&[0, 0, 10, 0, 0]]);
    let (uav, receiver) = (halves(1, 1, 20), halves(9, 1, 4));
    assert_eq!(columns_ceiling(&street, uav, plan(receiver)), at(4, 1));
    assert!(columns_los(&street, uav, raised(receiver, 1)));
    assert!(columns_los(&street, uav, receiver));
    assert!(!columns_los(&street, uav, raised(receiver, -1)));
    // The UAV one unit lower: z(3) falls by 1.5 / 4 of a unit.
    assert!(!columns_los(&street, raised(uav, -1), receiver));
    assert_eq!(columns_least_uav_height(&street, plan(uav), receiver), at(20, 1));
}

#[test]
fn behind_a_wall_above_the_uav_its_near_edge_sets_the_ceiling() {
    // UAV 5 high on x = 1, wall 10 high from x = 2 on, receiver at x = 4.5: 5 + 5 * 3.5 / 1 = 22.5.
    let street = grid(&[&[0, 0, 10, 0, 0]]);
    let (uav, receiver) = ([1024, 512, 5 * M], [4608, 512, 22 * M + 512]);
    assert_eq!(columns_ceiling(&street, uav, plan(receiver)), at(45, 2));
    assert!(columns_los(&street, uav, receiver));
    assert!(!columns_los(&street, uav, raised(receiver, -1)));
}

#[test]
fn behind_a_wall_level_with_the_uav_the_ceiling_is_that_level() {
    // z_u + (H - z_u) / t = z_u = 10 for every t.
    let street = grid(&[&[0, 0, 10, 0, 0]]);
    assert_eq!(columns_ceiling(&street, halves(1, 1, 10), plan(halves(9, 1, 0))), at(10, 1));
}

#[test]
fn the_highest_of_several_demands_is_the_ceiling() {
    // UAV 40 high at x = 0.5, receiver at x = 6.5, columns to x = 2 (24) and x = 5 (12):
    // 40 - 16 * 6 / 1.5 = -24 and 40 - 28 * 6 / 4.5 = 8/3. The ground up to x = 6 asks for 40 - 40 * 6 / 5.5 = -40/11.
    let street = grid(&[&[0, 24, 0, 0, 12, 0, 0]]);
    assert_eq!(columns_ceiling(&street, halves(1, 1, 40), plan(halves(13, 1, 0))), at(8, 3));
}

#[test]
fn a_receiver_above_the_uav_can_be_hidden_and_seen() {
    // UAV 2 high at x = 0.5, column 6 high over 1..2, receiver at x = 2.5.
    // Its near edge is a quarter of the way: 2 + 4 * 4 = 18.
    let street = grid(&[&[0, 6, 0]]);
    assert_eq!(columns_ceiling(&street, halves(1, 1, 2), plan(halves(5, 1, 0))), at(18, 1));
    assert!(!columns_los(&street, halves(1, 1, 2), halves(5, 1, 17)));
    assert!(columns_los(&street, halves(1, 1, 2), halves(5, 1, 18)));
}

#[test]
fn a_ray_passes_where_two_cells_touch_corner_to_corner() {
    // The line x = y meets the two high cells in (1, 1) only, the other two are 0.
    let checkers = grid(&[&[10, 0], &[0, 10]]);
    assert!(columns_los(&checkers, halves(1, 1, 1), halves(3, 3, 1)));
    // At height 0 it grazes the ground of the south-western cell.
    assert!(columns_los(&checkers, halves(1, 1, 0), halves(3, 3, 0)));
    // One unit to either side it cuts a high cell.
    assert!(!columns_los(&checkers, halves(1, 1, 1), [1536, 1537, M]));
    assert!(!columns_los(&checkers, halves(1, 1, 1), [1537, 1536, M]));
    // The other diagonal runs inside the high cells; the UAV's own is not exempt.
    assert!(!columns_los(&checkers, halves(1, 3, 1), halves(3, 1, 1)));
}

#[test]
fn a_ray_along_a_grid_line_is_decided_by_the_lower_side() {
    // Along y = 1, columns north and south: (3, 8), (8, 3), (5, 5) over x = 0..3; the lower are 3, 3, 5.
    // The receiver at x = 2.5 exempts the last pair.
    let rows = grid(&[&[3, 8, 5], &[8, 3, 5]]);
    assert!(columns_los(&rows, [256, 1024, 3 * M], [2560, 1024, 3 * M]));
    assert!(!columns_los(&rows, [256, 1024, 3 * M], [2560, 1024, 3 * M - 1]));
    // At x = 3.5, outside the raster, nothing is exempt and 5 counts as well, at its near edge, as it is above the UAV:
    // x from 0.25 to 3.5, near edge 2: 3 + 2 * 3.25 / 1.75 = 47/7.
    assert_eq!(columns_ceiling(&rows, [256, 1024, 3 * M], [3584, 1024]), at(47, 7));
}

#[test]
fn the_border_of_the_raster_is_a_free_wall_on_all_four_sides() {
    // All four border lines have the outside on one side; one unit further in, z = 1 < 9 blocks.
    let town = grid(&[&[9, 9], &[9, 9]]);
    for (uav, receiver, inward) in [
        ([-1024, 0, M], [3072, 0, M], [0, 1]),
        ([-1024, 2048, M], [3072, 2048, M], [0, -1]),
        ([0, -1024, M], [0, 3072, M], [1, 0]),
        ([2048, -1024, M], [2048, 3072, M], [-1, 0]),
    ] {
        assert!(columns_los(&town, uav, receiver));
        let shifted = |p: P3| [p[0] + inward[0], p[1] + inward[1], p[2]];
        assert!(!columns_los(&town, shifted(uav), shifted(receiver)));
    }
}

#[test]
fn outside_the_raster_nothing_blocks() {
    let town = grid(&[&[9]]);
    // The whole link is west of x = 0.
    assert!(columns_los(&town, meters(-2, 0, -50), meters(-1, 1, -50)));
    // It touches the raster in its south-western corner only: x + y = 0.
    assert!(columns_los(&town, meters(-1, 1, 0), meters(1, -1, 0)));
    // It crosses the raster from x = 0 to 1 at z = 5 < 9.
    assert!(!columns_los(&town, [-1024, 512, 5 * M], [2048, 512, 5 * M]));
}

#[test]
fn nodata_blocks_nothing_at_any_height() {
    // The UAV is on the edge x = 1 and leaves its column of 9 at once.
    let gap = grid(&[&[9, NODATA, NODATA, 9]]);
    assert_eq!(columns_ceiling(&gap, [1024, 512, 0], [3072, 512]), Ceiling::Clear);
    // From the middle of the column it does not: t = 0 is in the column, and 0 < 9.
    assert_eq!(columns_ceiling(&gap, [512, 512, 0], [3072, 512]), Ceiling::Never);
}

#[test]
fn a_raster_of_one_cell_never_blocks_its_own_receivers() {
    let one = grid(&[&[50]]);
    assert!(columns_los(&one, halves(9, 1, 3), halves(1, 1, 0)));
    // On its edge and on its corner the receiver still is in the closed square.
    assert!(columns_los(&one, halves(-9, 1, 3), halves(2, 1, 0)));
    assert!(columns_los(&one, halves(-9, -9, 3), halves(2, 2, 0)));
    // One unit past the edge it is not: the ray crosses x = 0..1 at most 3 high.
    assert!(!columns_los(&one, halves(-9, 1, 3), [1025, 512, 0]));
}

#[test]
fn a_receiver_on_an_edge_exempts_both_cells_and_on_a_corner_four() {
    let town = grid(&[&[7, 7, 7], &[7, 7, 7], &[7, 7, 7]]);
    // Receiver at (1, 0.5), UAV to the west of the raster: cells 0 and 1 of the southern row are exempt.
    assert!(columns_los(&town, [-512, 512, 1], [1024, 512, 0]));
    // Receiver at (1, 1), UAV to the south-west: cells to all four sides are exempt.
    assert!(columns_los(&town, [-512, -512, 1], [1024, 1024, 0]));
    // At (1, 1) seen from the east, the cells beyond x = 2 remain: z is at most 1 unit < 7 m.
    assert!(!columns_los(&town, [4096, 1024, 1], [1024, 1024, 0]));
    // Seen from the east along y = 1.5, from (1, 1.5), the cell of x = 1..2 is exempt, that of x = 2..3 is not.
    assert!(!columns_los(&town, [4096, 1536, 1], [1024, 1536, 0]));
}

#[test]
fn the_uavs_own_cell_blocks_unless_the_receiver_shares_it() {
    // UAV on its roof of 10 in the middle of the cell: the ray to x = 2.5 leaves at t = 1/4.
    let roof = grid(&[&[10, 0, 0]]);
    // At the roof, only receivers at 10 or above are seen: at t = 0 the demand is met, at t = 1/4 it is 10.
    assert_eq!(columns_ceiling(&roof, halves(1, 1, 10), plan(halves(5, 1, 0))), at(10, 1));
    // 4 above it: 14 - 4 * 4 = -2, but the middle cell of 0 is left at t = 3/4 and asks for 14 - 14 * 4 / 3 = -14/3.
    assert_eq!(columns_ceiling(&roof, halves(1, 1, 14), plan(halves(5, 1, 0))), at(-2, 1));
    // Below it: never.
    assert_eq!(columns_ceiling(&roof, halves(1, 1, 9), plan(halves(5, 1, 0))), Ceiling::Never);
    // In the same cell, or on its edge, the cell is exempt.
    assert_eq!(columns_ceiling(&roof, halves(1, 1, 9), [100, 100]), Ceiling::Clear);
    assert_eq!(columns_ceiling(&roof, halves(1, 1, 9), [1024, 1000]), Ceiling::Clear);
}

#[test]
fn a_uav_below_all_roofs_sees_along_its_street_only() {
    // The middle row is a street of 0 between rows of 20.
    let canyon = grid(&[&[20, 20, 20, 20], &[0, 0, 0, 0], &[20, 20, 20, 20]]);
    let uav = halves(1, 3, 10);
    assert!(columns_los(&canyon, uav, halves(7, 3, 0)));
    // A diagonal within the street.
    assert!(columns_los(&canyon, [512, 1100, 10 * M], [3584, 2000, 0]));
    // Along the wall: y = 2 has 20 on one side and 0 on the other.
    assert!(columns_los(&canyon, [512, 2048, 10 * M], [3584, 2048, 0]));
    // Onto the roof behind the wall at y = 2: the ray to (3.5, 2.5) is at y = 2 half way, over x = 2; the cell
    // (0, 2) is entered there and is not the receiver's own, which is (0, 3). Its near edge asks for 10 + 10 * 2 = 30.
    assert_eq!(columns_ceiling(&canyon, uav, plan(halves(7, 5, 0))), at(30, 1));
}

#[test]
fn a_vertical_link_is_clear_in_a_raster() {
    // All the cells around it are exempt, whatever stands there.
    let town = grid(&[&[30, 40], &[50, 60]]);
    for [x, y] in [[512, 512], [1024, 512], [1024, 1024], [0, 0]] {
        assert!(columns_los(&town, [x, y, 20 * M], [x, y, 0]));
        assert_eq!(columns_ceiling(&town, [x, y, 0], [x, y]), Ceiling::Clear);
    }
}

#[test]
fn a_link_of_no_length_is_clear() {
    assert!(columns_los(&grid(&[&[30]]), halves(1, 1, 5), halves(1, 1, 5)));
    assert!(prisms_los(&[block(0, 0, 10, 10, 30)], meters(5, 5, 5), meters(5, 5, 5)));
}

#[test]
fn a_platform_at_20_km_is_decided_to_the_lattice_unit() {
    // x from 0.5 to 2 + k/1024 cells is 1536 + k units, the last k of them behind the wall of 30 m:
    // 20480000 k / (1536 + k) >= 30720 iff 20449280 k >= 47185920 iff k >= 2.307...
    let town = grid(&[&[0, 30, 0]]);
    let uav = [512, 512, 20_480_000];
    assert!(!columns_los(&town, uav, [2048 + 2, 512, 0]));
    assert!(columns_los(&town, uav, [2048 + 3, 512, 0]));
    // At k = 2 the ceiling is 20480000 - (20480000 - 30720) * 1538 / 1536 = 4093 + 1/3 units:
    // 20449280 * 1538 / 1536 = 20449280 + 20449280 / 768 = 20449280 + 26626 + 2/3.
    let ceiling = Ratio::new(BigInt::from(12280), BigInt::from(3));
    assert_eq!(columns_ceiling(&town, uav, [2050, 512]), Ceiling::At(ceiling));
    assert!(columns_los(&town, uav, [2050, 512, 4094]));
    assert!(!columns_los(&town, uav, [2050, 512, 4093]));
}

#[test]
fn a_steep_line_north_south_is_treated_like_one_east_west() {
    // The shadow test, turned: rows from north to south, UAV in the northernmost, 30 high, wall 10 high over y = 3..4.
    // Its far edge is 2.5 cells from the UAV at y = 5.5: the ground is reached 3.75 cells from it, at y = 1.75 = 1792.
    let street = grid(&[&[0], &[0], &[10], &[0], &[0], &[0]]);
    let uav = halves(1, 11, 30);
    assert!(columns_los(&street, uav, [512, 1792, 0]));
    assert!(!columns_los(&street, uav, [512, 1793, 0]));
}

// ---------------------------------------------------------------------------------------------------------------------
// By hand: prisms.

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

#[test]
fn a_courtyard_is_open_and_its_walls_are_not() {
    let mut house = block(0, 0, 30, 30, 10);
    house.rings.push(block(10, 10, 20, 20, 0).rings.remove(0));
    let scene = [house];
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
    let shell: Vec<[i64; 2]> = block(0, 0, 30, 30, 0).rings.remove(0);
    let hole: Vec<[i64; 2]> = block(10, 10, 20, 20, 0).rings.remove(0);
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
    let ring = [
        [0, 15],
        [0, 0],
        [30, 0],
        [30, 30],
        [0, 30],
        [0, 15],
        [10, 15],
        [10, 20],
        [20, 20],
        [20, 10],
        [10, 10],
        [10, 15],
    ];
    let scene = [prism(&ring, 10)];
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
    let mut filled = scene.to_vec();
    filled.push(prism(&[[0, 0], [10, 2], [-2, 10]], 4));
    filled.push(prism(&[[0, 0], [-10, 8], [-10, -8]], 4));
    filled.push(prism(&[[0, 0], [-2, -10], [10, -2]], 4));
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
