//! Solids along a line of the plane: pieces and cells that a vertical plane cuts or runs along.
//!
//! Within the plane a wall is solid where there are pieces on both sides, up to the lower top. So a
//! piece with an edge along the line counts only in a pair with one on the other side. The same
//! holds for cells along a grid line.

use super::super::cell_walk::CellWalk;
use super::seen::Seen;
use crate::height_field::{Columns, Prisms};
use crate::quantity::{LatticePoint, VOID};

/// A piece with an edge along the line.
struct WallSide {
    piece: usize,
    is_left: bool,
    /// Range of the edge along the longer component of the line.
    range: [i64; 2],
}

/// Visits the pieces above `lowest` that a line crosses, each alone, and those along a wall in
/// pairs.
///
/// Cost: the pieces listed by the buckets along the line, and pairs of walls on it.
pub(super) fn pieces_along(
    prisms: &Prisms,
    [from, to]: [LatticePoint; 2],
    lowest: i64,
    mut visit: impl FnMut(&[usize]),
) {
    let (dx, dy) = (to.x - from.x, to.y - from.y);
    let side = |v: [i32; 2]| dx * (i64::from(v[1]) - from.y) - dy * (i64::from(v[0]) - from.x);
    let along = |v: [i32; 2]| i64::from(if dx.abs() >= dy.abs() { v[0] } else { v[1] });
    let mut walls: Vec<WallSide> = Vec::new();
    let mut seen = Seen::of(prisms.pieces().len());
    let buckets = prisms.buckets();
    let relative = |p: LatticePoint| (p.x - buckets.origin.0, p.y - buckets.origin.1);
    let mut walk = CellWalk::new(relative(from), relative(to), [buckets.size; 2]);
    loop {
        for &index in buckets.at(walk.cell.0, walk.cell.1).map_or(&[][..], |(_, items)| items) {
            let index = index as usize;
            let piece = &prisms.pieces()[index];
            if i64::from(piece.top) <= lowest || !seen.is_new(index) {
                continue;
            }
            let ring = prisms.ring(piece);
            let [is_left, is_right] = [1, -1].map(|sign| ring.iter().any(|v| side(*v).signum() == sign));
            if is_left && is_right {
                visit(&[index]);
                continue;
            }
            let on_line = || ring.iter().filter(|v| side(**v) == 0).map(|v| along(*v));
            if let (Some(first), Some(last)) = (on_line().min(), on_line().max())
                && first < last
            {
                walls.push(WallSide { piece: index, is_left, range: [first, last] });
            }
        }
        if walk.exit().is_none() {
            break;
        }
        walk.advance();
    }
    let (left, right): (Vec<WallSide>, Vec<WallSide>) = walls.into_iter().partition(|wall| wall.is_left);
    for a in &left {
        for b in right.iter().filter(|b| a.range[0].max(b.range[0]) < a.range[1].min(b.range[1])) {
            visit(&[a.piece, b.piece]);
        }
    }
}

/// A cell, or two along a grid line, below a line.
pub(super) struct CellAlong {
    /// Cells east and north of the south-west corner.
    pub(super) at: (i64, i64),
    /// Index of the cell with the lower top.
    pub(super) index: usize,
    pub(super) top: i32,
}

/// Visits the cells above `lowest` that a line crosses; where it runs along a grid line, the lower
/// of both sides.
pub(super) fn cells_along(
    columns: &Columns,
    [from, to]: [LatticePoint; 2],
    lowest: i64,
    mut visit: impl FnMut(&CellAlong),
) {
    let [width, height] = columns.steps();
    let is_along_column = from.x == to.x && from.x.rem_euclid(width) == 0;
    let is_along_row = from.y == to.y && from.y.rem_euclid(height) == 0;
    let mut walk = CellWalk::new((from.x, from.y), (to.x, to.y), [width, height]);
    loop {
        let at = walk.cell;
        let beyond = match (is_along_column, is_along_row) {
            (true, _) => (at.0 - 1, at.1),
            (_, true) => (at.0, at.1 - 1),
            _ => at,
        };
        let top = |cell: (i64, i64)| columns.top(cell.0, cell.1);
        let lower = if top(beyond) < top(at) { beyond } else { at };
        if let Some(index) = columns.index(lower.0, lower.1)
            && top(lower) > VOID
            && i64::from(top(lower)) > lowest
        {
            visit(&CellAlong { at, index, top: top(lower) });
        }
        if walk.exit().is_none() {
            return;
        }
        walk.advance();
    }
}
