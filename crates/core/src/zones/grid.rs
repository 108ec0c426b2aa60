//! The zones of a generated city, by construction.
//!
//! Streets are {x mod T ≤ s} and {y mod T ≤ s}; a crossroad is the intersection of both. Positions
//! are compared on the lattice of the buildings.

use super::zone::{NONE, Zone};
use crate::city::BuiltUp;
use crate::height_field::HeightField;

/// Returns the zone codes of the cells, row by row from the north-west. An open cell in the place
/// of a building, beyond the edge of the city, is street.
pub(super) fn codes(field: &HeightField, built_up: &BuiltUp) -> Vec<u8> {
    let (xs, ys) = field.positions().on_prisms();
    let along: Vec<bool> = xs.into_iter().map(|x| built_up.building_at(x).is_none()).collect();
    let cells = field.cells();
    let mut codes = Vec::with_capacity(field.grid().n_cells());
    for (row, y) in ys.into_iter().enumerate() {
        let across = built_up.building_at(y).is_none();
        codes.extend(along.iter().enumerate().map(|(col, along)| {
            if cells.building.contains(row, col) {
                Zone::Rooftop.code()
            } else if !cells.open.contains(row, col) {
                NONE
            } else if *along && across {
                Zone::Crossroad.code()
            } else {
                Zone::Street.code()
            }
        }));
    }
    codes
}
