//! Bytes of a packed city: numbers, options and lists, written and read.

use std::fmt;

/// Error of bytes that are no packed city.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct NotPacked;

impl fmt::Display for NotPacked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the scene of the page is damaged")
    }
}

/// Maps small numbers of either sign to small numbers.
pub(crate) fn zigzag(v: i32) -> u32 {
    (v << 1 ^ v >> 31).cast_unsigned()
}

pub(crate) fn unzigzag(v: u32) -> i32 {
    (v >> 1).cast_signed() ^ -(v & 1).cast_signed()
}

/// Bytes that are written.
pub(crate) struct Out(pub(crate) Vec<u8>);

impl Out {
    pub(crate) fn real(&mut self, v: f64) {
        self.0.extend(v.to_le_bytes());
    }

    /// Writes a whole number, in as many bytes as it needs.
    pub(crate) fn count(&mut self, mut v: u64) {
        while v >= 0x80 {
            self.0.push(v.to_le_bytes()[0] | 0x80);
            v >>= 7;
        }
        self.0.push(v.to_le_bytes()[0]);
    }

    pub(crate) fn int(&mut self, v: i64) {
        self.count((v << 1 ^ v >> 63).cast_unsigned());
    }

    pub(crate) fn option<T>(&mut self, value: Option<T>, write: impl FnOnce(&mut Self, T)) {
        self.0.push(u8::from(value.is_some()));
        if let Some(value) = value {
            write(self, value);
        }
    }

    pub(crate) fn list<T>(&mut self, list: &[T], mut write: impl FnMut(&mut Self, &T)) {
        self.count(list.len() as u64);
        list.iter().for_each(|item| write(self, item));
    }

    /// Writes all first bytes, then all second ones, and so on.
    pub(crate) fn bytes_apart(&mut self, values: &[u32]) {
        for k in 0..4 {
            self.0.extend(values.iter().map(|v| v.to_le_bytes()[k]));
        }
    }
}

/// Bytes that are read.
pub(crate) struct In<'a>(pub(crate) &'a [u8]);

impl In<'_> {
    pub(crate) fn byte(&mut self) -> Result<u8, NotPacked> {
        let (byte, rest) = self.0.split_first().ok_or(NotPacked)?;
        self.0 = rest;
        Ok(*byte)
    }

    pub(crate) fn array<const N: usize, T>(&mut self, n: usize, of: fn([u8; N]) -> T) -> Result<Vec<T>, NotPacked> {
        let n_bytes = n.checked_mul(N).filter(|n| *n <= self.0.len()).ok_or(NotPacked)?;
        let (bytes, rest) = self.0.split_at(n_bytes);
        self.0 = rest;
        let (values, _) = bytes.as_chunks();
        Ok(values.iter().map(|bytes| of(*bytes)).collect())
    }

    pub(crate) fn real(&mut self) -> Result<f64, NotPacked> {
        self.array(1, f64::from_le_bytes).map(|values| values[0])
    }

    pub(crate) fn count(&mut self) -> Result<u64, NotPacked> {
        let mut value = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 0x7F) << shift;
            if byte < 0x80 {
                return Ok(value);
            }
        }
        Err(NotPacked)
    }

    /// Reads the number of items in a list, of which each takes a byte or more.
    pub(crate) fn length(&mut self) -> Result<usize, NotPacked> {
        let n = self.count()?;
        usize::try_from(n).ok().filter(|n| *n <= self.0.len()).ok_or(NotPacked)
    }

    pub(crate) fn int(&mut self) -> Result<i64, NotPacked> {
        self.count().map(|v| (v >> 1).cast_signed() ^ -(v & 1).cast_signed())
    }

    pub(crate) fn narrow(&mut self) -> Result<i32, NotPacked> {
        self.int().and_then(|v| i32::try_from(v).map_err(|_| NotPacked))
    }

    pub(crate) fn option<T>(
        &mut self,
        read: impl FnOnce(&mut Self) -> Result<T, NotPacked>,
    ) -> Result<Option<T>, NotPacked> {
        match self.byte()? {
            0 => Ok(None),
            _ => read(self).map(Some),
        }
    }

    pub(crate) fn list<T>(
        &mut self,
        mut read: impl FnMut(&mut Self) -> Result<T, NotPacked>,
    ) -> Result<Vec<T>, NotPacked> {
        let n = self.length()?;
        (0..n).map(|_| read(self)).collect()
    }
}
