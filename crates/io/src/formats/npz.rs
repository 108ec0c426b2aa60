//! NumPy archives: a ZIP file of one `.npy` file per array, as `numpy.savez_compressed` writes it.
//!
//! # References
//! NumPy Enhancement Proposal 1, format version 1.0.

use std::io::{Seek, Write};

use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use crate::error::{Error, Result};

/// An array with its shape, the last index running fastest.
#[derive(Debug, Clone)]
pub enum NpyArray<'a> {
    /// Bytes.
    U8(&'a [u8], Vec<usize>),
    /// Unsigned integers of 32 bits.
    U32(&'a [u32], Vec<usize>),
    /// Integers of 64 bits.
    I64(&'a [i64], Vec<usize>),
    /// Floating point numbers of 32 bits.
    F32(&'a [f32], Vec<usize>),
    /// Floating point numbers of 64 bits.
    F64(&'a [f64], Vec<usize>),
    /// One string, an array without dimensions. NumPy drops zeros at its end.
    Text(&'a str),
    /// Strings, one dimension.
    Texts(&'a [String]),
}

/// Writes arrays under their names.
///
/// # Errors
/// E401 if `out` refuses the bytes, E402 if ZIP cannot hold the arrays (two of one name, a name of
/// more than 64 KiB).
///
/// # Panics
/// If an array does not hold as many values as its shape requires.
pub fn write_npz(out: &mut (impl Write + Seek), arrays: &[(String, NpyArray<'_>)]) -> Result<()> {
    let refused = |cause: zip::result::ZipError| match cause {
        zip::result::ZipError::Io(cause) => Error::refused("an npz file", &cause),
        other => Error::encode("an npz file", other),
    };
    let mut archive = ZipWriter::new(out);
    for (name, array) in arrays {
        // A fixed date, so that the same arrays give the same bytes.
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .compression_level(array.level())
            .last_modified_time(DateTime::default())
            .large_file(array.n_bytes() >= u64::from(u32::MAX) / 2);
        archive.start_file(format!("{name}.npy"), options).map_err(refused)?;
        array.write(&mut archive).map_err(|cause| refused(cause.into()))?;
    }
    archive.finish().map_err(refused)?;
    Ok(())
}

impl NpyArray<'_> {
    /// Returns the compression level, low for measures, which hardly repeat; `None` is the
    /// library's own level.
    fn level(&self) -> Option<i64> {
        matches!(self, NpyArray::F32(..) | NpyArray::F64(..)).then_some(1)
    }

    fn write(&self, out: &mut impl Write) -> std::io::Result<()> {
        let (kind, shape) = match self {
            NpyArray::U8(_, shape) => ("|u1".to_string(), shape.as_slice()),
            NpyArray::U32(_, shape) => ("<u4".to_string(), shape.as_slice()),
            NpyArray::I64(_, shape) => ("<i8".to_string(), shape.as_slice()),
            NpyArray::F32(_, shape) => ("<f4".to_string(), shape.as_slice()),
            NpyArray::F64(_, shape) => ("<f8".to_string(), shape.as_slice()),
            NpyArray::Text(text) => (format!("<U{}", text.chars().count().max(1)), [].as_slice()),
            NpyArray::Texts(texts) => (format!("<U{}", longest(texts)), &[texts.len()][..]),
        };
        out.write_all(&header(&kind, shape))?;
        let n_values = shape.iter().product();
        match self {
            NpyArray::U8(values, _) => write_values(out, values, n_values, |value| [value]),
            NpyArray::U32(values, _) => write_values(out, values, n_values, u32::to_le_bytes),
            NpyArray::I64(values, _) => write_values(out, values, n_values, i64::to_le_bytes),
            NpyArray::F32(values, _) => write_values(out, values, n_values, f32::to_le_bytes),
            NpyArray::F64(values, _) => write_values(out, values, n_values, f64::to_le_bytes),
            NpyArray::Text(text) => {
                let text = if text.is_empty() { "\0" } else { text };
                text.chars().try_for_each(|c| out.write_all(&u32::from(c).to_le_bytes()))
            }
            NpyArray::Texts(texts) => {
                let longest = longest(texts);
                texts.iter().try_for_each(|text| {
                    let padded = text.chars().map(u32::from).chain(std::iter::repeat(0)).take(longest);
                    out.write_all(&padded.flat_map(u32::to_le_bytes).collect::<Vec<u8>>())
                })
            }
        }
    }

    /// Returns the length of the values without the header \[bytes\].
    fn n_bytes(&self) -> u64 {
        let len = match self {
            NpyArray::U8(values, _) => values.len(),
            NpyArray::U32(values, _) => values.len() * 4,
            NpyArray::F32(values, _) => values.len() * 4,
            NpyArray::I64(values, _) => values.len() * 8,
            NpyArray::F64(values, _) => values.len() * 8,
            NpyArray::Text(text) => text.len() * 4,
            NpyArray::Texts(texts) => texts.len() * longest(texts) * 4,
        };
        len as u64
    }
}

/// Returns the number of characters of the longest string; NumPy has no strings of none.
fn longest(texts: &[String]) -> usize {
    texts.iter().map(|t| t.chars().count()).max().unwrap_or(0).max(1)
}

/// Returns magic number, version, and a Python literal padded so that the values begin at a
/// multiple of 64 bytes.
fn header(kind: &str, shape: &[usize]) -> Vec<u8> {
    let shape = match shape {
        [only] => format!("({only},)"),
        _ => format!("({})", shape.iter().map(usize::to_string).collect::<Vec<_>>().join(", ")),
    };
    let mut literal = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}");
    let unpadded = 10 + literal.len() + 1;
    literal.push_str(&" ".repeat(unpadded.next_multiple_of(64) - unpadded));
    literal.push('\n');
    let len = u16::try_from(literal.len()).expect("a shape of a few dimensions is short");
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend(len.to_le_bytes());
    header.extend(literal.bytes());
    header
}

fn write_values<T: Copy, const N: usize>(
    out: &mut impl Write,
    values: &[T],
    n_values: usize,
    bytes_of: impl Fn(T) -> [u8; N],
) -> std::io::Result<()> {
    assert_eq!(values.len(), n_values, "an array holds as many values as its shape says");
    values.chunks(1 << 14).try_for_each(|chunk| {
        let bytes: Vec<u8> = chunk.iter().flat_map(|&value| bytes_of(value)).collect();
        out.write_all(&bytes)
    })
}
