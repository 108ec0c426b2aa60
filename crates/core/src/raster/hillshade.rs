//! Hillshade: light from the north-west over a surface, as a factor on a color.
//!
//! Slopes are Horn's (1981) over the eight neighbors. The sun stands 45° high in the north-west, as
//! is usual in cartography. Walls are steep, so they saturate to a light and a dark rim, and roofs
//! become recognizable.

use std::borrow::Cow;

/// A surface on a regular grid.
#[derive(Debug)]
pub struct Surface<'a> {
    /// Heights \[m\], `[n_rows, n_cols]`; not finite where unknown.
    pub heights: Cow<'a, [f32]>,
    /// Number of columns.
    pub n_cols: usize,
    /// Number of rows.
    pub n_rows: usize,
    /// Distance between cell centers \[m\], along columns and rows.
    pub step_m: (f64, f64),
}

impl Surface<'_> {
    /// Returns the light on a cell relative to level ground: 1 there, up to about 1.4 facing the
    /// sun, 0 averted.
    ///
    /// Unknown neighbors, and neighbors beyond the border, count as high as the cell itself.
    pub fn light(&self, row: usize, col: usize) -> f64 {
        let center = self.heights[row * self.n_cols + col];
        if !center.is_finite() {
            return 1.0;
        }
        let (north, south) = (row.saturating_sub(1), (row + 1).min(self.n_rows - 1));
        let (west, east) = (col.saturating_sub(1), (col + 1).min(self.n_cols - 1));
        let at = |row: usize, col: usize| {
            let height = self.heights[row * self.n_cols + col];
            f64::from(if height.is_finite() { height } else { center })
        };
        let (nw, n, ne) = (at(north, west), at(north, col), at(north, east));
        let (sw, s, se) = (at(south, west), at(south, col), at(south, east));
        let (w, e) = (at(row, west), at(row, east));
        let slope_x = ((ne + 2.0 * e + se) - (nw + 2.0 * w + sw)) / (8.0 * self.step_m.0);
        let slope_y = ((nw + 2.0 * n + ne) - (sw + 2.0 * s + se)) / (8.0 * self.step_m.1);
        // The normal is (-slope_x, -slope_y, 1), the sun (-1/2, 1/2, 1/√2), and level ground
        // receives 1/√2.
        let towards_sun = 0.5 * (slope_x - slope_y) + std::f64::consts::FRAC_1_SQRT_2;
        let normal = (slope_x * slope_x + slope_y * slope_y + 1.0).sqrt();
        (towards_sun / normal).max(0.0) / std::f64::consts::FRAC_1_SQRT_2
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slopes_facing_north_west_are_lit_south_east_dark_and_voids_neutral() {
        let light =
            |heights: &[f32]| Surface { heights: heights.into(), n_cols: 3, n_rows: 3, step_m: (1.0, 1.0) }.light(1, 1);
        let rising_to_south_east = [0.0, 0.5, 1.0, 0.5, 1.0, 1.5, 1.0, 1.5, 2.0];
        assert!(light(&rising_to_south_east) > 1.1 && light(&rising_to_south_east.map(|h: f32| -h)) < 0.7);
        assert!((light(&[7.0; 9]) - 1.0).abs() < 1e-12 && (light(&[f32::NAN; 9]) - 1.0).abs() < 1e-12);
    }
}
