//! Outline of a building: onto the lattice, repaired, with the ground under it.

use super::building::RawFootprint;
use super::roof::{LatticeRoof, RoofFault, lattice_roof};
use crate::city::Ground;
use crate::outlines::{covered_shares, overlapped_cells};
use crate::overlay::{Polygon, Ring, Tangle, difference, doubled_area, even_odd, tangle};
use crate::quantity::{Frame, VOID};
use crate::raster::{CellLattice, Raster};
use skyshed_request::BaseRule;

/// A footprint after rounding and repair.
pub(super) struct Shaped {
    pub(super) raw: RawFootprint,
    pub(super) polygons: Vec<Polygon>,
    /// Indices of the raw polygons that were repaired.
    pub(super) repaired: Vec<usize>,
    /// Indices of the raw polygons without area.
    pub(super) degenerate: Vec<usize>,
    /// Indices of the raw polygons with a hole that lies outside of their shell, or reaches out of
    /// it.
    pub(super) stray_holes: Vec<usize>,
    pub(super) too_far: bool,
    /// Reason why it could not be repaired.
    pub(super) tangle: Option<Tangle>,
    /// Ground that it stands on; `None` where none is known.
    pub(super) base: Option<i32>,
    /// Its roof, if that is taken as it is.
    pub(super) roof: LatticeRoof,
    /// A height of the roof beyond the lattice \[m\].
    pub(super) bad_height: Option<f64>,
    /// `true` if the roof reaches beyond the ground surfaces.
    pub(super) overhangs: bool,
    /// `true` if ground surfaces reach beyond the roof.
    pub(super) bares_ground: bool,
}

/// Area by which a roof must reach beyond its ground surfaces to be reported \[square steps\]: half
/// a square meter. Less is due to how the file was drawn.
const LEAST_OVERHANG: i128 = 1 << 19;

/// Largest coordinate of a position \[lattice steps\].
const LIMIT: i64 = 1 << 26;

/// Brings a footprint onto the lattice, repairs its polygons and finds the ground that it stands
/// on.
pub(super) fn shape(raw: RawFootprint, (ground, rule): (&Ground, BaseRule), frame: Frame) -> Shaped {
    let mut shaped = Shaped {
        polygons: Vec::new(),
        repaired: Vec::new(),
        degenerate: Vec::new(),
        stray_holes: Vec::new(),
        too_far: false,
        tangle: None,
        base: None,
        roof: LatticeRoof::default(),
        bad_height: None,
        overhangs: false,
        bares_ground: false,
        raw,
    };
    if shaped.raw.roof.is_empty() {
        shape_polygons(&mut shaped, frame);
    } else {
        shape_roof(&mut shaped, frame);
    }
    shaped.base = match ground {
        Ground::Surface => None,
        Ground::Flat(z) => Some(*z),
        Ground::Terrain(terrain) => base_on(&shaped.polygons, &frame, terrain, rule),
    };
    shaped
}

/// Fills in the triangles of the roof, and the polygons that they cover.
fn shape_roof(shaped: &mut Shaped, frame: Frame) {
    match lattice_roof(&shaped.raw.roof, frame) {
        Ok(roof) => shaped.roof = roof,
        Err(RoofFault::Tangle(tangle)) => shaped.tangle = Some(tangle),
        Err(RoofFault::TooFar) => shaped.too_far = true,
        Err(RoofFault::Height(m)) => shaped.bad_height = Some(m),
    }
    shaped.polygons = shaped.roof.polygons();
    if shaped.polygons.is_empty() {
        shaped.degenerate.push(0);
    }
    let mut ground: Vec<Ring> = Vec::new();
    for rings in &shaped.raw.ground {
        let Some(rings) = lattice_rings(rings, frame) else {
            shaped.too_far = true;
            return;
        };
        shaped.tangle = shaped.tangle.or_else(|| tangle(&rings));
        if shaped.tangle.is_some() {
            return;
        }
        ground.extend(region_of(&rings).polygons.into_iter().flatten());
    }
    if !ground.is_empty() {
        let roof: Vec<Ring> = shaped.polygons.iter().flatten().cloned().collect();
        let area =
            |polygons: Vec<Polygon>| polygons.iter().flatten().map(|ring| doubled_area(ring)).sum::<i128>().abs();
        shaped.overhangs = area(difference(&roof, &ground)) > 2 * LEAST_OVERHANG;
        shaped.bares_ground = area(difference(&ground, &roof)) > 2 * LEAST_OVERHANG;
    }
}

/// Returns a position on the lattice; `None` beyond it.
pub(super) fn lattice_point(frame: Frame, [x, y]: [f64; 2]) -> Option<[i32; 2]> {
    let (x, y) = frame.lattice_from_world(x, y);
    let on_lattice = |v: i64| i32::try_from(v).ok().filter(|_| v.abs() <= LIMIT);
    Some([on_lattice(x)?, on_lattice(y)?])
}

