//! Tags of a TIFF file: its byte order, its image directories, and the values of tags by number.
//!
//! Nothing is trusted: each length is checked against the length of the file before it is read.
//!
//! Reference: TIFF 6.0 (1992) section 2, and the BigTIFF extension.

use std::collections::BTreeMap;
use std::io::{Read, Seek, SeekFrom};

use tiff_reader::ByteOrder;

use crate::error::{Cause, Error, ReadFault, Result, io_words};
use crate::input::{Input, Reader};

/// Tags that are read by number: the baseline ones, GDAL's and those of GeoTIFF.
pub(super) mod tag {
    pub(crate) use geotiff_core::tags::{
        TAG_GDAL_NODATA as GDAL_NODATA, TAG_GEO_ASCII_PARAMS as GEO_ASCII_PARAMS,
        TAG_GEO_DOUBLE_PARAMS as GEO_DOUBLE_PARAMS, TAG_GEO_KEY_DIRECTORY as GEO_KEY_DIRECTORY,
        TAG_MODEL_PIXEL_SCALE as MODEL_PIXEL_SCALE, TAG_MODEL_TIEPOINT as MODEL_TIE_POINT,
        TAG_MODEL_TRANSFORMATION as MODEL_TRANSFORMATION,
    };
    pub(crate) use tiff_core::{
        TAG_BITS_PER_SAMPLE as BITS_PER_SAMPLE, TAG_COMPRESSION as COMPRESSION, TAG_EXTRA_SAMPLES as EXTRA_SAMPLES,
        TAG_FILL_ORDER as FILL_ORDER, TAG_IMAGE_LENGTH as IMAGE_LENGTH, TAG_IMAGE_WIDTH as IMAGE_WIDTH,
        TAG_JPEG_TABLES as JPEG_TABLES, TAG_LERC_PARAMETERS as LERC_PARAMETERS,
        TAG_NEW_SUBFILE_TYPE as NEW_SUBFILE_TYPE, TAG_PHOTOMETRIC_INTERPRETATION as PHOTOMETRIC,
        TAG_PLANAR_CONFIGURATION as PLANAR_CONFIGURATION, TAG_PREDICTOR as PREDICTOR,
        TAG_ROWS_PER_STRIP as ROWS_PER_STRIP, TAG_SAMPLE_FORMAT as SAMPLE_FORMAT,
        TAG_SAMPLES_PER_PIXEL as SAMPLES_PER_PIXEL, TAG_STRIP_BYTE_COUNTS as STRIP_BYTE_COUNTS,
        TAG_STRIP_OFFSETS as STRIP_OFFSETS, TAG_TILE_BYTE_COUNTS as TILE_BYTE_COUNTS, TAG_TILE_LENGTH as TILE_LENGTH,
        TAG_TILE_OFFSETS as TILE_OFFSETS, TAG_TILE_WIDTH as TILE_WIDTH,
    };
    pub(crate) const GDAL_METADATA: u16 = 42112;
}

/// Largest text that a tag may hold \[bytes\]; color tables, profiles and the like are never read.
const MAX_TEXT_BYTES: u64 = 64 << 20;

/// A TIFF file open for random access, with its byte order and pointer size.
#[derive(Debug)]
pub(super) struct TiffSource {
    file: Reader,
    input: Input,
    len: u64,
    big_tiff: bool,
    byte_order: ByteOrder,
}

impl TiffSource {
    /// Opens the file and reads its first bytes; returns it with the offset of its first directory.
    pub(super) fn open(input: &Input) -> Result<(TiffSource, u64)> {
        let (file, len) = input.open()?;
        let mut source =
            TiffSource { file, input: input.clone(), len, big_tiff: false, byte_order: ByteOrder::LittleEndian };
        if len < 8 {
            return Err(source.truncated(format!("the file has {len} bytes, a TIFF header has at least 8")));
        }
        let head = source.bytes(0, 8, "the header")?;
        source.byte_order = match &head[..2] {
            b"II" => ByteOrder::LittleEndian,
            b"MM" => ByteOrder::BigEndian,
            _ => return Err(source.malformed("the file does not start like a TIFF (`II` or `MM`)")),
        };
        match source.u16(&head[2..4]) {
            42 => {
                let first = u64::from(source.u32(&head[4..8]));
                Ok((source, first))
            }
            43 => {
                source.big_tiff = true;
                let head = source.bytes(8, 8, "the BigTIFF header")?;
                let first = source.u64(&head);
                Ok((source, first))
            }
            version => Err(source.malformed(format!("TIFF version `{version}`, wanted 42 or 43 (BigTIFF)"))),
        }
    }

