//! Parts of words that need not be Unicode, such as paths on the command line.

use std::ffi::{OsStr, OsString};

/// Returns the parts of a word around each `pattern`, at least one.
#[cfg(unix)]
pub(crate) fn split(word: &OsStr, pattern: &str) -> Vec<OsString> {
    use std::os::unix::ffi::OsStrExt;
    let mut parts = Vec::new();
    let mut rest = word.as_bytes();
    while let Some(at) = rest.windows(pattern.len()).position(|bytes| bytes == pattern.as_bytes()) {
        parts.push(OsStr::from_bytes(&rest[..at]).to_os_string());
        rest = &rest[at + pattern.len()..];
    }
    parts.push(OsStr::from_bytes(rest).to_os_string());
    parts
}

/// Returns the parts of a word around each `pattern`, at least one. Invalid Unicode is replaced.
#[cfg(not(unix))]
pub(crate) fn split(word: &OsStr, pattern: &str) -> Vec<OsString> {
    word.to_string_lossy().split(pattern).map(OsString::from).collect()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::ffi::OsStrExt;

    #[test]
    fn words_are_split_whatever_their_bytes() {
        let of = |bytes: &[u8], pattern: &str| {
            split(OsStr::from_bytes(bytes), pattern).iter().map(|p| p.as_bytes().to_vec()).collect::<Vec<_>>()
        };
        assert_eq!(of(b"a=b\xff=c", "="), [b"a".to_vec(), b"b\xff".to_vec(), b"c".to_vec()]);
        assert_eq!(of(b"\xff{site}", "{site}"), [b"\xff".to_vec(), Vec::new()]);
        assert_eq!(of(b"\xff", "{site}"), [b"\xff".to_vec()]);
    }
}
