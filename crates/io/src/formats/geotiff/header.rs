//! Header of a TIFF picture, checked against the length of the file.
//!
//! All checks come before a pixel is read and before anything of the size of the picture is
//! allocated. Each block is checked against the length of the file; each product is computed where
//! it cannot overflow. After [`Image::parse`] the decoder may rely on the block table, the block
//! size and the sample type.
//!
//! Reference: TIFF 6.0 (1992), TIFF Technical Notes 1 to 3, and the LERC and Zstandard compressions
//! of libtiff.

use tiff_reader::ByteOrder;

use super::tags::{Directory, TiffSource, tag};
use crate::error::{Cause, Result};
use crate::formats::sample::Sample;

/// Largest decoded size of one compressed strip or tile \[bytes\].
const MAX_BLOCK_BYTES: u64 = 4 << 30;

/// Largest decoded strip or tile of a smaller raster \[bytes\].
const LARGE_BLOCK_BYTES: u64 = 64 << 20;

/// Compression of the bytes of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Codec {
    None,
    Lzw,
    Deflate,
    PackBits,
    Zstd,
    /// LERC, its blocks packed once more by the inner codec.
    Lerc(LercInner),
    Jpeg,
}

/// Second compression of LERC blocks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LercInner {
    None,
    Deflate,
    Zstd,
}

impl Codec {
    /// Returns the name that GDAL uses, in lower case.
    pub(super) fn name(self) -> &'static str {
        match self {
            Codec::None => "uncompressed",
            Codec::Lzw => "lzw",
            Codec::Deflate => "deflate",
            Codec::PackBits => "packbits",
            Codec::Zstd => "zstd",
            Codec::Lerc(LercInner::None) => "lerc",
            Codec::Lerc(LercInner::Deflate) => "lerc_deflate",
            Codec::Lerc(LercInner::Zstd) => "lerc_zstd",
            Codec::Jpeg => "jpeg",
        }
    }

    /// Returns the most decoded bytes per stored byte that the format can reach; `None` where
    /// constant blocks cost nothing.
    ///
    /// Deflate: 258 bytes in 2 bits, less the block overhead (zlib documents 1032). LZW: a 12-bit
    /// code encodes less than 4096 bytes. PackBits: 128 bytes in 2. Zstandard: a block of 128 KiB
    /// in 4 bytes.
    fn max_ratio(self) -> Option<u64> {
        match self {
            Codec::None => Some(1),
            Codec::PackBits => Some(64),
            Codec::Deflate => Some(1032),
            Codec::Lzw => Some(2731),
            Codec::Zstd => Some(32768),
            Codec::Lerc(_) | Codec::Jpeg => None,
        }
    }
}

/// Predictor: the form in which the samples of a row are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Predictor {
    None,
    /// Differences to the sample on the left.
    Horizontal,
    /// Differences of bytes, sorted by significance.
    FloatingPoint,
}

/// One picture of the file: its size, its sample type and the table of its blocks (strips or
/// tiles).
#[derive(Debug, Clone)]
pub(super) struct Image {
    pub(super) n_rows: usize,
    pub(super) n_cols: usize,
    pub(super) n_bands: usize,
    pub(super) sample: Sample,
    pub(super) codec: Codec,
    pub(super) predictor: Predictor,
    pub(super) tiled: bool,
    /// `true` if each band has blocks of its own.
    pub(super) planar: bool,
    pub(super) block_rows: usize,
    pub(super) block_cols: usize,
    /// `true` if stored bytes have their lowest bit first.
    pub(super) bits_reversed: bool,
    pub(super) jpeg_tables: Option<Vec<u8>>,
    /// Offset and length of each block \[bytes\]; length 0 where the block is missing (a sparse
    /// file).
    pub(super) blocks: Vec<(u64, u64)>,
}

impl Image {
    /// Reads and checks the tags of a picture of heights.
    pub(super) fn parse(source: &mut TiffSource, directory: &Directory) -> Result<Image> {
        let image = Image::parse_any(source, directory)?;
        if image.sample == Sample::Bit {
            let error = source.unsupported("1-bit samples are no heights, wanted integers or floats of 8 to 64 bits");
            return Err(error.because(Cause::OneBit));
        }
        Ok(image)
    }

    /// Reads and checks the tags of a validity mask (1 bit or 8 bits per cell).
    pub(super) fn parse_mask(source: &mut TiffSource, directory: &Directory) -> Result<Image> {
        let image = Image::parse_any(source, directory)?;
        if !matches!(image.sample, Sample::Bit | Sample::U8) || image.n_bands != 1 {
            return Err(source.unsupported("the mask is neither 1 nor 8 bits deep"));
        }
        Ok(image)
    }

