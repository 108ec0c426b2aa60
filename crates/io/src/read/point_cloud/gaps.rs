//! Heights for cells of a terrain without a point of the ground.

use rayon::prelude::*;
use spade::Point2;

use crate::quantity::{VOID, height_steps, meters};
use crate::read::triangulated_heights::{KnownHeight, TriangulatedHeights};

/// Fills the cells without a height: linearly within triangles of known cells (Delaunay), beyond
/// their hull with the height of the nearest.
///
/// Only known cells at the rim of gaps are corners. No circle around a triangle over a gap reaches
/// deeper into known cells than to their rim, so that these are the triangles of all known cells,
/// but for the choice among several corners of one circle.
pub(super) fn fill_gaps(cells: &mut [i32], n_cols: usize) {
    let n_rows = cells.len() / n_cols;
    let is_gap = |row: usize, col: usize| cells[row * n_cols + col] == VOID;
    let is_at_rim = |row: usize, col: usize| {
        let rows = row.saturating_sub(1)..=(row + 1).min(n_rows - 1);
        let cols = col.saturating_sub(1)..=(col + 1).min(n_cols - 1);
        rows.into_iter().any(|row| cols.clone().any(|col| is_gap(row, col)))
    };
    #[expect(clippy::cast_precision_loss, reason = "rows and columns are below 65536")]
    let place = |row: usize, col: usize| Point2::new(col as f64, row as f64);
    let rim = (0..cells.len()).filter_map(|index| {
        let (row, col) = (index / n_cols, index % n_cols);
        let is_corner = cells[index] != VOID && is_at_rim(row, col);
        is_corner.then(|| KnownHeight { at: place(row, col), height_m: meters(cells[index]) })
    });
    let ground = TriangulatedHeights::through(rim);
    cells.par_chunks_mut(n_cols).enumerate().for_each(|(row, cells)| {
        let height = ground.lookup();
        for (col, cell) in cells.iter_mut().enumerate().filter(|(_, cell)| **cell == VOID) {
            let at = place(row, col);
            *cell = height(at.x, at.y).and_then(height_steps).unwrap_or(VOID);
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_filled_as_if_all_known_cells_were_corners() {
        let (n, mut state) = (40_usize, 7_u32);
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            state >> 8
        };
        // A plane has the same heights whatever the triangles are.
        let plane = |row: usize, col: usize| i32::try_from(3000 + 64 * row + 16 * col).expect("a small height");
        let mut cells: Vec<i32> = (0..n * n).map(|k| plane(k / n, k % n)).collect();
        for row in 5..20 {
            cells[row * n + 7..row * n + 30].fill(VOID);
        }
        for _ in 0..300 {
            // The rim of the grid stays, so that all gaps lie within the hull.
            let (row, col) = (1 + random() as usize % (n - 2), 1 + random() as usize % (n - 2));
            cells[row * n + col] = VOID;
        }
        fill_gaps(&mut cells, n);
        let wrong = (0..n * n).filter(|k| (cells[*k] - plane(k / n, k % n)).abs() > 1).count();
        assert_eq!(wrong, 0);
    }

    #[test]
    fn beyond_the_hull_the_nearest_cell_counts() {
        let mut cells = vec![VOID; 5 * 4];
        cells[5 + 1] = 1024;
        fill_gaps(&mut cells, 5);
        assert!(cells.iter().all(|z| *z == 1024), "{cells:?}");
        let mut none = vec![VOID; 6];
        fill_gaps(&mut none, 3);
        assert!(none.iter().all(|z| *z == VOID));
    }
}