    /// Returns E302.
    pub(super) fn malformed(&self, what: impl Into<String>) -> Error {
        Error::malformed(&self.input, what)
    }

    /// Returns E303.
    pub(super) fn truncated(&self, what: impl Into<String>) -> Error {
        Error::truncated(&self.input, what)
    }

    /// Returns E304.
    pub(super) fn unsupported(&self, what: impl Into<String>) -> Error {
        Error::unsupported(&self.input, what)
    }

    pub(super) fn input(&self) -> &Input {
        &self.input
    }

    /// Returns the length of the file \[bytes\].
    pub(super) fn len(&self) -> u64 {
        self.len
    }

    pub(super) fn byte_order(&self) -> ByteOrder {
        self.byte_order
    }

    /// Reads bytes `offset..offset + len`; `what` names them in the error when the file ends
    /// before.
    pub(super) fn bytes(&mut self, offset: u64, len: u64, what: &str) -> Result<Vec<u8>> {
        let end = offset.checked_add(len).filter(|end| *end <= self.len);
        let (Some(_), Ok(n_bytes)) = (end, usize::try_from(len)) else {
            let text = format!("{what} ({len} bytes at byte {offset}) ends beyond the file of {} bytes", self.len);
            return Err(self.truncated(text).because(Cause::CutShort));
        };
        let mut bytes = vec![0; n_bytes];
        self.file
            .seek(SeekFrom::Start(offset))
            .and_then(|_| self.file.read_exact(&mut bytes))
            .map_err(|e| Error::read(&self.input, ReadFault::CannotOpen(format!("{what}: {}", io_words(&e)))))?;
        Ok(bytes)
    }

    fn u16(&self, bytes: &[u8]) -> u16 {
        let bytes = [bytes[0], bytes[1]];
        match self.byte_order {
            ByteOrder::LittleEndian => u16::from_le_bytes(bytes),
            ByteOrder::BigEndian => u16::from_be_bytes(bytes),
        }
    }

    fn u32(&self, bytes: &[u8]) -> u32 {
        let (first, second) = (u32::from(self.u16(&bytes[..2])), u32::from(self.u16(&bytes[2..4])));
        match self.byte_order {
            ByteOrder::LittleEndian => second << 16 | first,
            ByteOrder::BigEndian => first << 16 | second,
        }
    }

    fn u64(&self, bytes: &[u8]) -> u64 {
        let (first, second) = (u64::from(self.u32(&bytes[..4])), u64::from(self.u32(&bytes[4..8])));
        match self.byte_order {
            ByteOrder::LittleEndian => second << 32 | first,
            ByteOrder::BigEndian => first << 32 | second,
        }
    }

    /// Reads the directory of tags at `offset`; values are read on request.
    pub(super) fn directory(&mut self, offset: u64) -> Result<Directory> {
        let (count_len, entry_len, pointer_len) = if self.big_tiff { (8, 20, 8) } else { (2, 12, 4) };
        let head = self.bytes(offset, count_len, "the image directory")?;
        let n_entries = if self.big_tiff { self.u64(&head) } else { u64::from(self.u16(&head)) };
        if n_entries == 0 || n_entries > 65_535 {
            return Err(self.malformed(format!("the image directory has {n_entries} tags, wanted 1 to 65535")));
        }
        let entries_at = offset + count_len;
        let table = self.bytes(entries_at, n_entries * entry_len, "the image directory")?;
        let mut entries = BTreeMap::new();
        let mut at = entries_at;
        for entry in table.chunks_exact(if self.big_tiff { 20 } else { 12 }) {
            let (code, kind) = (self.u16(entry), self.u16(&entry[2..]));
            let (count, value_at) = if self.big_tiff {
                (self.u64(&entry[4..]), at + 12)
            } else {
                (u64::from(self.u32(&entry[4..])), at + 8)
            };
            let value_len = count.checked_mul(kind_len(kind));
            let value_at = match value_len {
                Some(len) if len <= pointer_len => value_at,
                _ if self.big_tiff => self.u64(&entry[12..]),
                _ => u64::from(self.u32(&entry[8..])),
            };
            // A repeated tag is an error of the writer; libtiff keeps the first as well.
            entries.entry(code).or_insert(Entry { kind, count, value_at });
            at += entry_len;
        }
        // Some writers forget the pointer after the last directory.
        let next = self.bytes(at, pointer_len, "the image directory").unwrap_or(vec![0; 8]);
        let next = if self.big_tiff { self.u64(&next) } else { u64::from(self.u32(&next)) };
        Ok(Directory { entries, next })
    }
}

