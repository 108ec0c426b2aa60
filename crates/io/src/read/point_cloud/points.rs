//! Points of a cloud, as records in batches. Nothing is allocated for a point.
//!
//! The decoders come from `laz`. It trusts the lengths in the heads of chunks, so that these are
//! checked here before it sees a chunk: they may not be longer than the file.

use std::io::{BufReader, Read, Seek, SeekFrom};

use laz::laszip::ChunkTable;
use laz::record::{LayeredPointRecordDecompressor, RecordDecompressor, SequentialPointRecordDecompressor};
use laz::{DecompressionSelection, LazItemType, LazVlr};

use super::file::{CloudFile, Packing, cut_short};
use super::octree;
use crate::error::{Cause, Error, Result};
use crate::guard::guarded;
use crate::input::{Input, Reader};

/// Records of one batch.
const BATCH: usize = 4096;
/// Chunk size of LASzip that stands for chunks of any size.
const ANY_SIZE: u32 = u32::MAX;

/// Reader of the bytes of a file.
pub(super) type CloudReader = BufReader<Reader>;

/// Consumer of batches of records; an error ends the reading.
pub(super) type Take<'a> = &'a mut dyn FnMut(&[u8]) -> Result<()>;

/// A chunk of a layered file: its offset \[bytes\], and its number of points.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Chunk {
    pub(super) at: u64,
    pub(super) n_points: u64,
}

/// Calls `take` with batches of the records of all points; of a COPC file, with those of the nodes
/// that meet `within` \[CRS units\].
///
/// # Errors
/// E302, E303 for damaged points; the first error of `take`.
pub(super) fn for_each_batch(file: &CloudFile<'_>, within: Option<[f64; 4]>, take: Take<'_>) -> Result<()> {
    let input = file.input;
    // The decoders are of other authors, and a bad file must not end the program.
    let read = guarded(|| {
        let reader = &mut file.reader()?;
        match &file.packing {
            None => plain(file, reader, take),
            Some(packing) if file.records.format < 6 => sequential(file, reader, packing, take),
            Some(Packing { laz, .. }) => match (file.octree, within) {
                (Some(info), Some(within)) => {
                    let chunks = octree::chunks_within(file, reader, info, within)?;
                    layered(file, reader, (laz, Some(&chunks)), take)
                }
                _ => layered(file, reader, (laz, None), take),
            },
        }
    });
    read.unwrap_or_else(|| Err(damaged(input, "the decoder gave up on its points")))
}

fn damaged(input: &Input, what: impl Into<String>) -> Error {
    Error::malformed(input, what).because(Cause::CutShort)
}

/// Calls `take` with batches of `n_points` records that `fill` writes.
fn in_batches(
    (n_points, record_length): (u64, usize),
    mut fill: impl FnMut(&mut [u8]) -> Result<()>,
    take: Take<'_>,
) -> Result<()> {
    let mut batch = vec![0; BATCH * record_length];
    let mut left = n_points;
    while left > 0 {
        let n = usize::try_from(left).map_or(BATCH, |left| left.min(BATCH));
        let batch = &mut batch[..n * record_length];
        fill(batch)?;
        take(batch)?;
        left -= n as u64;
    }
    Ok(())
}

/// Reads points that are stored as they are.
fn plain(file: &CloudFile<'_>, reader: &mut CloudReader, take: Take<'_>) -> Result<()> {
    let input = file.input;
    let failed = |error: std::io::Error| cut_short(input, &error);
    reader.seek(SeekFrom::Start(file.points_at)).map_err(failed)?;
    in_batches((file.n_points, file.records.length), |batch| reader.read_exact(batch).map_err(failed), take)
}

/// Reads points of the formats 0 to 5, compressed one after the other.
fn sequential(file: &CloudFile<'_>, reader: &mut CloudReader, packing: &Packing, take: Take<'_>) -> Result<()> {
    let input = file.input;
    let failed = |error: std::io::Error| cut_short(input, &error);
    let Packing { laz, is_chunked } = packing;
    let is_chunked = *is_chunked;
    let sizes = match is_chunked && laz.chunk_size() == ANY_SIZE {
        true => Some(chunk_sizes(file, reader)?),
        false => None,
    };
    let start = file.points_at + if is_chunked { ChunkTable::OFFSET_SIZE as u64 } else { 0 };
    reader.seek(SeekFrom::Start(start)).map_err(failed)?;
    let mut sizes = sizes.map(Vec::into_iter);
    let mut left = file.n_points;
    let mut decoder = SequentialPointRecordDecompressor::new(reader);
    while left > 0 {
        let n = match &mut sizes {
            Some(sizes) => {
                sizes.next().filter(|n| *n > 0).ok_or_else(|| damaged(input, "its chunks hold too few points"))?
            }
            None if is_chunked => u64::from(laz.chunk_size()),
            None => left,
        };
        let n = n.min(left);
        decoder.reset();
        decoder.set_fields_from(laz.items()).map_err(|error| damaged(input, error.to_string()))?;
        in_batches((n, file.records.length), |batch| decoder.decompress_many(batch).map_err(failed), take)?;
        left -= n;
    }
    Ok(())
}

