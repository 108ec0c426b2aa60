//! Description at the end of a Parquet file, looked through before a library reads it.
//!
//! The schema is a tree in a list: each element says how many of the next ones are its children. A
//! tree that is deeper than any real one, or larger than its list, would exhaust the stack or the
//! memory.
//!
//! # References
//! Apache Parquet format 2.12, `FileMetaData`.

use super::compact::{LIST, MOST_NESTED, STRUCT, Words, is_number};
use super::shapes::DESCRIPTION;

/// Numbers of fields.
const SCHEMA: i16 = 2;
const NUM_CHILDREN: i16 = 5;

/// Refuses a description whose fields have other types than the format says, or whose schema is no
/// tree, or too deep.
pub(super) fn check(description: &[u8]) -> Result<(), String> {
    Words::of(description).walk(&DESCRIPTION)?;
    let mut words = Words::of(description);
    let (mut field, mut has_schema) = (0, false);
    while let Some((number, kind)) = words.field(field)? {
        field = number;
        if (number, kind) == (SCHEMA, LIST) {
            check_schema(&mut words)?;
            has_schema = true;
        } else {
            words.skip(kind, MOST_NESTED)?;
        }
    }
    has_schema.then_some(()).ok_or_else(|| "a description without a schema".into())
}

fn check_schema(words: &mut Words<'_>) -> Result<(), String> {
    let (n, kind) = words.list()?;
    if kind != STRUCT {
        return Err("a schema that is no list of elements".into());
    }
    // Children that are still to come, from the root on.
    let mut open: Vec<usize> = Vec::new();
    for k in 0..n {
        let n_children = n_children(words)?;
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

/// Reads an element of a schema, and returns the number of its children.
fn n_children(words: &mut Words<'_>) -> Result<usize, String> {
    let (mut last, mut n) = (0, 0);
    while let Some((number, kind)) = words.field(last)? {
        last = number;
        match number {
            NUM_CHILDREN if is_number(kind) => {
                n = usize::try_from(words.signed()?).map_err(|_| "an element with less than no children")?;
            }
            _ => words.skip(kind, MOST_NESTED)?,
        }
    }
    Ok(n)
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
        bytes.push(0);
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
        assert!(refused(&[0xBC; 40]).contains("without end"));
        // Fields after the schema, of the types of the format and of others.
        let with = |more: &[u8]| [&described(&[0])[..11], more, &[0]].concat();
        assert_eq!(check(&with(&[0x16, 2])), Ok(()));
        assert!(refused(&with(&[0x18, 1, b'a'])).contains("field 3: a value of type 8"));
        // Lists of truths in a field that the format does not have, few and billions.
        assert!(refused(&with(&[0x79, 0x21, 1, 1])).contains("truths"));
        assert!(refused(&with(&[0x79, 0xF1, 0xFF, 0xFF, 0xFF, 0xFF, 0x07])).contains("announces"));
        let whole = described(&[2, 0, 1, 0]);
        (0..whole.len()).for_each(|n| drop(refused(&whole[..n])));
    }
}
