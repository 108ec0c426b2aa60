//! PNG files: pictures in true color, bare masks with a palette, both with their provenance as
//! text.
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
    // An inch is 25.4 mm.
    let per_m = (dpi * 5000 + 63) / 127;
    let rgb: Vec<u8> = image.pixels().flat_map(|pixel| [pixel.0[0], pixel.0[1], pixel.0[2]]).collect();
    let look = |encoder: &mut Encoder<'_, '_>| {
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
        encoder.set_pixel_dims(Some(png::PixelDimensions { xppu: per_m, yppu: per_m, unit: png::Unit::Meter }));
    };
    encode([image.width(), image.height()], look, provenance, |writer| writer.write_image_data(&rgb))
}

/// Draws a mask with one pixel per cell and nothing else: no frame, no words.
///
/// `mask` is `[n_rows, n_cols]`, columns running fastest. Blue is line of sight, orange none, gray
/// not a receiver; out of range and nodata are transparent. The file has a palette of two bits per
/// pixel and is written row by row. So 16384 × 16384 cells need no more memory than the encoded
/// file.
///
/// # Errors
/// * A mask of another length than the raster.
/// * An empty raster, or more than 2³¹ − 1 cells a side.
/// * A keyword of `provenance` that PNG does not allow (1 to 79 characters of Latin-1).
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

/// Draws the number of UAVs that see each cell, in the colors of the picture, with one pixel per
/// cell and nothing else.
///
/// `count` and `mask` are `[n_rows, n_cols]`, columns running fastest; `mask` marks the receivers.
/// Beyond 252 UAVs, several counts share a color.
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
    // The entries of cells that are no receivers, and of transparent cells, follow the counts.
    const MOST: u32 = 252;
    let shown = n_sites.min(MOST);
    let (other, nothing) = (shown + 1, shown + 2);
    let mut palette = colors::count_colors(shown);
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

/// Encodes a picture of nearly gray colors with a palette of 64. A pixel takes the mean color of
/// all pixels whose green, divided by 4, is the same integer.
///
/// # Errors
/// An array of another length than the raster, an empty raster or one of more than 2³¹ − 1 cells a
/// side.
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

/// Encodes a picture of a few colors with their opacities; `write` writes its pixels.
fn encode_palette(
    [n_cols, n_rows]: [usize; 2],
    (depth, colors, opacities): (png::BitDepth, &[Rgb], &[u8]),
    provenance: &[(String, String)],
    write: impl FnOnce(&mut png::Writer<&mut Vec<u8>>) -> Result<(), png::EncodingError>,
) -> Result<Vec<u8>, String> {
    let side = |n: usize| u32::try_from(n).ok().filter(|&n| n <= i32::MAX.unsigned_abs());
    let too_large = || format!("cannot draw {n_cols} × {n_rows} cells as PNG: at most 2147483647 a side");
    let (width, height) = side(n_cols).zip(side(n_rows)).ok_or_else(too_large)?;
    let look = |encoder: &mut Encoder<'_, '_>| {
        encoder.set_color(png::ColorType::Indexed);
        encoder.set_depth(depth);
        encoder.set_palette(colors.concat());
        if !opacities.is_empty() {
            encoder.set_trns(opacities.to_vec());
        }
        encoder.set_filter(png::Filter::NoFilter);
    };
    encode([width, height], look, provenance, write)
}

type Encoder<'a, 'b> = png::Encoder<'a, &'b mut Vec<u8>>;

/// Encodes a file of this size: `look` sets the format of its pixels, `write` writes them.
fn encode(
    [width, height]: [u32; 2],
    look: impl FnOnce(&mut Encoder<'_, '_>),
    provenance: &[(String, String)],
    write: impl FnOnce(&mut png::Writer<&mut Vec<u8>>) -> Result<(), png::EncodingError>,
) -> Result<Vec<u8>, String> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    look(&mut encoder);
    for (keyword, text) in provenance {
        let latin_1 = keyword.chars().all(|c| matches!(c, ' '..='~' | '\u{A1}'..='\u{FF}'));
        if !(1..=79).contains(&keyword.chars().count()) || !latin_1 || keyword.trim() != keyword {
            return Err(format!("cannot store `{keyword}` in PNG: a keyword is 1 to 79 printable Latin-1 characters"));
        }
        encoder.add_itxt_chunk(keyword.clone(), text.replace('\0', " ")).map_err(cannot)?;
    }
    let mut writer = encoder.write_header().map_err(cannot)?;
    write(&mut writer).map_err(cannot)?;
    writer.finish().map_err(cannot)?;
    Ok(file)
}

fn cannot(error: png::EncodingError) -> String {
    format!("cannot encode PNG: {error}")
}
