//! Reader of XML that refuses tags and texts without an end.

use std::io::{BufRead, Read};

/// Reader of a limited number of bytes for each event.
pub(super) struct Bounded<R> {
    inner: R,
    /// Most bytes of an event.
    most: usize,
    /// Bytes that may be read until the next event.
    left: usize,
}

impl<R> Bounded<R> {
    pub(super) fn new(inner: R, most: usize) -> Bounded<R> {
        Bounded { inner, most, left: most }
    }

    /// Begins an event.
    pub(super) fn begin_event(&mut self) {
        self.left = self.most;
    }
}

impl<R: Read> Read for Bounded<R> {
    fn read(&mut self, bytes: &mut [u8]) -> std::io::Result<usize> {
        self.inner.read(bytes)
    }
}

impl<R: BufRead> BufRead for Bounded<R> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        if self.left == 0 {
            return Err(std::io::Error::other(format!("a tag or text of more than {} MiB", self.most >> 20)));
        }
        self.inner.fill_buf()
    }

    fn consume(&mut self, n: usize) {
        self.left = self.left.saturating_sub(n);
        self.inner.consume(n);
    }
}
