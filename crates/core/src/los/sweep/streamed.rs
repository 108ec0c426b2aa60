//! The sweep over columns that are not in memory: the same bounds, strip by strip.
//!
//! A quadrant is passed outward in strips of lines, each read once. A receiver that its bounds leave undecided may be
//! hidden only by the lines that they suspect ([`super`]). Those of its own strip are walked at once; for the others the
//! receiver waits, in 12 bytes, in the queue of the strip that holds the farthest of them. When the quadrant is done,
//! or the queues are full, the strips are read once more, from the outside in: each receiver is walked over the suspected
//! lines there, and is either hidden, or seen, or waits for the next strip inward.
//!
//! So every cell is read about twice, memory is that of one strip, the queues and a bit per cell, and the outcome is
//! that of [`sweep_los`](super::sweep_los), whatever the strips.

use super::super::columns_los;
use super::columns_reader::{StreamedHeights, StreamedScene};
use super::quadrant_pass::QuadrantPass;
use super::quadrants::{CELL, Quadrant, Swept, as_i64, near_cells};
use crate::error::Result;
use crate::height_field::Columns;
use crate::quantity::LatticePoint;
use crate::raster::{BitGrid, CellWindow};

/// Decides which of the wanted receivers are in line of sight, as [`sweep_los`](super::sweep_los) does for columns in
/// memory.
///
/// `passed` is called with a number of cells as they are passed, and says whether to go on; what is found after it said
/// no means nothing. Threads of the current pool share each strip.
///
/// # Errors
/// Those of the reader.
pub fn streamed_sweep_los(scene: &StreamedScene<'_>, passed: &(dyn Fn(u64) -> bool + Sync)) -> Result<Swept> {
    if i64::from(scene.max_top) <= scene.uav.z.min(scene.receivers.range().0) {
        return Ok(Swept { los: scene.wanted.clone(), undecided: 0 });
    }
    let (n_rows, n_cols) = scene.columns.shape();
    let mut los = BitGrid::new(n_rows, n_cols);
    let mut undecided = 0;
    for quadrant in [Quadrant::North, Quadrant::South, Quadrant::East, Quadrant::West] {
        let Some(pass) = QuadrantPass::new(scene, quadrant) else { continue };
        undecided += pass.run(&mut los, passed)?;
    }
    near_box(scene, &mut los)?;
    Ok(Swept { los, undecided })
}

/// Asks `ray` for the cells around the UAV that no wedge decides.
fn near_box(scene: &StreamedScene<'_>, los: &mut BitGrid) -> Result<()> {
    let (n_rows, n_cols) = scene.columns.shape();
    let (rows, cols) = near_cells(scene.uav, n_rows, CellWindow { row: 0, col: 0, n_rows, n_cols });
    if rows.is_empty() || cols.is_empty() {
        return Ok(());
    }
    let window = CellWindow { row: rows.start, col: cols.start, n_rows: rows.len(), n_cols: cols.len() };
    let (mut tops, mut bases) = (Vec::new(), Vec::new());
    scene.columns.read_tops(window, &mut tops)?;
    if matches!(scene.receivers, StreamedHeights::Over { is_top: false, .. }) {
        scene.columns.read_bases(window, &mut bases)?;
    }
    let columns = Columns::new(rows.len(), cols.len(), tops);
    let origin = (as_i64(cols.start) * CELL, as_i64(n_rows - rows.end) * CELL);
    let uav = LatticePoint { x: scene.uav.x - origin.0, y: scene.uav.y - origin.1, z: scene.uav.z };
    for row in rows.clone() {
        for col in cols.clone().filter(|col| scene.wanted.contains(row, *col)) {
            let (near_row, near_col) = (row - rows.start, col - cols.start);
            let cell = near_row * cols.len() + near_col;
            let z = match scene.receivers {
                StreamedHeights::Flat(z) => i64::from(z),
                StreamedHeights::Over { is_top, above, .. } => {
                    i64::from(if is_top { columns.tops()[cell] } else { bases[cell] }) + i64::from(above)
                }
            };
            let (x, y) = columns.center(near_row, near_col);
            if columns_los(&columns, uav, LatticePoint { x, y, z }) {
                los.insert(row, col);
            }
        }
    }
    Ok(())
}
