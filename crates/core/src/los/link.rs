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
        && field.columns().is_none_or(|c| columns_los(c, uav.on_columns(), field.seen_on_columns(receiver)))
}

/// Least visible heights of a receiver past each solid of a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeastHeights {
    /// Past the prisms.
    pub prisms: LeastHeight,
    /// Past the columns. Over a curved earth the terrain below footprints is as the UAV sees it,
    /// lower by `columns_drop`.
    pub columns: LeastHeight,
    /// Drop of the columns at the receiver \[1/1024 m\].
    pub columns_drop: i32,
    /// `true` if the receiver is in line of sight at its own height; exact.
    pub is_los: bool,
}

impl LeastHeights {
    /// Returns the least visible height past both solids \[1/1024 m above the datum\].
    pub fn height_steps(&self) -> f64 {
        self.prisms.height_steps().max(self.columns_height_steps())
    }

    /// Returns the least visible height past the columns \[1/1024 m above the datum\].
    pub fn columns_height_steps(&self) -> f64 {
        self.columns.height_steps() + f64::from(self.columns_drop)
    }
}

/// Returns the least visible height past each solid at the receiver's place. The receiver is LoS
/// from the higher one up.
pub fn link_least_receiver_heights(field: &HeightField, uav: &Station, receiver: &Station) -> LeastHeights {
    let seen_on_columns = field.seen_on_columns(receiver);
    let of_prisms = |p| prisms_least_receiver_height(p, uav.on_prisms(), receiver.on_prisms());
    let of_columns = |c| columns_least_receiver_height(c, uav.on_columns(), seen_on_columns);
    let prisms = field.prisms().map_or(LeastHeight::Clear, of_prisms);
    let columns = field.columns().map_or(LeastHeight::Clear, of_columns);
    let is_los = match field.prisms().filter(|prisms| prisms.earth().is_some() || prisms.are_sloped()) {
        Some(_) => link_los(field, uav, receiver),
        None => prisms.is_met_by(receiver.z) && columns.is_met_by(receiver.z),
    };
    let columns_drop = i32::try_from(receiver.z - seen_on_columns.z).unwrap_or(0);
    LeastHeights { prisms, columns, columns_drop, is_los }
}

/// Returns the least UAV height over its place, not below `floor`, that sees the receiver \[1/1024
/// m above the datum\].
pub(crate) fn link_least_height(field: &HeightField, uav: &Station, receiver: &Station, floor: i64) -> f64 {
    let of_prisms = |p| prisms_least_height_above(p, uav.on_prisms(), receiver.on_prisms(), floor).height_steps();
    let of_columns =
        |c| columns_least_height_above(c, uav.on_columns(), field.seen_on_columns(receiver), floor).height_steps();
    #[expect(clippy::cast_precision_loss, reason = "heights are far below 2^53")]
    let least = field.prisms().map_or(floor as f64, |p| of_prisms(p).max(floor as f64));
    field.columns().map_or(least, |c| of_columns(c).max(least))
}

/// Returns the least lattice height of a UAV over its place, not below `floor`, that sees the
/// receiver \[1/1024 m\]. Returns `None` if no height does. Exact.
pub(crate) fn link_least_step(field: &HeightField, uav: &Station, receiver: &Station, floor: i64) -> Option<i64> {
    let prisms = |floor| match field.prisms() {
        Some(p) => prisms_least_step(p, uav.on_prisms(), receiver.on_prisms(), floor),
        None => Some(floor),
    };
    let columns = |floor| match field.columns() {
        Some(c) => columns_least_step(c, uav.on_columns(), field.seen_on_columns(receiver), floor),
        None => Some(floor),
    };
    prisms(floor).and_then(columns)
}
