//! Resolutions of a GeoTIFF: their tags, their encoded blocks, and the head of a file that locates
//! the blocks.

use std::borrow::Cow;
use std::io::{Cursor, Seek, SeekFrom, Write};

use rayon::prelude::*;
use tiff_core::{ByteOrder, Compression, Predictor, Tag, TagValue};
use tiff_writer::compress::{BlockEncodingOptions, compress_block};
use tiff_writer::{TiffWriteSample, encoder};
use zlib_rs::{DeflateConfig, ReturnCode, Strategy, compress_bound, compress_slice};

use skyshed_request::TiffLayout;

use super::geo_tags::place_tags;
use super::image::{Bands, ClassColor, GeoTiffImage};
use crate::error::{Error, Result};

/// Rows and columns of a tile \[cells\], a multiple of 16 as TIFF demands.
pub(super) const TILE: usize = 256;
/// Largest side of a level without a smaller overview \[cells\].
const LARGEST_WITHOUT_OVERVIEW: usize = 256;
/// Largest number of overviews.
const MOST_OVERVIEWS: usize = 4;

/// Least length of a strip of more than one row \[bytes\]; TIFF 6.0 recommends about 8 KB, as GDAL
/// does.
const STRIP_BYTES: usize = 8192;

/// Writes header, directories and blocks, the smallest overview first.
pub(super) fn write_levels(out: &mut impl Write, levels: &[Level<'_>], force_big: bool) -> Result<()> {
    let head = head(levels, force_big)?;
    out.write_all(&head).map_err(failed)?;
    for level in levels.iter().rev() {
        for block in &level.blocks {
            out.write_all(block).map_err(failed)?;
        }
    }
    Ok(())
}

/// One resolution: its tags except those of block places, and its encoded tiles or strips band by
/// band.
pub(super) struct Level<'a> {
    pub(super) tags: Vec<Tag>,
    pub(super) blocks: Vec<Cow<'a, [u8]>>,
}

/// Returns the number of overviews of a raster, each half as large as the one before.
pub(super) fn n_overviews((n_rows, n_cols): (usize, usize)) -> usize {
    let is_large = |level: &usize| n_rows.max(n_cols).div_ceil(1 << level) > LARGEST_WITHOUT_OVERVIEW;
    (0..MOST_OVERVIEWS).take_while(is_large).count()
}

/// Returns the tags of a level except those of block places.
pub(super) fn level_tags<T: TiffWriteSample>(
    image: &GeoTiffImage<'_>,
    (shape, reduction): ((usize, usize), usize),
    names: &[&str],
    predictor: Predictor,
) -> Result<Vec<Tag>> {
    let mut tags = picture_tags::<T>(image, shape, names.len(), predictor)?;
    match reduction {
        1 => tags.extend(place_tags(image, names)?),
        _ => tags.push(Tag::new(tiff_core::TAG_NEW_SUBFILE_TYPE, TagValue::Long(vec![1]))),
    }
    Ok(tags)
}

/// Returns the tags that describe the picture itself.
fn picture_tags<T: TiffWriteSample>(
    image: &GeoTiffImage<'_>,
    (n_rows, n_cols): (usize, usize),
    n_bands: usize,
    predictor: Predictor,
) -> Result<Vec<Tag>> {
    let count = |n: usize| u32::try_from(n).map_err(|_| too_large(n));
    let n_samples = u16::try_from(n_bands).map_err(|_| too_large(n_bands))?;
    if n_samples == 0 {
        return Err(Error::encode("a GeoTIFF", "it has no bands"));
    }
    let palette = image.palette.filter(|_| n_bands == 1 && matches!(image.bands, Bands::Byte(_)));
    // Photometric 1: zero is black; 3: colors from the map. Planar configuration 2: one plane per
    // band.
    let photometric = if palette.is_some() { 3 } else { 1 };
    let planes = if n_bands > 1 { 2 } else { 1 };
    let mut tags = vec![
        Tag::new(tiff_core::TAG_IMAGE_WIDTH, TagValue::Long(vec![count(n_cols)?])),
        Tag::new(tiff_core::TAG_IMAGE_LENGTH, TagValue::Long(vec![count(n_rows)?])),
        Tag::new(tiff_core::TAG_BITS_PER_SAMPLE, TagValue::Short(vec![T::BITS_PER_SAMPLE; n_bands])),
        Tag::new(tiff_core::TAG_PHOTOMETRIC_INTERPRETATION, TagValue::Short(vec![photometric])),
        Tag::new(tiff_core::TAG_SAMPLES_PER_PIXEL, TagValue::Short(vec![n_samples])),
        Tag::new(tiff_core::TAG_PLANAR_CONFIGURATION, TagValue::Short(vec![planes])),
        Tag::new(tiff_core::TAG_SAMPLE_FORMAT, TagValue::Short(vec![T::SAMPLE_FORMAT; n_bands])),
    ];
    let codec = |codec: Compression| Tag::new(tiff_core::TAG_COMPRESSION, TagValue::Short(vec![codec.to_code()]));
    match image.layout {
        TiffLayout::Cog => tags.extend([
            codec(Compression::Deflate),
            Tag::new(tiff_core::TAG_PREDICTOR, TagValue::Short(vec![predictor.to_code()])),
            Tag::new(tiff_core::TAG_TILE_WIDTH, TagValue::Long(vec![count(TILE)?])),
            Tag::new(tiff_core::TAG_TILE_LENGTH, TagValue::Long(vec![count(TILE)?])),
        ]),
        TiffLayout::Plain => tags.extend([
            codec(Compression::None),
            Tag::new(tiff_core::TAG_ROWS_PER_STRIP, TagValue::Long(vec![count(rows_per_strip::<T>(n_cols))?])),
        ]),
    }
    if n_bands > 1 {
        // Bands after the first are data without a color.
        tags.push(Tag::new(tiff_core::TAG_EXTRA_SAMPLES, TagValue::Short(vec![0; n_bands - 1])));
    }
    if let Some(palette) = palette {
        tags.push(Tag::new(tiff_core::TAG_COLOR_MAP, TagValue::Short(color_map(palette))));
    }
    if let Some(nodata) = image.nodata {
        let text = if nodata.is_nan() { "nan".to_string() } else { nodata.to_string() };
        tags.push(Tag::new(geotiff_core::tags::TAG_GDAL_NODATA, TagValue::Ascii(text)));
    }
    Ok(tags)
}

