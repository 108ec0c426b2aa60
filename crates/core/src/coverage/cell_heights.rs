//! Layers of heights, cell by cell: least receiver height, margin, and least height of the UAV.

use super::HeightLayers;
use super::output_rows::Row;
use super::view::{SeenReceivers, Threads, View};
use crate::height_field::{HeightField, Place};
use crate::los::{GridHeights, link_least_height, link_least_receiver_heights};
use crate::quantity::{MAX_HEIGHT_M, STEPS_PER_UNIT, VOID, meters};
use crate::raster::{BitGrid, set_bits};

/// Least heights of the links of receivers of one kind, as far as an engine finds them at once.
#[derive(Debug, Default)]
pub(super) struct FoundHeights {
    of_receivers: Option<GridHeights>,
    of_uav: Option<GridHeights>,
}

/// Layers of heights of one UAV's map.
#[derive(Debug, Clone, Copy)]
pub(super) struct CellHeights {
    layers: HeightLayers,
    /// Lowest height that a UAV may have at its place \[1/1024 m\]; [`VOID`], below all others, if
    /// none is known.
    lowest_uav_height: i32,
}

impl CellHeights {
    pub(super) fn new(view: &View<'_>, layers: HeightLayers) -> Self {
        CellHeights { layers, lowest_uav_height: view.scene().below_uav().surface }
    }

    /// Returns heights of receivers in range that the engine finds at once, and which of them are
    /// in line of sight if it finds both together.
    pub(super) fn found(&self, receivers: &SeenReceivers<'_>, in_range: &BitGrid) -> (FoundHeights, Option<BitGrid>) {
        let lowest = i64::from(self.lowest_uav_height);
        let of_uav = self.layers.least_height.then(|| receivers.least_uav_heights(in_range, lowest)).flatten();
        let of_receivers = self.layers.margin || self.layers.least_receiver_height;
        let found = of_receivers.then(|| receivers.los_and_least_heights(in_range, Threads::All)).flatten();
        let (los, of_receivers) = found.unzip();
        (FoundHeights { of_receivers, of_uav }, los)
    }

    /// Fills the layers of a row for some receivers, of which those in `los` are in line of sight.
    pub(super) fn fill(
        &self,
        out: &mut Row<'_>,
        receivers: &SeenReceivers<'_>,
        row: usize,
        (wanted, los): (&[u64], &[u64]),
        found: &FoundHeights,
    ) {
        if !self.layers.has_heights() {
            return;
        }
        for col in set_bits(wanted) {
            let cell = (row, col);
            if self.layers.margin || self.layers.least_receiver_height {
                let is_los = los[col / 64] >> (col % 64) & 1 == 1;
                let (least, margin) = receivers.least_height_and_margin(cell, is_los, found.of_receivers.as_ref());
                debug_assert_eq!(is_los, margin >= 0.0);
                out.set_heights(col, (least, margin));
            }
            if let Some(v) = out.least_height.get_mut(col) {
                let of = |height: f64| self.least_uav_height(height);
                let found = found.of_uav.as_ref().and_then(|heights| heights.settled(cell, of));
                *v = found.unwrap_or_else(|| of(receivers.least_uav_height(cell, self.lowest_uav_height.into())));
            }
        }
    }

    /// Returns the least height of the UAV \[m\] from one that must not be below the surface
    /// \[1/1024 m\]; infinite where no height that it can have is enough.
    fn least_uav_height(&self, least: f64) -> f32 {
        match least.max(floor_of(self.lowest_uav_height)) / f64::from(STEPS_PER_UNIT) {
            least if least > MAX_HEIGHT_M => f32::INFINITY,
            least if least < -MAX_HEIGHT_M => f32::NEG_INFINITY,
            least => narrow(least),
        }
    }
}

impl SeenReceivers<'_> {
    /// Returns the least visible height over a receiver's cell \[m\], not below what the receiver
    /// stands on, and its margin \[m\], whose sign is exact. Taken from heights that were found at
    /// once, if they settle it; else one walk finds it.
    #[inline(always)]
    pub(super) fn least_height_and_margin(
        &self,
        cell: (usize, usize),
        is_los: bool,
        found: Option<&GridHeights>,
    ) -> (f32, f32) {
        let (z, base) = (self.height(cell), self.base(cell));
        let settled = found.and_then(|heights| heights.settled(cell, |height| with_margin(height, z, base, is_los)));
        settled.unwrap_or_else(|| self.walked_height_and_margin(cell))
    }

    /// Returns the same as [`SeenReceivers::least_height_and_margin`], by one walk.
    #[inline(never)]
    pub(super) fn walked_height_and_margin(&self, cell: (usize, usize)) -> (f32, f32) {
        let (receiver, scene) = (self.station(cell), self.view.scene());
        let least = link_least_receiver_heights(scene.field(), &scene.uav().station, &receiver);
        with_margin(least.height_steps(), receiver.z, self.base(cell), least.is_los)
    }

    /// Returns the least height of the UAV, not below `lowest`, that sees a receiver \[1/1024 m\],
    /// by one walk.
    fn least_uav_height(&self, cell: (usize, usize), lowest: i64) -> f64 {
        let scene = self.view.scene();
        link_least_height(scene.field(), &scene.uav().station, &self.station(cell), lowest)
    }
}

/// Returns a least visible height \[m\] and the margin \[m\] of a receiver at height `z` on `base`,
/// in line of sight or not, from a least height \[1/1024 m\].
pub(super) fn with_margin(least: f64, z: i64, base: i32, is_los: bool) -> (f32, f32) {
    let least = least.max(f64::from(base)) / f64::from(STEPS_PER_UNIT);
    #[expect(clippy::cast_precision_loss, reason = "heights are at most 2^27 steps")]
    let height = z as f64 / f64::from(STEPS_PER_UNIT);
    // The sign is decided exactly; rounding to f32 must not turn it.
    let margin = narrow(height - least);
    (narrow(least), if is_los { margin.max(0.0) + 0.0 } else { margin.min(-f32::MIN_POSITIVE) })
}

/// Returns the surface that a UAV at a place must not be below \[1/1024 m\]: the ground, or the
/// roof or surface there; [`VOID`] if none is known.
pub fn surface_under(field: &HeightField, place: &Place) -> i32 {
    field.below_uav(place).surface
}

/// Returns a surface as the least height over it \[1/1024 m\]; nothing known bounds nothing.
fn floor_of(surface: i32) -> f64 {
    if surface == VOID { f64::NEG_INFINITY } else { meters(surface) * f64::from(STEPS_PER_UNIT) }
}

#[expect(clippy::cast_possible_truncation, reason = "layers are stored as f32, 4 mm at 32 km")]
fn narrow(v: f64) -> f32 {
    v as f32
}
