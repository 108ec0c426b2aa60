//! The layers of heights, cell by cell: least receiver height, margin, and the least height of the UAV.

use super::row_bands::Row;
use super::{HeightLayers, Uav};
use crate::height_field::{GridPositions, HeightField, Place, Station};
use crate::los::{GridHeights, GridReceivers, link_least_height, link_least_receiver_heights};
use crate::quantity::{MAX_HEIGHT_M, STEPS_PER_UNIT, VOID, meters};
use crate::raster::set_bits;

/// The least heights of the links of receivers of one kind, as far as they are asked for and the engine finds them at once.
#[derive(Debug, Default)]
pub(super) struct FoundHeights {
    pub(super) of_receivers: Option<GridHeights>,
    pub(super) of_uav: Option<GridHeights>,
}

/// The layers of heights, cell by cell.
pub(super) struct CellHeights<'a> {
    field: &'a HeightField,
    uav: &'a Uav,
    layers: HeightLayers,
    /// Lowest height that a UAV may have at its place \[1/1024 m\].
    surface_under_uav: i32,
}

impl<'a> CellHeights<'a> {
    pub(super) fn new(field: &'a HeightField, uav: &'a Uav, layers: HeightLayers) -> Self {
        CellHeights { field, uav, layers, surface_under_uav: surface_under(field, &uav.station.place) }
    }

    /// The lowest height that the UAV may have \[1/1024 m\]: [`VOID`], below all others, if none is known.
    pub(super) fn lowest_uav_height(&self) -> i32 {
        self.surface_under_uav
    }

    /// Fills the layers of a row for some receivers, of which those in `los` are in line of sight.
    pub(super) fn fill(
        &self,
        out: &mut Row<'_>,
        positions: &GridPositions,
        receivers: &GridReceivers<'_>,
        row: usize,
        (wanted, los): (&[u64], &[u64]),
        found: &FoundHeights,
    ) {
        if !self.layers.has_heights() {
            return;
        }
        let first = row * self.field.grid().n_cols();
        for col in set_bits(wanted) {
            let z = receivers.height(first + col);
            let receiver = || Station { place: positions.center(row, col), z };
            let is_los = los[col / 64] >> (col % 64) & 1 == 1;
            if self.layers.margin || self.layers.least_receiver_height {
                let base = receivers.base(first + col);
                let of = |height: f64| with_margin(height, z, base, is_los);
                let found = found.of_receivers.as_ref().and_then(|heights| heights.settled((row, col), of));
                let (least, margin) =
                    found.unwrap_or_else(|| least_height_and_margin(self.field, self.uav, &receiver(), base));
                debug_assert_eq!(is_los, margin >= 0.0);
                out.set_heights(col, (least, margin));
            }
            if let Some(v) = out.least_height.get_mut(col) {
                let of = |height: f64| self.least_uav_height(height);
                let found = found.of_uav.as_ref().and_then(|heights| heights.settled((row, col), of));
                *v = found.unwrap_or_else(|| {
                    let lowest = i64::from(self.surface_under_uav);
                    of(link_least_height(self.field, &self.uav.station, &receiver(), lowest))
                });
            }
        }
    }

    /// The least height of the UAV \[m\] from one that must not be below the surface \[1/1024 m\]; infinite where no height that it
    /// can have is enough.
    fn least_uav_height(&self, least: f64) -> f32 {
        match least.max(floor_of(self.surface_under_uav)) / f64::from(STEPS_PER_UNIT) {
            least if least > MAX_HEIGHT_M => f32::INFINITY,
            least if least < -MAX_HEIGHT_M => f32::NEG_INFINITY,
            least => narrow(least),
        }
    }
}

/// The least visible height of a receiver \[m above the datum\], not below what it stands on, and its margin \[m\], whose sign is exact.
pub(super) fn least_height_and_margin(field: &HeightField, uav: &Uav, receiver: &Station, base: i32) -> (f32, f32) {
    let least = link_least_receiver_heights(field, &uav.station, receiver);
    with_margin(least.height_steps(), receiver.z, base, least.is_los)
}

/// A least visible height \[m\] and the margin of a receiver at height `z` on `base`, in line of sight or not, from a least height \[1/1024 m\].
pub(super) fn with_margin(least: f64, z: i64, base: i32, is_los: bool) -> (f32, f32) {
    let least = least.max(f64::from(base)) / f64::from(STEPS_PER_UNIT);
    #[expect(clippy::cast_precision_loss, reason = "heights are at most 2^27 steps")]
    let height = z as f64 / f64::from(STEPS_PER_UNIT);
    // The sign is decided exactly; rounding to f32 must not turn it.
    let margin = narrow(height - least);
    (narrow(least), if is_los { margin.max(0.0) + 0.0 } else { margin.min(-f32::MIN_POSITIVE) })
}

/// The surface that a UAV at a place must not be below \[1/1024 m\]: the ground, or the roof or surface there; [`VOID`] if
/// none is known.
pub fn surface_under(field: &HeightField, place: &Place) -> i32 {
    field.below_uav(place).surface
}

/// A surface as the least height over it \[1/1024 m\]; nothing known bounds nothing.
fn floor_of(surface: i32) -> f64 {
    if surface == VOID { f64::NEG_INFINITY } else { meters(surface) * f64::from(STEPS_PER_UNIT) }
}

#[expect(clippy::cast_possible_truncation, reason = "layers are stored as f32, 4 mm at 32 km")]
fn narrow(v: f64) -> f32 {
    v as f32
}
