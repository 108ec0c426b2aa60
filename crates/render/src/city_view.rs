//! The body of a city picture: the solids seen from above or from the side.
//!
//! A roof has the color of its height, the same in both pictures; walls are grayer shades of it.
//! The plan has flat colors with outlines; the view also has sun, shadows and gloom. Several
//! samples per pixel are averaged in linear light.

use glam::{DVec2, DVec3};
use image::RgbaImage;
use rayon::prelude::*;

use super::city_light::Atmosphere;
use super::city_solids::{GROUND, OWNER, PLATE, Solids, is_roof, normal_of};
use super::colors::{self, Light, Ramp, Rgb};
use super::z_buffer::{Projection, View, ZBuffer, samples};

/// Samples per pixel along one side.
const SAMPLES: usize = 2;
/// Direction to the eye: south-south-west, 35° high.
const EYE: DVec3 = DVec3::new(-0.40, -0.80, 0.62);

/// Draws the city from above, north up, filling `size` \[px\] without a margin.
pub(crate) fn draw_plan(solids: &Solids<'_>, size: [usize; 2], tallest_m: f64) -> RgbaImage {
    let view = solids.view_from_above(size).magnified(SAMPLES as f64);
    let buffer = solids.buffer(&view, size.map(|n| n * SAMPLES));
    let outlined = !solids.is_raster();
    resolve(&buffer, size, |tag, x, y| {
        let factor = if outlined && is_outline(&buffer, tag, x, y) { 0.55 } else { 1.0 };
        colors::shade(albedo(solids, tag, tallest_m), factor)
    })
}

/// Draws the city from the south-south-west within `size` \[px\], no higher than it needs to be,
/// and returns the view, too.
pub(crate) fn draw_view(solids: &Solids<'_>, size: [usize; 2], tallest_m: f64) -> (RgbaImage, View) {
    let center = 0.5 * solids.size;
    let reach = solids.size.length().max(1.0);
    let eye = center + EYE.normalize() * reach * 1.9;
    let mut view = View::new(Projection::Perspective, eye, center - eye, DVec3::Z);
    let used = solids.fit(&mut view, DVec2::new(size[0] as f64, size[1] as f64), 6.0);
    let size = samples(used);
    let fine = view.magnified(SAMPLES as f64);
    let buffer = solids.buffer(&fine, size.map(|n| n * SAMPLES));
    let atmosphere = Atmosphere::new(solids);
    let outlined = !solids.is_raster();
    let image = resolve(&buffer, size, |tag, x, y| {
        let depth = f64::from(buffer.depth[y * buffer.width + x]);
        let point = fine.unproject(DVec3::new(x as f64 + 0.5, y as f64 + 0.5, depth));
        let mut normal = normal_of(tag);
        // Rings run in either direction, but every visible face of a solid is turned to the viewer.
        if !fine.sees(point, normal) {
            normal = -normal;
        }
        let color = albedo(solids, tag, tallest_m);
        let color = if is_roof(tag) { color } else { colors::mix(color, [0x8C, 0x90, 0x96], 0.18) };
        let line = if outlined && is_outline(&buffer, tag, x, y) { 0.66 } else { 1.0 };
        colors::shade(color, line * atmosphere.light(point, normal))
    });
    (image, view)
}

fn albedo(solids: &Solids<'_>, tag: u64, tallest_m: f64) -> Rgb {
    match tag & OWNER {
        GROUND => colors::OPEN_GROUND,
        PLATE => [0xD8, 0xD5, 0xCC],
        owner => solids.height_of(owner).map_or(colors::OPEN_GROUND, |height| Ramp::Height.at(height / tallest_m)),
    }
}

/// Returns `true` when a sample borders another building, another side of its own building, or the
/// ground.
fn is_outline(buffer: &ZBuffer, tag: u64, x: usize, y: usize) -> bool {
    let differs = |x: usize, y: usize| {
        let other = buffer.tag[y * buffer.width + x];
        if other == tag || other == 0 {
            return false;
        }
        let is_building = tag & OWNER < PLATE || other & OWNER < PLATE;
        is_building && (tag & OWNER != other & OWNER || normal_of(tag).dot(normal_of(other)) < 0.8)
    };
    (x + 1 < buffer.width && differs(x + 1, y)) || (y + 1 < buffer.height && differs(x, y + 1))
}

/// Colors all samples and averages them in linear light; empty samples are white paper.
fn resolve(buffer: &ZBuffer, size: [usize; 2], color: impl Fn(u64, usize, usize) -> Rgb + Sync) -> RgbaImage {
    let light = Light::tables();
    let mut pixels = vec![255_u8; size[0] * size[1] * 4];
    pixels.par_chunks_exact_mut(size[0] * 4).enumerate().for_each(|(row, pixels)| {
        for (col, pixel) in pixels.chunks_exact_mut(4).enumerate() {
            let mut sum = [0_u32; 3];
            let mut n = 0;
            for y in row * SAMPLES..(row + 1) * SAMPLES {
                for x in col * SAMPLES..(col + 1) * SAMPLES {
                    let tag = buffer.tag[y * buffer.width + x];
                    let color = if tag == 0 { colors::WHITE } else { color(tag, x, y) };
                    light.linear(color).iter().zip(&mut sum).for_each(|(c, sum)| *sum += c);
                    n += 1;
                }
            }
            for k in 0..3 {
                pixel[k] = light.srgb((sum[k] + n / 2) / n);
            }
        }
    });
    let [width, height] = size.map(|n| u32::try_from(n).expect("a view has at most 4000 pixels a side"));
    RgbaImage::from_raw(width, height, pixels).expect("the buffer has this size")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::city_solids::{CityHeights, CityModel, block};

    #[test]
    fn a_plan_shows_roofs_by_height_and_open_ground_of_prisms_and_of_rasters() {
        let prisms = [block(110.0, 210.0, 30.0, 10.0), block(160.0, 260.0, 30.0, 40.0)];
        let mut surface = vec![0.0_f32; 100 * 100];
        for (from_row, from_col, top) in [(60, 10, 10.0), (10, 60, 40.0)] {
            (from_row..from_row + 30).for_each(|row| surface[row * 100 + from_col..][..30].fill(top));
        }
        let heights = CityHeights { n_cols: 100, n_rows: 100, surface_m: &surface, ground_m: &[0.0; 100 * 100] };
        for model in [CityModel::Prisms(&prisms), CityModel::Heights(heights)] {
            let solids = Solids::new(&model, [100.0, 200.0, 200.0, 300.0]);
            let plan = draw_plan(&solids, [200, 200], 40.0);
            for (x, y, color) in [(50, 150, Ramp::Height.at(0.25)), (150, 50, Ramp::Height.at(1.0))] {
                assert_eq!(plan.get_pixel(x, y).0[..3], color);
            }
            assert_eq!(plan.get_pixel(50, 50).0[..3], colors::OPEN_GROUND);
        }
    }

    #[test]
    fn an_empty_city_is_drawn() {
        let solids = Solids::new(&CityModel::Prisms(&[]), [0.0, 0.0, 100.0, 50.0]);
        assert!(draw_view(&solids, [300, 300], 1.0).0.width() > 100);
    }
}
