//! Outline of a building: onto the lattice, repaired, with the ground under it.

use super::building::RawFootprint;
use super::lattice_polygon::{lattice_rings, region_of};
use super::roof::{LatticeRoof, RoofFault, lattice_roof};
use crate::city::Ground;
use crate::outlines::{covered_shares, overlapped_cells};
use crate::overlay::{Polygon, Ring, Tangle, difference, doubled_area};
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
    let shapes = if shaped.raw.roof.is_empty() { shape_polygons } else { shape_roof };
    shaped.tangle = shapes(&mut shaped, frame).err();
    shaped.base = match ground {
        Ground::Surface => None,
        Ground::Flat(z) => Some(*z),
        Ground::Terrain(terrain) => base_on(&shaped.polygons, &frame, terrain, rule),
    };
    shaped
}

/// Fills in the triangles of the roof, and the polygons that they cover.
fn shape_roof(shaped: &mut Shaped, frame: Frame) -> Result<(), Tangle> {
    match lattice_roof(&shaped.raw.roof, frame) {
        Ok(roof) => shaped.roof = roof,
        Err(RoofFault::Tangle(tangle)) => return Err(tangle),
        Err(RoofFault::TooFar) => shaped.too_far = true,
        Err(RoofFault::Height(m)) => shaped.bad_height = Some(m),
    }
    shaped.polygons = shaped.roof.polygons()?;
    if shaped.polygons.is_empty() {
        shaped.degenerate.push(0);
    }
    let mut ground: Vec<Ring> = Vec::new();
    for rings in &shaped.raw.ground {
        let Some(rings) = lattice_rings(rings, frame) else {
            shaped.too_far = true;
            return Ok(());
        };
        ground.extend(region_of(&rings)?.polygons.into_iter().flatten());
    }
    if !ground.is_empty() {
        let roof: Vec<Ring> = shaped.polygons.iter().flatten().cloned().collect();
        let area =
            |polygons: Vec<Polygon>| polygons.iter().flatten().map(|ring| doubled_area(ring)).sum::<i128>().abs();
        shaped.overhangs = area(difference(&roof, &ground)?) > 2 * LEAST_OVERHANG;
        shaped.bares_ground = area(difference(&ground, &roof)?) > 2 * LEAST_OVERHANG;
    }
    Ok(())
}

/// Repairs the polygons.
fn shape_polygons(shaped: &mut Shaped, frame: Frame) -> Result<(), Tangle> {
    for (k, polygon) in shaped.raw.polygons.iter().enumerate() {
        let Some(rings) = lattice_rings(polygon, frame) else {
            shaped.too_far = true;
            return Ok(());
        };
        let region = region_of(&rings)?;
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
    Ok(())
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
