//! A painted map at another size.

use image::RgbaImage;

use super::colors::{self, FULL_LIGHT, Light};

/// Returns an opaque image at another size. A pixel is the average, in linear light, of the source
/// pixels that it covers. So a map shrinks without losing thin streets and grows without blur.
pub(crate) fn resized(image: &RgbaImage, width: u32, height: u32) -> RgbaImage {
    if image.dimensions() == (width, height) {
        return image.clone();
    }
    let light = Light::tables();
    let [from_cols, from_rows, to_cols, to_rows] = [image.width(), image.height(), width, height].map(|n| n as usize);
    let cols = covered(from_cols, to_cols);
    let mut pixels: Vec<u8> = Vec::with_capacity(to_cols * to_rows * 4);
    for parts in covered(from_rows, to_rows) {
        // Rows first: each source row is read once for all pixels of a row.
        let mut row = vec![[0.0_f64; 3]; from_cols];
        for (source, share) in parts {
            let colors = image.as_raw()[source * from_cols * 4..].chunks_exact(4);
            for (sum, color) in row.iter_mut().zip(colors) {
                let linear = light.linear([color[0], color[1], color[2]]);
                (0..3).for_each(|k| sum[k] += share * f64::from(linear[k]));
            }
        }
        for parts in &cols {
            let mut sum = [0.0_f64; 3];
            for (source, share) in parts {
                (0..3).for_each(|k| sum[k] += share * row[*source][k]);
            }
            let code = |linear: f64| u32::try_from(colors::index(linear.round(), 4095)).unwrap_or(FULL_LIGHT);
            pixels.extend(sum.map(|linear| light.srgb(code(linear))));
            pixels.push(255);
        }
    }
    RgbaImage::from_raw(width, height, pixels).expect("the buffer has this size")
}

/// Returns for each of `to` pixels the source pixels of `from` that it covers, with their shares,
/// which sum to 1.
fn covered(from: usize, to: usize) -> Vec<Vec<(usize, f64)>> {
    let step = from as f64 / to as f64;
    let parts = |k: usize| {
        let (low, high) = (step * k as f64, (step * (k + 1) as f64).min(from as f64));
        let part = |source: usize| {
            let length = high.min((source + 1) as f64) - low.max(source as f64);
            (source, length / (high - low))
        };
        (colors::index(low, from - 1)..from).take_while(|source| (*source as f64) < high).map(part).collect()
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
}
