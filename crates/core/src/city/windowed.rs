//! Scenes that are read window by window.

use super::Solids;
use crate::error::Result;
use crate::raster::{CellWindow, GeoRef};

/// The solids of a scene that is read window by window.
pub trait WindowedSolids: Sync {
    /// The grid of receivers, whose cells are those of the columns.
    fn grid(&self) -> &GeoRef;

    /// What receivers stand on.
    fn base(&self) -> WindowedBase;

    /// The solids over the cells of a window: [`Solids::Raster`].
    fn solids(&self, window: CellWindow) -> Result<Solids>;
}

/// What the receivers of a windowed scene stand on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WindowedBase {
    /// The surface.
    Surface,
    /// A plane \[1/1024 m above the datum\].
    Flat(i32),
    /// A terrain.
    Terrain,
}

/// Whole rows of a grid, as many as a row of tiles holds, from the north.
pub fn row_bands(grid: &GeoRef) -> impl Iterator<Item = CellWindow> {
    const ROWS: usize = 256;
    let (n_rows, n_cols) = (grid.n_rows(), grid.n_cols());
    (0..n_rows).step_by(ROWS).map(move |row| CellWindow { row, col: 0, n_rows: ROWS.min(n_rows - row), n_cols })
}
