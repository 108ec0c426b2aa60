//! Polygons on the lattice: positions, rings, and regions without crossings.

use crate::overlay::{Polygon, Ring, Tangle, check_crossings, difference, doubled_area, even_odd};
use crate::quantity::Frame;

/// Largest coordinate of a position \[lattice steps\].
const LIMIT: i64 = 1 << 26;

/// Returns a position on the lattice; `None` beyond it.
pub(super) fn lattice_point(frame: Frame, [x, y]: [f64; 2]) -> Option<[i32; 2]> {
    let (x, y) = frame.lattice_from_world(x, y);
    let on_lattice = |v: i64| i32::try_from(v).ok().filter(|_| v.abs() <= LIMIT);
    Some([on_lattice(x)?, on_lattice(y)?])
}

/// Returns the rings of a polygon on the lattice that enclose an area; `None` beyond it.
pub(super) fn lattice_rings(rings: &[Vec<[f64; 2]>], frame: Frame) -> Option<Vec<Ring>> {
    let on_lattice = |ring: &Vec<[f64; 2]>| ring.iter().map(|p| lattice_point(frame, *p)).collect();
    rings.iter().map(on_lattice).collect::<Option<Vec<Ring>>>().map(enclosing)
}

/// Returns the rings that enclose an area, without corners that repeat the one before. Without a
/// shell there is nothing to take holes out of, and no ring is returned.
pub(super) fn enclosing(mut rings: Vec<Ring>) -> Vec<Ring> {
    for ring in &mut rings {
        ring.dedup();
        while ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
    }
    if rings.first().is_some_and(|shell| shell.len() < 3) {
        rings.clear();
    }
    rings.retain(|ring| ring.len() >= 3);
    rings
}

/// Returns polygons on the lattice and repaired; none beyond it.
pub(super) fn lattice_polygons(polygons: &[Vec<Vec<[f64; 2]>>], frame: Frame) -> Vec<Polygon> {
    let rings = polygons.iter().map(|polygon| lattice_rings(polygon, frame)).collect::<Option<Vec<_>>>();
    let regions = rings.unwrap_or_default().into_iter().filter_map(|rings| region_of(&rings).ok());
    regions.flat_map(|region| region.polygons).collect()
}

/// Repaired region of a polygon.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Region {
    /// Polygons, shell first, whose edges do not cross.
    pub polygons: Vec<Polygon>,
    /// `true` if the rings as drawn describe another region.
    pub is_repaired: bool,
    /// `true` if a hole lies outside of the shell, or reaches out of it. That part does not belong
    /// to the region.
    pub has_stray_hole: bool,
}

/// Returns the region of a polygon of rings, the shell first: the area of the shell without those
/// of the holes, all by the even-odd rule.
///
/// Where edges cross off the lattice, the crossing is rounded to it and the edges bend by less than
/// a step. Coordinates are within ±2^26.
///
/// # Errors
/// Edges that cross too often.
pub fn region_of(rings: &[Ring]) -> Result<Region, Tangle> {
    check_crossings(rings)?;
    let polygons = even_odd(rings);
    // A valid polygon comes back with the area of its shell minus that of its holes, and with as
    // many rings. A hole outside of the shell would have added its area.
    let area = |ring: &Ring| doubled_area(ring).abs();
    let before = rings.first().map_or(0, area) - rings.iter().skip(1).map(area).sum::<i128>();
    let after: i128 = polygons.iter().map(|p| area(&p[0]) - p[1..].iter().map(area).sum::<i128>()).sum();
    let n_rings: usize = polygons.iter().map(Vec::len).sum();
    if before == after && n_rings == rings.len() {
        return Ok(Region { polygons, is_repaired: false, has_stray_hole: false });
    }
    let Some((shell, holes)) = rings.split_first().filter(|(_, holes)| !holes.is_empty()) else {
        return Ok(Region { polygons, is_repaired: true, has_stray_hole: false });
    };
    // Each ring is resolved by itself, wound alike, so that regions add up by their winding
    // numbers.
    let shell = even_odd(std::slice::from_ref(shell)).concat();
    let holes: Vec<_> = holes.iter().flat_map(|hole| even_odd(std::slice::from_ref(hole)).concat()).collect();
    let has_stray_hole = !difference(&holes, &shell)?.is_empty();
    Ok(Region { polygons: difference(&shell, &holes)?, is_repaired: true, has_stray_hole })
}

#[expect(clippy::cast_precision_loss, reason = "reported as a share of area")]
pub(super) fn polygon_area(polygon: &[Vec<[i32; 2]>]) -> f64 {
    let area = |r: &Vec<[i32; 2]>| doubled_area(r).abs() as f64;
    polygon.first().map_or(0.0, area) - polygon.iter().skip(1).map(area).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_hole_covers_is_never_a_building() {
        let square = |w: i32, s: i32, side: i32| vec![[w, s], [w + side, s], [w + side, s + side], [w, s + side]];
        let area = |region: &Region| {
            let of_ring = |ring: &Vec<[i32; 2]>| doubled_area(ring).abs() / 2;
            region.polygons.iter().map(|p| of_ring(&p[0]) - p[1..].iter().map(of_ring).sum::<i128>()).sum::<i128>()
        };
        let shell = square(0, 0, 100);
        for (holes, wanted, is_stray) in [
            (vec![square(200, 0, 10)], 10_000, true),
            (vec![square(90, 90, 20)], 10_000 - 100, true),
            (vec![square(100, 0, 10)], 10_000, true),
            (vec![square(0, 0, 200)], 0, true),
            // Holes that overlap, one in another, one twice, one at the wall.
            (vec![square(10, 10, 20), square(20, 20, 20)], 10_000 - 700, false),
            (vec![square(10, 10, 30), square(20, 20, 5)], 10_000 - 900, false),
            (vec![square(10, 10, 30), square(10, 10, 30)], 10_000 - 900, false),
            (vec![square(0, 10, 30)], 10_000 - 900, false),
        ] {
            let rings: Vec<_> = std::iter::once(shell.clone()).chain(holes).collect();
            let region = region_of(&rings).expect("few crossings");
            assert_eq!((area(&region), region.has_stray_hole), (wanted, is_stray), "{rings:?}");
        }
    }
}
