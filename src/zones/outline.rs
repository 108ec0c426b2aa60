//! The outlines of what is built, joined to blocks, and the open ground between them and the frame.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::Overlay;
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::i_float::int::point::IntPoint;

use super::cell_outline::rings_around;
use crate::height_field::HeightField;
use crate::quantity::STEPS_PER_UNIT;

/// A free-standing block smaller than this \[m²\] (a kiosk, a shed) does not divide the street that it stands in.
const SMALLEST_BLOCK_M2: f64 = 25.0;

/// Lattice steps per cell for the outlines of rasters, so that edges which cross do so nearly on the lattice.
const STEPS_PER_CELL: i32 = 64;

/// Blocks are clamped to this far from the origin \[steps\]; the overlay's integers are exact within it.
const FARTHEST: i64 = 1 << 28;

/// A polygon: its shell counterclockwise, then its holes clockwise.
type Shape = Vec<Vec<IntPoint<i32>>>;

/// The outlines of a scene on an integer lattice.
pub(super) struct Outlines {
    blocks: Vec<Shape>,
    /// The extent of the scene \[steps\]: west, south, east, north.
    frame: [i32; 4],
    /// Length of a lattice step along x and y \[m\].
    step_m: [f64; 2],
    /// World position of the lattice's origin.
    origin: [f64; 2],
}

/// Open ground: polygons whose edges do not cross, and the frame around them, in meters from the lattice's origin.
pub(super) struct OpenGround {
    /// Rings, not closed; open ground lies inside by the even-odd rule.
    pub(super) rings: Vec<Vec<[f64; 2]>>,
    /// West, south, east, north.
    pub(super) frame: [f64; 4],
    /// World position of the origin \[CRS units\].
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
        let point = |x: i32, y: i32| IntPoint { x, y };
        match (field.prisms(), field.prisms_frame()) {
            (Some(prisms), Some(lattice)) => {
                let rings: Vec<Vec<IntPoint<i32>>> = prisms
                    .pieces()
                    .iter()
                    .map(|p| prisms.ring(p).iter().map(|v| point(clamp(v[0].into()), clamp(v[1].into()))).collect())
                    .collect();
                let (west, south) = lattice.lattice_from_world(grid.x_min(), grid.y_min());
                let (east, north) = lattice.lattice_from_world(grid.x_max(), grid.y_max());
                let steps = f64::from(STEPS_PER_UNIT);
                Outlines {
                    blocks: joined(&rings, FillRule::NonZero),
                    frame: [west, south, east, north].map(clamp),
                    step_m: [lattice.unit_x / steps, lattice.unit_y / steps],
                    origin: [lattice.x_origin, lattice.y_origin],
                }
            }
            _ => {
                let corner = |k: usize| clamp(i64::try_from(k).unwrap_or(FARTHEST) * i64::from(STEPS_PER_CELL));
                let rings: Vec<Vec<IntPoint<i32>>> = rings_around(&field.cells().building)
                    .into_iter()
                    .map(|ring| ring.into_iter().map(|[x, y]| point(corner(x), corner(y))).collect())
                    .collect();
                let steps = f64::from(STEPS_PER_CELL);
                Outlines {
                    blocks: joined(&rings, FillRule::NonZero),
                    frame: [0, 0, corner(grid.n_cols()), corner(grid.n_rows())],
                    step_m: [grid.cell_width() / steps, grid.cell_height() / steps],
                    origin: [grid.x_min(), grid.y_min()],
                }
            }
        }
    }

    /// The frame less the blocks that are large enough to divide a street.
    pub(super) fn open_ground(&self) -> OpenGround {
        let step_m2 = self.step_m[0] * self.step_m[1];
        let blocks: Vec<Shape> = self
            .blocks
            .iter()
            .filter(|shape| shape.first().is_some_and(|shell| area(shell) * step_m2 >= SMALLEST_BLOCK_M2))
            .cloned()
            .collect();
        let [west, south, east, north] = self.frame;
        let corners = [[west, south], [east, south], [east, north], [west, north]];
        let frame: Vec<IntPoint<i32>> = corners.iter().map(|c| IntPoint { x: c[0], y: c[1] }).collect();
        let open =
            Overlay::<i32>::from_subj_and_clip(&frame, &blocks).overlay(OverlayRule::Difference, FillRule::NonZero);
        let meters = |p: &IntPoint<i32>| [f64::from(p.x) * self.step_m[0], f64::from(p.y) * self.step_m[1]];
        let rings = open.iter().flatten().map(|ring| ring.iter().map(meters).collect()).collect();
        let [x_step, y_step] = self.step_m;
        OpenGround {
            rings,
            frame: [
                f64::from(west) * x_step,
                f64::from(south) * y_step,
                f64::from(east) * x_step,
                f64::from(north) * y_step,
            ],
            origin: self.origin,
        }
    }
}

fn joined(rings: &[Vec<IntPoint<i32>>], rule: FillRule) -> Vec<Shape> {
    if rings.is_empty() {
        return Vec::new();
    }
    Overlay::<i32>::from_subj(rings).overlay(OverlayRule::Subject, rule)
}

/// Area inside a ring \[steps²\].
fn area(ring: &[IntPoint<i32>]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    let doubled: f64 =
        ring.iter().zip(next).map(|(a, b)| f64::from(a.x) * f64::from(b.y) - f64::from(b.x) * f64::from(a.y)).sum();
    doubled.abs() / 2.0
}