/// Returns the bytes per value of a TIFF field type, 0 for an unknown type.
fn kind_len(kind: u16) -> u64 {
    match kind {
        1 | 2 | 6 | 7 => 1,
        3 | 8 => 2,
        4 | 9 | 11 | 13 => 4,
        5 | 10 | 12 | 16..=18 => 8,
        _ => 0,
    }
}

/// One tag: its field type, the number of its values and the byte at which they begin.
#[derive(Debug, Clone, Copy)]
struct Entry {
    kind: u16,
    count: u64,
    value_at: u64,
}

/// One image directory: its tags, and the offset of the next directory (0: there is none).
#[derive(Debug, Clone)]
pub(super) struct Directory {
    entries: BTreeMap<u16, Entry>,
    pub(super) next: u64,
}

impl Directory {
    pub(super) fn has(&self, tag: u16) -> bool {
        self.entries.contains_key(&tag)
    }

    /// Reads the raw bytes of a tag's values with their type; `None` if the tag is absent.
    fn raw(&self, source: &mut TiffSource, tag: u16) -> Result<Option<(u16, Vec<u8>)>> {
        let Some(&Entry { kind, count, value_at }) = self.entries.get(&tag) else { return Ok(None) };
        let Some(len) = count.checked_mul(kind_len(kind)).filter(|len| *len > 0) else {
            let text = format!("tag {tag} holds {count} values of field type `{kind}`, which cannot be read");
            return Err(source.malformed(text));
        };
        Ok(Some((kind, source.bytes(value_at, len, &format!("tag {tag}"))?)))
    }

    /// Reads the values of an unsigned integer tag.
    pub(super) fn integers(&self, source: &mut TiffSource, tag: u16) -> Result<Option<Vec<u64>>> {
        let Some((kind, bytes)) = self.raw(source, tag)? else { return Ok(None) };
        let values = match kind {
            1 | 7 => bytes.iter().map(|b| u64::from(*b)).collect(),
            3 => bytes.chunks_exact(2).map(|b| u64::from(source.u16(b))).collect(),
            4 | 13 => bytes.chunks_exact(4).map(|b| u64::from(source.u32(b))).collect(),
            16 | 18 => bytes.chunks_exact(8).map(|b| source.u64(b)).collect(),
            _ => {
                let text = format!("tag {tag} has field type `{kind}`, wanted an unsigned integer");
                return Err(source.malformed(text));
            }
        };
        Ok(Some(values))
    }

    /// Reads the single value of an unsigned integer tag.
    pub(super) fn integer(&self, source: &mut TiffSource, tag: u16) -> Result<Option<u64>> {
        match self.integers(source, tag)?.as_deref() {
            None => Ok(None),
            Some([value]) => Ok(Some(*value)),
            Some(values) => {
                let text = format!("tag {tag} holds {} values, wanted one", values.len());
                Err(source.malformed(text))
            }
        }
    }

    /// Reads the values of a floating-point tag.
    pub(super) fn floats(&self, source: &mut TiffSource, tag: u16) -> Result<Option<Vec<f64>>> {
        let Some((kind, bytes)) = self.raw(source, tag)? else { return Ok(None) };
        match kind {
            11 => Ok(Some(bytes.chunks_exact(4).map(|b| f64::from(f32::from_bits(source.u32(b)))).collect())),
            12 => Ok(Some(bytes.chunks_exact(8).map(|b| f64::from_bits(source.u64(b))).collect())),
            _ => Err(source.malformed(format!("tag {tag} has field type `{kind}`, wanted floating point"))),
        }
    }

    /// Reads the text of an ASCII tag up to its first NUL.
    pub(super) fn text(&self, source: &mut TiffSource, tag: u16) -> Result<Option<String>> {
        if self.entries.get(&tag).is_some_and(|e| e.count > MAX_TEXT_BYTES) {
            return Err(source.malformed(format!("tag {tag} is a text of more than {MAX_TEXT_BYTES} bytes")));
        }
        let Some((_, bytes)) = self.raw(source, tag)? else { return Ok(None) };
        let end = bytes.iter().position(|b| *b == 0).unwrap_or(bytes.len());
        Ok(Some(String::from_utf8_lossy(&bytes[..end]).into_owned()))
    }
}
