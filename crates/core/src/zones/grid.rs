//! The zones of a generated city, by construction: streets are {x mod T ≤ s} and {y mod T ≤ s}, and a crossroad is where
//! both hold. Positions are compared on the lattice, where the buildings are.

use super::zone::{NONE, Zone};
use crate::city::BuiltUp;
use crate::height_field::HeightField;
use crate::quantity::STEPS_PER_UNIT;

/// The zone codes of the cells, row by row from the north-west. An open cell in the place of a building, beyond the edge
/// of the city, is street.
pub(super) fn codes(field: &HeightField, built_up: &BuiltUp) -> Vec<u8> {
    let positions = field.positions();
    let along: Vec<bool> = positions.prisms_xs().map(|x| is_street(built_up, x)).collect();
    let cells = field.cells();
    let mut codes = Vec::with_capacity(field.grid().n_cells());
    for (row, y) in positions.prisms_ys().enumerate() {
        let across = is_street(built_up, y);
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

/// Whether a position along x or y \[1/1024 m\] is in no building's open span.
fn is_street(built_up: &BuiltUp, v: i64) -> bool {
    #[expect(clippy::cast_possible_truncation, reason = "a city has far fewer than 2^31 columns")]
    let k = (v as f64 / f64::from(STEPS_PER_UNIT) / built_up.period()).floor() as i32;
    (k - 1..=k + 1).all(|k| {
        let [from, to] = built_up.building_span(k);
        v <= from || v >= to
    })
}