    fn parse_any(source: &mut TiffSource, directory: &Directory) -> Result<Image> {
        let n_cols = dimension(source, directory, tag::IMAGE_WIDTH, "width")?;
        let n_rows = dimension(source, directory, tag::IMAGE_LENGTH, "height")?;
        let n_bands = match directory.integer(source, tag::SAMPLES_PER_PIXEL)?.unwrap_or(1) {
            n @ 1..=65_535 => n,
            n => return Err(source.malformed(format!("{n} samples per cell, wanted 1 to 65535"))),
        };
        if let Some(extra) = directory.integers(source, tag::EXTRA_SAMPLES)?
            && extra.len() as u64 > n_bands
        {
            let text = format!("{} extra samples of only {n_bands} samples per cell", extra.len());
            return Err(source.malformed(text));
        }
        let sample = sample_type(source, directory, n_bands)?;
        let codec = codec(source, directory)?;
        let predictor = predictor(source, directory, codec, sample)?;
        let planar = match directory.integer(source, tag::PLANAR_CONFIGURATION)?.unwrap_or(1) {
            1 => false,
            2 => n_bands > 1,
            other => return Err(source.malformed(format!("planar configuration `{other}`, wanted 1 or 2"))),
        };
        let bits_reversed = match directory.integer(source, tag::FILL_ORDER)?.unwrap_or(1) {
            1 => false,
            2 => codec != Codec::Jpeg,
            other => return Err(source.malformed(format!("fill order `{other}`, wanted 1 or 2"))),
        };
        let jpeg_tables = match codec {
            Codec::Jpeg => {
                // Several samples in one JPEG stream are a color picture, whose color space would
                // have to be undone.
                if n_bands > 1 && !planar {
                    let error = source.unsupported("a JPEG color picture, wanted one band of heights");
                    return Err(error.because(Cause::ColorJpeg));
                }
                directory
                    .integers(source, tag::JPEG_TABLES)?
                    .map(|table| table.iter().map(|value| u8::try_from(*value).unwrap_or(0)).collect())
            }
            _ => None,
        };
        let tiled = directory.has(tag::TILE_WIDTH) || directory.has(tag::TILE_OFFSETS);
        let (block_rows, block_cols) = if tiled {
            let rows = dimension(source, directory, tag::TILE_LENGTH, "tile height")?;
            (rows, dimension(source, directory, tag::TILE_WIDTH, "tile width")?)
        } else {
            // Writers put 2^32 - 1 for all rows.
            match directory.integer(source, tag::ROWS_PER_STRIP)?.unwrap_or(n_rows) {
                0 => return Err(source.malformed("0 rows per strip, wanted at least 1")),
                rows => (rows.min(n_rows), n_cols),
            }
        };
        let dimensions = [n_rows, n_cols, n_bands, block_rows, block_cols].map(usize::try_from);
        let [Ok(n_rows), Ok(n_cols), Ok(n_bands), Ok(block_rows), Ok(block_cols)] = dimensions else {
            return Err(
                source.malformed(format!("{n_cols} columns x {n_rows} rows are more than this machine can count"))
            );
        };
        let mut image = Image {
            n_rows,
            n_cols,
            n_bands,
            sample,
            codec,
            predictor,
            tiled,
            planar,
            block_rows,
            block_cols,
            bits_reversed,
            jpeg_tables,
            blocks: Vec::new(),
        };
        image.blocks = image.block_table(source, directory)?;
        Ok(image)
    }

    /// Returns the number of blocks side by side.
    pub(super) fn blocks_across(&self) -> usize {
        self.n_cols.div_ceil(self.block_cols)
    }

    /// Returns the number of blocks from north to south.
    pub(super) fn blocks_down(&self) -> usize {
        self.n_rows.div_ceil(self.block_rows)
    }

    /// Returns the number of samples of a cell that lie side by side in a block.
    pub(super) fn samples_per_block_cell(&self) -> usize {
        if self.planar { 1 } else { self.n_bands }
    }

    /// Returns the number of rows that a block stores: tiles are padded to their full height, the
    /// last strip is not.
    pub(super) fn stored_rows(&self, block_row: usize) -> usize {
        if self.tiled { self.block_rows } else { self.block_rows.min(self.n_rows - block_row * self.block_rows) }
    }

