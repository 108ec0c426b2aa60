//! One link of a scene: both solids together, each on its own lattice.

use super::columns_ray::columns_least_height_above;
use super::prisms_ray::prisms_least_height_above;
use super::{
    LeastHeight, columns_least_receiver_height, columns_least_step, columns_los, prisms_least_receiver_height,
    prisms_least_step, prisms_los,
};
use crate::height_field::{HeightField, Station};

/// Decides whether a link is LoS: clear of the prisms and clear of the columns.
#[inline]
pub fn link_los(field: &HeightField, uav: &Station, receiver: &Station) -> bool {
    field.prisms().is_none_or(|p| prisms_los(p, uav.on_prisms(), receiver.on_prisms()))
        && field.columns().is_none_or(|c| columns_los(c, uav.on_columns(), receiver.on_columns()))
}

/// The least visible height of each solid at the receiver's place, prisms first: the receiver is LoS from the higher one up.
pub fn link_least_receiver_heights(
    field: &HeightField,
    uav: &Station,
    receiver: &Station,
) -> (LeastHeight, LeastHeight) {
    let of_prisms = |p| prisms_least_receiver_height(p, uav.on_prisms(), receiver.on_prisms());
    let of_columns = |c| columns_least_receiver_height(c, uav.on_columns(), receiver.on_columns());
    (field.prisms().map_or(LeastHeight::Clear, of_prisms), field.columns().map_or(LeastHeight::Clear, of_columns))
}

/// The least UAV height over its place, not below `floor`, that sees the receiver \[1/1024 m above the datum\].
pub(crate) fn link_least_height(field: &HeightField, uav: &Station, receiver: &Station, floor: i64) -> f64 {
    let of_prisms = |p| prisms_least_height_above(p, uav.on_prisms(), receiver.on_prisms(), floor).height_steps();
    let of_columns = |c| columns_least_height_above(c, uav.on_columns(), receiver.on_columns(), floor).height_steps();
    #[expect(clippy::cast_precision_loss, reason = "heights are far below 2^53")]
    let least = field.prisms().map_or(floor as f64, |p| of_prisms(p).max(floor as f64));
    field.columns().map_or(least, |c| of_columns(c).max(least))
}

/// The least lattice height of a UAV over its place, not below `floor`, that sees the receiver \[1/1024 m\]; `None` where
/// no height does. Exact.
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