/// Reads the numbers of points of chunks of any size.
fn chunk_sizes(file: &CloudFile<'_>, reader: &mut CloudReader) -> Result<Vec<u64>> {
    let (input, length) = (file.input, file.length);
    let failed = |error: std::io::Error| cut_short(input, &error);
    let mut offset_at = |at: u64| {
        let mut bytes = [0; 8];
        reader.seek(SeekFrom::Start(at))?;
        reader.read_exact(&mut bytes)?;
        Ok(u64::from_le_bytes(bytes))
    };
    // A writer that could not go back has the offset at the end.
    let is_good = |at: &u64| *at > file.points_at && at.checked_add(8).is_some_and(|end| end <= length);
    let mut at = offset_at(file.points_at).map_err(failed)?;
    if !is_good(&at) {
        at = offset_at(length.saturating_sub(8)).map_err(failed)?;
    }
    if !is_good(&at) {
        return Err(damaged(input, format!("its table of chunks is at byte {at} of {length}")));
    }
    reader.seek(SeekFrom::Start(at)).map_err(failed)?;
    let mut head = [0; 8];
    reader.read_exact(&mut head).map_err(failed)?;
    let n_chunks = u64::from(u32::from_le_bytes([head[4], head[5], head[6], head[7]]));
    // The first point of a chunk is stored as it is.
    if n_chunks > length / file.records.length as u64 {
        return Err(damaged(input, format!("{n_chunks} chunks in {length} bytes, wanted fewer")));
    }
    reader.seek(SeekFrom::Start(at)).map_err(failed)?;
    let table = ChunkTable::read(reader, true).map_err(failed)?;
    Ok(table.as_ref().iter().map(|chunk| chunk.point_count).collect())
}

/// Reads points of the formats 6 to 10, compressed in layers: some chunks, or all in their order.
fn layered(
    file: &CloudFile<'_>,
    reader: &mut CloudReader,
    (laz, chunks): (&LazVlr, Option<&[Chunk]>),
    take: Take<'_>,
) -> Result<()> {
    let (input, length, record_length) = (file.input, file.length, file.records.length);
    let failed = |error: std::io::Error| cut_short(input, &error);
    let n_layers: usize = laz.items().iter().map(|item| n_layers_of(item.item_type())).sum();
    let mut head = vec![0; record_length + 4 + 4 * n_layers];
    let mut chunks = chunks.map(<[Chunk]>::iter);
    let mut left = file.n_points;
    let mut at = file.points_at + ChunkTable::OFFSET_SIZE as u64;
    let mut decoder = LayeredPointRecordDecompressor::new(reader);
    while left > 0 {
        let chunk = match &mut chunks {
            None => None,
            Some(chunks) => match chunks.next() {
                Some(chunk) => Some(chunk),
                None => break,
            },
        };
        at = chunk.map_or(at, |chunk| chunk.at);
        let reader = decoder.get_mut();
        reader.seek(SeekFrom::Start(at)).map_err(failed)?;
        reader.read_exact(&mut head).map_err(failed)?;
        let word = |bytes: &[u8]| u64::from(u32::from_le_bytes(std::array::from_fn(|k| bytes[k])));
        let n = word(&head[record_length..]);
        let n_bytes: u64 = head[record_length + 4..].chunks_exact(4).map(word).sum();
        let end = at + head.len() as u64 + n_bytes;
        if n == 0 || n > left || chunk.is_some_and(|chunk| chunk.n_points != n) || end > length {
            let what = format!("a chunk at byte {at} of {length} has {n} points in {n_bytes} bytes, which cannot be");
            return Err(damaged(input, what));
        }
        reader.seek(SeekFrom::Start(at)).map_err(failed)?;
        decoder.reset();
        decoder.set_fields_from(laz.items()).map_err(|error| damaged(input, error.to_string()))?;
        decoder.set_selection(needed());
        in_batches((n, record_length), |batch| decoder.decompress_many(batch).map_err(failed), take)?;
        (at, left) = (end, left - n);
    }
    Ok(())
}

/// Returns the fields that are needed beside x, y and returns; other layers are skipped.
fn needed() -> DecompressionSelection {
    DecompressionSelection::base().decompress_z().decompress_classification().decompress_flags()
}

/// Returns the number of layers of an item of a point.
fn n_layers_of(item: LazItemType) -> usize {
    match item {
        LazItemType::Point14 => 9,
        LazItemType::RGBNIR14 => 2,
        LazItemType::Byte14(n) => usize::from(n),
        _ => 1,
    }
}
