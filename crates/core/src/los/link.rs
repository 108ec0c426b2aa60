//! One link of a scene: both solids together, each on its own lattice.

use super::{
    LeastHeight, columns_least_height, columns_least_receiver_height, columns_least_step, columns_los,
    prisms_least_height, prisms_least_receiver_height, prisms_least_step, prisms_los,
};
use crate::height_field::{Columns, HeightField, Prisms, Station};
use crate::quantity::LatticePoint;

/// Decides whether a link is LoS: clear of the prisms and clear of the columns.
#[inline]
pub fn link_los(field: &HeightField, uav: &Station, receiver: &Station) -> bool {
    field.prisms().is_none_or(|p| prisms_los(p, uav.on_prisms(), receiver.on_prisms()))
        && field.columns().is_none_or(|c| columns_los(c, uav.on_columns(), receiver.on_columns()))
}

/// A least height for each solid, prisms first.
fn of_solids(
    field: &HeightField,
    (uav, receiver): (&Station, &Station),
    of_prisms: fn(&Prisms, LatticePoint, LatticePoint) -> LeastHeight,
    of_columns: fn(&Columns, LatticePoint, LatticePoint) -> LeastHeight,
) -> (LeastHeight, LeastHeight) {
    (
        field.prisms().map_or(LeastHeight::Clear, |p| of_prisms(p, uav.on_prisms(), receiver.on_prisms())),
        field.columns().map_or(LeastHeight::Clear, |c| of_columns(c, uav.on_columns(), receiver.on_columns())),
    )
}

/// The least visible height of each solid at the receiver's place, prisms first: the receiver is LoS from the higher one up.
pub fn link_least_receiver_heights(
    field: &HeightField,
    uav: &Station,
    receiver: &Station,
) -> (LeastHeight, LeastHeight) {
    of_solids(field, (uav, receiver), prisms_least_receiver_height, columns_least_receiver_height)
}

/// The least UAV height over the UAV's place that sees the receiver, for each solid, prisms first.
pub(crate) fn link_least_heights(field: &HeightField, uav: &Station, receiver: &Station) -> (LeastHeight, LeastHeight) {
    of_solids(field, (uav, receiver), prisms_least_height, columns_least_height)
}

/// The least lattice height of a UAV over its place, not below `floor`, that sees the receiver \[1/1024 m\]; `None` where
/// no height does. Exact, and cheaper than [`link_least_heights`].
pub(crate) fn link_least_step(field: &HeightField, uav: &Station, receiver: &Station, floor: i64) -> Option<i64> {
    let prisms = |floor| match field.prisms() {
        Some(p) => prisms_least_step(p, uav.on_prisms(), receiver.on_prisms(), floor),
        None => Some(floor),
    };
    let columns = |floor| match field.columns() {
        Some(c) => columns_least_step(c, uav.on_columns(), receiver.on_columns(), floor),
        None => Some(floor),
    };
    prisms(floor).and_then(columns)
}
