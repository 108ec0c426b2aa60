//! Obstacles between a UAV and receivers of one height in a box: the pieces of prisms in the buckets
//! that meet the hull of both.

use std::ops::ControlFlow;

use super::geometry::as_f64;
use crate::height_field::{Piece, Prisms};
use crate::quantity::LatticePoint;

/// The pieces that a walk has visited; a piece is in several buckets.
#[derive(Default)]
pub(super) struct Visits {
    /// For each piece, the last walk that visited it.
    of: Vec<u32>,
    /// The present walk.
    now: u32,
}

impl Visits {
    /// Begins a walk among some prisms.
    #[inline(always)]
    pub(super) fn begin(&mut self, prisms: &Prisms) {
        // Marks of other prisms are older than the walk.
        self.of.resize(self.of.len().max(prisms.pieces().len()), 0);
        self.now += 1;
    }

    /// Returns `true` at the first visit of a piece in this walk.
    #[inline(always)]
    fn is_first(&mut self, piece: u32) -> bool {
        std::mem::replace(&mut self.of[piece as usize], self.now) != self.now
    }
}

/// The region between a UAV and receivers of one height in a box: the hull of both, and the height
/// of its rays.
pub(super) struct Between {
    uav: LatticePoint,
    /// The axis along which the box is farther away, 0 for x. The flag is `true` if it is on its
    /// negative side.
    axis: usize,
    is_mirrored: bool,
    /// Distance of its nearer and its farther side along that axis \[lattice steps\].
    distance: (f64, f64),
    /// Its extent across, relative to the UAV \[lattice steps\].
    across: (f64, f64),
    /// Height of the receivers above the UAV \[1/1024 m\].
    rise: f64,
}

impl Between {
    /// Makes the region; `bounds` are west, south, east and north of the receivers.
    pub(super) fn new(uav: LatticePoint, [west, south, east, north]: [i64; 4], z: i64) -> Self {
        let sides = [(west - uav.x, east - uav.x), (south - uav.y, north - uav.y)];
        let gap = |(low, high): (i64, i64)| low.max(-high).max(0);
        let axis = usize::from(gap(sides[1]) >= gap(sides[0]));
        let (low, high) = sides[axis];
        let across = sides[1 - axis];
        Between {
            uav,
            axis,
            is_mirrored: high < 0,
            distance: (as_f64(gap((low, high))), as_f64(low.abs().max(high.abs()))),
            across: (as_f64(across.0), as_f64(across.1)),
            rise: as_f64(z - uav.z),
        }
    }

    /// Calls `visit` with the pieces that may hide the UAV from a receiver, in rows of buckets from
    /// the receivers on.
    #[inline(always)]
    pub(super) fn visit(
        &self,
        prisms: &Prisms,
        visits: &mut Visits,
        mut visit: impl FnMut(&Piece) -> ControlFlow<()>,
    ) -> ControlFlow<()> {
        if prisms.pieces().is_empty() {
            return ControlFlow::Continue(());
        }
        let buckets = prisms.buckets();
        let (near, far) = self.distance;
        let uav = [self.uav.x, self.uav.y];
        let (origin, shape) = ([buckets.origin.0, buckets.origin.1], [buckets.shape.0, buckets.shape.1]);
        let (from_origin, across_origin) =
            (uav[self.axis] - origin[self.axis], uav[1 - self.axis] - origin[1 - self.axis]);
        // Positions in buckets, from the first one on.
        let bucket = |at: f64, n: i64| {
            #[expect(clippy::cast_possible_truncation, reason = "saturates, and is clamped")]
            let k = (at / as_f64(buckets.size)).floor() as i64;
            k.clamp(0, n - 1)
        };
        // The receivers may be on both sides of the UAV.
        let on_both_sides = near <= 0.0;
        let (low, high) = match (on_both_sides, self.is_mirrored) {
            (true, _) => (-far, far),
            (false, true) => (-far, 0.0),
            (false, false) => (0.0, far),
        };
        let (n_along, n_across) = (shape[self.axis], shape[1 - self.axis]);
        let first = bucket(as_f64(from_origin) + low - 2.0, n_along);
        let last = bucket(as_f64(from_origin) + high + 2.0, n_along);
        for k in first..=last {
            let row = if self.is_mirrored { k } else { last - (k - first) };
            // Distances of the row from the UAV, and its part of the rays.
            let (south, north) =
                (as_f64(row * buckets.size - from_origin), as_f64((row + 1) * buckets.size - from_origin));
            let (from, to) = if self.is_mirrored { (-north, -south) } else { (south, north) };
            let (start, end) =
                if on_both_sides { (0.0, 1.0) } else { ((from / far).clamp(0.0, 1.0), (to / near).clamp(0.0, 1.0)) };
            // Lowest height of the rays there; a step is more than the error of all of this.
            let lowest = self.rise * if self.rise > 0.0 { start } else { end } + as_f64(self.uav.z) - 1.0;
            // Rays that rise towards the UAV are higher in all later rows.
            if self.rise <= 0.0 && f64::from(prisms.max_top()) <= lowest {
                return ControlFlow::Continue(());
            }
            let west = self.across.0 * if self.across.0 < 0.0 { end } else { start } - 2.0;
            let east = self.across.1 * if self.across.1 < 0.0 { start } else { end } + 2.0;
            let across = |at: f64| bucket(as_f64(across_origin) + at, n_across);
            for col in across(west)..=across(east) {
                let (east, north) = if self.axis == 1 { (col, row) } else { (row, col) };
                let Some((max_top, pieces)) = buckets.at(east, north) else { continue };
                if f64::from(max_top) <= lowest {
                    continue;
                }
                for &number in pieces {
                    let piece = &prisms.pieces()[number as usize];
                    // A piece that is too low here may not be in a later bucket.
                    if f64::from(piece.top) > lowest && visits.is_first(number) {
                        visit(piece)?;
                    }
                }
            }
        }
        ControlFlow::Continue(())
    }
}
