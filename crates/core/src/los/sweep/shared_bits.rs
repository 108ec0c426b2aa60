//! Bits of a sweep, written by several threads row by row; those of columns are turned into rows strip by strip.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

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

    /// The bits as a set of cells, of `n_cols` to a line.
    pub(super) fn into_grid(self, n_cols: usize) -> BitGrid {
        BitGrid::from_words(n_cols, self.words.into_iter().map(AtomicU64::into_inner).collect())
    }
}

/// Bits of a strip of 64 columns, written by one thread column by column.
pub(super) struct StripBits {
    /// Of each column 64 rows to a word, all columns of the same rows together.
    blocks: Vec<[u64; 64]>,
    /// The blocks that may hold bits.
    used: Range<usize>,
}

impl StripBits {
    /// None of them set.
    pub(super) fn new(n_rows: usize) -> Self {
        StripBits { blocks: vec![[0; 64]; n_rows.div_ceil(64)], used: 0..0 }
    }

    /// Makes room for bits of the rows `rows` alone, once those before have been moved.
    pub(super) fn begin(&mut self, rows: &Range<usize>) {
        self.used = rows.start / 64..rows.end.div_ceil(64);
    }

    /// Adds bits to word `word` of a column of the strip.
    #[inline]
    pub(super) fn add(&mut self, column: usize, word: usize, bits: u64) {
        debug_assert!(bits == 0 || self.used.contains(&word));
        self.blocks[word][column] |= bits;
    }

    /// Moves all bits to `rows`, of which the strip is word `word`.
    pub(super) fn move_to(&mut self, rows: &SharedBits, word: usize) {
        let used = self.used.clone();
        for (band, block) in used.clone().zip(&mut self.blocks[used]) {
            if block.iter().fold(0, |any, bits| any | bits) == 0 {
                continue;
            }
            transpose(block);
            for (k, bits) in block.iter_mut().enumerate() {
                if *bits != 0 {
                    rows.add(64 * band + k, word, std::mem::take(bits), true);
                }
            }
        }
    }
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
