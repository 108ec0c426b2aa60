//! GeoTIFF out: tiled, deflated, with overviews, laid out as a cloud optimized GeoTIFF; or plain strips for readers that
//! know no more, and for comparing how long programs take without their codecs.
//!
//! All blocks of tiled files are compressed in parallel and held in memory, so that every offset is known before the first
//! byte is written: header, directories (full resolution first), blocks of the smallest overview, …, blocks of the full
//! resolution. Plain files have their directory behind their strips (`plain.rs`). The bytes depend on the input alone, not
//! on the number of threads or the time of day.
//!
//! The codecs and the byte layout of tags are those of `tiff-writer`. What says where the picture lies and what it is about
//! is in `geo_tags.rs`; GDAL's tag for nodata (42113) is written here.
//!
//! # References
//! TIFF 6.0 (1992); OGC 21-026, Cloud Optimized GeoTIFF; the GDAL driver documentation.

use std::borrow::Cow;
use std::io::{Cursor, Seek, SeekFrom, Write};

use rayon::prelude::*;
use tiff_core::{ByteOrder, Compression, Predictor, Tag, TagValue};
use tiff_writer::compress::{BlockEncodingOptions, compress_block};
use tiff_writer::{TiffWriteSample, encoder};

use super::geo_tags::place_tags;
use super::overview::{Reduce, first_of, most_frequent, overview};
use super::plain::write_plain;
use crate::error::{Error, Result, io_words};
use crate::raster::GeoRef;

/// Rows and columns of a tile \[cells\], a multiple of 16 as TIFF demands.
pub(super) const TILE: usize = 256;
/// Overviews are made while the next larger level is larger than this \[cells\] …
const LARGEST_WITHOUT_OVERVIEW: usize = 256;
/// … and up to this reduction.
const LARGEST_REDUCTION: usize = 16;

/// Least length of a strip of more than one row \[bytes\]; TIFF 6.0 asks for about 8 KB, as does GDAL.
const STRIP_BYTES: usize = 8192;

/// How the cells of a file are arranged and compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TiffLayout {
    /// Tiles of 256 × 256 cells, deflated, with overviews: a cloud optimized GeoTIFF.
    #[default]
    Cog,
    /// Strips of whole rows, neither compressed nor reduced. The strips of a band follow each other without gaps, north
    /// first, so a band is one stretch of little-endian numbers; the first begins behind the header, at byte 8, or 16 of a
    /// BigTIFF.
    Plain,
}

