//! Backdrop of the mask: one byte per cell, which the page colors.
//!
//! 0 is no data. 1 to 127 is open ground: 64 is level, lower values face away from the light. 128
//! to 255 is a building, from light and low to dark and tall, with its walls in light and shade.

use skyshed_core::height_field::HeightField;
use skyshed_core::raster::Surface;

/// Strength of the light on a building's tone.
const RELIEF: f64 = 0.35;

/// Returns the backdrop of a scene.
pub(crate) fn backdrop(field: &HeightField) -> Vec<u8> {
    let grid = field.grid();
    let heights = field.above_ground_m();
    let unit = grid.meters_per_unit();
    let surface = Surface {
        heights: (&heights[..]).into(),
        n_cols: grid.n_cols(),
        n_rows: grid.n_rows(),
        step_m: (grid.cell_width() * unit, grid.cell_height() * unit),
    };
    let building = &field.cells().building;
    let (low, high) = usual_heights(&heights, |row, col| building.contains(row, col), grid.n_cols());
    let mut tones = vec![0; grid.n_cells()];
    for row in 0..grid.n_rows() {
        for col in 0..grid.n_cols() {
            let height = heights[row * grid.n_cols() + col];
            if !height.is_finite() {
                continue;
            }
            let relief = surface.light(row, col) - 1.0;
            tones[row * grid.n_cols() + col] = if building.contains(row, col) {
                let tone = ((f64::from(height) - low) / (high - low)).clamp(0.0, 1.0);
                128 + byte((tone - RELIEF * relief) * 127.0, 127)
            } else {
                1 + byte(63.0 + relief * 63.0, 126)
            };
        }
    }
    tones
}

/// Returns the heights between which most buildings lie \[m\].
fn usual_heights(heights: &[f32], is_building: impl Fn(usize, usize) -> bool, n_cols: usize) -> (f64, f64) {
    // An odd step has no factor of two in common with the length of a row.
    let step = (heights.len() / 200_000).max(1) | 1;
    let cells = (0..heights.len()).step_by(step).filter(|cell| is_building(cell / n_cols, cell % n_cols));
    let mut found: Vec<f32> = cells.map(|cell| heights[cell]).filter(|height| height.is_finite()).collect();
    found.sort_unstable_by(f32::total_cmp);
    let (Some(low), Some(high)) = (found.get(found.len() / 50), found.get(found.len() - found.len() / 50 - 1)) else {
        return (0.0, 1.0);
    };
    (f64::from(*low), f64::from(*high).max(f64::from(*low) + 1.0))
}

/// Returns a number rounded and limited to 0 to `most`.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "clamped")]
fn byte(value: f64, most: u8) -> u8 {
    value.round().clamp(0.0, f64::from(most)) as u8
}
