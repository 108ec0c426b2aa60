//! Descriptions within a Parquet file, looked through before a library reads them.
//!
//! The library goes by the numbers of fields, not by their types, and leaves out what it does not
//! know element by element. So it is handed only what has the types of the format, and lists that
//! are no longer than their bytes.
//!
//! # References
//! Apache Thrift, compact protocol.

/// Deepest nesting of columns, and of structures of a description.
pub(super) const MOST_NESTED: usize = 32;

/// Types of values.
const TRUE: u8 = 1;
const FALSE: u8 = 2;
const BYTE: u8 = 3;
const SMALLEST_INTEGER: u8 = 4;
const LARGEST_INTEGER: u8 = 6;
const DOUBLE: u8 = 7;
const BINARY: u8 = 8;
pub(super) const LIST: u8 = 9;
const SET: u8 = 10;
const MAP: u8 = 11;
pub(super) const STRUCT: u8 = 12;
const UUID: u8 = 13;

/// Type of a value by the format.
#[derive(Debug)]
pub(super) enum Shape {
    /// Truth of a field, without bytes of its own.
    Truth,
    Byte,
    /// Integer of 16, 32 or 64 bits.
    Number,
    Double,
    Bytes,
    List(&'static Shape),
    /// Structure: types of its fields from number 1 on.
    Struct(&'static [Shape]),
    /// Value that the library leaves out.
    Any,
}

/// Returns `true` for the type of an integer.
pub(super) fn is_number(kind: u8) -> bool {
    (SMALLEST_INTEGER..=LARGEST_INTEGER).contains(&kind)
}

/// Bytes that are left of a description.
pub(super) struct Words<'a> {
    bytes: &'a [u8],
}

impl<'a> Words<'a> {
    pub(super) fn of(bytes: &'a [u8]) -> Self {
        Words { bytes }
    }

    fn take(&mut self, n: usize) -> Result<&[u8], String> {
        let (taken, rest) = self.bytes.split_at_checked(n).ok_or("a description that ends early")?;
        self.bytes = rest;
        Ok(taken)
    }

    fn byte(&mut self) -> Result<u8, String> {
        self.take(1).map(|byte| byte[0])
    }

    fn number(&mut self) -> Result<u64, String> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            number |= u64::from(byte & 0x7F) << shift;
            if byte & 0x80 == 0 {
                return Ok(number);
            }
        }
        Err("a number of more than 64 bits".into())
    }

    pub(super) fn signed(&mut self) -> Result<i64, String> {
        let number = self.number()?;
        Ok((number >> 1).cast_signed() ^ -(number & 1).cast_signed())
    }

    fn length(&mut self) -> Result<usize, String> {
        let length = usize::try_from(self.number()?).unwrap_or(usize::MAX);
        if length > self.bytes.len() {
            return Err(format!(
                "a description that announces {length} bytes or values where {} are left",
                self.bytes.len()
            ));
        }
        Ok(length)
    }

    /// Returns number and type of the next field of a structure; `None` at its end.
    pub(super) fn field(&mut self, last: i16) -> Result<Option<(i16, u8)>, String> {
        let head = self.byte()?;
        if head == 0 {
            return Ok(None);
        }
        let number = match head >> 4 {
            0 => i16::try_from(self.signed()?).map_err(|_| "a field with a number that is none")?,
            more => last.saturating_add(i16::from(more)),
        };
        Ok(Some((number, head & 0x0F)))
    }

    /// Returns length and type of a list.
    pub(super) fn list(&mut self) -> Result<(usize, u8), String> {
        let head = self.byte()?;
        let n = if head >> 4 == 15 { self.length()? } else { usize::from(head >> 4) };
        Ok((n, head & 0x0F))
    }

    /// Leaves out a value that nests no deeper than `depth`.
    pub(super) fn skip(&mut self, kind: u8, depth: usize) -> Result<(), String> {
        let inner = depth.checked_sub(1).ok_or("a description that nests without end")?;
        match kind {
            TRUE | FALSE => {}
            BYTE => drop(self.byte()?),
            SMALLEST_INTEGER..=LARGEST_INTEGER => drop(self.number()?),
            DOUBLE => drop(self.take(8)?),
            UUID => drop(self.take(16)?),
            BINARY => {
                let n = self.length()?;
                self.take(n)?;
            }
            LIST | SET => {
                let (n, of) = self.list()?;
                (0..n).try_for_each(|_| self.skip_element(of, inner))?;
            }
            MAP => {
                let n = self.length()?;
                let kinds = if n > 0 { self.byte()? } else { 0 };
                for _ in 0..n {
                    self.skip_element(kinds >> 4, inner)?;
                    self.skip_element(kinds & 0x0F, inner)?;
                }
            }
            STRUCT => {
                let mut last = 0;
                while let Some((number, of)) = self.field(last)? {
                    last = number;
                    self.skip(of, inner)?;
                }
            }
            kind => return Err(format!("a value of type {kind} in the description")),
        }
        Ok(())
    }

    /// Leaves out an element of a list. The library takes truths in lists for nothing: some bytes
    /// that announce billions of them would keep it for ever.
    fn skip_element(&mut self, kind: u8, depth: usize) -> Result<(), String> {
        match kind {
            TRUE | FALSE => Err("a list of truths, of which the format has none".into()),
            kind => self.skip(kind, depth),
        }
    }

    /// Leaves out a structure whose fields have the types of the format.
    pub(super) fn walk(&mut self, fields: &[Shape]) -> Result<(), String> {
        let mut last = 0;
        while let Some((number, kind)) = self.field(last)? {
            last = number;
            self.walk_field(fields, (number, kind))?;
        }
        Ok(())
    }

    /// Leaves out a field of a structure.
    pub(super) fn walk_field(&mut self, fields: &[Shape], (number, kind): (i16, u8)) -> Result<(), String> {
        let place = usize::try_from(number).ok().and_then(|number| number.checked_sub(1));
        let shape = place.and_then(|place| fields.get(place)).unwrap_or(&Shape::Any);
        self.walk_value(shape, kind).map_err(|what| format!("field {number}: {what}"))
    }

    fn walk_value(&mut self, shape: &Shape, kind: u8) -> Result<(), String> {
        match (shape, kind) {
            (Shape::List(of), LIST) => {
                let (n, kind) = self.list()?;
                (0..n).try_for_each(|_| self.walk_value(of, kind))
            }
            (Shape::Struct(fields), STRUCT) => self.walk(fields),
            (Shape::Any, _)
            | (Shape::Truth, TRUE | FALSE)
            | (Shape::Byte, BYTE)
            | (Shape::Number, SMALLEST_INTEGER..=LARGEST_INTEGER)
            | (Shape::Double, DOUBLE)
            | (Shape::Bytes, BINARY) => self.skip(kind, MOST_NESTED),
            _ => Err(format!("a value of type {kind}, where the format has another")),
        }
    }
}
