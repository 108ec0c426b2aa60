//! The outline of a building: onto the lattice, repaired by the even-odd rule, and the ground under it.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::Overlay;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::i_float::int::point::IntPoint;

use super::Ground;
use super::building::RawFootprint;
use crate::quantity::{Frame, VOID};
use crate::raster::Raster;

/// A footprint after rounding and repair.
pub(super) struct Shaped {
    pub(super) raw: RawFootprint,
    pub(super) polygons: Vec<Vec<Vec<[i32; 2]>>>,
    /// Which of the raw polygons were repaired.
    pub(super) repaired: Vec<usize>,
    /// Which of them have no area.
    pub(super) degenerate: Vec<usize>,
    pub(super) too_far: bool,
    /// The lowest ground under the footprint, `None` over nodata.
    pub(super) base: Option<i32>,
}

/// Brings a footprint onto the lattice, repairs its polygons and finds the ground under it.
pub(super) fn shape(raw: RawFootprint, ground: &Ground, frame: Frame) -> Shaped {
    let mut shaped =
        Shaped { polygons: Vec::new(), repaired: Vec::new(), degenerate: Vec::new(), too_far: false, base: None, raw };
    let limit = 1_i64 << 26;
    for (k, polygon) in shaped.raw.polygons.iter().enumerate() {
        let mut rings: Vec<Vec<[i32; 2]>> = Vec::new();
        for ring in polygon {
            let mut points: Vec<[i32; 2]> = Vec::with_capacity(ring.len());
            for &[x, y] in ring {
                let (x, y) = frame.lattice_from_world(x, y);
                if x.abs() > limit || y.abs() > limit {
                    shaped.too_far = true;
                    return shaped;
                }
                #[expect(clippy::cast_possible_truncation, reason = "within ±2^26 by the check above")]
                let point = [x as i32, y as i32];
                if points.last() != Some(&point) {
                    points.push(point);
                }
            }
            while points.len() > 1 && points.first() == points.last() {
                points.pop();
            }
            if points.len() >= 3 {
                rings.push(points);
            }
        }
        let (mended, repaired) = even_odd(&rings);
        if mended.is_empty() {
            shaped.degenerate.push(k);
        } else if repaired {
            shaped.repaired.push(k);
        }
        shaped.polygons.extend(mended);
    }
    shaped.base = match ground {
        Ground::Surface => None,
        Ground::Flat(z) => Some(*z),
        Ground::Terrain(terrain) => lowest_under(&shaped.raw.polygons, terrain),
    };
    shaped
}

/// The region that rings enclose by the even-odd rule, as polygons (shell first) whose edges do not cross, and whether
/// that changed the polygon.
///
/// Where edges cross off the lattice, the crossing is rounded to it and the edges bend by less than a step. Coordinates
/// are within ±2^26.
pub fn even_odd(rings: &[Vec<[i32; 2]>]) -> (Vec<Vec<Vec<[i32; 2]>>>, bool) {
    let contours: Vec<Vec<IntPoint<i32>>> =
        rings.iter().map(|r| r.iter().map(|p| IntPoint { x: p[0], y: p[1] }).collect()).collect();
    let shapes = Overlay::<i32>::from_subj(&contours).overlay(OverlayRule::Subject, FillRule::EvenOdd);
    let polygons: Vec<Vec<Vec<[i32; 2]>>> = shapes
        .into_iter()
        .map(|shape| shape.into_iter().map(|c| c.into_iter().map(|p| [p.x, p.y]).collect()).collect())
        .collect();
    // A valid polygon comes back with the area of its shell less that of its holes and with as many rings.
    let area = |ring: &Vec<[i32; 2]>| doubled_area(ring).abs();
    let before = rings.first().map_or(0, area) - rings.iter().skip(1).map(area).sum::<i64>();
    let after: i64 = polygons.iter().map(|p| area(&p[0]) - p[1..].iter().map(area).sum::<i64>()).sum();
    let n_rings: usize = polygons.iter().map(Vec::len).sum();
    let repaired = before != after || n_rings != rings.len();
    (polygons, repaired)
}

