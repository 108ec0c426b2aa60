//! Fields of messages in the encoding of Protocol Buffers.
//!
//! Nothing is copied, and nothing is reserved for a count or a length. A block that unpacks to
//! millions of empty messages therefore takes no more memory than its bytes.
//!
//! # References
//! Protocol Buffers Documentation, Encoding.

/// Fault of a message.
pub(super) type Fault = &'static str;

/// A message, or numbers without names.
#[derive(Debug, Clone, Copy)]
pub(super) struct Message<'a>(pub(super) &'a [u8]);

/// Value of a field.
#[derive(Debug, Clone, Copy)]
pub(super) enum Value<'a> {
    Number(u64),
    Bytes(&'a [u8]),
    /// Four or eight bytes, which no field of interest has.
    Fixed,
}

impl<'a> Message<'a> {
    /// Returns the next field with its number.
    pub(super) fn next_field(&mut self) -> Result<Option<(u64, Value<'a>)>, Fault> {
        if self.0.is_empty() {
            return Ok(None);
        }
        let key = self.varint()?;
        let value = match key & 7 {
            0 => Value::Number(self.varint()?),
            1 => self.take(8).map(|_| Value::Fixed)?,
            2 => {
                let length = self.varint()?;
                Value::Bytes(self.take(usize::try_from(length).unwrap_or(usize::MAX))?)
            }
            5 => self.take(4).map(|_| Value::Fixed)?,
            _ => return Err("a field of an unknown type"),
        };
        Ok(Some((key >> 3, value)))
    }

    /// Returns the next of some packed numbers.
    pub(super) fn next_number(&mut self) -> Result<Option<u64>, Fault> {
        if self.0.is_empty() { Ok(None) } else { self.varint().map(Some) }
    }

    fn varint(&mut self) -> Result<u64, Fault> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let (first, rest) = self.0.split_first().ok_or("a number that is cut off")?;
            self.0 = rest;
            number |= u64::from(first & 0x7f) << shift;
            if first & 0x80 == 0 {
                return Ok(number);
            }
        }
        Err("a number of more than ten bytes")
    }

    fn take(&mut self, n: usize) -> Result<&'a [u8], Fault> {
        let (taken, rest) = self.0.split_at_checked(n).ok_or("a field that is longer than its message")?;
        self.0 = rest;
        Ok(taken)
    }
}

impl<'a> Value<'a> {
    pub(super) fn bytes(self) -> Result<&'a [u8], Fault> {
        if let Value::Bytes(bytes) = self { Ok(bytes) } else { Err("a number in place of bytes") }
    }

    pub(super) fn number(self) -> Result<u64, Fault> {
        if let Value::Number(number) = self { Ok(number) } else { Err("bytes in place of a number") }
    }

    /// Returns the numbers of a list: packed, or one alone.
    pub(super) fn numbers(self) -> Result<Numbers<'a>, Fault> {
        match self {
            Value::Bytes(bytes) => Ok(Numbers::Packed(Message(bytes))),
            Value::Number(number) => Ok(Numbers::One(Some(number))),
            Value::Fixed => Err("a list of unknown numbers"),
        }
    }
}

/// Numbers of a list.
#[derive(Debug, Clone, Copy)]
pub(super) enum Numbers<'a> {
    Packed(Message<'a>),
    One(Option<u64>),
}

impl Numbers<'_> {
    pub(super) fn next_number(&mut self) -> Result<Option<u64>, Fault> {
        match self {
            Numbers::Packed(message) => message.next_number(),
            Numbers::One(number) => Ok(number.take()),
        }
    }
}

/// Returns a number of which the last bit is the sign.
pub(super) fn signed(number: u64) -> i64 {
    (number >> 1).cast_signed() ^ -(number & 1).cast_signed()
}
