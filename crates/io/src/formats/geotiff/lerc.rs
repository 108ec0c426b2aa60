//! LERC blocks, which carry their own size, sample type and mask.
//!
//! The crate `lerc-reader` decodes. Its decoder allocates the size that the blob declares, so size
//! and type are compared with the block first.

use lerc_core::PixelData;

use super::header::Image;
use crate::formats::sample::Sample;

/// Decodes one blob into samples in the byte order of the machine and, where it has a mask, a byte
/// for each cell, 0 where it is void. The error names the fault.
pub(super) fn decode_lerc(image: &Image, blob: &[u8], n_rows: usize) -> Result<(Vec<u8>, Option<Vec<u8>>), String> {
    let n_samples = image.samples_per_block_cell();
    let (cols, rows, depth) = declared_size(blob).ok_or("not a LERC blob of version 2 to 6")?;
    let wanted = [image.block_cols, n_rows, n_samples].map(|n| u32::try_from(n).ok());
    if wanted != [Some(cols), Some(rows), Some(depth)] {
        let block = format!("{} x {n_rows} x {n_samples}", image.block_cols);
        return Err(format!("a LERC blob of {cols} x {rows} x {depth} samples, wanted {block}"));
    }
    let decoded = lerc_reader::decode_first(blob).map_err(|e| format!("LERC: {e}"))?;
    macro_rules! native_bytes {
        ($values:expr) => {
            $values.iter().flat_map(|value| value.to_ne_bytes()).collect::<Vec<u8>>()
        };
    }
    let (sample, bytes) = match &decoded.pixels {
        PixelData::I8(values) => (Sample::I8, native_bytes!(values)),
        PixelData::U8(values) => (Sample::U8, native_bytes!(values)),
        PixelData::I16(values) => (Sample::I16, native_bytes!(values)),
        PixelData::U16(values) => (Sample::U16, native_bytes!(values)),
        PixelData::I32(values) => (Sample::I32, native_bytes!(values)),
        PixelData::U32(values) => (Sample::U32, native_bytes!(values)),
        PixelData::F32(values) => (Sample::F32, native_bytes!(values)),
        PixelData::F64(values) => (Sample::F64, native_bytes!(values)),
    };
    if sample != image.sample {
        return Err(format!("{} samples in a LERC blob, wanted {}", sample.name(), image.sample.name()));
    }
    let n_cells = image.block_cols * n_rows;
    let valid = decoded.mask;
    if bytes.len() != n_cells * n_samples * usize::from(sample.bits() / 8)
        || valid.as_ref().is_some_and(|valid| valid.len() != n_cells)
    {
        return Err("a LERC blob of another size than it declares".to_owned());
    }
    Ok((bytes, valid))
}

/// Returns columns, rows and samples per cell from the head of a LERC2 blob.
fn declared_size(blob: &[u8]) -> Option<(u32, u32, u32)> {
    let field = |at: usize| Some(u32::from_le_bytes(blob.get(at..at + 4)?.try_into().ok()?));
    if !blob.starts_with(b"Lerc2 ") {
        return None;
    }
    // Version, then a checksum from version 3 on, rows, columns, and a depth from version 4 on.
    match field(6)? {
        2 => Some((field(14)?, field(10)?, 1)),
        3 => Some((field(18)?, field(14)?, 1)),
        4..=6 => Some((field(18)?, field(14)?, field(22)?)),
        _ => None,
    }
}
