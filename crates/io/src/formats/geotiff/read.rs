//! Decoding of the blocks of a TIFF file into rows of samples.
//!
//! Blocks are read one band of rows at a time, decoded in parallel, and passed on row by row from
//! north to south. Memory is thus one band and not one picture. The crate `tiff-reader`
//! decompresses and undoes predictors. Places and sizes of the blocks come from the checked header,
//! so a codec receives only bytes that exist, and a limit on its output.

use std::ops::Range;

use rayon::prelude::*;
use tiff_reader::{ByteOrder, filters};

use super::header::{Codec, Image, LercInner, Predictor};
use super::lerc::decode_lerc;
use super::tags::TiffSource;
use crate::error::{Cause, Result};
use crate::formats::sample::Sample;
use crate::guard::guarded;

/// Decoded bytes held at a time, unless one row of blocks needs more.
const BAND_BYTES: u64 = 16 << 20;
/// Decoded bytes that a block may hold beyond its cells; some writers pad.
const PADDING_BYTES: usize = 64 << 10;

/// Cells of one band to read.
#[derive(Debug, Clone)]
pub(super) struct Region {
    pub(super) rows: Range<usize>,
    pub(super) cols: Range<usize>,
    pub(super) band: usize,
}

/// `n_cells` cells side by side in one row, from column `col` on.
#[derive(Debug)]
pub(super) struct Span<'a> {
    pub(super) row: usize,
    pub(super) col: usize,
    pub(super) n_cells: usize,
    /// Samples of the cells; `None` where the file stores nothing.
    pub(super) samples: Option<Samples<'a>>,
}

/// Stored samples of a [`Span`].
#[derive(Debug)]
pub(super) struct Samples<'a> {
    /// One decoded row of a block, in the byte order of the machine.
    bytes: &'a [u8],
    /// Index of the first sample, and distance to the next \[samples\].
    first: usize,
    stride: usize,
    /// For each cell, 0 if the codec marks it as void.
    valid: Option<&'a [u8]>,
}

/// A decoded block, or its requested part.
#[derive(Debug, Default)]
struct Block {
    bytes: Vec<u8>,
    /// One byte per cell, 0 where the cell is void; only LERC has it.
    valid: Option<Vec<u8>>,
}

/// Rows of one row of blocks.
struct RowRun {
    first_row: usize,
    n_rows: usize,
    block_row: usize,
    /// First row within the block.
    first_in_block: usize,
}

/// A block to decode: its index, its stored bytes and the number of their rows.
struct Job {
    index: usize,
    stored: Vec<u8>,
    n_rows: usize,
}

