//! The oracle proves itself on rasters small enough to compute by hand.

use num_bigint::BigInt;
use num_rational::Ratio;

use crate::oracle::{Ceiling, Columns, P3, Prism, columns_ceiling, columns_least_uav_height, columns_los, prisms_los};
use crate::shapes::{M, moved, plan, raised, rectangle};

// ---------------------------------------------------------------------------------------------------------------------
// Scenes in meters and cells.

/// Marks nodata in a grid of heights.
const NODATA: i64 = i64::MIN;

/// A raster from heights in meters, the northern row first.
fn grid(rows: &[&[i64]]) -> Columns {
    let cell = |&height: &i64| if height == NODATA { None } else { Some(height * M) };
    let heights = rows.iter().flat_map(|row| row.iter().map(cell)).collect();
    Columns { n_cols: rows[0].len(), n_rows: rows.len(), heights }
}

/// A point from half meters or half cells east and north, and meters up.
pub(crate) fn halves(x: i64, y: i64, z: i64) -> P3 {
    [x * M / 2, y * M / 2, z * M]
}

/// A point in meters.
pub(crate) fn meters(x: i64, y: i64, z: i64) -> P3 {
    [x * M, y * M, z * M]
}

/// A prism over one ring in meters.
pub(crate) fn prism(ring: &[[i64; 2]], top: i64) -> Prism {
    moved(&[crate::shapes::prism(ring, top)], |p| p.map(|c| c * M), |top| top * M).remove(0)
}

/// A prism over a rectangle in meters.
pub(crate) fn block(west: i64, south: i64, east: i64, north: i64, top: i64) -> Prism {
    prism(&rectangle(west, south, east, north), top)
}

/// A ceiling of num/den meters.
pub(crate) fn at(num: i64, den: i64) -> Ceiling {
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
