//! Bits of a sweep, written by several threads: those of two quadrants by row, those of the others by column.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;

use crate::raster::BitGrid;

/// Bits that several threads write, one line after another.
pub(super) struct SharedBits {
    words: Vec<AtomicU64>,
    per_line: usize,
}

impl SharedBits {
    /// None of them set.
    pub(super) fn new(n_lines: usize, n_cells: usize) -> Self {
        let per_line = n_cells.div_ceil(64);
        let mut words = Vec::with_capacity(n_lines * per_line);
        words.resize_with(n_lines * per_line, || AtomicU64::new(0));
        SharedBits { words, per_line }
    }

    /// The words of a line.
    pub(super) fn line(&self, line: usize) -> &[AtomicU64] {
        &self.words[line * self.per_line..(line + 1) * self.per_line]
    }

    /// Adds bits to a word, which others may write at the same time if it is shared.
    #[inline]
    pub(super) fn add(&self, line: usize, word: usize, bits: u64, is_shared: bool) {
        let word = &self.words[line * self.per_line + word];
        match (bits, is_shared) {
            (0, _) => {}
            (_, true) => {
                word.fetch_or(bits, Ordering::Relaxed);
            }
            // PERF: without a lock, behind which all other reads and writes would wait.
            (_, false) => word.store(word.load(Ordering::Relaxed) | bits, Ordering::Relaxed),
        }
    }
}

/// Rows that several threads found, and columns that they found, together: the bits of either in cells of `wanted`.
pub(super) fn rows_and_columns(rows: &SharedBits, cols: &SharedBits, wanted: &BitGrid) -> BitGrid {
    let n_cols = wanted.n_cols();
    let mut los = BitGrid::new(wanted.n_rows(), n_cols);
    let per_row = los.words_per_row();
    los.words_mut().par_chunks_mut(64 * per_row).enumerate().for_each(|(band, out)| {
        let n_band = out.len() / per_row;
        for word in 0..per_row {
            let mut block = [0_u64; 64];
            let n_here = (n_cols - 64 * word).min(64);
            let mut any = 0;
            for (k, bits) in block.iter_mut().enumerate().take(n_here) {
                *bits = cols.line(64 * word + k)[band].load(Ordering::Relaxed);
                any |= *bits;
            }
            if any != 0 {
                transpose(&mut block);
            }
            for k in 0..n_band {
                let own = rows.line(64 * band + k)[word].load(Ordering::Relaxed);
                out[k * per_row + word] = (own | block[k]) & wanted.row(64 * band + k)[word];
            }
        }
    });
    los
}

/// Turns a block of bits over: bit `c` of word `r` becomes bit `r` of word `c` (Warren, Hacker's Delight, 7-3).
pub(super) fn transpose(block: &mut [u64; 64]) {
    let mut width = 32;
    let mut mask = 0x0000_0000_ffff_ffff_u64;
    while width != 0 {
        let mut k = 0;
        while k < 64 {
            let swapped = ((block[k] >> width) ^ block[k + width]) & mask;
            block[k] ^= swapped << width;
            block[k + width] ^= swapped;
            k = (k + width + 1) & !width;
        }
        width >>= 1;
        mask ^= mask << width;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_transposed_block_has_rows_for_columns() {
        let mut block: [u64; 64] =
            std::array::from_fn(|r| (r as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(7));
        let before = block;
        transpose(&mut block);
        for (r, row) in before.iter().enumerate() {
            for (c, column) in block.iter().enumerate() {
                assert_eq!(row >> c & 1, column >> r & 1);
            }
        }
    }
}
