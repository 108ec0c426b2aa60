//! Parquet file that is read by parts.
//!
//! Lengths in the file are compared with it before anything is reserved.

use std::io::{BufRead, BufReader, ErrorKind, Read, Seek, SeekFrom};
use std::sync::{Arc, Mutex, PoisonError};

use bytes::Bytes;
use parquet::errors::ParquetError;
use parquet::file::reader::{ChunkReader, Length};

use super::footer;
use crate::error::Result;
use crate::input::{Input, Reader};

/// Length of the end of a file: that of its description, and four letters.
const END_BYTES: u64 = 8;
/// Most bytes of a page, and beside them for each packed byte. Writers make pages of 1 MiB.
const MOST_UNPACKED: (u64, u64) = (64 << 20, 150);

/// File that is read by parts.
pub(super) struct Chunks {
    pub(super) reader: Arc<Mutex<Reader>>,
    pub(super) length: u64,
}

impl Chunks {
    pub(super) fn of(input: &Input) -> Result<Chunks> {
        let (reader, length) = input.open()?;
        Ok(Chunks { reader: Arc::new(Mutex::new(reader)), length })
    }

    /// Refuses a file whose description would exhaust the stack or the memory.
    pub(super) fn check_footer(&self) -> parquet::errors::Result<()> {
        let found = |what: String| ParquetError::General(what);
        let Some(before_end) = self.length.checked_sub(END_BYTES) else {
            return Err(found(format!("a file of {} bytes", self.length)));
        };
        let end = self.get_bytes(before_end, 8)?;
        let length = u32::from_le_bytes([end[0], end[1], end[2], end[3]]);
        let Some(start) = before_end.checked_sub(u64::from(length)).filter(|_| &end[4..] == b"PAR1") else {
            return Err(found(format!("it announces {length} bytes of description at its end")));
        };
        footer::check(&self.get_bytes(start, length as usize)?).map_err(found)
    }

    /// Returns the most bytes that its values may take, packed or not.
    pub(super) fn most_bytes(&self) -> usize {
        usize::try_from(MOST_UNPACKED.0.saturating_add(MOST_UNPACKED.1.saturating_mul(self.length)))
            .unwrap_or(usize::MAX)
    }

    pub(super) fn at(&self, start: u64) -> BufReader<Chunk> {
        BufReader::new(Chunk { reader: Arc::clone(&self.reader), at: start, has_ended: false })
    }
}

/// A part of a file from some byte on.
pub(super) struct Chunk {
    reader: Arc<Mutex<Reader>>,
    at: u64,
    has_ended: bool,
}

impl Read for Chunk {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        // Descriptions of pages announce lists, whose elements are skipped one by one beyond the end, too.
        if self.has_ended {
            return Err(ErrorKind::UnexpectedEof.into());
        }
        let mut reader = self.reader.lock().unwrap_or_else(PoisonError::into_inner);
        reader.seek(SeekFrom::Start(self.at))?;
        let n = reader.read(bytes)?;
        self.at += n as u64;
        self.has_ended = n == 0 && !bytes.is_empty();
        Ok(n)
    }
}

impl Length for Chunks {
    fn len(&self) -> u64 {
        self.length
    }
}

impl ChunkReader for Chunks {
    type T = BufReader<Chunk>;

    fn get_read(&self, start: u64) -> parquet::errors::Result<Self::T> {
        let mut reader = self.at(start);
        // Pages are read from here on. What one takes is reserved before it is unpacked.
        if let Some((unpacked, packed)) = page_sizes(reader.fill_buf()?)
            && unpacked > MOST_UNPACKED.0.saturating_add(MOST_UNPACKED.1.saturating_mul(packed))
        {
            return Err(ParquetError::General(format!("a page of {unpacked} bytes packed into {packed}")));
        }
        Ok(reader)
    }

    fn get_bytes(&self, start: u64, length: usize) -> parquet::errors::Result<Bytes> {
        // Lengths in a file are compared with it before anything is reserved.
        if start.saturating_add(length as u64) > self.length {
            return Err(ParquetError::EOF(format!("it announces {length} bytes at byte {start} of {}", self.length)));
        }
        let mut bytes = Vec::with_capacity(length);
        self.at(start).take(length as u64).read_to_end(&mut bytes)?;
        if bytes.len() < length {
            return Err(ParquetError::EOF(format!("it ends {} bytes early", length - bytes.len())));
        }
        Ok(bytes.into())
    }
}

/// Returns the sizes of a page \[bytes\], unpacked and packed, that its header begins with.
fn page_sizes(header: &[u8]) -> Option<(u64, u64)> {
    let mut rest = header;
    let mut field = || {
        // A field of 32 bits with the next number.
        let (0x15, mut bytes) = rest.split_first().map(|(head, rest)| (*head, rest))? else { return None };
        let mut number = 0;
        for shift in (0..35).step_by(7) {
            let (byte, after) = bytes.split_first()?;
            bytes = after;
            number |= u64::from(byte & 0x7F) << shift;
            if byte & 0x80 == 0 {
                break;
            }
        }
        rest = bytes;
        Some(number >> 1)
    };
    let [_kind, unpacked, packed] = [field()?, field()?, field()?];
    Some((unpacked, packed))
}

#[cfg(test)]
mod tests {
    use std::io::{ErrorKind, Read};

    use super::{Chunks, page_sizes};
    use crate::Input;

    #[test]
    fn the_end_of_a_file_is_told_once() {
        let chunks = Chunks::of(&Input::bytes("a.parquet", b"PAR1".to_vec())).unwrap();
        let (mut part, mut bytes) = (chunks.at(2), [0; 8]);
        assert_eq!(part.read(&mut bytes).unwrap(), 2);
        assert_eq!(part.read(&mut bytes).unwrap(), 0);
        assert_eq!(part.read(&mut bytes).unwrap_err().kind(), ErrorKind::UnexpectedEof);
    }

    #[test]
    fn sizes_stand_at_the_beginning_of_a_page() {
        assert_eq!(page_sizes(&[0x15, 4, 0x15, 0xFE, 0xFF, 0xFF, 0xFF, 0x0F, 0x15, 80, 0]), Some((2_147_483_647, 40)));
        assert_eq!(page_sizes(&[0x15, 0, 0x15, 0x80, 1, 0x15]), None);
        assert_eq!(page_sizes(b"PAR1"), None);
    }
}