/// Twice the area of what some polygons (shell first, edges that do not cross) cover of a rectangle from its south-west to
/// its north-east corner; what several of them cover counts once.
///
/// Where edges cross off the lattice, the crossing is rounded to it. Coordinates are within ±2^26.
pub fn covered_area(polygons: &[&[Vec<[i32; 2]>]], [x0, y0, x1, y1]: [i32; 4]) -> u64 {
    // Wound alike, shells and holes add up to 1 inside each polygon and to 0 outside.
    let wound = |(k, ring): (usize, &Vec<[i32; 2]>)| {
        let mut points: Vec<IntPoint<i32>> = ring.iter().map(|p| IntPoint { x: p[0], y: p[1] }).collect();
        if (doubled_area(ring) > 0) != (k == 0) {
            points.reverse();
        }
        points
    };
    let contours: Vec<_> = polygons.iter().flat_map(|rings| rings.iter().enumerate().map(wound)).collect();
    let corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(|[x, y]| IntPoint { x, y });
    let clipped = Overlay::<i32>::from_subj_and_clip(&contours, &vec![corners.to_vec()])
        .overlay(OverlayRule::Intersect, FillRule::NonZero);
    let area = |contour: &Vec<IntPoint<i32>>| {
        doubled_area(&contour.iter().map(|p| [p.x, p.y]).collect::<Vec<_>>()).unsigned_abs()
    };
    clipped.iter().map(|shape| area(&shape[0]) - shape[1..].iter().map(area).sum::<u64>()).sum()
}

/// Twice the signed area of a ring of lattice points within ±2^26: below 2^55 for any ring that does not wind many
/// times, and only compared.
fn doubled_area(ring: &[[i32; 2]]) -> i64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter()
        .zip(next)
        .map(|(a, b)| i64::from(a[0]) * i64::from(b[1]) - i64::from(b[0]) * i64::from(a[1]))
        .fold(0, i64::wrapping_add)
}

#[expect(clippy::cast_precision_loss, reason = "reported as a share of area")]
pub(super) fn polygon_area(polygon: &[Vec<[i32; 2]>]) -> f64 {
    let area = |r: &Vec<[i32; 2]>| doubled_area(r).abs() as f64;
    polygon.first().map_or(0.0, area) - polygon.iter().skip(1).map(area).sum::<f64>()
}