/// Calls `visit` for all cells of the region, row by row, each row from west to east.
pub(super) fn for_each_span(
    source: &mut TiffSource,
    image: &Image,
    region: &Region,
    mut visit: impl FnMut(Span<'_>),
) -> Result<()> {
    let block_cols = region.cols.start / image.block_cols..region.cols.end.div_ceil(image.block_cols);
    let (band_first, stride) = if image.planar { (0, 1) } else { (region.band, image.n_bands) };
    // Rows of blocks have a known size. Only sparse ones may be too wide to hold, and these hold
    // nothing.
    let row_len = usize::try_from(image.row_bytes()).unwrap_or(usize::MAX);
    let mut row = region.rows.start;
    while row < region.rows.end {
        let runs = next_runs(image, row..region.rows.end, block_cols.len());
        row = runs.last().map_or(region.rows.end, |run| run.first_row + run.n_rows);
        let blocks = read_blocks(source, image, region.band, &runs, block_cols.clone())?;
        for (run, blocks) in runs.iter().zip(blocks.chunks(block_cols.len())) {
            for row_in_run in 0..run.n_rows {
                for (block_col, block) in block_cols.clone().zip(blocks) {
                    let block_start = block_col * image.block_cols;
                    let start = region.cols.start.max(block_start);
                    let end = region.cols.end.min(block_start + image.block_cols);
                    let samples = block.as_ref().map(|block| {
                        // Uncompressed blocks were read from the first wanted row on.
                        let skipped = if image.codec == Codec::None { 0 } else { run.first_in_block };
                        let at = skipped + row_in_run;
                        let cells = at * image.block_cols + (start - block_start);
                        Samples {
                            bytes: &block.bytes[at * row_len..(at + 1) * row_len],
                            first: (start - block_start) * stride + band_first,
                            stride,
                            valid: block.valid.as_ref().map(|valid| &valid[cells..cells + (end - start)]),
                        }
                    });
                    visit(Span { row: run.first_row + row_in_run, col: start, n_cells: end - start, samples });
                }
            }
        }
    }
    Ok(())
}

/// Returns the next rows to read: whole rows of blocks until a band is full, or a part of one where
/// rows can be read singly.
fn next_runs(image: &Image, rows: Range<usize>, n_blocks: usize) -> Vec<RowRun> {
    let row_bytes = image.row_bytes().saturating_mul(n_blocks as u64);
    let rows_per_band = usize::try_from((BAND_BYTES / row_bytes).max(1)).unwrap_or(usize::MAX);
    let mut runs = Vec::new();
    let (mut row, mut n_held) = (rows.start, 0);
    while row < rows.end && n_held < rows_per_band {
        let (block_row, first_in_block) = (row / image.block_rows, row % image.block_rows);
        let mut n_rows = (image.block_rows - first_in_block).min(rows.end - row);
        if image.codec == Codec::None {
            n_rows = n_rows.min(rows_per_band);
            n_held += n_rows;
        } else {
            n_held += image.stored_rows(block_row);
        }
        runs.push(RowRun { first_row: row, n_rows, block_row, first_in_block });
        row += n_rows;
    }
    runs
}

/// Reads and decodes the blocks of some rows, run by run and from west to east; `None` for a
/// missing block.
fn read_blocks(
    source: &mut TiffSource,
    image: &Image,
    band: usize,
    runs: &[RowRun],
    block_cols: Range<usize>,
) -> Result<Vec<Option<Block>>> {
    let mut jobs = Vec::with_capacity(runs.len() * block_cols.len());
    for run in runs {
        for block_col in block_cols.clone() {
            let plane = if image.planar { band } else { 0 };
            let index = (plane * image.blocks_down() + run.block_row) * image.blocks_across() + block_col;
            jobs.push(read_block(source, image, index, run)?);
        }
    }
    let byte_order = source.byte_order();
    let blocks: Vec<_> = jobs
        .into_par_iter()
        .map(|job| match job {
            None => Ok(None),
            Some(job) => {
                let index = job.index;
                // The codecs are of other authors, and a bad file must not end the program.
                let decoded = guarded(|| decode(image, byte_order, job));
                let decoded = decoded.unwrap_or_else(|| Err("the decoder gave up on its bytes".to_owned()));
                decoded.map(Some).map_err(|text| (index, text))
            }
        })
        .collect();
    blocks
        .into_iter()
        .map(|block| {
            block.map_err(|(index, text)| {
                let error = source.truncated(format!("{}: {text}", image.block_name(index)));
                error.because(Cause::DamagedBlock)
            })
        })
        .collect()
}

/// Reads the stored bytes of a block; of an uncompressed one only the rows of `run`.
fn read_block(source: &mut TiffSource, image: &Image, index: usize, run: &RowRun) -> Result<Option<Job>> {
    let (offset, len) = image.blocks[index];
    if len == 0 {
        return Ok(None);
    }
    let name = image.block_name(index);
    if image.codec == Codec::None {
        let row_bytes = image.row_bytes();
        let (first, n_rows) = (run.first_in_block as u64 * row_bytes, run.n_rows as u64 * row_bytes);
        let stored = source.bytes(offset + first, n_rows, &name)?;
        return Ok(Some(Job { index, stored, n_rows: run.n_rows }));
    }
    let n_rows = image.stored_rows(run.block_row);
    let decoded = image.row_bytes().saturating_mul(n_rows as u64);
    if len > decoded.saturating_mul(4).saturating_add(PADDING_BYTES as u64) {
        let text = format!("{name} has {len} bytes ({}) for {decoded} bytes of cells", image.codec.name());
        return Err(source.truncated(text).because(Cause::DamagedHeader));
    }
    let stored = source.bytes(offset, len, &name)?;
    Ok(Some(Job { index, stored, n_rows }))
}

/// Decodes the rows of one block into samples in the byte order of the machine; the error names the
/// fault.
fn decode(image: &Image, byte_order: ByteOrder, job: Job) -> std::result::Result<Block, String> {
    let Job { index, mut stored, n_rows } = job;
    let row_bytes = usize::try_from(image.row_bytes()).map_err(|_| "too wide to decode")?;
    let needed = row_bytes.checked_mul(n_rows).ok_or("too large to decode")?;
    if image.bits_reversed {
        stored.iter_mut().for_each(|byte| *byte = byte.reverse_bits());
    }
    let limit = row_bytes.saturating_mul(image.block_rows).max(needed).saturating_add(PADDING_BYTES);
    let unpack = |code: u16, tables: Option<&[u8]>| {
        filters::decompress(code, &stored, index, tables, limit).map_err(|e| e.to_string())
    };
    let mut bytes = match image.codec {
        Codec::None => stored,
        Codec::Lzw => unpack(5, None)?,
        Codec::Deflate => unpack(8, None)?,
        Codec::PackBits => unpack(32773, None)?,
        Codec::Zstd => unpack(50000, None)?,
        Codec::Jpeg => {
            check_jpeg_size(&stored, image.block_cols, n_rows)?;
            unpack(7, image.jpeg_tables.as_deref())?
        }
        Codec::Lerc(inner) => {
            let limit = limit.saturating_mul(2);
            let unpack = |code| filters::decompress(code, &stored, index, None, limit).map_err(|e| e.to_string());
            let payload = match inner {
                LercInner::Deflate => unpack(8)?,
                LercInner::Zstd => unpack(50000)?,
                LercInner::None => stored,
            };
            let (bytes, valid) = decode_lerc(image, &payload, n_rows)?;
            return Ok(Block { bytes, valid });
        }
    };
    if bytes.len() < needed {
        return Err(format!("decodes to {} bytes, wanted {needed}", bytes.len()));
    }
    bytes.truncate(needed);
    let predictor = match image.predictor {
        Predictor::None => 1,
        Predictor::Horizontal => 2,
        Predictor::FloatingPoint => 3,
    };
    let is_float = image.predictor == Predictor::FloatingPoint && image.sample == Sample::F32;
    if is_float && image.samples_per_block_cell() == 1 {
        let mut planes = vec![0; row_bytes];
        bytes.chunks_exact_mut(row_bytes).for_each(|row| undo_float_predictor(row, &mut planes));
        return Ok(Block { bytes, valid: None });
    }
    if image.sample.bits() > 8 || predictor != 1 {
        let samples = u16::try_from(image.samples_per_block_cell()).map_err(|_| "too many samples per cell")?;
        for row in bytes.chunks_exact_mut(row_bytes) {
            filters::fix_endianness_and_predict(row, image.sample.bits(), samples, byte_order, predictor)
                .map_err(|e| e.to_string())?;
        }
    }
    Ok(Block { bytes, valid: None })
}

/// Decodes a row of the floating-point predictor into 32-bit floats of the machine, one sample a
/// cell.
///
/// Bytes are stored as differences to the byte before. They are sorted into planes, the highest
/// byte of all cells first, in any byte order of the file. `planes` is scratch space for them.
///
/// PERF: with the code of the library a strip-by-strip map of 50 000² cells took 99 s of user CPU,
/// with this one 57.
///
/// # References
/// Adobe Photoshop TIFF Technical Note 3 (2005).
fn undo_float_predictor(row: &mut [u8], planes: &mut [u8]) {
    let mut sum = 0_u8;
    for (plane, difference) in planes.iter_mut().zip(row.iter()) {
        sum = sum.wrapping_add(*difference);
        *plane = sum;
    }
    let n = row.len() / 4;
    let (high, rest) = planes.split_at(n);
    let (second, rest) = rest.split_at(n);
    let (third, low) = rest.split_at(n);
    let cells = row.as_chunks_mut::<4>().0.iter_mut().zip(high).zip(second).zip(third).zip(low);
    for ((((cell, a), b), c), d) in cells {
        *cell = u32::from_be_bytes([*a, *b, *c, *d]).to_ne_bytes();
    }
}

/// Checks that a JPEG stream holds one component of exactly the size of its block.
///
/// The decoder sees only a number of bytes, which a picture of another shape may have too.
fn check_jpeg_size(stream: &[u8], n_cols: usize, n_rows: usize) -> std::result::Result<(), String> {
    let mut at = 2;
    while let Some([0xff, marker, high, low]) = stream.get(at..at + 4) {
        // Start-of-frame markers, without the three other markers in their range.
        if (0xc0..=0xcf).contains(marker) && ![0xc4, 0xc8, 0xcc].contains(marker) {
            let Some(frame) = stream.get(at + 5..at + 10) else { break };
            let rows = usize::from(u16::from_be_bytes([frame[0], frame[1]]));
            let cols = usize::from(u16::from_be_bytes([frame[2], frame[3]]));
            if (cols, rows, frame[4]) == (n_cols, n_rows, 1) {
                return Ok(());
            }
            return Err(format!(
                "a JPEG of {cols} x {rows} cells and {} components, wanted {n_cols} x {n_rows} and 1",
                frame[4]
            ));
        }
        at += 2 + usize::from(u16::from_be_bytes([*high, *low]));
    }
    Err("a JPEG without a frame".to_owned())
}

impl Samples<'_> {
    /// Puts numbers of at most 16 bits, or 32-bit floats, into cells as the bits of 32-bit floats.
    pub(super) fn put_floats(&self, sample: Sample, cells: &mut [i32]) {
        macro_rules! typed {
            ($type:ty) => {{
                const WIDTH: usize = size_of::<$type>();
                let samples = self.bytes[self.first * WIDTH..].chunks_exact(self.stride * WIDTH);
                for (cell, sample) in cells.iter_mut().zip(samples) {
                    let sample = <$type>::from_ne_bytes(*sample.first_chunk().expect("as many bytes as a sample has"));
                    *cell = f32::from(sample).to_bits().cast_signed();
                }
            }};
        }
        match sample {
            Sample::U8 => typed!(u8),
            Sample::I8 => typed!(i8),
            Sample::U16 => typed!(u16),
            Sample::I16 => typed!(i16),
            _ => typed!(f32),
        }
    }

    /// Calls `visit` with the index and the value of each cell; NaN where the codec marks the cell
    /// as void.
    pub(super) fn for_each(&self, sample: Sample, n_cells: usize, mut visit: impl FnMut(usize, f64)) {
        match self.valid {
            None => self.for_each_stored(sample, n_cells, visit),
            Some(valid) => {
                self.for_each_stored(sample, n_cells, |i, value| {
                    visit(i, if valid[i] == 0 { f64::NAN } else { value })
                });
            }
        }
    }

    fn for_each_stored(&self, sample: Sample, n_cells: usize, mut visit: impl FnMut(usize, f64)) {
        macro_rules! typed {
            ($type:ty, $to_f64:expr) => {{
                const WIDTH: usize = size_of::<$type>();
                let cells = self.bytes[self.first * WIDTH..].chunks(self.stride * WIDTH).take(n_cells);
                for (i, cell) in cells.enumerate() {
                    let mut bytes = [0; WIDTH];
                    bytes.copy_from_slice(&cell[..WIDTH]);
                    visit(i, $to_f64(<$type>::from_ne_bytes(bytes)));
                }
            }};
        }
        match sample {
            Sample::Bit => {
                for i in 0..n_cells {
                    let bit = self.first + i * self.stride;
                    visit(i, f64::from(self.bytes[bit / 8] >> (7 - bit % 8) & 1));
                }
            }
            Sample::U8 => typed!(u8, f64::from),
            Sample::U16 => typed!(u16, f64::from),
            Sample::U32 => typed!(u32, f64::from),
            // Values beyond 2^53 are rounded. No height is that high, and nodata values are rounded
            // in the same way.
            Sample::U64 => typed!(u64, |v| v as f64),
            Sample::I8 => typed!(i8, f64::from),
            Sample::I16 => typed!(i16, f64::from),
            Sample::I32 => typed!(i32, f64::from),
            Sample::I64 => typed!(i64, |v| v as f64),
            Sample::F16 => typed!(u16, f64_from_half),
            Sample::F32 => typed!(f32, f64::from),
            Sample::F64 => typed!(f64, f64::from),
        }
    }
}

