//! Sets of cells as shapes: their connected parts, the parts' outlines, and the cells that polygons
//! overlap.

mod cell_outline;
mod cell_parts;
mod overlapped_cells;
mod simpler_rings;

pub(crate) use cell_outline::traced_around;
pub use cell_parts::{CellPart, labelled_parts};
pub(crate) use cell_parts::{cell_parts, doubled_cells, n_cell_parts};
pub use overlapped_cells::{covered_shares, overlapped_cells};
pub(crate) use simpler_rings::simpler_rings;
