//! PNG files: pictures in true color, bare masks with a palette, both with their provenance as text.
//!
//! A file holds no time and nothing of the machine, so that equal input gives equal bytes.

use std::io::Write;

use image::RgbaImage;

use super::check;
use super::colors::{self, Rgb};

/// Encodes an opaque picture as an RGB file that is printed at `dpi` \[pixels per inch\].
///
/// # Errors
/// A keyword of `provenance` that PNG does not allow.
pub(crate) fn encode_picture(image: &RgbaImage, dpi: u32, provenance: &[(String, String)]) -> Result<Vec<u8>, String> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, image.width(), image.height());
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    // An inch is 25.4 mm.
    let per_m = (dpi * 5000 + 63) / 127;
    encoder.set_pixel_dims(Some(png::PixelDimensions { xppu: per_m, yppu: per_m, unit: png::Unit::Meter }));
    add_provenance(&mut encoder, provenance)?;
    let mut rgb = Vec::with_capacity(image.as_raw().len() / 4 * 3);
    for pixel in image.pixels() {
        rgb.extend_from_slice(&pixel.0[..3]);
    }
    let mut writer = encoder.write_header().map_err(|e| cannot(&e))?;
    writer.write_image_data(&rgb).map_err(|e| cannot(&e))?;
    writer.finish().map_err(|e| cannot(&e))?;
    Ok(file)
}

/// Draws a mask with one pixel per cell and nothing else: no frame, no words.
///
/// `mask` is `[n_rows, n_cols]`, columns running fastest. Blue is line of sight, orange none, gray not a receiver;
/// out of range and nodata are transparent. The file has a palette of two bits per pixel, so that 16384 × 16384 cells
/// need no more than the encoded file.
///
/// # Errors
/// A mask of another length than the raster, an empty raster or one of more than 2³¹ − 1
/// cells a side, or a keyword of `provenance` that PNG does not allow (1 to 79 characters of Latin-1).
pub fn draw_bare(
    n_cols: usize,
    n_rows: usize,
    mask: &[u8],
    provenance: &[(String, String)],
) -> Result<Vec<u8>, String> {
    let n_cells = [n_cols, n_rows];
    check::shape("mask", mask.len(), n_cells)?;
    let palette = [colors::NLOS, colors::LOS, colors::BUILDING, colors::WHITE];
    encode_palette(n_cells, (png::BitDepth::Two, &palette, &[255, 255, 255, 0]), provenance, |writer| {
        let mut stream = writer.stream_writer()?;
        let mut packed = vec![0_u8; n_cols.div_ceil(4)];
        for row in mask.chunks_exact(n_cols) {
            for (byte, cells) in packed.iter_mut().zip(row.chunks(4)) {
                *byte = cells.iter().zip([6, 4, 2, 0]).map(|(&class, shift)| class.min(3) << shift).sum();
            }
            stream.write_all(&packed)?;
        }
        stream.finish()
    })
}

/// One pixel per cell and nothing else: how many UAVs see it, in the colors of the picture.
///
/// `count` and `mask` are `[n_rows, n_cols]`, columns running fastest; `mask` tells which cells are receivers. More than
/// 252 UAVs share colors.
///
/// # Errors
/// As [`draw_bare`].
pub fn draw_bare_count(
    n_cols: usize,
    n_rows: usize,
    count: &[u32],
    mask: &[u8],
    n_sites: u32,
    provenance: &[(String, String)],
) -> Result<Vec<u8>, String> {
    let n_cells = [n_cols, n_rows];
    check::shape("mask", mask.len(), n_cells)?;
    check::shape("count", count.len(), n_cells)?;
    // Not a receiver, and nothing to show, come after the counts.
    const MOST: u32 = 252;
    let shown = n_sites.min(MOST);
    let (other, nothing) = (shown + 1, shown + 2);
    let mut palette: Vec<Rgb> = (0..=shown).map(|k| colors::count_color(k, shown)).collect();
    palette.extend([colors::BUILDING, colors::WHITE]);
    let mut opacity = vec![255; palette.len()];
    opacity[nothing as usize] = 0;
    let index = |cell: usize| match mask[cell] {
        0 | 1 if n_sites <= MOST => count[cell].min(shown),
        0 | 1 if count[cell] == 0 => 0,
        0 | 1 => {
            let share = u64::from(count[cell] - 1) * u64::from(shown - 1) / u64::from(n_sites - 1);
            1 + u32::try_from(share).unwrap_or(shown - 1)
        }
        2 => other,
        _ => nothing,
    };
    let pixels: Vec<u8> = (0..mask.len()).map(|cell| u8::try_from(index(cell)).unwrap_or(u8::MAX)).collect();
    encode_palette(n_cells, (png::BitDepth::Eight, &palette, &opacity), provenance, |writer| {
        writer.write_image_data(&pixels)
    })
}

/// Encodes a picture of nearly gray colors with a palette of 64 of them: each pixel takes the mean color of those whose
/// green is the same to a quarter.
///
/// # Errors
/// An array of another length than the raster, an empty raster or one of more than 2³¹ − 1 cells a side.
pub(crate) fn encode_grays(n_cells: [usize; 2], colors: &[Rgb]) -> Result<Vec<u8>, String> {
    check::shape("colors", colors.len(), n_cells)?;
    let level = |color: &Rgb| color[1] / 4;
    let mut sums = [[0_u64; 4]; 64];
    for color in colors {
        let sum = &mut sums[usize::from(level(color))];
        (0..3).for_each(|k| sum[k] += u64::from(color[k]));
        sum[3] += 1;
    }
    let mean = |[r, g, b, n]: [u64; 4]| [r, g, b].map(|c| u8::try_from((c + n / 2) / n.max(1)).unwrap_or(u8::MAX));
    let pixels: Vec<u8> = colors.iter().map(level).collect();
    encode_palette(n_cells, (png::BitDepth::Eight, &sums.map(mean), &[]), &[], |writer| {
        writer.write_image_data(&pixels)
    })
}