/// The lowest terrain under a footprint: over the cells of its vertices and the cell centers inside.
///
/// OpenStreetMap measures `height` from the lowest point where the building meets the ground.
fn lowest_under(polygons: &[Vec<Vec<[f64; 2]>>], terrain: &Raster<i32>) -> Option<i32> {
    let georef = terrain.georef();
    let (n_rows, n_cols) = (georef.n_rows(), georef.n_cols());
    let mut lowest: Option<i32> = None;
    let mut meet = |height: i32| {
        if height != VOID {
            lowest = Some(lowest.map_or(height, |l| l.min(height)));
        }
    };
    for polygon in polygons {
        let in_cells: Vec<Vec<(f64, f64)>> =
            polygon.iter().map(|r| r.iter().map(|&[x, y]| georef.cells_from_world(x, y)).collect()).collect();
        let points = || in_cells.iter().flatten();
        for &(x, y) in points() {
            if x >= 0.0 && y >= 0.0 && x < n_cols as f64 && y < n_rows as f64 {
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "inside the grid")]
                let (col, from_south) = (x as usize, y as usize);
                meet(terrain.row(n_rows - 1 - from_south)[col]);
            }
        }
        let south = points().map(|p| p.1).fold(f64::INFINITY, f64::min).max(0.0);
        let north = points().map(|p| p.1).fold(f64::NEG_INFINITY, f64::max).min(n_rows as f64);
        if south >= north {
            continue;
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the grid")]
        let rows = south as usize..(north.ceil() as usize).min(n_rows);
        for from_south in rows {
            let y = from_south as f64 + 0.5;
            let mut crossings: Vec<f64> = Vec::new();
            for ring in &in_cells {
                for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                    if (a.1 <= y) != (b.1 <= y) {
                        crossings.push(a.0 + (y - a.1) / (b.1 - a.1) * (b.0 - a.0));
                    }
                }
            }
            crossings.sort_unstable_by(f64::total_cmp);
            for pair in crossings.chunks_exact(2) {
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the grid")]
                let (from, to) = (
                    (pair[0] + 0.5).floor().clamp(0.0, n_cols as f64) as usize,
                    (pair[1] + 0.5).floor().clamp(0.0, n_cols as f64) as usize,
                );
                terrain.row(n_rows - 1 - from_south)[from..to.max(from)].iter().for_each(|&h| meet(h));
            }
        }
    }
    lowest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::raster::GeoRef;

    #[test]
    fn a_bow_tie_becomes_two_triangles_and_counts_as_repaired() {
        let (polygons, repaired) = even_odd(&[vec![[0, 0], [200, 200], [200, 0], [0, 200]]]);
        assert!(repaired);
        let area: i64 = polygons.iter().flatten().map(|r| doubled_area(r).abs()).sum();
        assert_eq!((polygons.len(), area), (2, 40_000));
    }

    #[test]
    fn a_valid_polygon_with_a_hole_is_left_alone() {
        let rings = [vec![[0, 0], [90, 7], [100, 100], [3, 80]], vec![[40, 40], [40, 60], [60, 60]]];
        let (polygons, repaired) = even_odd(&rings);
        assert!(!repaired);
        assert_eq!(polygons.len(), 1);
        assert_eq!(polygons[0].len(), 2);
    }

    #[test]
    fn what_several_polygons_cover_counts_once_and_holes_count_as_they_are() {
        let square = |x: i32, y: i32, s: i32| vec![[x, y], [x + s, y], [x + s, y + s], [x, y + s]];
        let mut hole = square(2, 2, 4);
        // The first overlaps the second by 4 × 4; the hole, wound either way, is half covered by a third.
        for _ in 0..2 {
            let court = vec![square(0, 0, 8), hole.clone()];
            let (second, third) = (vec![square(4, 4, 8)], vec![square(2, 2, 2)]);
            let all: [&[Vec<[i32; 2]>]; 3] = [&court, &second, &third];
            // 64 − 16 of the first, 64 − (16 − 4 in the hole) of the second, 4 of the third in the hole.
            assert_eq!(covered_area(&all, [-100, -100, 100, 100]), 2 * (48 + 52 + 4));
            // Of 5 × 5 in its corner: less 3 × 3 of the hole, which the third covers by 2 × 2 and the second by 1.
            assert_eq!(covered_area(&all, [0, 0, 5, 5]), 2 * (25 - 9 + 4 + 1));
            hole.reverse();
        }
        assert_eq!(covered_area(&[], [0, 0, 5, 5]), 0);
    }

    #[test]
    fn a_hole_equal_to_its_shell_leaves_nothing() {
        let square = vec![[0, 0], [10, 0], [10, 10], [0, 10]];
        assert!(even_odd(&[square.clone(), square]).0.is_empty());
        assert!(even_odd(&[]).0.is_empty());
    }

    #[test]
    fn the_base_of_a_building_is_the_lowest_ground_under_it() {
        let grid = GeoRef::new((0.0, 4.0), (1.0, 1.0), (4, 4), None).expect("a valid grid");
        let terrain = Raster::new(grid, (0..16).collect::<Vec<_>>());
        // Columns 1–2, rows 1–2 from the north: values 5, 6, 9, 10; the vertex (3, 1) lies in cell (row 2, col 3).
        let ring = vec![[1.2, 1.2], [2.8, 1.2], [2.8, 2.8], [1.2, 2.8]];
        assert_eq!(lowest_under(&[vec![ring]], &terrain), Some(5));
        assert_eq!(lowest_under(&[vec![vec![[9.0, 9.0], [9.5, 9.0], [9.0, 9.5]]]], &terrain), None);
    }
}
