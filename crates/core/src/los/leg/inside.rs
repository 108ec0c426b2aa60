//! Parts of a leg inside a building or below the ground.

use super::super::cell_walk::CellWalk;
use super::Leg;
use super::half_space::{HalfSpace, walls_of, walls_of_cell};
use super::links::Links;
use super::place::{LegPart, merged_parts};
use super::upright::pieces_along;
use crate::height_field::{Columns, HeightField, Prisms};
use crate::quantity::VOID;

/// Returns the parts of a leg inside a building or below the ground, sorted and disjoint.
///
/// There no receiver can be placed: it would be in the interior of the prisms, or below the roof or
/// the ground of a cell. On a grid line the cell to the north-east counts. Ground that is not known
/// counts as absent.
pub fn inside_parts(field: &HeightField, leg: &Leg) -> Vec<LegPart> {
    let mut parts = Vec::new();
    if let Some(prisms) = field.prisms() {
        let ends = [leg.from.on_prisms(), leg.to.on_prisms()];
        inside_prisms(prisms, &Links::new(ends[0], ends, leg.window), &mut parts);
    }
    let ends = [leg.from.on_columns(), leg.to.on_columns()];
    let along = Links::new(ends[0], ends, leg.window);
    if let Some(columns) = field.columns() {
        below_cells(field, columns, &along, &mut parts);
    }
    if let Some(ground) = field.flat_ground() {
        parts.extend(along.part_below(leg.window.part(), &HalfSpace::below(ground)));
    }
    merged_parts(parts)
}

/// Adds the parts of a leg in the interior of prisms.
pub(super) fn inside_prisms(prisms: &Prisms, leg: &Links, parts: &mut Vec<LegPart>) {
    if leg.along[..2] == [0, 0] {
        if let Some((height, _)) = prisms.exact_solid_at(leg.start.x, leg.start.y) {
            let den = i128::from(height.den);
            let room = height.num - i128::from(leg.start.z) * den;
            parts.extend(leg.window.part().where_above_zero(room, -i128::from(leg.along[2]) * den));
        }
        return;
    }
    pieces_along(prisms, leg.ends_in_plane(), leg.lowest(), |pieces| {
        let of_piece = |&index: &usize| {
            let piece = &prisms.pieces()[index];
            let part = leg.part_inside(walls_of(prisms.ring(piece)))?;
            leg.part_below(part, &HalfSpace::below_piece(prisms, piece))
        };
        let all = pieces.iter().map(of_piece).try_fold(leg.window.part(), |all, part| all.and(&part?));
        parts.extend(all);
    });
}

/// Adds the parts of a leg below the roof or the ground of the cell that holds them.
fn below_cells(field: &HeightField, columns: &Columns, leg: &Links, parts: &mut Vec<LegPart>) {
    let mut visit = |at: (i64, i64)| {
        let Some(height) = columns.index(at.0, at.1).map(|index| field.indoors_below_at(index)) else { return };
        if height > VOID
            && let Some(part) = leg.part_inside(walls_of_cell(columns, at))
        {
            parts.extend(leg.part_below(part, &HalfSpace::below(height)));
        }
    };
    let [width, height] = columns.steps();
    let (start, end) = (leg.start, leg.end);
    if (start.x, start.y) == (end.x, end.y) {
        visit((start.x.div_euclid(width), start.y.div_euclid(height)));
        return;
    }
    let mut walk = CellWalk::new((start.x, start.y), (end.x, end.y), [width, height]);
    loop {
        visit(walk.cell);
        if walk.exit().is_none() {
            return;
        }
        walk.advance();
    }
}
