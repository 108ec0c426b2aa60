//! Pieces that were visited already, since several buckets list a piece.

/// A set of indices.
pub(super) struct Seen {
    bits: Vec<u64>,
}

impl Seen {
    /// Returns the empty set of indices below `n`.
    pub(super) fn of(n: usize) -> Seen {
        Seen { bits: vec![0; n.div_ceil(64)] }
    }

    /// Adds an index; returns `true` if it is new.
    #[inline]
    pub(super) fn is_new(&mut self, index: usize) -> bool {
        let (word, bit) = (&mut self.bits[index / 64], 1 << (index % 64));
        let is_new = *word & bit == 0;
        *word |= bit;
        is_new
    }
}
