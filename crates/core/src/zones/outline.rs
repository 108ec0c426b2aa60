//! The outlines of what is built, joined to blocks, and the open ground between them and the frame.

use super::cell_outline::rings_around;
use crate::height_field::HeightField;
use crate::overlay::{Polygon, Ring, difference, doubled_area, union};
use crate::quantity::STEPS_PER_UNIT;

/// A free-standing block smaller than this \[m²\] (a kiosk, a shed) does not divide the street that it stands in.
const SMALLEST_BLOCK_M2: f64 = 25.0;

/// Lattice steps along the longer side of a raster: 1024 or more per cell.
const STEPS_PER_RASTER: f64 = (1 << 26) as f64;

/// Blocks are clamped to this far from the origin \[steps\]; the overlay's integers are exact within it.
const FARTHEST: i64 = 1 << 28;

/// The outlines of a scene on a lattice of equal steps along x and y. Cells need not be square, so their corners are
/// rounded to it.
pub(super) struct Outlines {
    blocks: Vec<Polygon>,
    /// The extent of the scene \[steps\]: west, south, east, north.
    frame: [i32; 4],
    /// Length of a lattice step \[m\].
    step_m: f64,
    /// World position of the lattice's origin.
    origin: [f64; 2],
}

/// Open ground: polygons whose edges do not cross, and the frame around them, on the lattice.
pub(super) struct OpenGround {
    /// Rings, not closed: shells counterclockwise and holes clockwise.
    pub(super) rings: Vec<Ring>,
    /// West, south, east, north \[steps\].
    pub(super) frame: [i32; 4],
    /// Length of a lattice step \[m\].
    pub(super) step_m: f64,
    /// World position of the lattice's origin \[CRS units\].
    pub(super) origin: [f64; 2],
}

impl Outlines {
    /// The blocks of a scene: connected footprints, or connected building cells, as one polygon each.
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
                let pieces: Vec<Polygon> = prisms.pieces().iter().map(|p| vec![ring(prisms.ring(p))]).collect();
                let (west, south) = lattice.lattice_from_world(grid.x_min(), grid.y_min());
                let (east, north) = lattice.lattice_from_world(grid.x_max(), grid.y_max());
                let steps = f64::from(STEPS_PER_UNIT);
                Outlines {
                    blocks: union(pieces),
                    frame: [west, south, east, north].map(clamp),
                    step_m: lattice.unit_x / steps,
                    origin: [lattice.x_origin, lattice.y_origin],
                }
            }
            _ => {
                let width = grid.cell_width() * grid.n_cols() as f64;
                let height = grid.cell_height() * grid.n_rows() as f64;
                let step_m = width.max(height) / STEPS_PER_RASTER;
                #[expect(clippy::cast_possible_truncation, reason = "at most 2^26")]
                let corner = |k: usize, cell: f64| (k as f64 * cell / step_m).round() as i32;
                let [x_at, y_at] = [grid.cell_width(), grid.cell_height()].map(|cell| move |k: usize| corner(k, cell));
                let rings: Vec<Ring> = rings_around(&field.cells().building)
                    .into_iter()
                    .map(|ring| ring.into_iter().map(|[x, y]| [x_at(x), y_at(y)]).collect())
                    .collect();
                Outlines {
                    blocks: union(vec![rings]),
                    frame: [0, 0, x_at(grid.n_cols()), y_at(grid.n_rows())],
                    step_m,
                    origin: [grid.x_min(), grid.y_min()],
                }
            }
        }
    }

    /// The frame less the blocks that are large enough to divide a street.
    pub(super) fn open_ground(&self) -> OpenGround {
        let step_m2 = self.step_m * self.step_m;
        #[expect(clippy::cast_precision_loss, reason = "compared with a size that is not exact either")]
        let area_m2 = |shell: &Ring| doubled_area(shell).abs() as f64 / 2.0 * step_m2;
        let is_large = |block: &&Polygon| block.first().is_some_and(|shell| area_m2(shell) >= SMALLEST_BLOCK_M2);
        let blocks: Vec<Ring> = self.blocks.iter().filter(is_large).flatten().cloned().collect();
        let [west, south, east, north] = self.frame;
        let frame: Ring = vec![[west, south], [east, south], [east, north], [west, north]];
        let rings = difference(&[frame], &blocks).concat();
        OpenGround { rings, frame: self.frame, step_m: self.step_m, origin: self.origin }
    }
}

impl OpenGround {
    /// The open ground after another pass of the overlay, where rounded crossings made edges cross anew.
    pub(super) fn again(&self) -> OpenGround {
        let rings = union(vec![self.rings.clone()]).concat();
        OpenGround { rings, ..*self }
    }
}
