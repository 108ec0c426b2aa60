//! Output of a sweep: bits of receivers in line of sight and, on request, least heights. All wedges
//! write them at once, row by row. Bits of columns are turned into rows, 64 columns at a time.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use super::frame::Frame;
use super::simd::STRIP;
use crate::raster::BitGrid;

/// The results of a sweep.
pub(super) struct Output<'a> {
    /// The requested receivers; `is_all` is `true` if they are all cells.
    pub(super) wanted: &'a BitGrid,
    is_all: bool,
    los: Bits,
    /// Least heights \[1/1024 m above the datum\], as bits of doubles.
    pub(super) heights: Option<Vec<AtomicU64>>,
    pub(super) undecided: AtomicU64,
}

impl<'a> Output<'a> {
    pub(super) fn new(wanted: &'a BitGrid, with_heights: bool) -> Self {
        let n_cells = wanted.n_rows() * wanted.n_cols();
        let unknown = || AtomicU64::new(f64::NEG_INFINITY.to_bits());
        Output {
            wanted,
            is_all: wanted.count() == n_cells as u64,
            los: Bits::new(wanted.n_rows(), wanted.n_cols()),
            heights: with_heights.then(|| (0..n_cells).map(|_| unknown()).collect()),
            undecided: AtomicU64::new(0),
        }
    }

    /// Returns the bins of the first level of a quadrant that hold a requested receiver.
    pub(super) fn wanted_bins(&self, frame: &Frame) -> u32 {
        if self.is_all { u32::MAX } else { frame.wanted_bins(self.wanted) }
    }

    /// Adds a receiver in line of sight.
    pub(super) fn add(&self, row: usize, col: usize) {
        self.los.add(row, col / 64, 1 << (col % 64), true);
    }

    /// Sets the least height of a cell.
    #[inline(always)]
    pub(super) fn set_height(&self, row: usize, col: usize, height: f64) {
        if let Some(heights) = &self.heights {
            heights[row * self.wanted.n_cols() + col].store(height.to_bits(), Ordering::Relaxed);
        }
    }

    /// Returns the wanted receivers in line of sight, the number that the bounds left undecided,
    /// and the least heights.
    pub(super) fn into_parts(self) -> (BitGrid, u64, Option<Vec<f64>>) {
        let words = self.los.words.into_iter().map(AtomicU64::into_inner).collect();
        let los = BitGrid::from_words(self.wanted.n_cols(), words);
        let los = if self.is_all { los } else { los.and(self.wanted) };
        let heights = self.heights.map(|h| h.into_iter().map(|h| f64::from_bits(h.into_inner())).collect());
        (los, self.undecided.into_inner(), heights)
    }
}

/// Bits that several threads write, one row after another.
struct Bits {
    words: Vec<AtomicU64>,
    per_row: usize,
}

impl Bits {
    fn new(n_rows: usize, n_cols: usize) -> Self {
        let per_row = n_cols.div_ceil(64);
        let mut words = Vec::with_capacity(n_rows * per_row);
        words.resize_with(n_rows * per_row, || AtomicU64::new(0));
        Bits { words, per_row }
    }

    /// Adds bits to a word, which other threads may write at the same time if it is shared.
    #[inline]
    fn add(&self, row: usize, word: usize, bits: u64, is_shared: bool) {
        let word = &self.words[row * self.per_row + word];
        match (bits, is_shared) {
            (0, _) => {}
            (_, true) => {
                word.fetch_or(bits, Ordering::Relaxed);
            }
            // PERF: without a locked operation, behind which all other reads and writes would wait.
            (_, false) => word.store(word.load(Ordering::Relaxed) | bits, Ordering::Relaxed),
        }
    }
}

/// The results of one wedge of a quadrant.
pub(super) struct WedgeOutput<'a, 'w> {
    pub(super) output: &'a Output<'w>,
    /// For 64 columns, words of 64 raster rows, all columns of the same rows together. Empty if
    /// rows are rows of the raster.
    blocks: Vec<[u64; STRIP]>,
    /// The number of the strip of those columns, and the blocks that may hold bits.
    strip: usize,
    used: Range<usize>,
    pub(super) undecided: u64,
}

impl<'a, 'w> WedgeOutput<'a, 'w> {
    pub(super) fn new(output: &'a Output<'w>, frame: &Frame) -> Self {
        let n_blocks = if frame.quadrant.has_raster_rows() { 0 } else { frame.shape.0.div_ceil(64) };
        WedgeOutput { output, blocks: vec![[0; STRIP]; n_blocks], strip: 0, used: 0..0, undecided: 0 }
    }

    /// Adds receivers in line of sight to a word of a row. A shared word may hold receivers of
    /// another wedge.
    #[inline(always)]
    pub(super) fn add(&mut self, frame: &Frame, row: usize, word: usize, bits: u64, is_shared: bool) {
        let line = frame.line(row);
        if frame.quadrant.has_raster_rows() {
            self.output.los.add(line, word, bits, is_shared);
        } else if bits != 0 {
            if self.strip != line / STRIP {
                self.flush();
                self.strip = line / STRIP;
            }
            self.used = if self.used.is_empty() {
                word..word + 1
            } else {
                self.used.start.min(word)..self.used.end.max(word + 1)
            };
            self.blocks[word][line % STRIP] |= bits;
        }
    }

    /// Returns the requested receivers among those of a word of a row.
    #[inline(always)]
    pub(super) fn wanted(&self, frame: &Frame, row: usize, word: usize, bits: u64) -> u64 {
        let (wanted, line) = (self.output.wanted, frame.line(row));
        if self.output.is_all || bits == 0 {
            return bits;
        }
        if frame.quadrant.has_raster_rows() {
            return bits & wanted.row(line)[word];
        }
        // PERF: along a column each requested bit is in a cache line of its own.
        let (mut left, mut found) = (bits, 0);
        while left != 0 {
            let bit = left.trailing_zeros();
            left &= left - 1;
            found |= u64::from(wanted.contains(64 * word + bit as usize, line)) << bit;
        }
        found
    }

    /// Moves the bits of columns to their rows.
    pub(super) fn flush(&mut self) {
        let used = std::mem::take(&mut self.used);
        for (band, block) in used.clone().zip(&mut self.blocks[used]) {
            if block.iter().fold(0, |any, bits| any | bits) == 0 {
                continue;
            }
            transpose(block);
            for (k, bits) in block.iter_mut().enumerate() {
                if *bits != 0 {
                    self.output.los.add(64 * band + k, self.strip, std::mem::take(bits), true);
                }
            }
        }
        self.output.undecided.fetch_add(std::mem::take(&mut self.undecided), Ordering::Relaxed);
    }
}

/// Transposes a block of bits: bit `c` of word `r` becomes bit `r` of word `c` (Warren, Hacker's
/// Delight, 7-3).
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
