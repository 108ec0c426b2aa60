//! The outlines of buildings, joined to blocks, and the open ground between them and the frame.

use std::collections::HashMap;

use super::cell_outline::rings_around;
use crate::disjoint_sets::DisjointSets;
use crate::height_field::HeightField;
use crate::overlay::{
    FINER, FineRing, Polygon, Ring, Tangle, are_many, arranged, doubled_area, fine_difference, fine_union, finer, union,
};
use crate::quantity::STEPS_PER_UNIT;

/// Area below which a free-standing block (a kiosk, a shed) does not divide its street \[m²\].
const SMALLEST_BLOCK_M2: f64 = 25.0;

/// Most lattice steps along a raster, a power of two. Its cells are at least 2^10 steps wide.
const STEPS_PER_RASTER: usize = 1 << 26;

/// Distance from the origin to which blocks are clamped \[steps\]; the overlay's integers are exact
/// within it.
const FARTHEST: i64 = 1 << 28;

/// Outlines of a scene on a lattice of equal steps along x and y.
pub(super) struct Outlines {
    /// Footprints, or the building cells of a raster, which make up the blocks.
    pieces: Vec<Polygon>,
    /// The extent of the scene \[steps\]: west, south, east, north.
    frame: [i32; 4],
    /// Length of a lattice step \[m\].
    step_m: f64,
    /// Centers of the columns of cells from west to east, and of the rows from south to north
    /// \[half steps\].
    centers: [Vec<i64>; 2],
}

/// Open ground on the finer lattice of an arrangement: polygons whose edges do not cross, and the
/// frame around them.
pub(super) struct OpenGround {
    /// Rings, not closed: shells counterclockwise and holes clockwise.
    pub(super) rings: Vec<FineRing>,
    /// West, south, east, north.
    pub(super) frame: [i64; 4],
    /// Length of a step of the finer lattice \[m\].
    pub(super) step_m: f64,
    /// Centers of the columns of cells from west to east, and of the rows from south to north.
    pub(super) centers: [Vec<i64>; 2],
}

impl Outlines {
    /// Returns the outlines of the footprints of a scene, or of its building cells.
    pub(super) fn of(field: &HeightField) -> Self {
        let grid = field.grid();
        let clamp = |v: i64| {
            #[expect(clippy::cast_possible_truncation, reason = "clamped to ±2^28")]
            let v = v.clamp(-FARTHEST, FARTHEST) as i32;
            v
        };
        match (field.prisms(), field.prisms_frame()) {
            (Some(prisms), Some(lattice)) => {
                let ring = |ring: &[[i32; 2]]| ring.iter().map(|v| v.map(|v| clamp(v.into()))).collect();
                let (west, south) = lattice.lattice_from_world(grid.x_min(), grid.y_min());
                let (east, north) = lattice.lattice_from_world(grid.x_max(), grid.y_max());
                let (xs, mut ys) = field.positions().on_prisms();
                ys.reverse();
                Outlines {
                    pieces: prisms.pieces().iter().map(|p| vec![ring(prisms.ring(p))]).collect(),
                    frame: [west, south, east, north].map(clamp),
                    step_m: lattice.unit_x / f64::from(STEPS_PER_UNIT),
                    centers: [xs, ys].map(|centers| centers.into_iter().map(|v| 2 * v).collect()),
                }
            }
            _ => {
                let sizes = [grid.cell_width(), grid.cell_height()];
                let counts = [grid.n_cols(), grid.n_rows()];
                // One whole number of steps to a cell everywhere, so that the lattice has the
                // symmetries of the grid. The longer side of a cell has a power of two, the shorter
                // one is rounded.
                let longer = sizes[0].max(sizes[1]);
                let most = counts[0].max(counts[1]).next_power_of_two();
                let step_m = longer / (STEPS_PER_RASTER / most).max(1) as f64;
                #[expect(clippy::cast_possible_truncation, reason = "at most 2^26")]
                let steps = sizes.map(|size| (size / step_m).round() as i32);
                #[expect(clippy::cast_possible_truncation, clippy::cast_possible_wrap, reason = "at most 2^26")]
                let corner = |axis: usize, k: usize| steps[axis] * k as i32;
                let centers = [0, 1].map(|axis| {
                    (0..counts[axis]).map(|k| i64::from(corner(axis, k)) + i64::from(corner(axis, k + 1))).collect()
                });
                let rings = rings_around(&field.cells().building)
                    .into_iter()
                    .map(|ring| ring.into_iter().map(|[x, y]| [corner(0, x), corner(1, y)]).collect())
                    .collect();
                Outlines {
                    pieces: vec![rings],
                    frame: [0, 0, corner(0, counts[0]), corner(1, counts[1])],
                    step_m,
                    centers,
                }
            }
        }
    }

    /// Returns the frame without the blocks that are large enough to divide a street.
    ///
    /// # Errors
    /// Outlines that cross too often.
    pub(super) fn open_ground(self) -> Result<OpenGround, Tangle> {
        // Outlines on one another would have too many crossings. They are joined first. This rounds
        // the crossings to the coarse lattice, and not alike from all sides.
        let is_tangled = self.pieces.len() > 1 && are_many(self.pieces.iter().flatten());
        let pieces = if is_tangled { union(self.pieces)? } else { self.pieces };
        let [west, south, east, north] = self.frame;
        let frame: Ring = vec![[west, south], [east, south], [east, north], [west, north]];
        let rings: Vec<Ring> = pieces.into_iter().flatten().chain([frame]).collect();
        let mut rings = arranged(&rings)?;
        let frame = rings.split_off(rings.len() - 1);
        let step_m = self.step_m / FINER as f64;
        let blocks = large_blocks(fine_union(&rings), step_m);
        Ok(OpenGround {
            rings: fine_difference(&frame, &blocks).concat(),
            frame: self.frame.map(|v| finer([v, 0])[0]),
            step_m,
            centers: self.centers.map(|centers| centers.into_iter().map(|v| v * (FINER / 2)).collect()),
        })
    }
}

/// Returns the rings of blocks that are not small. Polygons that meet at a corner are one block.
fn large_blocks(polygons: Vec<Vec<FineRing>>, step_m: f64) -> Vec<FineRing> {
    let mut blocks = DisjointSets::new(polygons.len());
    let mut polygon_at: HashMap<[i64; 2], usize> = HashMap::new();
    for (k, polygon) in polygons.iter().enumerate() {
        for corner in polygon.iter().flatten() {
            blocks.join(*polygon_at.entry(*corner).or_insert(k), k);
        }
    }
    let mut doubled = vec![0; polygons.len()];
    for (k, polygon) in polygons.iter().enumerate() {
        doubled[blocks.root(k)] += polygon.first().map_or(0, |shell| doubled_area(shell));
    }
    let is_large = |doubled: i128| doubled as f64 / 2.0 * step_m * step_m >= SMALLEST_BLOCK_M2;
    let numbered = polygons.into_iter().enumerate();
    numbered.filter(|(k, _)| is_large(doubled[blocks.root(*k)])).flat_map(|(_, polygon)| polygon).collect()
}

impl OpenGround {
    /// Returns the open ground after another pass of the overlay, for edges that cross because
    /// crossings were rounded.
    pub(super) fn again(self) -> OpenGround {
        OpenGround { rings: fine_union(&self.rings).concat(), ..self }
    }
}