/// Encodes a picture of a few colors with their opacities; `write` hands over its pixels.
fn encode_palette(
    [n_cols, n_rows]: [usize; 2],
    (depth, colors, opacities): (png::BitDepth, &[Rgb], &[u8]),
    provenance: &[(String, String)],
    write: impl FnOnce(&mut png::Writer<&mut Vec<u8>>) -> Result<(), png::EncodingError>,
) -> Result<Vec<u8>, String> {
    let side = |n: usize| u32::try_from(n).ok().filter(|&n| n <= i32::MAX.unsigned_abs());
    let too_large = || format!("cannot draw {n_cols} × {n_rows} cells as PNG: at most 2147483647 a side");
    let (width, height) = side(n_cols).zip(side(n_rows)).ok_or_else(too_large)?;
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(depth);
    encoder.set_palette(colors.concat());
    if !opacities.is_empty() {
        encoder.set_trns(opacities.to_vec());
    }
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_filter(png::Filter::NoFilter);
    add_provenance(&mut encoder, provenance)?;
    let mut writer = encoder.write_header().map_err(|e| cannot(&e))?;
    write(&mut writer).map_err(|e| cannot(&e))?;
    writer.finish().map_err(|e| cannot(&e))?;
    Ok(file)
}

fn add_provenance<W: Write>(encoder: &mut png::Encoder<'_, W>, provenance: &[(String, String)]) -> Result<(), String> {
    for (keyword, text) in provenance {
        let latin_1 = keyword.chars().all(|c| matches!(c, ' '..='~' | '\u{A1}'..='\u{FF}'));
        if !(1..=79).contains(&keyword.chars().count()) || !latin_1 || keyword.trim() != keyword {
            return Err(format!("cannot store `{keyword}` in PNG: a keyword is 1 to 79 printable Latin-1 characters"));
        }
        let text = text.replace('\0', " ");
        encoder.add_itxt_chunk(keyword.clone(), text).map_err(|e| cannot(&e))?;
    }
    Ok(())
}

fn cannot(error: &dyn std::fmt::Display) -> String {
    format!("cannot encode PNG: {error}")
}

#[cfg(test)]
/// The pixels of a PNG.
pub(crate) fn read_png(file: &[u8]) -> image::DynamicImage {
    let mut decoder = png::Decoder::new(std::io::Cursor::new(file));
    decoder.set_transformations(
        png::Transformations::EXPAND | png::Transformations::STRIP_16 | png::Transformations::ALPHA,
    );
    let mut reader = decoder.read_info().expect("it is a PNG");
    let mut pixels = vec![0; reader.output_buffer_size().expect("it fits in memory")];
    let frame = reader.next_frame(&mut pixels).expect("it is a whole PNG");
    // Gray becomes gray with opacity.
    let rgba = match frame.color_type {
        png::ColorType::Rgba => pixels,
        _ => pixels.chunks_exact(2).flat_map(|p| [p[0], p[0], p[0], p[1]]).collect(),
    };
    image::DynamicImage::ImageRgba8(image::RgbaImage::from_raw(frame.width, frame.height, rgba).expect("all pixels"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bare_picture_has_one_pixel_per_cell_in_the_palette() {
        let mask = [0, 1, 2, 3, 255, 1, 0, 0, 1, 2];
        let file = draw_bare(5, 2, &mask, &[]).expect("the mask has the right length");
        let image = read_png(&file).to_rgba8();
        assert_eq!(image.dimensions(), (5, 2));
        let colors = [[0xE6, 0x9F, 0x00, 255], [0x00, 0x72, 0xB2, 255], [0xC3, 0xC6, 0xC9, 255]];
        for (x, y, color) in [(0, 0, colors[0]), (1, 0, colors[1]), (2, 0, colors[2]), (4, 1, colors[2])] {
            assert_eq!(image.get_pixel(x, y).0, color);
        }
        assert_eq!((image.get_pixel(3, 0).0[3], image.get_pixel(4, 0).0[3]), (0, 0));
        assert!(draw_bare(2, 2, &[1; 3], &[]).is_err() && draw_bare(0, 2, &[], &[]).is_err());
    }

    #[test]
    fn provenance_is_read_back_and_bad_keywords_are_refused() {
        let provenance = [("Software".to_string(), "skyshed 1 — Ångström, θ".to_string())];
        let file = draw_bare(1, 1, &[1], &provenance).expect("the keyword is valid");
        let reader = png::Decoder::new(std::io::Cursor::new(&file)).read_info().expect("it is a PNG");
        let text = &reader.info().utf8_text[0];
        assert_eq!((text.keyword.as_str(), text.get_text().expect("text")), ("Software", provenance[0].1.clone()));
        for keyword in ["", " padded", "λ", &"k".repeat(80)] {
            assert!(draw_bare(1, 1, &[1], &[(keyword.to_string(), String::new())]).is_err(), "{keyword:?}");
        }
    }
}
