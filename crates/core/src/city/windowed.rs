//! Scenes read window by window.

use super::Solids;
use crate::error::Result;
use crate::raster::{CellWindow, GeoRef};

/// The solids of a scene read window by window.
pub trait WindowedSolids: Sync {
    /// Returns the grid of receivers, whose cells are those of the columns.
    fn grid(&self) -> &GeoRef;

    /// Returns the base of the receivers.
    fn base(&self) -> WindowedBase;

    /// Returns the solids over the cells of a window: [`Solids::Raster`].
    fn solids(&self, window: CellWindow) -> Result<Solids>;
}

/// The base on which the receivers of a windowed scene stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WindowedBase {
    /// The surface.
    Surface,
    /// A plane \[1/1024 m above the datum\].
    Flat(i32),
    /// A terrain.
    Terrain,
}

/// Rows of a strip: those of a tile of the GeoTIFFs that are written.
pub const STRIP_ROWS: usize = 256;

/// Splits a grid into strips of whole rows from the north, the last of what is left.
pub fn strips(grid: &GeoRef) -> impl Iterator<Item = CellWindow> {
    let (n_rows, n_cols) = (grid.n_rows(), grid.n_cols());
    (0..n_rows).step_by(STRIP_ROWS).map(move |row| CellWindow {
        row,
        col: 0,
        n_rows: STRIP_ROWS.min(n_rows - row),
        n_cols,
    })
}
