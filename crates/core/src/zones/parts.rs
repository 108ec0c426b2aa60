//! The connected parts of the zones, each with its outline: one crossroad, one courtyard, one block of buildings.

use super::{Zone, ZoneMap};
use crate::outlines::{CellPart, cell_parts, n_cell_parts};

impl ZoneMap {
    /// The parts of a zone, those that begin farther south first.
    ///
    /// Cost: a few operations per cell of the grid.
    pub fn parts(&self, zone: Zone) -> Vec<CellPart> {
        cell_parts(&self.cells(zone))
    }

    /// Number of parts of a zone.
    pub fn n_parts(&self, zone: Zone) -> usize {
        n_cell_parts(&self.cells(zone))
    }
}
