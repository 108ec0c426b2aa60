//! Which cells of the receivers' grid are roofs of a vector scene.

use super::HeightField;
use super::prisms::{holds_half_open, side};
use crate::quantity::VOID;

impl HeightField {
    /// The roof of every cell whose center is in the interior of B and above the ground.
    pub(super) fn rasterize_roofs(&self) -> Vec<i32> {
        let mut roofs = vec![VOID; self.grid.n_cells()];
        let Some((prisms, _)) = &self.prisms else { return roofs };
        let positions = self.positions();
        let xs: Vec<i64> = positions.prisms_xs().collect();
        let ys: Vec<i64> = positions.prisms_ys().collect();
        let n_cols = self.grid.n_cols();
        let mut on_an_edge: Vec<(usize, usize)> = Vec::new();
        for piece in prisms.pieces() {
            let ring = prisms.ring(piece);
            let range = |k: usize| {
                let values = || ring.iter().map(|v| i64::from(v[k]));
                (values().min().unwrap_or(0), values().max().unwrap_or(0))
            };
            let ((west, east), (south, north)) = (range(0), range(1));
            let cols = xs.partition_point(|x| *x < west)..xs.partition_point(|x| *x <= east);
            let rows = ys.partition_point(|y| *y > north)..ys.partition_point(|y| *y >= south);
            for row in rows {
                for col in cols.clone() {
                    let (x, y) = (xs[col], ys[row]);
                    if holds_half_open(ring, x, y) {
                        let roof = &mut roofs[row * n_cols + col];
                        *roof = (*roof).max(piece.top);
                    }
                    if is_on_boundary(ring, x, y) {
                        on_an_edge.push((row, col));
                    }
                }
            }
        }
        // On an edge the half-open rule above tells the roof, but only a shared edge is inside the solid.
        for (row, col) in on_an_edge {
            if prisms.solid_below(xs[col], ys[row]) == VOID {
                roofs[row * n_cols + col] = VOID;
            }
        }
        // A roof that is not above the ground hides nothing and is no place to stand on.
        for (index, roof) in roofs.iter_mut().enumerate().filter(|(_, r)| **r != VOID) {
            let center = positions.center(index / n_cols, index % n_cols);
            let ground = self.ground_at(&center);
            let inside = self.inside_prisms_below(&center);
            if inside <= ground {
                *roof = VOID;
            }
        }
        roofs
    }
}

/// Whether a position inside or on a convex counterclockwise ring lies on its boundary.
fn is_on_boundary(ring: &[[i32; 2]], x: i64, y: i64) -> bool {
    let sides = || (0..ring.len()).map(|k| side(ring[k], ring[(k + 1) % ring.len()], x, y));
    sides().all(|s| s >= 0) && sides().any(|s| s == 0)
}
