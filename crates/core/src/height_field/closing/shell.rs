//! Corners and edges of footprints near the border of the closing, which may bound the centers of
//! discs.

use super::cells::Cells;
use super::grid::Grid;
use super::vectors::{Edge, Place, length, minus, plus};
use crate::city::Footprint;
use crate::raster::BitGrid;

/// The corners and edges of footprints that may bound E.
pub(super) struct Shell {
    pub(super) radius: f64,
    pub(super) points: Vec<Place>,
    pub(super) edges: Vec<Edge>,
    pub(super) grid: Grid,
}

impl Shell {
    /// Returns edges that pass cells of `near`, their ends, and other corners in these cells.
    pub(super) fn of(footprints: &[Footprint], cells: &Cells, near: &BitGrid, radius: f64) -> Shell {
        let place = |p: &[i32; 2]| cells.place(p.map(i64::from));
        let (mut points, mut edges) = (Vec::new(), Vec::new());
        for ring in footprints.iter().flat_map(|f| f.polygons.iter().flatten()) {
            let next = ring.iter().cycle().skip(1);
            let passes = |from: Place, to: Place| length(minus(to, from)) > 0.0 && passes(cells, near, from, to);
            let mut is_end = ring.last().zip(ring.first()).is_some_and(|(from, to)| passes(place(from), place(to)));
            for (from, to) in ring.iter().zip(next).map(|(from, to)| (place(from), place(to))) {
                let is_kept = passes(from, to);
                if is_end || is_kept || cells.holds(near, from) {
                    points.push(from);
                }
                edges.extend(is_kept.then(|| Edge::between(from, to)));
                is_end = is_kept;
            }
        }
        Shell { radius, grid: Grid::of(&points, &edges), points, edges }
    }
}

pub(super) fn index_of(k: usize) -> u32 {
    u32::try_from(k).unwrap_or(u32::MAX)
}

/// Returns whether an edge passes a cell of a set, or comes near one: by the cells around places at
/// most a side apart.
fn passes(cells: &Cells, set: &BitGrid, from: Place, to: Place) -> bool {
    let d = minus(to, from);
    steps(cells, length(d)).any(|t| holds_near(cells, set, plus(from, t, d)))
}

/// Returns shares of a length, at most a side of a cell apart, with both ends.
pub(super) fn steps(cells: &Cells, length: f64) -> impl Iterator<Item = f64> + use<> {
    #[expect(clippy::cast_precision_loss, reason = "a side is below 2^26")]
    let side = cells.side as f64;
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "at most the cells of the grid")]
    let n = (length / side).ceil().max(1.0) as u32;
    (0..=n).map(move |k| f64::from(k) / f64::from(n))
}

/// Returns whether the cell of a place or one of its eight neighbors is in a set.
pub(super) fn holds_near(cells: &Cells, set: &BitGrid, place: Place) -> bool {
    let Some((row, col)) = cells.at(place) else { return false };
    let rows = row.saturating_sub(1)..(row + 2).min(cells.n_rows);
    rows.into_iter().any(|row| (col.saturating_sub(1)..(col + 2).min(cells.n_cols)).any(|col| set.contains(row, col)))
}