/// Returns the rings of a polygon on the lattice that enclose an area; `None` beyond it.
fn lattice_rings(rings: &[Vec<[f64; 2]>], frame: Frame) -> Option<Vec<Ring>> {
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
    let is_sound = |rings: &Vec<Ring>| tangle(rings).is_none();
    rings
        .unwrap_or_default()
        .iter()
        .filter(|rings| is_sound(rings))
        .flat_map(|rings| region_of(rings).polygons)
        .collect()
}

/// Repairs the polygons.
fn shape_polygons(shaped: &mut Shaped, frame: Frame) {
    for (k, polygon) in shaped.raw.polygons.iter().enumerate() {
        let Some(rings) = lattice_rings(polygon, frame) else {
            shaped.too_far = true;
            return;
        };
        shaped.tangle = tangle(&rings);
        if shaped.tangle.is_some() {
            return;
        }
        let region = region_of(&rings);
        if region.polygons.is_empty() {
            shaped.degenerate.push(k);
        } else if region.is_repaired {
            shaped.repaired.push(k);
        }
        if region.has_stray_hole {
            shaped.stray_holes.push(k);
        }
        shaped.polygons.extend(region.polygons);
    }
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
pub fn region_of(rings: &[Ring]) -> Region {
    let polygons = even_odd(rings);
    // A valid polygon comes back with the area of its shell minus that of its holes, and with as
    // many rings. A hole outside of the shell would have added its area.
    let area = |ring: &Ring| doubled_area(ring).abs();
    let before = rings.first().map_or(0, area) - rings.iter().skip(1).map(area).sum::<i128>();
    let after: i128 = polygons.iter().map(|p| area(&p[0]) - p[1..].iter().map(area).sum::<i128>()).sum();
    let n_rings: usize = polygons.iter().map(Vec::len).sum();
    if before == after && n_rings == rings.len() {
        return Region { polygons, is_repaired: false, has_stray_hole: false };
    }
    let Some((shell, holes)) = rings.split_first().filter(|(_, holes)| !holes.is_empty()) else {
        return Region { polygons, is_repaired: true, has_stray_hole: false };
    };
    // Each ring is resolved by itself, wound alike, so that regions add up by their winding
    // numbers.
    let shell = even_odd(std::slice::from_ref(shell)).concat();
    let holes: Vec<_> = holes.iter().flat_map(|hole| even_odd(std::slice::from_ref(hole)).concat()).collect();
    let has_stray_hole = !difference(&holes, &shell).is_empty();
    Region { polygons: difference(&shell, &holes), is_repaired: true, has_stray_hole }
}

#[expect(clippy::cast_precision_loss, reason = "reported as a share of area")]
pub(super) fn polygon_area(polygon: &[Vec<[i32; 2]>]) -> f64 {
    let area = |r: &Vec<[i32; 2]>| doubled_area(r).abs() as f64;
    polygon.first().map_or(0.0, area) - polygon.iter().skip(1).map(area).sum::<f64>()
}

/// Returns the ground that a footprint stands on, by the terrain columns that its area overlaps;
/// `None` if none of them is known.
///
/// OpenStreetMap measures `height` from the lowest point where the building meets the ground.
fn base_on(polygons: &[Polygon], frame: &Frame, terrain: &Raster<i32>, rule: BaseRule) -> Option<i32> {
    let georef = terrain.georef();
    let lattice = CellLattice::under(frame, georef);
    let ring = |ring: &Ring| ring.iter().map(|p| lattice.position(frame, *p)).collect::<Vec<_>>();
    let polygons: Vec<Vec<Vec<[i64; 2]>>> = polygons.iter().map(|rings| rings.iter().map(ring).collect()).collect();
    let shape = (georef.n_rows(), georef.n_cols());
    if rule == BaseRule::Mean {
        let (mut sum, mut area) = (0.0, 0.0);
        covered_shares(&polygons, lattice.steps, shape, |row, col, share| {
            let z = terrain.row(row)[col];
            if z != VOID {
                sum += share * f64::from(z);
                area += share;
            }
        });
        #[expect(clippy::cast_possible_truncation, reason = "between the heights of two cells")]
        return (area > 0.0).then(|| (sum / area + 0.5).floor() as i32);
    }
    let mut base: Option<i32> = None;
    overlapped_cells(&polygons, lattice.steps, shape, |row, cols| {
        for z in terrain.row(row)[cols].iter().copied().filter(|z| *z != VOID) {
            base = Some(match (base, rule) {
                (None, _) => z,
                (Some(base), BaseRule::Highest) => base.max(z),
                (Some(base), _) => base.min(z),
            });
        }
    });
    base
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
            let region = region_of(&rings);
            assert_eq!((area(&region), region.has_stray_hole), (wanted, is_stray), "{rings:?}");
        }
    }
}
