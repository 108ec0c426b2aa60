//! The layers of heights, cell by cell: least receiver height, margin, and the least height of the UAV.

use super::row_bands::Row;
use super::{HeightLayers, Uav};
use crate::height_field::{GridPositions, HeightField, Place, Station};
use crate::los::{GridReceivers, link_least_heights, link_least_receiver_heights};
use crate::quantity::{MAX_HEIGHT_M, STEPS_PER_UNIT, VOID, meters};
use crate::raster::set_bits;

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

    /// Fills the layers of a row for some receivers, of which those in `los` are in line of sight; `least` are the least heights of all
    /// receivers of the row that are, if they are known.
    pub(super) fn fill(
        &self,
        out: &mut Row<'_>,
        positions: &GridPositions,
        receivers: &GridReceivers<'_>,
        row: usize,
        (wanted, los): (&[u64], &[u64]),
        least: Option<&[f64]>,
    ) {
        if !self.layers.has_heights() {
            return;
        }
        let first = row * self.field.grid().n_cols();
        for col in set_bits(wanted) {
            let receiver = Station { place: positions.center(row, col), z: receivers.height(first + col) };
            let is_los = los[col / 64] >> (col % 64) & 1 == 1;
            if self.layers.margin || self.layers.least_receiver_height {
                let base = receivers.base(first + col);
                let (least, margin) = match least {
                    Some(least) => with_margin(least[col], receiver.z, base, is_los),
                    None => least_height_and_margin(self.field, self.uav, &receiver, base),
                };
                debug_assert_eq!(is_los, margin >= 0.0);
                if let Some(v) = out.least_receiver_height.get_mut(col) {
                    *v = narrow(least);
                }
                if let Some(v) = out.margin.get_mut(col) {
                    *v = margin;
                }
            }
            if let Some(v) = out.least_height.get_mut(col) {
                let (b, t) = link_least_heights(self.field, &self.uav.station, &receiver);
                let least = b.height_steps().max(t.height_steps()).max(floor_of(self.surface_under_uav));
                let least = least / f64::from(STEPS_PER_UNIT);
                *v = match least {
                    least if least > MAX_HEIGHT_M => f32::INFINITY,
                    least if least < -MAX_HEIGHT_M => f32::NEG_INFINITY,
                    least => narrow(least),
                };
            }
        }
    }
}

/// The least visible height of a receiver \[m above the datum\], not below what it stands on, and its margin \[m\], whose sign is exact.
pub(super) fn least_height_and_margin(field: &HeightField, uav: &Uav, receiver: &Station, base: i32) -> (f64, f32) {
    let (b, t) = link_least_receiver_heights(field, &uav.station, receiver);
    let is_los = b.is_met_by(receiver.z) && t.is_met_by(receiver.z);
    with_margin(b.height_steps().max(t.height_steps()), receiver.z, base, is_los)
}

/// A least visible height \[m\] and the margin of a receiver at height `z` on `base`, in line of sight or not, from a least height \[1/1024 m\].
fn with_margin(least: f64, z: i64, base: i32, is_los: bool) -> (f64, f32) {
    let least = least.max(f64::from(base)) / f64::from(STEPS_PER_UNIT);
    #[expect(clippy::cast_precision_loss, reason = "heights are at most 2^27 steps")]
    let height = z as f64 / f64::from(STEPS_PER_UNIT);
    // The sign is decided exactly; rounding to f32 must not turn it.
    let margin = narrow(height - least);
    (least, if is_los { margin.max(0.0) + 0.0 } else { margin.min(-f32::MIN_POSITIVE) })
}

/// The surface that a UAV at a place must not be below \[1/1024 m\]: the ground, or the roof or surface there; [`VOID`] if
/// none is known.
pub fn surface_under(field: &HeightField, place: &Place) -> i32 {
    field.ground_at(place).max(field.inside_prisms_below(place)).max(field.inside_columns_below(place))
}

/// A surface as the least height over it \[1/1024 m\]; nothing known bounds nothing.
fn floor_of(surface: i32) -> f64 {
    if surface == VOID { f64::NEG_INFINITY } else { meters(surface) * f64::from(STEPS_PER_UNIT) }
}

#[expect(clippy::cast_possible_truncation, reason = "layers are stored as f32, 4 mm at 32 km")]
fn narrow(v: f64) -> f32 {
    v as f32
}