    /// Returns the size of one decoded row of a block \[bytes\]; cannot overflow where the block
    /// table has been checked.
    pub(super) fn row_bytes(&self) -> u64 {
        let samples = self.block_cols as u128 * self.samples_per_block_cell() as u128;
        let bytes = (samples * u128::from(self.sample.bits())).div_ceil(8);
        u64::try_from(bytes).unwrap_or(u64::MAX)
    }

    /// Returns the name of block `index` for messages.
    pub(super) fn block_name(&self, index: usize) -> String {
        format!("{} {index}", if self.tiled { "tile" } else { "strip" })
    }

    /// Reads the places of all blocks, and checks that the file can hold them.
    fn block_table(&self, source: &mut TiffSource, directory: &Directory) -> Result<Vec<(u64, u64)>> {
        let (offsets_tag, counts_tag) = if self.tiled {
            (tag::TILE_OFFSETS, tag::TILE_BYTE_COUNTS)
        } else {
            (tag::STRIP_OFFSETS, tag::STRIP_BYTE_COUNTS)
        };
        let kind = if self.tiled { "tiles" } else { "strips" };
        let planes = if self.planar { self.n_bands } else { 1 };
        let n_blocks = self.blocks_across() as u128 * self.blocks_down() as u128 * planes as u128;
        let Some(offsets) = directory.integers(source, offsets_tag)? else {
            return Err(source.malformed(format!("no {kind}: tag {offsets_tag} is missing")));
        };
        if (offsets.len() as u128) < n_blocks {
            let text = format!(
                "{} columns x {} rows need {n_blocks} {kind}, the file lists {}",
                self.n_cols,
                self.n_rows,
                offsets.len()
            );
            return Err(source.truncated(text).because(Cause::DamagedHeader));
        }
        let counts = match directory.integers(source, counts_tag)? {
            Some(counts) if counts.len() as u128 >= n_blocks => counts,
            // Old writers leave out the lengths where they follow from the size of the picture.
            None if self.codec == Codec::None => vec![u64::MAX; offsets.len()],
            _ => return Err(source.truncated(format!("the lengths of some {kind} are missing (tag {counts_tag})"))),
        };
        // `offsets` holds at least `n_blocks` values, so the number fits.
        let n_blocks = usize::try_from(n_blocks).unwrap_or(usize::MAX);
        let mut blocks: Vec<(u64, u64)> = offsets.into_iter().zip(counts).take(n_blocks).collect();
        for (index, block) in blocks.iter_mut().enumerate() {
            self.check_block(source, index, block)?;
        }
        Ok(blocks)
    }

    /// Checks that block `index` lies in the file and can hold its rows; trims a length beyond the
    /// size of these rows.
    fn check_block(&self, source: &TiffSource, index: usize, block: &mut (u64, u64)) -> Result<()> {
        if block.0 == 0 || block.1 == 0 {
            *block = (0, 0);
            return Ok(());
        }
        let block_row = index / self.blocks_across() % self.blocks_down();
        let rows = self.stored_rows(block_row) as u128;
        let needed = u64::try_from(u128::from(self.row_bytes()) * rows).unwrap_or(u64::MAX);
        let (name, len) = (self.block_name(index), source.len());
        if self.codec == Codec::None && block.1 > needed {
            block.1 = needed;
        }
        let (offset, count) = *block;
        if offset.checked_add(count).is_none_or(|end| end > len) {
            let text = format!("{name} ({count} bytes at byte {offset}) ends beyond the file of {len} bytes");
            return Err(source.truncated(text).because(Cause::CutShort));
        }
        if self.codec.max_ratio().is_some_and(|ratio| count.saturating_mul(ratio) < needed) {
            let text = format!("{name} has {count} bytes ({}), which cannot hold {needed}", self.codec.name());
            return Err(source.truncated(text).because(Cause::DamagedHeader));
        }
        // Row by row is possible only without compression.
        let raster = self.row_bytes().saturating_mul(self.blocks_across() as u64).saturating_mul(self.n_rows as u64);
        let most = MAX_BLOCK_BYTES.min(raster.max(LARGE_BLOCK_BYTES));
        if self.codec != Codec::None && needed > most {
            let error = source.unsupported(format!("{name} decodes to {needed} bytes, at most {most} can be held"));
            return Err(error.because(Cause::LargeBlock));
        }
        Ok(())
    }
}

