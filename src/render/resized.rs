//! A painted map at another size.

use image::RgbaImage;

use super::colors::Light;

/// Returns an opaque image at another size: a pixel is the average, in linear light, of what it covers, so that a map
/// shrinks without losing thin streets and grows without blur.
pub(crate) fn resized(image: &RgbaImage, width: u32, height: u32) -> RgbaImage {
    if image.dimensions() == (width, height) {
        return image.clone();
    }
    let light = Light::tables();
    let (cols, rows) = (covered(image.width(), width), covered(image.height(), height));
    let mut out = RgbaImage::new(width, height);
    for (y, parts_y) in rows.iter().enumerate() {
        // Rows first: each source row is read once for all pixels of a row.
        let mut row = vec![[0.0_f64; 3]; image.width() as usize];
        for &(source, share) in parts_y {
            for (x, sum) in row.iter_mut().enumerate() {
                let [r, g, b, _] = image.get_pixel(x as u32, source).0;
                let linear = light.linear([r, g, b]);
                (0..3).for_each(|k| sum[k] += share * f64::from(linear[k]));
            }
        }
        for (x, parts_x) in cols.iter().enumerate() {
            let mut sum = [0.0_f64; 3];
            for &(source, share) in parts_x {
                (0..3).for_each(|k| sum[k] += share * row[source as usize][k]);
            }
            let [r, g, b] = sum.map(|linear| light.srgb(linear.round() as u32));
            out.put_pixel(x as u32, y as u32, image::Rgba([r, g, b, 255]));
        }
    }
    out
}

/// For each of `to` pixels the source pixels of `from` that it covers, with their shares, which sum to 1.
fn covered(from: u32, to: u32) -> Vec<Vec<(u32, f64)>> {
    let step = f64::from(from) / f64::from(to);
    let parts = |k: u32| {
        let (low, high) = (step * f64::from(k), (step * f64::from(k + 1)).min(f64::from(from)));
        let part = |source: u32| {
            let length = high.min(f64::from(source + 1)) - low.max(f64::from(source));
            (source, length / (high - low))
        };
        (low as u32..from).take_while(|source| f64::from(*source) < high).map(part).collect()
    };
    (0..to).map(parts).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_are_averaged_in_linear_light_and_kept_where_uniform() {
        let mut image = RgbaImage::from_pixel(4, 4, image::Rgba([0, 114, 178, 255]));
        for y in 0..4 {
            image.put_pixel(0, y, image::Rgba([255, 255, 255, 255]));
            image.put_pixel(1, y, image::Rgba([0, 0, 0, 255]));
        }
        let half = resized(&image, 2, 3);
        // Half of white light is 188 in sRGB (IEC 61966-2-1), not 128.
        assert_eq!(half.get_pixel(0, 1).0, [188, 188, 188, 255]);
        assert_eq!(half.get_pixel(1, 2).0, [0, 114, 178, 255]);
        let larger = resized(&image, 10, 8);
        assert_eq!((larger.get_pixel(1, 0).0[0], larger.get_pixel(3, 0).0[0]), (255, 0));
        assert_eq!(resized(&image, 4, 4), image);
    }

    #[test]
    fn the_shares_of_a_pixel_sum_to_one() {
        for (from, to) in [(1, 7), (7, 1), (1400, 999), (3, 3), (999, 1400)] {
            let parts = covered(from, to);
            assert_eq!(parts.len(), to as usize);
            assert!(parts.iter().all(|p| (p.iter().map(|(_, share)| share).sum::<f64>() - 1.0).abs() < 1e-9));
        }
    }
}
