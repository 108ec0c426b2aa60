//! Seal of a file: at its end, a digest of all bytes before. Readers of GeoTIFF and EXR find all that
//! they read by offsets, so they ignore it.

use std::fs::{File, OpenOptions};
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

use super::format::Format;
use crate::digest::Sha256;

/// Words before the digits of a digest.
const WORDS: &[u8] = b"\nsha256 ";

/// Length of a seal: its words, the digits of a digest, and the end of the line \[bytes\].
const BYTES: usize = WORDS.len() + 64 + 1;

/// Returns `true` if files of a format can be sealed. Of the other rasters PNG and NPZ hold
/// checksums of their own.
pub(super) fn can_seal(format: Format) -> bool {
    matches!(format, Format::GeoTiff | Format::Exr)
}

/// Seals a file.
pub(super) fn seal(path: &Path) -> io::Result<()> {
    let length = std::fs::metadata(path)?.len();
    let seal = seal_of(&mut BufReader::new(File::open(path)?), length)?;
    let mut file = OpenOptions::new().append(true).open(path)?;
    file.write_all(&seal)?;
    file.sync_all()
}

/// Returns `true` if a file still ends with the digest of its bytes, and for formats without one.
///
/// Cost: that of reading the file.
pub fn is_unchanged(path: &Path, format: Format) -> bool {
    !can_seal(format) || ends_with_seal(path).unwrap_or(false)
}

fn ends_with_seal(path: &Path) -> io::Result<bool> {
    let Some(length) = std::fs::metadata(path)?.len().checked_sub(BYTES as u64) else { return Ok(false) };
    let mut file = BufReader::new(File::open(path)?);
    let wanted = seal_of(&mut file, length)?;
    let mut found = Vec::new();
    file.read_to_end(&mut found)?;
    Ok(found == wanted)
}

/// Returns the seal of the next `length` bytes.
fn seal_of(file: &mut impl Read, length: u64) -> io::Result<Vec<u8>> {
    let mut digest = Sha256::default();
    let mut part = vec![0; 1 << 16];
    let mut left = file.take(length);
    loop {
        match left.read(&mut part)? {
            0 => break,
            n => digest.update(&part[..n]),
        }
    }
    Ok([WORDS, digest.hex_digits().as_bytes(), b"\n"].concat())
}