fn dimension(source: &mut TiffSource, directory: &Directory, tag: u16, name: &str) -> Result<u64> {
    match directory.integer(source, tag)? {
        Some(n) if n > 0 && n <= 1 << 32 => Ok(n),
        Some(n) => Err(source.malformed(format!("{name} `{n}`, wanted 1 to 4294967296 cells"))),
        None => Err(source.malformed(format!("no {name}: tag {tag} is missing"))),
    }
}

fn sample_type(source: &mut TiffSource, directory: &Directory, n_bands: u64) -> Result<Sample> {
    let uniform = |values: Option<Vec<u64>>, default: u64| match values.as_deref() {
        None => Some(default),
        Some([first, rest @ ..]) => rest.iter().all(|v| v == first).then_some(*first),
        Some([]) => None,
    };
    let bits = directory.integers(source, tag::BITS_PER_SAMPLE)?;
    let format = directory.integers(source, tag::SAMPLE_FORMAT)?;
    let (Some(bits), Some(format)) = (uniform(bits, 1), uniform(format, 1)) else {
        return Err(source.unsupported(format!("the {n_bands} bands have different sample types, wanted one")));
    };
    let sample = match (format, bits) {
        (1 | 4, 1) => Sample::Bit,
        (1 | 4, 8) => Sample::U8,
        (1 | 4, 16) => Sample::U16,
        (1 | 4, 32) => Sample::U32,
        (1 | 4, 64) => Sample::U64,
        (2, 8) => Sample::I8,
        (2, 16) => Sample::I16,
        (2, 32) => Sample::I32,
        (2, 64) => Sample::I64,
        (3, 16) => Sample::F16,
        (3, 32) => Sample::F32,
        (3, 64) => Sample::F64,
        _ => {
            let kind = match format {
                1 | 4 => "unsigned integer",
                2 => "signed integer",
                3 => "floating-point",
                5 | 6 => "complex",
                _ => "unknown",
            };
            let text = format!("{bits}-bit {kind} samples, wanted integers of 8 to 64 bits or floats of 16 to 64 bits");
            return Err(source.unsupported(text).because(Cause::SampleType));
        }
    };
    Ok(sample)
}

fn codec(source: &mut TiffSource, directory: &Directory) -> Result<Codec> {
    let code = directory.integer(source, tag::COMPRESSION)?.unwrap_or(1);
    let name = match code {
        1 => return Ok(Codec::None),
        5 => return Ok(Codec::Lzw),
        7 => return Ok(Codec::Jpeg),
        8 | 32946 => return Ok(Codec::Deflate),
        32773 => return Ok(Codec::PackBits),
        50000 => return Ok(Codec::Zstd),
        34887 if source.byte_order() == ByteOrder::BigEndian => {
            // GDAL swaps the samples before it makes a blob of them, other writers do not, and no
            // tag records it.
            let error = source.unsupported("LERC in a big-endian file, whose samples may be stored in either order");
            return Err(error.because(Cause::Compression));
        }
        34887 => {
            let parameters = directory.integers(source, tag::LERC_PARAMETERS)?.unwrap_or_default();
            match parameters.get(1).unwrap_or(&0) {
                0 => return Ok(Codec::Lerc(LercInner::None)),
                1 => return Ok(Codec::Lerc(LercInner::Deflate)),
                2 => return Ok(Codec::Lerc(LercInner::Zstd)),
                _ => "LERC of a later version",
            }
        }
        2..=4 => "CCITT fax",
        6 => "old-style JPEG",
        34925 => "LZMA",
        50001 => "WebP",
        50002 => "JPEG XL",
        _ => "unknown",
    };
    let wanted = "none, LZW, deflate, PackBits, Zstandard, LERC or JPEG";
    let error = source.unsupported(format!("unsupported compression `{code}` ({name}), wanted {wanted}"));
    // No program decodes an unknown compression.
    Err(error.because(if name == "unknown" { Cause::DamagedHeader } else { Cause::Compression }))
}

fn predictor(source: &mut TiffSource, directory: &Directory, codec: Codec, sample: Sample) -> Result<Predictor> {
    let code = directory.integer(source, tag::PREDICTOR)?.unwrap_or(1);
    // Other codecs have no predictor; as in libtiff, the tag is not read.
    if !matches!(codec, Codec::Lzw | Codec::Deflate | Codec::Zstd) {
        return Ok(Predictor::None);
    }
    match code {
        1 => Ok(Predictor::None),
        2 if sample.bits() >= 8 => Ok(Predictor::Horizontal),
        3 if sample.is_float() => Ok(Predictor::FloatingPoint),
        _ => Err(source.unsupported(format!("unsupported predictor `{code}` for {} samples", sample.name()))),
    }
}
