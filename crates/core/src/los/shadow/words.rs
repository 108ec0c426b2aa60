//! Cells of a row as bits: 64 in a machine word.

use crate::raster::bits_between;

#[inline(always)]
fn as_index(v: u64) -> usize {
    usize::try_from(v).unwrap_or(usize::MAX)
}

/// Returns the bits for columns outside of `first..end`, in the word that begins at column `base`.
#[inline(always)]
pub(super) fn bits_outside(first: u64, end: u64, base: u64) -> u64 {
    let below = |col: u64| {
        let n = col.saturating_sub(base).min(64);
        (1_u64 << (n & 63)).wrapping_sub(1) | (n >> 6).wrapping_neg()
    };
    below(first) | !below(end)
}

/// Clears bits `first..end` of a row; none if `first ≥ end`.
#[inline(always)]
pub(super) fn clear(words: &mut [u64], first: u64, end: u64) {
    if first >= end {
        return;
    }
    let last = end - 1;
    let (from, to) = (as_index(first / 64), as_index(last / 64));
    let (head, tail) = (u64::MAX << (first % 64), u64::MAX >> (63 - last % 64));
    if from == to {
        words[from] &= !(head & tail);
        return;
    }
    words[from] &= !head;
    words[from + 1..to].fill(0);
    words[to] &= !tail;
}

/// Calls `f` with the column of each set bit within `first..end`.
#[inline(always)]
pub(super) fn for_each_bit(words: &[u64], first: usize, end: usize, mut f: impl FnMut(usize)) {
    for (word, bits) in words.iter().enumerate().take(end.div_ceil(64)).skip(first / 64) {
        let mut bits = bits & bits_between(first, end, word);
        while bits != 0 {
            f(word * 64 + bits.trailing_zeros() as usize);
            bits &= bits - 1;
        }
    }
}
