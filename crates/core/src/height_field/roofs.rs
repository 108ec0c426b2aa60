//! Cells of the receivers' grid that are roofs of a vector scene.

use std::sync::Arc;

use std::ops::Range;

use super::solid::Solid;
use super::{HeightField, Prisms};
use crate::quantity::VOID;
use crate::raster::BitGrid;

impl HeightField {
    /// Finds the roof of every cell of a vector scene whose center is in the interior of B and
    /// above the ground.
    ///
    /// Cost: the rows that each edge of a piece passes, and the cells in each piece.
    pub(super) fn find_roofs(&mut self) {
        let Some(roofs) = self.prisms().map(|prisms| self.roofs_of(prisms)) else { return };
        if let Solid::Vector(vector) = &mut self.solid {
            vector.roofs = Arc::new(roofs);
        }
    }

    fn roofs_of(&self, prisms: &Prisms) -> Vec<i32> {
        let mut roofs = vec![VOID; self.grid.n_cells()];
        let positions = self.positions();
        let (xs, ys) = positions.on_prisms();
        let centers = Centers { xs, ys };
        let n_cols = self.grid.n_cols();
        let mut on_an_edge = BitGrid::new(self.grid.n_rows(), n_cols);
        for piece in prisms.pieces() {
            centers.visit(prisms.ring(piece), |row, cols, is_edge| {
                if is_edge {
                    cols.for_each(|col| on_an_edge.insert(row, col));
                    return;
                }
                match prisms.plane(piece) {
                    None => roofs[row * n_cols..][cols].iter_mut().for_each(|roof| *roof = (*roof).max(piece.top)),
                    Some(plane) => cols.for_each(|col| {
                        let roof = &mut roofs[row * n_cols + col];
                        *roof = (*roof).max(plane.lowest_above(centers.xs[col], centers.ys[row]));
                    }),
                }
            });
        }
        // A roof that is not above the ground hides nothing and is no place to stand on.
        for (index, roof) in roofs.iter_mut().enumerate().filter(|(_, roof)| **roof != VOID) {
            let (row, col) = (index / n_cols, index % n_cols);
            let center = positions.center(row, col);
            // On an edge the half-open rule above tells the roof, but only a shared edge is inside
            // the solid.
            let inside = if on_an_edge.contains(row, col) { self.inside_prisms_below(&center) } else { *roof };
            if inside == VOID || inside <= self.ground_at(&center) {
                *roof = VOID;
            }
        }
        roofs
    }
}

/// The centers of cells on the lattice of the prisms.
struct Centers {
    /// West to east.
    xs: Vec<i64>,
    /// North to south.
    ys: Vec<i64>,
}

impl Centers {
    /// Calls `visit` for each row with the columns that a convex counterclockwise ring holds by the
    /// half-open rule (`false`), and with those whose centers are on its boundary (`true`).
    fn visit(&self, ring: &[[i32; 2]], mut visit: impl FnMut(usize, Range<usize>, bool)) {
        let rows = |low: i64, high: i64| self.ys.partition_point(|y| *y > high)..self.ys.partition_point(|y| *y >= low);
        let col = |x: i64| self.xs.partition_point(|center| *center < x);
        let ys = || ring.iter().map(|v| i64::from(v[1]));
        let (Some(south), Some(north)) = (ys().min(), ys().max()) else { return };
        let all_rows = rows(south, north);
        // Of each row the first column inside, and the first beyond.
        let mut spans = vec![[0, 0]; all_rows.len()];
        for (k, &a) in ring.iter().enumerate() {
            let (a, b) = (a.map(i64::from), ring[(k + 1) % ring.len()].map(i64::from));
            if a[1] == b[1] {
                rows(a[1], a[1]).for_each(|row| visit(row, col(a[0].min(b[0]))..col(a[0].max(b[0]) + 1), true));
                continue;
            }
            // Down along the west side of the ring, up along its east side.
            let (low, high, end) = if b[1] < a[1] { (b, a, 0) } else { (a, b, 1) };
            let (dx, dy) = (high[0] - low[0], high[1] - low[1]);
            for row in rows(low[1], high[1]) {
                // EXACT: x·dy of the edge in this row, below 2^57.
                let x = low[0] * dy + (self.ys[row] - low[1]) * dx;
                let first = -(-x).div_euclid(dy);
                if x % dy == 0 {
                    visit(row, col(first)..col(first + 1), true);
                }
                // A corner between two edges counts to the upper one; the north end of the ring is
                // not in it.
                if self.ys[row] < high[1] {
                    spans[row - all_rows.start][end] = col(first);
                }
            }
        }
        all_rows.zip(spans).for_each(|(row, [from, to])| visit(row, from..to.max(from), false));
    }
}

#[cfg(test)]
mod tests {
    use super::super::prisms::{holds_half_open, side};
    use super::*;

    #[test]
    fn rows_of_a_ring_are_what_its_edges_say_of_each_center() {
        let centers = Centers { xs: (-2..12).collect(), ys: (-3..12).rev().collect() };
        let rings: [&[[i32; 2]]; 5] = [
            &[[0, 0], [9, 0], [9, 9], [0, 9]],
            &[[4, -2], [10, 4], [4, 10], [-2, 4]],
            &[[0, 0], [7, 3], [2, 8]],
            &[[1, 1], [5, 1], [9, 4], [9, 8], [5, 10], [1, 9]],
            &[[3, 3], [4, 3], [4, 4]],
        ];
        for ring in rings {
            let mut found = [Vec::new(), Vec::new()];
            centers.visit(ring, |row, cols, is_edge| {
                found[usize::from(is_edge)].extend(cols.map(|col| (row, col)));
            });
            let mut wanted = [Vec::new(), Vec::new()];
            for (row, &y) in centers.ys.iter().enumerate() {
                for (col, &x) in centers.xs.iter().enumerate() {
                    let sides = || (0..ring.len()).map(|k| side(ring[k], ring[(k + 1) % ring.len()], x, y));
                    if holds_half_open(ring, x, y) {
                        wanted[0].push((row, col));
                    }
                    if sides().all(|s| s >= 0) && sides().any(|s| s == 0) {
                        wanted[1].push((row, col));
                    }
                }
            }
            found[1].sort_unstable();
            found[1].dedup();
            assert_eq!(found, wanted, "{ring:?}");
        }
    }
}