/// Returns red of all 256 values, then green, then blue, in 16 bits.
fn color_map(palette: &[ClassColor]) -> Vec<u16> {
    let mut map = vec![0; 3 * 256];
    for class in palette {
        for (plane, &shade) in class.rgba[..3].iter().enumerate() {
            map[plane * 256 + usize::from(class.value)] = u16::from(shade) * 257;
        }
    }
    map
}

/// Encoding of tiles, except for their predictor.
pub(super) const TILE_ENCODING: BlockEncodingOptions<'static> = BlockEncodingOptions {
    byte_order: ByteOrder::LittleEndian,
    compression: Compression::Deflate,
    predictor: Predictor::None,
    samples_per_pixel: 1,
    row_width_pixels: TILE,
    jpeg_options: None,
    jpeg_sampling: None,
    // PERF: at the default level, measures take a third more time of a whole command, and a sixth
    // less space on a disk.
    deflate_level: Some(1),
};

/// Type of the cells of a tile.
pub(super) trait Tile: TiffWriteSample + Send + Sync {
    /// Returns a tile as it is stored.
    fn compressed(samples: &[Self], options: BlockEncodingOptions<'_>, index: usize) -> Result<Vec<u8>> {
        compress_block(samples, options, index).map_err(refused)
    }
}

impl Tile for f32 {}

impl Tile for u32 {}

/// Classes come in runs: only the byte before is matched, which takes a fifth of the time of the
/// default search of zlib.
impl Tile for u8 {
    fn compressed(samples: &[Self], _: BlockEncodingOptions<'_>, _: usize) -> Result<Vec<u8>> {
        let config = DeflateConfig { strategy: Strategy::Rle, ..DeflateConfig::default() };
        let mut stream = vec![0; compress_bound(samples.len())];
        match compress_slice(&mut stream, samples, config) {
            // PERF: only what is used is kept until the file is written.
            (packed, ReturnCode::Ok) => Ok(packed.to_vec()),
            (_, code) => Err(Error::encode("a GeoTIFF", format!("zlib: {code:?}"))),
        }
    }
}

/// Returns the tiles of all bands, band by band, row by row; tiles at the margin repeat the last
/// row and column.
pub(super) fn compressed_tiles<T: Tile>(
    bands: &[&[T]],
    (n_rows, n_cols): (usize, usize),
    predictor: Predictor,
) -> Result<Vec<Vec<u8>>> {
    let options = BlockEncodingOptions { predictor, ..TILE_ENCODING };
    let (down, across) = (n_rows.div_ceil(TILE), n_cols.div_ceil(TILE));
    (0..bands.len() * down * across)
        .into_par_iter()
        .map(|index| {
            let (band, tile) = (bands[index / (down * across)], index % (down * across));
            let (top, left) = (tile / across * TILE, tile % across * TILE);
            let mut samples = Vec::with_capacity(TILE * TILE);
            for row in top..top + TILE {
                let row = row.min(n_rows - 1) * n_cols;
                let inside = &band[row + left..row + n_cols.min(left + TILE)];
                samples.extend_from_slice(inside);
                samples.resize(samples.len() + TILE - inside.len(), inside[inside.len() - 1]);
            }
            T::compressed(&samples, options, index)
        })
        .collect()
}

pub(super) fn rows_per_strip<T: TiffWriteSample>(n_cols: usize) -> usize {
    STRIP_BYTES.div_ceil(n_cols * T::BYTES_PER_SAMPLE)
}

