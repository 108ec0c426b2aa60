//! Shadows of the plateaus of a raster over a curved earth, as bounds on what its cells hide.
//!
//! **Why.** A sweep takes 3 ns a cell for any raster. For a raster of few flat blocks, shadows of
//! prisms take a quarter of it. But over a curved earth cells are lowered one by one, each by the
//! rounded drop of its center, while prisms are curved.
//!
//! **Method.** The two differ nowhere by more than some steps of the lattice. One part is half a
//! step for the rounding. The other is the change of the drop from the center of a cell to its
//! corners, r away: c (2 d r + r²) at a distance d, c = 1/2KR.
//!
//! Let s be more than that. If the link is clear of the columns, the link with both ends raised by
//! 2s is clear of the prisms. If columns hide the link, prisms hide it with both ends lowered by
//! 2s. One s is for the obstacles. The other is for the receiver, which is lowered by a rounded
//! drop as well. Receivers between the two bounds are decided by the columns.
//!
//! **Ground.** Cells outside the plateaus are the ground, which the prisms lack. It hides no
//! receiver if rays climb by more than 2s before they leave the receiver's own cell, half a cell
//! away. From there on the ground falls away and stays below them.

use super::{ShadowGrid, ShadowScene, shadow_los};
use crate::height_field::{Bulge, CurvedGround, Plateaus};
use crate::quantity::{LatticePoint, STEPS_PER_UNIT};
use crate::raster::{BitGrid, CellWindow};
use crate::simd::SimdLevel;

/// Distance from the center of a cell to its corner, with a step for a UAV whose position is
/// rounded \[lattice steps\].
const HALF_DIAGONAL: f64 = 0.7072 * STEPS_PER_UNIT as f64 + 1.0;

/// The plateaus of a raster as one UAV sees them over a curved earth, with receivers at one height
/// beside them.
#[derive(Debug)]
pub(super) struct CurvedPlateaus<'a> {
    pub(super) plateaus: &'a Plateaus,
    pub(super) bulge: Bulge,
    pub(super) grid: &'a ShadowGrid,
    pub(super) level: SimdLevel,
    pub(super) n_bands: usize,
}

impl CurvedPlateaus<'_> {
    /// Returns the wanted receivers that surely are in line of sight, and those that possibly are;
    /// `None` if the ground may hide some. Receivers are at height `z` over a flat earth and within
    /// a window.
    pub(super) fn bounds(
        &self,
        uav: LatticePoint,
        z: i64,
        (wanted, window): (&BitGrid, CellWindow),
    ) -> Option<(BitGrid, BitGrid)> {
        let shift = 2 * self.difference(uav, z, window)?;
        let earth = Some(CurvedGround { bulge: self.bulge, ground: None });
        let prisms = &self.plateaus.prisms().on_earth(earth);
        let cast = |wanted: &BitGrid, by: i64| {
            let (grid, level, n_bands) = (self.grid, self.level, self.n_bands);
            let scene = ShadowScene { prisms, casters: prisms.casters(), grid, wanted, level, n_bands };
            shadow_los(&scene, LatticePoint { z: uav.z + by, ..uav }, z + by).los
        };
        let perhaps = cast(wanted, shift);
        Some((cast(&perhaps, -shift), perhaps))
    }

    /// Returns a bound on the difference between a cell and a prism of its height \[lattice
    /// steps\]. Returns `None` if that difference, or the earth, may hide receivers that no prism
    /// hides.
    fn difference(&self, uav: LatticePoint, z: i64, window: CellWindow) -> Option<i64> {
        let CellWindow { row, col, n_rows, n_cols } = window;
        let farthest_of = |along: &[i64], at: i64| {
            along.iter().fold(0, |most, v| most.max((v - at).abs())) + i64::from(STEPS_PER_UNIT)
        };
        #[expect(clippy::cast_precision_loss, reason = "lengths of at most 2^27 steps, heights of at most 2^29")]
        let (east, north, rise) = (
            farthest_of(&self.grid.xs[col..col + n_cols], uav.x) as f64,
            farthest_of(&self.grid.ys[row..row + n_rows], uav.y) as f64,
            (uav.z - z) as f64,
        );
        let (c, distance) = (self.bulge.coefficient(), east.hypot(north));
        let difference = (c * HALF_DIAGONAL * (2.0 * distance + HALF_DIAGONAL) + 0.5).floor() + 1.0;
        let climb = (rise - c * distance * distance) / distance * f64::from(STEPS_PER_UNIT / 2);
        #[expect(clippy::cast_possible_truncation, reason = "less than a climb")]
        (climb > 2.0 * difference).then_some(difference as i64)
    }
}
