//! Passages between cells of open ground, and the streets that they form.

use super::mesh::{Beyond, Mesh};

/// Width \[m\] below which a side is no passage.
const NARROWEST_PASSAGE_M: f64 = 1.0;

/// Share of another gate's width below which a gate counts as narrower. Without it, the mouths of
/// streets with parallel walls would depend on rounding.
const NARROWER_SHARE: f64 = 0.97;

/// Distance, in widths of the narrowest gate so far, over which the search for a narrower gate
/// continues after gates stop narrowing. The streets of a generated city are at least 0.46 times as
/// long as wide, for α ≥ 0.1.
const MOUTH_SEARCH_WIDTHS: f64 = 0.35;

/// Passages between cells. A gate is a side, seen from either of its cells.
pub(super) struct Gates<'a> {
    pub(super) mesh: &'a Mesh,
    /// By side: the same side of the cell beyond; `None` if it is no gate.
    beyond: Vec<Option<usize>>,
    /// By side: `true` for a gate at which no branch was cut off.
    is_live: Vec<bool>,
}

/// Street between two junctions, or from a junction to a dead end.
pub(super) struct Chain {
    /// Gates along it, each as a side of the cell before it. There is one more gate than cells,
    /// except at a dead end.
    pub(super) gates: Vec<usize>,
    pub(super) cells: Vec<usize>,
    /// Side by which it reaches the junction at its end; `None` at a dead end.
    pub(super) end: Option<usize>,
}

impl<'a> Gates<'a> {
    pub(super) fn of(mesh: &'a Mesh) -> Self {
        let beyond = |side: usize| match mesh.beyond(side) {
            Beyond::Open(other) if mesh.meters(mesh.length(side)) >= NARROWEST_PASSAGE_M => Some(other),
            _ => None,
        };
        let beyond: Vec<Option<usize>> = (0..mesh.n_sides()).map(beyond).collect();
        let is_live = beyond.iter().map(Option::is_some).collect();
        Gates { mesh, beyond, is_live }
    }

    /// Returns the same side of the cell beyond if the side is a gate, whether cut off or not.
    pub(super) fn beyond(&self, side: usize) -> Option<usize> {
        self.beyond[side]
    }

    /// Returns the remaining gates of a cell, each with its side of the cell beyond.
    pub(super) fn live(&self, cell: usize) -> impl Iterator<Item = (usize, usize)> {
        self.mesh.sides(cell).filter(|side| self.is_live[*side]).filter_map(|side| Some((side, self.beyond[side]?)))
    }

    /// Returns the number of remaining gates of a cell.
    pub(super) fn degree(&self, cell: usize) -> usize {
        self.live(cell).count()
    }

    /// Returns `true` if three streets or more leave a cell: through gates, or two through gates
    /// and one over a corner of the frame.
    pub(super) fn is_junction(&self, cell: usize) -> bool {
        let degree = self.degree(cell);
        degree >= 3 || (degree == 2 && self.mesh.frame_corners(cell).next().is_some())
    }

    /// Removes a gate from the cells on both sides.
    pub(super) fn cut(&mut self, side: usize) {
        self.is_live[side] = false;
        if let Some(other) = self.beyond[side] {
            self.is_live[other] = false;
        }
    }

    /// Returns the chain of cells that leaves a junction through a gate.
    pub(super) fn chain(&self, gate: usize) -> Chain {
        let mut chain = Chain { gates: vec![gate], cells: Vec::new(), end: None };
        let mut out = gate;
        while let Some(back) = self.beyond[out] {
            let cell = self.mesh.cell(back);
            if self.is_junction(cell) {
                chain.end = Some(back);
                break;
            }
            chain.cells.push(cell);
            let Some((onward, _)) = self.live(cell).find(|(side, _)| *side != back) else { break };
            chain.gates.push(onward);
            out = onward;
        }
        chain
    }

    /// Returns the position of the gate at which a chain's street begins. The search goes to the
    /// end of the narrowing, and on to a narrower gate nearby.
    pub(super) fn mouth(&self, gates: impl Iterator<Item = usize>) -> usize {
        let (mut best, mut width, mut walked) = (0, i64::MAX, 0);
        let mut last = None;
        let mut is_narrowing = true;
        for (k, gate) in gates.enumerate() {
            let length = self.mesh.length(gate);
            let is_narrower = (length as f64) < NARROWER_SHARE * width as f64;
            is_narrowing &= is_narrower;
            walked += last.map_or(0, |last| self.mesh.distance(last, gate));
            last = Some(gate);
            if !is_narrowing && walked as f64 > MOUTH_SEARCH_WIDTHS * width as f64 {
                break;
            }
            if is_narrower {
                (best, width, walked) = (k, length, 0);
            }
        }
        best
    }
}
