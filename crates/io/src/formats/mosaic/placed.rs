//! A tile in its place: which cells of the mosaic it covers.

use super::tile::Tile;
use crate::raster::CellWindow;

/// The cells of a grid of `n_rows` × `n_cols` that a tile covers which begins at row and column `origin`; `None` if it lies
/// outside. `bounds` is a rectangle of the grid that it is cut to, first and end row and column.
pub(super) fn covered_area(
    (n_rows, n_cols): (usize, usize),
    tile: &Tile,
    origin: (i64, i64),
    bounds: Option<[i64; 4]>,
) -> Option<CellWindow> {
    let range = |n: usize, origin: i64, n_tile: usize, bounds: Option<(i64, i64)>| {
        let (least, most) = bounds.unwrap_or((i64::MIN, i64::MAX));
        let start = i128::from(origin).max(i128::from(least)).max(0);
        let end = (i128::from(origin) + n_tile as i128).min(i128::from(most)).min(n as i128);
        let (start, length) = (usize::try_from(start).ok()?, usize::try_from(end - start).ok()?);
        (length > 0).then_some((start, length))
    };
    let (row, rows) = range(n_rows, origin.0, tile.n_rows, bounds.map(|[first, end, ..]| (first, end)))?;
    let (col, cols) = range(n_cols, origin.1, tile.n_cols, bounds.map(|[_, _, first, end]| (first, end)))?;
    Some(CellWindow { row, col, n_rows: rows, n_cols: cols })
}
