//! Light on a city: the sun with the shadows that it casts, and the gloom of narrow streets.
//!
//! Shadows come from a second z-buffer that sees the city as the sun does. Gloom measures how far
//! the blurred roofs around a point rise above it. These roofs come from a coarse z-buffer that
//! looks down. Gloom is cheap, smooth, and close to the loss of visible sky.

use glam::{DVec2, DVec3};

use super::city_solids::Solids;
use super::colors;
use super::paint::narrow;
use super::z_buffer::{Projection, View, ZBuffer, samples};

/// Direction to the sun: west-south-west, 40° high.
const SUN: DVec3 = DVec3::new(-0.72, -0.25, 0.64);
/// Samples a side of the sun's view; `GLOOM_SIDE` is that of the coarse view from above.
const SHADOW_SIDE: f64 = 2048.0;
const GLOOM_SIDE: f64 = 384.0;

/// Sun, shadows and gloom.
#[derive(Debug)]
pub(crate) struct Atmosphere {
    sun: DVec3,
    shadow: ZBuffer,
    shadow_view: View,
    /// About the distance \[m\] by which a point is lifted off its face for the shadow test.
    lift: f64,
    gloom: Vec<f32>,
    gloom_size: [usize; 2],
    gloom_step: DVec2,
    gloom_reach: f64,
}

impl Atmosphere {
    /// Lights a city.
    pub(crate) fn new(solids: &Solids<'_>) -> Self {
        let sun = SUN.normalize();
        let reach = solids.size.length().max(1.0);
        let eye = 0.5 * solids.size + sun * reach;
        let mut shadow_view = View::new(Projection::Parallel, eye, -sun, DVec3::Z);
        let used = solids.fit(&mut shadow_view, DVec2::splat(SHADOW_SIDE), 2.0);
        let shadow = solids.buffer(&shadow_view, samples(used));

        let longer = solids.size.x.max(solids.size.y).max(1e-9);
        let gloom_size = samples(solids.size.truncate() / longer * GLOOM_SIDE);
        let gloom_step = DVec2::new(solids.size.x / gloom_size[0] as f64, solids.size.y / gloom_size[1] as f64);
        let roofs = solids.buffer(&solids.view_from_above(gloom_size), gloom_size);
        let top = narrow(solids.size.z + 1.0);
        let mut gloom: Vec<f32> = roofs.depth.iter().map(|d| if d.is_finite() { top + d } else { 0.0 }).collect();
        for _ in 0..2 {
            blur_rows(&mut gloom, gloom_size[0], 4);
            gloom = transposed(&gloom, gloom_size[0]);
            blur_rows(&mut gloom, gloom_size[1], 4);
            gloom = transposed(&gloom, gloom_size[1]);
        }
        let gloom_reach = 9.0 * gloom_step.max_element();
        Self { sun, shadow, shadow_view, lift: reach / SHADOW_SIDE, gloom, gloom_size, gloom_step, gloom_reach }
    }

    /// Returns the light on a point: 1 on an open roof in the sun.
    pub(crate) fn light(&self, point: DVec3, normal: DVec3) -> f64 {
        let facing = normal.dot(self.sun).max(0.0) / self.sun.z;
        let lit = if facing > 0.0 { facing * self.sunlit(point + normal * 1.5 * self.lift) } else { 0.0 };
        // A wall is darkened by the roofs before it, not by its own building.
        let place = point.truncate() + normal.truncate() * 0.8 * self.gloom_reach;
        let rise = (self.roofs_around(place) - point.z).max(0.0);
        let open = 1.0 / (1.0 + 0.6 * rise / self.gloom_reach);
        (0.56 * open + 0.44 * lit).min(1.12)
    }

    /// Returns the share of the sun that a point receives, smoothed over four samples.
    fn sunlit(&self, point: DVec3) -> f64 {
        let at = self.shadow_view.project(point);
        let (x, y) = (at.x - 0.5, at.y - 0.5);
        if x < 0.0 || y < 0.0 {
            return 1.0;
        }
        let (col, row) = (colors::index(x, self.shadow.width), colors::index(y, self.shadow.height));
        let (fx, fy) = (x - col as f64, y - row as f64);
        let mut lit = 0.0;
        for (row, wy) in [(row, 1.0 - fy), (row + 1, fy)] {
            for (col, wx) in [(col, 1.0 - fx), (col + 1, fx)] {
                let outside = row >= self.shadow.height || col >= self.shadow.width;
                if outside || f64::from(self.shadow.depth[row * self.shadow.width + col]) <= at.z + self.lift {
                    lit += wx * wy;
                }
            }
        }
        lit
    }

    /// Returns the blurred height of roofs around a place \[m\].
    fn roofs_around(&self, place: DVec2) -> f64 {
        let [w, h] = self.gloom_size;
        let x = place.x / self.gloom_step.x - 0.5;
        let y = h as f64 - place.y / self.gloom_step.y - 0.5;
        let (col, row) = (colors::index(x, w - 1), colors::index(y, h - 1));
        let (fx, fy) = ((x - col as f64).clamp(0.0, 1.0), (y - row as f64).clamp(0.0, 1.0));
        let at = |row: usize, col: usize| f64::from(self.gloom[row.min(h - 1) * w + col.min(w - 1)]);
        let upper = at(row, col) * (1.0 - fx) + at(row, col + 1) * fx;
        let lower = at(row + 1, col) * (1.0 - fx) + at(row + 1, col + 1) * fx;
        upper * (1.0 - fy) + lower * fy
    }
}

/// Averages each value with `reach` neighbors on either side of its row.
fn blur_rows(values: &mut [f32], n_cols: usize, reach: usize) {
    for row in values.chunks_exact_mut(n_cols) {
        let old = row.to_vec();
        for (col, value) in row.iter_mut().enumerate() {
            let window = &old[col.saturating_sub(reach)..(col + reach + 1).min(n_cols)];
            *value = window.iter().sum::<f32>() / window.len() as f32;
        }
    }
}

fn transposed(values: &[f32], n_cols: usize) -> Vec<f32> {
    let n_rows = values.len() / n_cols;
    (0..values.len()).map(|k| values[k % n_rows * n_cols + k / n_rows]).collect()
}
