//! Branches that are shorter than their gates are wide: recesses, niches, the corners of squares.
//!
//! A branch is a part of the ground that one gate separates and that holds no cycle. A gate has a
//! branch on one side, or on both if the ground as a whole holds no cycle. The reach of a branch
//! depends only on the branches beyond the other gates of its first cell. So branches are found
//! from the dead ends on, each once, in any order.

use super::gates::Gates;
use super::mesh::Beyond;

/// Share of its gate's width below which a branch is cut off.
const SHORTEST_BRANCH_WIDTHS: f64 = 1.0;

/// Reach of a branch that ends at the frame or holds a corner of it: the street is assumed to
/// continue beyond it.
const ENDLESS: i64 = i64::MAX;

/// Cuts off branches of junctions whose reach from their gates is less than the gates' width.
/// Returns the gates as sides of the junctions.
///
/// All are cut off at once, so a branch is as long as before the cut.
pub(super) fn cut_short(gates: &mut Gates) -> Vec<usize> {
    let reaches = reaches(gates);
    let is_short = |side: &usize| is_short(gates, &reaches, *side);
    let cut: Vec<usize> = (0..gates.mesh.n_sides()).filter(is_short).collect();
    cut.iter().for_each(|side| gates.cut(*side));
    cut
}

/// Returns `true` if a side is a gate of a junction, and the branch beyond it is too short for a
/// street.
fn is_short(gates: &Gates, reaches: &[Option<i64>], side: usize) -> bool {
    let width = gates.mesh.length(side);
    reaches[side].is_some_and(|reach| (reach as f64) < SHORTEST_BRANCH_WIDTHS * width as f64)
        && gates.is_junction(gates.mesh.cell(side))
}

/// Returns the reach of the branches beyond gates, by side; `None` without a gate, or with a cycle
/// beyond it.
fn reaches(gates: &Gates) -> Vec<Option<i64>> {
    let mesh = gates.mesh;
    let mut reaches = vec![None; mesh.n_sides()];
    // Gates of each cell whose branch beyond is not known yet.
    let mut n_unknown: Vec<usize> = (0..mesh.n_cells()).map(|cell| gates.degree(cell)).collect();
    let mut open: Vec<usize> = (0..mesh.n_cells()).filter(|cell| n_unknown[*cell] == 1).collect();
    while let Some(cell) = open.pop() {
        for (gate, trunk) in gates.live(cell) {
            // With one unknown, the cell begins the branch beyond that gate. With none, it begins a
            // branch beyond each of its gates.
            let is_known = n_unknown[cell] == 0 || reaches[gate].is_none();
            if !is_known || reaches[trunk].is_some() {
                continue;
            }
            reaches[trunk] = Some(reach(gates, &reaches, gate));
            let trunk = mesh.cell(trunk);
            n_unknown[trunk] -= 1;
            if n_unknown[trunk] <= 1 {
                open.push(trunk);
            }
        }
    }
    reaches
}

/// Returns the reach, from a gate, of the branch that begins with the gate's cell.
fn reach(gates: &Gates, reaches: &[Option<i64>], gate: usize) -> i64 {
    let mesh = gates.mesh;
    let cell = mesh.cell(gate);
    let others = || gates.live(cell).map(|(side, _)| side).filter(|side| *side != gate);
    let is_end = others().all(|side| is_short(gates, reaches, side));
    let ends_at_frame = is_end && mesh.sides(cell).any(|side| mesh.beyond(side) == Beyond::Frame);
    if ends_at_frame || mesh.frame_corners(cell).next().is_some() {
        return ENDLESS;
    }
    let through = |side: usize| reaches[side].unwrap_or(0).saturating_add(mesh.distance(side, gate));
    others().map(through).fold(mesh.depth(gate), i64::max)
}
