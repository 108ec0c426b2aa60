//! The ground below a leg, in parts of one height.

use super::super::cell_walk::CellWalk;
use super::links::LegWindow;
use crate::height_field::{HeightField, Place, Station};
use crate::quantity::VOID;

/// A part of a leg over ground of one height.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GroundPart {
    /// The part.
    pub window: LegWindow,
    /// Ground \[1/1024 m above the datum\]; [`VOID`] where none is known.
    pub ground: i32,
}

/// Returns the parts of a leg between two places over ground of one height each, in their order.
///
/// The ground of a cell ends at its borders. On a border along the leg that of the cell to the
/// north or east counts.
pub fn ground_parts(field: &HeightField, from: &Place, to: &Place) -> Vec<GroundPart> {
    let whole = |ground| vec![GroundPart { window: LegWindow::WHOLE, ground }];
    if let Some(ground) = field.flat_ground() {
        return whole(ground);
    }
    let Some(columns) = field.columns() else { return whole(field.ground_at(from)) };
    let [from, to] = [from, to].map(|place| {
        let at = Station { place: *place, z: 0 }.on_columns();
        (at.x, at.y)
    });
    let mut walk = CellWalk::new(from, to, columns.steps());
    let ground_of = |cell: (i64, i64)| columns.index(cell.0, cell.1).map_or(VOID, |index| field.ground_of_cell(index));
    let (mut parts, mut start) = (Vec::new(), (0, 1));
    let mut ground = ground_of(walk.cell);
    while let Some(exit) = walk.exit() {
        walk.advance();
        let next = ground_of(walk.cell);
        // A leg that begins on a border leaves the cell before it at once.
        if next != ground {
            if exit.n > 0 {
                parts.push(GroundPart { window: LegWindow::new(start, (exit.n, exit.d)), ground });
                start = (exit.n, exit.d);
            }
            ground = next;
        }
    }
    parts.push(GroundPart { window: LegWindow::new(start, (1, 1)), ground });
    parts
}