/// Returns the exact value of an IEEE 754 half-precision number.
fn f64_from_half(bits: u16) -> f64 {
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    match exponent {
        0 => sign * fraction * f64::powi(2.0, -24),
        31 if fraction > 0.0 => f64::NAN,
        31 => sign * f64::INFINITY,
        _ => sign * (1024.0 + fraction) * f64::powi(2.0, exponent - 25),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_precision_numbers_are_exact() {
        for (bits, value) in [
            (0x0000, 0.0),
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (0x0400, 6.103_515_625e-5),
            (0x0001, 5.960_464_477_539_063e-8),
            (0x7c00, f64::INFINITY),
        ] {
            assert_eq!(f64_from_half(bits).to_bits(), f64::to_bits(value), "{bits:#06x}");
        }
        assert!(f64_from_half(0x7e00).is_nan());
    }

    #[test]
    fn a_jpeg_of_another_shape_is_refused() {
        let mut stream = vec![0xff, 0xd8, 0xff, 0xe0, 0, 4, 0, 0, 0xff, 0xc0, 0, 11, 8, 0, 32, 0, 8, 1, 1, 0x11, 0];
        assert!(check_jpeg_size(&stream, 8, 32).is_ok());
        assert!(check_jpeg_size(&stream, 16, 16).is_err_and(|text| text.contains("8 x 32")));
        stream.truncate(14);
        assert!(check_jpeg_size(&stream, 8, 32).is_err());
    }
}
