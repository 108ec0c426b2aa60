//! Open half-spaces that bound a solid: below its roof and on the inner side of its walls.

use crate::height_field::{Columns, Piece, Prisms, RoofPlane};
use crate::quantity::LatticePoint;

/// An open half-space: the points p with `normal·p + offset > 0`.
#[derive(Debug, Clone, Copy)]
pub(super) struct HalfSpace {
    normal: [i64; 3],
    offset: i128,
}

impl HalfSpace {
    /// Returns the points left of the vertical plane through an edge.
    fn left_of(from: [i64; 2], to: [i64; 2]) -> HalfSpace {
        let (ex, ey) = (to[0] - from[0], to[1] - from[1]);
        let offset = i128::from(ey) * i128::from(from[0]) - i128::from(ex) * i128::from(from[1]);
        HalfSpace { normal: [-ey, ex, 0], offset }
    }

    /// Returns the points below a flat top.
    pub(super) fn below(top: i32) -> HalfSpace {
        HalfSpace { normal: [0, 0, -1], offset: i128::from(top) }
    }

    /// Returns the points below a sloped roof.
    fn below_roof(plane: &RoofPlane) -> HalfSpace {
        let [east, north] = plane.rise();
        let offset = -plane.above(LatticePoint { x: 0, y: 0, z: 0 });
        HalfSpace { normal: [east, north, -plane.area()], offset }
    }

    /// Returns the points below the top of a piece.
    pub(super) fn below_piece(prisms: &Prisms, piece: &Piece) -> HalfSpace {
        prisms.plane(piece).map_or_else(|| HalfSpace::below(piece.top), |plane| HalfSpace::below_roof(&plane))
    }

    /// Returns the value of the linear form at a point: above 0 inside. Exact.
    pub(super) fn value(&self, p: LatticePoint) -> i128 {
        self.offset + self.change([p.x, p.y, p.z])
    }

    /// Returns by how much the value changes along a vector. Exact.
    pub(super) fn change(&self, along: [i64; 3]) -> i128 {
        let product = |k: usize| i128::from(self.normal[k]) * i128::from(along[k]);
        product(0) + product(1) + product(2)
    }
}

/// Returns the inner sides of the walls of a convex counterclockwise ring.
pub(super) fn walls_of(ring: &[[i32; 2]]) -> impl Iterator<Item = HalfSpace> {
    let corner = |k: usize| ring[k % ring.len()].map(i64::from);
    (0..ring.len()).map(move |k| HalfSpace::left_of(corner(k), corner(k + 1)))
}

/// Returns the inner sides of the walls of a column, by cells east and north of the south-west
/// corner.
pub(super) fn walls_of_cell(columns: &Columns, (east, north): (i64, i64)) -> [HalfSpace; 4] {
    let [width, height] = columns.steps();
    let side = |normal: [i64; 3], offset: i64| HalfSpace { normal, offset: i128::from(offset) };
    [
        side([1, 0, 0], -east * width),
        side([-1, 0, 0], (east + 1) * width),
        side([0, 1, 0], -north * height),
        side([0, -1, 0], (north + 1) * height),
    ]
}
