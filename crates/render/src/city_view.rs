//! The body of a city picture: the solids seen from above or from the side.
//!
//! Roofs have the color of their height, the same in both; walls are grayer shades of it. The plan is flat color with
//! outlines; the view has sun, shadows and gloom as well. Several samples per pixel are averaged in linear light.

use glam::{DVec2, DVec3};
use image::RgbaImage;
use rayon::prelude::*;

use super::city_light::Atmosphere;
use super::city_solids::{GROUND, OWNER, OWNER_BITS, PLATE, Solids, normal_of};
use super::colors::{self, Light, Ramp, Rgb};
use super::z_buffer::{Projection, View, ZBuffer};

/// Samples per pixel along one side.
const SAMPLES: usize = 2;
/// Towards the eye: south-south-west, 35° high.
const EYE: DVec3 = DVec3::new(-0.40, -0.80, 0.62);

/// A painted view and what overlays need to match it.
#[derive(Debug)]
pub(crate) struct CityImage {
    /// The picture; transparent paper is white.
    pub(crate) image: RgbaImage,
    view: View,
    depth: ZBuffer,
    origin: DVec3,
}

impl CityImage {
    /// Returns the place \[px\] of a point \[m\].
    pub(crate) fn place(&self, point: [f64; 3]) -> [f64; 2] {
        self.view.project(DVec3::from(point) - self.origin).truncate().to_array()
    }

    /// Returns the screen direction of a direction on the ground, shortened as the view shortens it.
    pub(crate) fn direction(&self, direction: [f64; 2]) -> [f64; 2] {
        self.view.direction(DVec2::from(direction).extend(0.0)).to_array()
    }

    /// Returns whether nothing stands between a point and the viewer.
    pub(crate) fn is_visible(&self, point: [f64; 3]) -> bool {
        let at = self.view.magnified(SAMPLES as f64).project(DVec3::from(point) - self.origin);
        if at.x < 0.0 || at.y < 0.0 {
            return true;
        }
        let (x, y) = (colors::index(at.x, self.depth.width), colors::index(at.y, self.depth.height));
        if x >= self.depth.width || y >= self.depth.height {
            return true;
        }
        f64::from(self.depth.depth[y * self.depth.width + x]) <= at.z + 0.002 * at.z.abs()
    }

    /// Returns the height of what stands at a place on the plan \[m\], or nothing outside it.
    pub(crate) fn surface_below(&self, point: [f64; 2]) -> Option<f64> {
        let at = self.view.magnified(SAMPLES as f64).project(DVec2::from(point).extend(0.0) - self.origin);
        let inside = at.x >= 0.0 && at.y >= 0.0 && at.x < self.depth.width as f64 && at.y < self.depth.height as f64;
        if !inside {
            return None;
        }
        let sample =
            colors::index(at.y, self.depth.height - 1) * self.depth.width + colors::index(at.x, self.depth.width - 1);
        let depth = f64::from(self.depth.depth[sample]);
        depth.is_finite().then(|| self.view.unproject(DVec3::new(at.x, at.y, depth)).z + self.origin.z)
    }
}

/// Draws the city from above, north up, filling `size` \[px\] without a margin.
pub(crate) fn draw_plan(solids: &Solids<'_>, size: [usize; 2], tallest_m: f64) -> CityImage {
    let above = DVec3::new(0.0, 0.0, solids.size.z + 1.0);
    let mut view = View::new(Projection::Parallel, above, DVec3::NEG_Z, DVec3::Y);
    let corners = [DVec3::ZERO, DVec3::new(solids.size.x, solids.size.y, 0.0)];
    view.fit(corners.into_iter(), DVec2::new(size[0] as f64, size[1] as f64), 0.0);
    let buffer = solids.buffer(&view.magnified(SAMPLES as f64), size.map(|n| n * SAMPLES));
    let outlined = !solids.is_raster();
    let image = resolve(&buffer, size, |tag, x, y| {
        let factor = if outlined && is_outline(&buffer, tag, x, y) { 0.55 } else { 1.0 };
        colors::shade(albedo(solids, tag, tallest_m), factor)
    });
    CityImage { image, view, depth: buffer, origin: solids.origin }
}