/// The bands of an image: name and values row by row from the north-west cell, all of one type.
#[derive(Debug, Clone)]
pub enum Bands<'a> {
    /// Classes; overviews show the most frequent one, the smaller on a tie.
    Byte(Vec<(String, &'a [u8])>),
    /// Measures; overviews show one of the cells.
    Float(Vec<(String, &'a [f32])>),
    /// Counts or sets of bits; overviews show one of the cells.
    UInt32(Vec<(String, &'a [u32])>),
}

/// How a class is called and drawn.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ClassColor {
    /// The cell value.
    pub value: u8,
    /// The name shown in a legend.
    pub name: String,
    /// Red, green, blue, opacity.
    pub rgba: [u8; 4],
}

/// Everything that goes into a GeoTIFF file.
#[derive(Debug, Clone)]
pub struct GeoTiffImage<'a> {
    /// Where the cells lie.
    pub georef: &'a GeoRef,
    /// The values.
    pub bands: Bands<'a>,
    /// The value that means no data, in all bands.
    pub nodata: Option<f64>,
    /// Colors of a single byte band. TIFF has no opacity: it is left to the renderer.
    pub palette: Option<&'a [ClassColor]>,
    /// Items of GDAL's metadata: key and value.
    pub metadata: &'a [(String, String)],
    /// Arrangement of the cells.
    pub layout: TiffLayout,
}

/// The file as bytes.
///
/// # Errors
/// E402 if TIFF cannot hold the image.
///
/// # Panics
/// If a band does not hold one value per cell.
pub fn encode_geotiff(image: &GeoTiffImage<'_>) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write_geotiff(&mut bytes, image)?;
    Ok(bytes)
}

/// Writes the file front to back; a BigTIFF if it is above 4 GiB, or 3 GiB of a plain one.
///
/// # Errors
/// E401 if `out` refuses the bytes, E402 if TIFF cannot hold the image.
///
/// # Panics
/// If a band does not hold one value per cell.
pub fn write_geotiff(out: &mut impl Write, image: &GeoTiffImage<'_>) -> Result<()> {
    write_as(out, image, false)
}

fn write_as(out: &mut impl Write, image: &GeoTiffImage<'_>, force_big: bool) -> Result<()> {
    let levels = match &image.bands {
        Bands::Byte(bands) => levels(image, bands, Predictor::None, most_frequent, Some)?,
        Bands::Float(bands) => levels(image, bands, Predictor::FloatingPoint, first_of, |_| None)?,
        Bands::UInt32(bands) => levels(image, bands, Predictor::None, first_of, |_| None)?,
    };
    match levels.as_slice() {
        [only] if image.layout == TiffLayout::Plain => write_plain(out, only, force_big),
        levels => write_levels(out, levels, force_big),
    }
}

/// Header, directories and blocks, the smallest overview first.
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

/// One resolution: its tags except for the places of the blocks, and its encoded tiles or strips band by band.
pub(super) struct Level<'a> {
    pub(super) tags: Vec<Tag>,
    pub(super) blocks: Vec<Cow<'a, [u8]>>,
}

/// All resolutions, the full one first.
///
/// `as_bytes` gives the cells as they are stored without compression, if they need no encoding.
fn levels<'a, T: TiffWriteSample + Send + Sync>(
    image: &GeoTiffImage<'_>,
    bands: &[(String, &'a [T])],
    predictor: Predictor,
    reduce: Reduce<T>,
    as_bytes: fn(&'a [T]) -> Option<&'a [u8]>,
) -> Result<Vec<Level<'a>>> {
    let (n_rows, n_cols) = (image.georef.n_rows(), image.georef.n_cols());
    let names: Vec<&str> = bands.iter().map(|(name, _)| name.as_str()).collect();
    for (name, values) in bands {
        assert_eq!(values.len(), image.georef.n_cells(), "band `{name}` holds one value per cell");
    }
    let mut levels = Vec::new();
    let mut reduction = 1;
    loop {
        let shape = (n_rows.div_ceil(reduction), n_cols.div_ceil(reduction));
        let reduced: Vec<Vec<T>> = match reduction {
            1 => Vec::new(),
            _ => bands.iter().map(|(_, values)| overview(values, (n_rows, n_cols), reduction, reduce)).collect(),
        };
        let cells: Vec<&[T]> = match reduction {
            1 => bands.iter().map(|(_, values)| *values).collect(),
            _ => reduced.iter().map(Vec::as_slice).collect(),
        };
        let tags = level_tags::<T>(image, (shape, reduction), &names, predictor)?;
        let blocks = match image.layout {
            TiffLayout::Cog => compressed_tiles(&cells, shape, predictor)?.into_iter().map(Cow::Owned).collect(),
            TiffLayout::Plain => plain_strips(bands, shape.1, as_bytes)?,
        };
        levels.push(Level { tags, blocks });
        if is_last_level(shape, reduction) || image.layout == TiffLayout::Plain {
            return Ok(levels);
        }
        reduction *= 2;
    }
}

/// Whether no smaller overview is made than one of this shape and reduction.
pub(super) fn is_last_level((n_rows, n_cols): (usize, usize), reduction: usize) -> bool {
    reduction >= LARGEST_REDUCTION || n_rows.max(n_cols) <= LARGEST_WITHOUT_OVERVIEW
}

/// The tags of a level but for the places of its blocks.
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

/// The tags that describe the picture as such.
fn picture_tags<T: TiffWriteSample>(
    image: &GeoTiffImage<'_>,
    (n_rows, n_cols): (usize, usize),
    n_bands: usize,
    predictor: Predictor,
) -> Result<Vec<Tag>> {
    let count = |n: usize| u32::try_from(n).map_err(|_| too_large(n));
    let n_samples = u16::try_from(n_bands).map_err(|_| too_large(n_bands))?;
    if n_samples == 0 {
        return Err(Error::internal(402, "cannot write a GeoTIFF without bands"));
    }
    let palette = image.palette.filter(|_| n_bands == 1 && matches!(image.bands, Bands::Byte(_)));
    // 1: zero is black, 3: colors from the map. 2: one plane per band.
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
        // Bands after the first are data of no color.
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

/// Red of all 256 values, then green, then blue, in 16 bits.
fn color_map(palette: &[ClassColor]) -> Vec<u16> {
    let mut map = vec![0; 3 * 256];
    for class in palette {
        for (plane, &shade) in class.rgba[..3].iter().enumerate() {
            map[plane * 256 + usize::from(class.value)] = u16::from(shade) * 257;
        }
    }
    map
}

/// How tiles are encoded, but for their predictor.
const TILE_ENCODING: BlockEncodingOptions<'static> = BlockEncodingOptions {
    byte_order: ByteOrder::LittleEndian,
    compression: Compression::Deflate,
    predictor: Predictor::None,
    samples_per_pixel: 1,
    row_width_pixels: TILE,
    jpeg_options: None,
    jpeg_sampling: None,
    deflate_level: None,
};

/// The tiles of all bands, band by band, row by row; tiles at the margin repeat the last row and column.
pub(super) fn compressed_tiles<T: TiffWriteSample + Send + Sync>(
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
            compress_block(&samples, options, index).map_err(refused)
        })
        .collect()
}

pub(super) fn rows_per_strip<T: TiffWriteSample>(n_cols: usize) -> usize {
    STRIP_BYTES.div_ceil(n_cols * T::BYTES_PER_SAMPLE)
}

/// The strips of all bands, band by band, from the north; the last one of a band holds the rows that are left.
fn plain_strips<'a, T: TiffWriteSample + Send + Sync>(
    bands: &[(String, &'a [T])],
    n_cols: usize,
    as_bytes: fn(&'a [T]) -> Option<&'a [u8]>,
) -> Result<Vec<Cow<'a, [u8]>>> {
    let options = BlockEncodingOptions {
        compression: Compression::None,
        predictor: Predictor::None,
        row_width_pixels: n_cols,
        ..TILE_ENCODING
    };
    let strip = rows_per_strip::<T>(n_cols) * n_cols;
    let strips: Vec<&'a [T]> = bands.iter().flat_map(|(_, band)| band.chunks(strip)).collect();
    let encoded = |(index, cells): (usize, &&'a [T])| match as_bytes(cells) {
        Some(bytes) => Ok(Cow::Borrowed(bytes)),
        None => compress_block(cells, options, index).map(Cow::Owned).map_err(refused),
    };
    strips.par_iter().enumerate().map(encoded).collect()
}

/// Header and all directories: everything before the blocks.
fn head(levels: &[Level<'_>], force_big: bool) -> Result<Vec<u8>> {
    let data: u64 = levels.iter().map(Level::n_bytes).sum();
    let is_big = force_big || data + head_len(levels, false)? > u64::from(u32::MAX);
    let head_len = head_len(levels, is_big)?;

    // Blocks begin after the head, those of the smallest level first.
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

/// Length of [`head`] \[bytes\].
fn head_len(levels: &[Level<'_>], is_big: bool) -> Result<u64> {
    let even = |n: u64| n + n % 2;
    let mut len = encoder::header_len(is_big);
    for level in levels {
        let tags = level.tags_at(0, is_big);
        len = even(len + encoder::estimate_ifd_size(ByteOrder::LittleEndian, is_big, &tags).map_err(refused)?);
    }
    Ok(len)
}

/// Directories begin on even offsets.
fn align(head: &mut Cursor<Vec<u8>>) -> Result<()> {
    if head.get_ref().len() % 2 == 1 { write_all(head, &[0]) } else { Ok(()) }
}

fn write_all(head: &mut Cursor<Vec<u8>>, bytes: &[u8]) -> Result<()> {
    head.write_all(bytes).map_err(|cause| refused(cause.into()))
}

impl Level<'_> {
    /// Length of all blocks \[bytes\].
    fn n_bytes(&self) -> u64 {
        self.blocks.iter().map(|block| block.len() as u64).sum()
    }

    /// All tags in order, for blocks that begin at `start`.
    fn tags_at(&self, start: u64, is_big: bool) -> Vec<Tag> {
        let lens: Vec<u64> = self.blocks.iter().map(|block| block.len() as u64).collect();
        tags_with_places(&self.tags, TILE_PLACES, &lens, start, is_big)
    }
}

/// The tags that hold where tiles begin and how long they are.
const TILE_PLACES: (u16, u16) = (tiff_core::TAG_TILE_OFFSETS, tiff_core::TAG_TILE_BYTE_COUNTS);

/// Tags, and those that hold where blocks of some lengths begin, one behind the other from `start` on, and how long they
/// are: all in order.
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
    // Saturation is out of reach: a file in which an offset does not fit in 32 bits is a BigTIFF.
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
    Error::file(401, format!("cannot write a GeoTIFF: {}", io_words(&cause)))
}

pub(super) fn refused(cause: tiff_writer::Error) -> Error {
    Error::internal(402, format!("cannot encode a GeoTIFF: {cause}"))
}

fn too_large(n: usize) -> Error {
    Error::internal(402, format!("cannot encode a GeoTIFF: {n} is more than TIFF can count"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn classic_and_big_files_hold_the_same() {
        let crs = crate::crs::from_epsg(25832).unwrap();
        let georef = GeoRef::new((500_000.0, 5_400_000.0), (1.0, 1.0), (300, 700), Some(crs)).unwrap();
        let cells: Vec<f32> = (0..georef.n_cells()).map(|i| (i % 977) as f32 / 8.0).collect();
        let bands = Bands::Float(vec![("a".to_string(), &cells), ("b".to_string(), &cells)]);
        for (layout, n_overviews, force_big, magic) in [
            (TiffLayout::Cog, 2, false, 42),
            (TiffLayout::Cog, 2, true, 43),
            (TiffLayout::Plain, 0, false, 42),
            (TiffLayout::Plain, 0, true, 43),
        ] {
            let image = GeoTiffImage {
                georef: &georef,
                bands: bands.clone(),
                nodata: Some(-9999.0),
                palette: None,
                metadata: &[],
                layout,
            };
            let mut bytes = Vec::new();
            write_as(&mut bytes, &image, force_big).unwrap();
            assert_eq!(bytes[2], magic);
            let file = geotiff_reader::GeoTiffFile::from_bytes(bytes).unwrap();
            assert_eq!((file.width(), file.height(), file.band_count()), (700, 300, 2));
            assert_eq!(file.overview_count(), n_overviews);
            assert_eq!(file.read_band::<f32>(1).unwrap().iter().copied().collect::<Vec<_>>(), cells);
        }
    }
}