/// Returns header and all directories: everything before the blocks.
fn head(levels: &[Level<'_>], force_big: bool) -> Result<Vec<u8>> {
    let data: u64 = levels.iter().map(Level::n_bytes).sum();
    let is_big = force_big || data + head_len(levels, false)? > u64::from(u32::MAX);
    let head_len = head_len(levels, is_big)?;

    // Blocks begin after the head, the smallest level first.
    let mut starts = vec![0; levels.len()];
    let mut next = head_len;
    for (level, start) in levels.iter().zip(&mut starts).rev() {
        *start = next;
        next += level.n_bytes();
    }

    let mut head = Cursor::new(Vec::new());
    let order = ByteOrder::LittleEndian;
    let header = encoder::write_header(&mut head, order, is_big).map_err(refused)?;
    let mut pointer = None;
    for (level, &start) in levels.iter().zip(&starts) {
        align(&mut head)?;
        let tags = level.tags_at(start, is_big);
        let (offsets, counts) = TILE_PLACES;
        let directory = encoder::write_ifd(&mut head, order, is_big, &tags, offsets, counts, level.blocks.len())
            .map_err(refused)?;
        match pointer {
            None => encoder::patch_first_ifd(&mut head, header, order, is_big, directory.ifd_offset),
            Some(pointer) => encoder::patch_next_ifd(&mut head, order, is_big, pointer, directory.ifd_offset),
        }
        .map_err(refused)?;
        head.seek(SeekFrom::End(0)).map_err(|cause| refused(cause.into()))?;
        pointer = Some(directory.next_ifd_pointer_offset);
    }
    align(&mut head)?;
    assert_eq!(head.get_ref().len() as u64, head_len, "blocks begin where the directories say");
    Ok(head.into_inner())
}

/// Returns the length of [`head`] \[bytes\].
fn head_len(levels: &[Level<'_>], is_big: bool) -> Result<u64> {
    let even = |n: u64| n + n % 2;
    let mut len = encoder::header_len(is_big);
    for level in levels {
        let tags = level.tags_at(0, is_big);
        len = even(len + encoder::estimate_ifd_size(ByteOrder::LittleEndian, is_big, &tags).map_err(refused)?);
    }
    Ok(len)
}

/// Pads to an even offset, where directories begin.
fn align(head: &mut Cursor<Vec<u8>>) -> Result<()> {
    if head.get_ref().len() % 2 == 1 { write_all(head, &[0]) } else { Ok(()) }
}

fn write_all(head: &mut Cursor<Vec<u8>>, bytes: &[u8]) -> Result<()> {
    head.write_all(bytes).map_err(|cause| refused(cause.into()))
}

impl Level<'_> {
    /// Returns the length of all blocks \[bytes\].
    fn n_bytes(&self) -> u64 {
        self.blocks.iter().map(|block| block.len() as u64).sum()
    }

    /// Returns all tags in order, for blocks that begin at `start`.
    fn tags_at(&self, start: u64, is_big: bool) -> Vec<Tag> {
        let lens: Vec<u64> = self.blocks.iter().map(|block| block.len() as u64).collect();
        tags_with_places(&self.tags, TILE_PLACES, &lens, start, is_big)
    }
}

/// Tags of the offsets and of the lengths of tiles.
const TILE_PLACES: (u16, u16) = (tiff_core::TAG_TILE_OFFSETS, tiff_core::TAG_TILE_BYTE_COUNTS);

/// Returns the tags in order, with those of the offsets and lengths of blocks. The blocks follow
/// one another from `start` on.
pub(super) fn tags_with_places(
    tags: &[Tag],
    (offsets_code, counts_code): (u16, u16),
    lens: &[u64],
    start: u64,
    is_big: bool,
) -> Vec<Tag> {
    let mut next = start;
    let mut offsets = Vec::with_capacity(lens.len());
    for len in lens {
        offsets.push(next);
        next += len;
    }
    // Saturation is impossible: a file with an offset beyond 32 bits is a BigTIFF.
    let narrow = |n| u32::try_from(n).unwrap_or(u32::MAX);
    let value = |numbers: Vec<u64>| match is_big {
        true => TagValue::Long8(numbers),
        false => TagValue::Long(numbers.into_iter().map(narrow).collect()),
    };
    let mut tags = tags.to_vec();
    tags.push(Tag::new(offsets_code, value(offsets)));
    tags.push(Tag::new(counts_code, value(lens.to_vec())));
    tags.sort_by_key(|tag| tag.code);
    tags
}

pub(super) fn failed(cause: std::io::Error) -> Error {
    Error::refused("a GeoTIFF", &cause)
}

pub(super) fn refused(cause: tiff_writer::Error) -> Error {
    Error::encode("a GeoTIFF", cause)
}

fn too_large(n: usize) -> Error {
    Error::encode("a GeoTIFF", format!("{n} is more than TIFF can count"))
}