/// Draws the city from the south-south-west within `size` \[px\]; the picture is as high as it needs to be.
pub(crate) fn draw_view(solids: &Solids<'_>, size: [usize; 2], tallest_m: f64) -> CityImage {
    let center = 0.5 * solids.size;
    let reach = solids.size.length().max(1.0);
    let eye = center + EYE.normalize() * reach * 1.9;
    let mut view = View::new(Projection::Perspective, eye, center - eye, DVec3::Z);
    let used = solids.fit(&mut view, DVec2::new(size[0] as f64, size[1] as f64), 6.0);
    let size = [used.x, used.y].map(|side| colors::index(side.ceil(), 4000).max(1));
    let fine = view.magnified(SAMPLES as f64);
    let buffer = solids.buffer(&fine, size.map(|n| n * SAMPLES));
    let atmosphere = Atmosphere::new(solids);
    let outlined = !solids.is_raster();
    let image = resolve(&buffer, size, |tag, x, y| {
        let depth = f64::from(buffer.depth[y * buffer.width + x]);
        let point = fine.unproject(DVec3::new(x as f64 + 0.5, y as f64 + 0.5, depth));
        let mut normal = normal_of(tag);
        // Rings run either way around, but what is seen of a solid is turned to the viewer.
        if !fine.sees(point, normal) {
            normal = -normal;
        }
        let color = albedo(solids, tag, tallest_m);
        let color = if tag >> OWNER_BITS == 0 { color } else { colors::mix(color, [0x8C, 0x90, 0x96], 0.18) };
        let line = if outlined && is_outline(&buffer, tag, x, y) { 0.66 } else { 1.0 };
        colors::shade(color, line * atmosphere.light(point, normal))
    });
    CityImage { image, view, depth: buffer, origin: solids.origin }
}

fn albedo(solids: &Solids<'_>, tag: u32, tallest_m: f64) -> Rgb {
    match tag & OWNER {
        GROUND => colors::OPEN_GROUND,
        PLATE => [0xD8, 0xD5, 0xCC],
        owner => solids.height_of(owner).map_or(colors::OPEN_GROUND, |height| Ramp::Height.at(height / tallest_m)),
    }
}

/// Returns whether a sample borders another building, another side of its own, or the ground.
fn is_outline(buffer: &ZBuffer, tag: u32, x: usize, y: usize) -> bool {
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

/// Colors all samples and averages them in linear light; where nothing is, the paper is white.
fn resolve(buffer: &ZBuffer, size: [usize; 2], color: impl Fn(u32, usize, usize) -> Rgb + Sync) -> RgbaImage {
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
    use crate::city_picture::{CityHeights, CityModel};
    use crate::city_solids::block;

    #[test]
    fn a_plan_shows_roofs_by_height_and_open_ground() {
        let prisms = [block(110.0, 210.0, 30.0, 10.0), block(160.0, 260.0, 30.0, 40.0)];
        let solids = Solids::new(&CityModel::Prisms(&prisms), [100.0, 200.0, 200.0, 300.0]);
        let plan = draw_plan(&solids, [200, 200], 40.0);
        let at = |x: f64, y: f64| {
            let [col, row] = plan.place([x, y, 0.0]).map(super::super::sheet::pixels);
            let pixel = plan.image.get_pixel(col, row).0;
            [pixel[0], pixel[1], pixel[2]]
        };
        assert_eq!(at(125.0, 225.0), Ramp::Height.at(0.25));
        assert_eq!(at(175.0, 275.0), Ramp::Height.at(1.0));
        assert_eq!(at(125.0, 275.0), colors::OPEN_GROUND);
        assert!(plan.surface_below([175.0, 275.0]).is_some_and(|z| (z - 40.0).abs() < 1e-3));
    }

    #[test]
    fn a_view_hides_what_is_behind_a_tower() {
        let prisms = [block(40.0, 40.0, 20.0, 80.0)];
        let solids = Solids::new(&CityModel::Prisms(&prisms), [0.0, 0.0, 100.0, 100.0]);
        let view = draw_view(&solids, [400, 400], 80.0);
        assert!(view.is_visible([50.0, 20.0, 1.0]));
        assert!(!view.is_visible([58.0, 70.0, 1.0]));
        assert!(view.is_visible([50.0, 50.0, 90.0]));
        assert!(view.image.width() <= 400 && view.image.height() <= 400);
    }

    #[test]
    fn rasters_become_columns_of_the_same_city() {
        let mut surface = vec![0.0_f32; 100 * 100];
        for row in 40..60 {
            surface[row * 100 + 40..row * 100 + 60].fill(30.0);
        }
        let heights = CityHeights { n_cols: 100, n_rows: 100, surface_m: &surface, ground_m: None };
        let solids = Solids::new(&CityModel::Heights(heights), [0.0, 0.0, 100.0, 100.0]);
        assert_eq!(solids.building_heights().len(), 400);
        let plan = draw_plan(&solids, [100, 100], 30.0);
        assert_eq!(plan.image.get_pixel(50, 50).0[..3], Ramp::Height.at(1.0));
        assert_eq!(plan.image.get_pixel(20, 50).0[..3], colors::OPEN_GROUND);
    }

    #[test]
    fn an_empty_city_is_drawn() {
        let solids = Solids::new(&CityModel::Prisms(&[]), [0.0, 0.0, 100.0, 50.0]);
        assert!(draw_view(&solids, [300, 300], 1.0).image.width() > 100);
    }
}
