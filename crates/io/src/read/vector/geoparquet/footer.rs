//! Description at the end of a Parquet file, looked through before a library builds its schema.
//!
//! The schema is a tree in a list: each element says how many of the next ones are its children. A
//! tree that is deeper than any real one, or larger than its list, would exhaust the stack or the
//! memory.
//!
//! # References
//! Apache Thrift, compact protocol; Apache Parquet format 2.12, `FileMetaData`.

/// Deepest nesting of columns, and of structures of the description.
const MOST_NESTED: usize = 32;
/// Numbers of fields.
const SCHEMA: i16 = 2;
const NUM_CHILDREN: i16 = 5;

/// Types of values.
const TRUE: u8 = 1;
const FALSE: u8 = 2;
const BYTE: u8 = 3;
const SMALLEST_INTEGER: u8 = 4;
const LARGEST_INTEGER: u8 = 6;
const DOUBLE: u8 = 7;
const BINARY: u8 = 8;
const LIST: u8 = 9;
const SET: u8 = 10;
const MAP: u8 = 11;
const STRUCT: u8 = 12;
const UUID: u8 = 13;

/// Refuses a description whose schema is no tree, or too deep.
pub(super) fn check(description: &[u8]) -> Result<(), String> {
    let mut words = Words { bytes: description };
    let mut field = 0;
    while let Some((number, kind)) = words.field(field)? {
        field = number;
        if (number, kind) == (SCHEMA, LIST) {
            return check_schema(&mut words);
        }
        words.skip(kind, MOST_NESTED)?;
    }
    Err("a description without a schema".into())
}

fn check_schema(words: &mut Words<'_>) -> Result<(), String> {
    let (n, kind) = words.list()?;
    if kind != STRUCT {
        return Err("a schema that is no list of elements".into());
    }
    // Children that are still to come, from the root on.
    let mut open: Vec<usize> = Vec::new();
    for k in 0..n {
        let n_children = words.n_children()?;
        if n_children > n - 1 - k {
            return Err(format!("an element of the schema with {n_children} children, where {} follow", n - 1 - k));
        }
        if let Some(left) = open.last_mut() {
            *left -= 1;
        }
        open.push(n_children);
        if open.len() > MOST_NESTED {
            return Err(format!("a schema nested more than {MOST_NESTED} deep"));
        }
        while open.last() == Some(&0) {
            open.pop();
        }
        if open.is_empty() && k + 1 < n {
            return Err("a schema with two roots".into());
        }
    }
    Ok(())
}

/// Bytes that are left of a description.
struct Words<'a> {
    bytes: &'a [u8],
}

impl Words<'_> {
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

    fn signed(&mut self) -> Result<i64, String> {
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
    fn field(&mut self, last: i16) -> Result<Option<(i16, u8)>, String> {
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
    fn list(&mut self) -> Result<(usize, u8), String> {
        let head = self.byte()?;
        let n = if head >> 4 == 15 { self.length()? } else { usize::from(head >> 4) };
        Ok((n, head & 0x0F))
    }

    /// Reads an element of a schema, and returns the number of its children.
    fn n_children(&mut self) -> Result<usize, String> {
        let (mut last, mut n) = (0, 0);
        while let Some((number, kind)) = self.field(last)? {
            last = number;
            match number {
                NUM_CHILDREN if (SMALLEST_INTEGER..=LARGEST_INTEGER).contains(&kind) => {
                    n = usize::try_from(self.signed()?).map_err(|_| "an element with less than no children")?;
                }
                _ => self.skip(kind, MOST_NESTED)?,
            }
        }
        Ok(n)
    }

    /// Leaves out a value that nests no deeper than `depth`.
    fn skip(&mut self, kind: u8, depth: usize) -> Result<(), String> {
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

    /// Leaves out an element of a list, where truths take a byte each.
    fn skip_element(&mut self, kind: u8, depth: usize) -> Result<(), String> {
        match kind {
            TRUE | FALSE => self.byte().map(drop),
            kind => self.skip(kind, depth),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a description of a version, and of a schema whose elements have these numbers of children.
    fn described(children: &[u8]) -> Vec<u8> {
        let mut bytes = vec![0x15, 2, 0x19, 0xF0 | STRUCT, u8::try_from(children.len()).unwrap()];
        for n in children {
            // A name, and the number of children.
            bytes.extend([0x48, 1, b'a', 0x15, n << 1, 0]);
        }
        bytes
    }

    #[test]
    fn only_trees_that_are_not_too_deep_pass() {
        assert_eq!(check(&described(&[2, 0, 1, 0])), Ok(()));
        let refused = |bytes: &[u8]| check(bytes).unwrap_err();
        assert!(refused(&described(&[3, 0])).contains("3 children, where 1 follow"));
        assert!(refused(&described(&[1, 0, 0])).contains("two roots"));
        let deep = [vec![1; 40], vec![0]].concat();
        assert!(refused(&described(&deep)).contains("more than 32 deep"));
        assert!(refused(&[0x15, 2, 0x19, 0xFC, 0xFF, 0xFF, 3]).contains("announces"));
        assert!(refused(&[0x1C; 40]).contains("without end"));
        let whole = described(&[2, 0, 1, 0]);
        (0..whole.len()).for_each(|n| drop(refused(&whole[..n])));
    }
}
