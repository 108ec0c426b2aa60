//! `xdraw`: the steepest slope so far, interpolated from one line of cells to the next.

use super::quadrants::{Line, NOTHING, Quadrant, by_quadrants};
use crate::height_field::Columns;
use crate::quantity::LatticePoint;
use crate::raster::{BitGrid, CellWindow};

/// Returns the receivers of `wanted` that `xdraw` takes for LoS: *approximate*.
///
/// The ray to the center of a cell crosses the line of cells before its own between two centers.
/// The slope that hides the receiver is interpolated between the steepest slopes up to and
/// including these two cells. The `window` holds the wanted cells and the cells between them and
/// the UAV. The function `height` returns the height of the receiver of a row and column \[1/1024 m
/// above the datum\].
///
/// Cost: one interpolation per cell of the window.
pub fn xdraw_los(
    columns: &Columns,
    uav: LatticePoint,
    height: &(dyn Fn(usize, usize) -> i64 + Sync),
    wanted: &BitGrid,
    window: CellWindow,
) -> BitGrid {
    by_quadrants(columns, uav, (wanted, window), |quadrant| seen(quadrant, height, wanted))
}

fn seen(quadrant: &Quadrant<'_>, height: &(dyn Fn(usize, usize) -> i64 + Sync), wanted: &BitGrid) -> BitGrid {
    let mut los = BitGrid::new(wanted.n_rows(), wanted.n_cols());
    // The steepest slope up to and including each cell of the line before.
    let mut before: Option<(Line, Vec<f64>)> = None;
    for line in quadrant.lines() {
        let steepest: Vec<f64> = (line.first..line.end)
            .map(|lateral| {
                let hidden_below = match &before {
                    Some((last, slopes)) => interpolated(quadrant, (&line, lateral), last, slopes),
                    None => NOTHING,
                };
                let cell = quadrant.cell(&line, lateral);
                if wanted.contains(cell.0, cell.1)
                    && quadrant.decides(&line, lateral)
                    && quadrant.slope_of(&line, height(cell.0, cell.1)) >= hidden_below
                {
                    los.insert(cell.0, cell.1);
                }
                hidden_below.max(quadrant.slope(&line, lateral))
            })
            .collect();
        before = Some((line, steepest));
    }
    los
}

/// Returns the slope at the ray's crossing of the line before, interpolated between the two nearest
/// centers of that line.
#[inline]
fn interpolated(quadrant: &Quadrant<'_>, (line, lateral): (&Line, i64), last: &Line, slopes: &[f64]) -> f64 {
    if slopes.is_empty() {
        return NOTHING;
    }
    let offset = quadrant.offset(lateral);
    let crossing = offset * (last.distance / line.distance);
    // Towards the UAV: from the cell of the same lateral number to the next one.
    let to_the_next = if offset > crossing { -1 } else { 1 };
    let weight = (offset - crossing).abs().min(1.0);
    let slope = |lateral: i64| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped to the line")]
        slopes[(lateral.clamp(last.first, last.end - 1) - last.first) as usize]
    };
    let (near, next) = (slope(lateral), slope(lateral + to_the_next));
    near * (1.0 - weight) + next * weight
}
