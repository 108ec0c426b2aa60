//! Sets of cells as bits, 64 cells to a word, combined and counted word by word.

use std::borrow::Cow;
use std::ops::Range;

use fearless_simd::Simd;

use super::CellWindow;
use crate::dispatch;
use crate::simd::SimdLevel;

/// A set of cells of a grid of shape `[n_rows, n_cols]`, row 0 north.
///
/// Bit `col % 64` of word `col / 64` of a row is cell `col`. Bits beyond the last column are 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BitGrid {
    n_rows: usize,
    n_cols: usize,
    words_per_row: usize,
    words: Vec<u64>,
}

impl BitGrid {
    /// Returns the empty set.
    pub fn new(n_rows: usize, n_cols: usize) -> Self {
        let words_per_row = n_cols.div_ceil(64);
        BitGrid { n_rows, n_cols, words_per_row, words: vec![0; n_rows * words_per_row] }
    }

    /// Makes a set from its words, row by row from the north. Bits beyond the last column must be
    /// 0.
    ///
    /// # Panics
    /// If the words are not whole rows, or if there are no columns.
    pub fn from_words(n_cols: usize, words: Vec<u64>) -> Self {
        let words_per_row = n_cols.div_ceil(64);
        assert!(words_per_row > 0 && words.len().is_multiple_of(words_per_row), "whole rows");
        BitGrid { n_rows: words.len() / words_per_row, n_cols, words_per_row, words }
    }

    /// Returns the set of all cells.
    pub fn full(n_rows: usize, n_cols: usize) -> Self {
        let mut all = BitGrid::new(n_rows, n_cols);
        all.words.fill(u64::MAX);
        if !n_cols.is_multiple_of(64) {
            let last = (1 << (n_cols % 64)) - 1;
            all.words.chunks_mut(all.words_per_row).for_each(|row| row[row.len() - 1] = last);
        }
        all
    }

    /// Returns the cells of a window, as a set with the window's shape.
    #[must_use]
    pub(crate) fn part(&self, window: CellWindow) -> Self {
        let mut part = BitGrid::new(window.n_rows, window.n_cols);
        let (first, shift) = (window.col / 64, window.col % 64);
        for row in 0..window.n_rows {
            let of_whole = self.row(window.row + row);
            for k in 0..part.words_per_row {
                let word = |at: usize| of_whole.get(first + k + at).copied().unwrap_or(0);
                let joined = if shift == 0 { word(0) } else { word(0) >> shift | word(1) << (64 - shift) };
                part.words[row * part.words_per_row + k] = joined & bits_between(0, window.n_cols, k);
            }
        }
        part
    }

    /// Returns the set of all cells of a window, in a grid of this shape.
    pub(crate) fn of_window((n_rows, n_cols): (usize, usize), window: CellWindow) -> Self {
        let mut cells = BitGrid::new(n_rows, n_cols);
        let (from, to) = (window.col, window.col + window.n_cols);
        for row in window.row..window.row + window.n_rows {
            for k in from / 64..to.div_ceil(64) {
                cells.words[row * cells.words_per_row + k] = bits_between(from, to, k);
            }
        }
        cells
    }

    /// Returns the cells in some rows; other rows are empty.
    ///
    /// PERF: memory of the other rows is not touched, so the kernel need not provide it.
    #[must_use]
    pub(crate) fn in_rows(&self, rows: Range<usize>) -> Self {
        let mut kept = BitGrid::new(self.n_rows, self.n_cols);
        let words = rows.start * self.words_per_row..rows.end * self.words_per_row;
        kept.words[words.clone()].copy_from_slice(&self.words[words]);
        kept
    }

    /// Returns the number of corners of the outlines of the set within the grid. Where two cells
    /// touch at a corner alone there are two.
    pub(crate) fn n_corners(&self) -> u64 {
        let last = self.n_cols.saturating_sub(1);
        let between = |row: usize| -> u64 {
            let (above, below) = (self.row(row - 1), self.row(row));
            // Each cell beside the next; the last of a row has none.
            let next = |row: &[u64], k: usize| row[k] >> 1 | row.get(k + 1).map_or(0, |word| word << 63);
            let of_word = |k: usize| {
                let (a, b, c, d) = (above[k], next(above, k), below[k], next(below, k));
                let (one, two) = (a ^ b ^ c ^ d, !(a ^ d) & !(b ^ c) & (a ^ b));
                let ones = |word: u64| u64::from((word & bits_between(0, last, k)).count_ones());
                ones(one) + 2 * ones(two)
            };
            (0..above.len()).map(of_word).sum()
        };
        (1..self.n_rows).map(between).sum()
    }

    /// Returns the number of rows.
    #[inline]
    pub fn n_rows(&self) -> usize {
        self.n_rows
    }

    /// Returns the number of columns.
    #[inline]
    pub fn n_cols(&self) -> usize {
        self.n_cols
    }

    /// Returns the number of words that hold one row.
    #[inline]
    pub fn words_per_row(&self) -> usize {
        self.words_per_row
    }

    /// Returns the words of a row.
    #[inline]
    pub fn row(&self, row: usize) -> &[u64] {
        &self.words[row * self.words_per_row..(row + 1) * self.words_per_row]
    }

    /// Returns all words, row by row: `words_per_row` each.
    #[inline]
    pub fn words(&self) -> &[u64] {
        &self.words
    }

    /// Returns all words, row by row, for writing. Bits beyond the last column must stay 0.
    pub fn words_mut(&mut self) -> &mut [u64] {
        &mut self.words
    }

    /// Returns the first and the last column in `cols` whose cell of this row is in the set.
    pub(crate) fn ends_of_row(&self, row: usize, cols: Range<usize>) -> Option<(usize, usize)> {
        let words = self.row(row);
        let mut within =
            (cols.start / 64..cols.end.div_ceil(64)).map(|k| (k, words[k] & bits_between(cols.start, cols.end, k)));
        let is_used = |(_, word): &(usize, u64)| *word != 0;
        let (first, word) = within.clone().find(is_used)?;
        let (last, last_word) = within.rfind(is_used)?;
        Some((64 * first + word.trailing_zeros() as usize, 64 * last + 63 - last_word.leading_zeros() as usize))
    }

    /// Returns `true` if a cell is in the set.
    #[inline]
    pub fn contains(&self, row: usize, col: usize) -> bool {
        self.words[row * self.words_per_row + col / 64] >> (col % 64) & 1 == 1
    }

    /// Adds a cell to the set.
    #[inline]
    pub fn insert(&mut self, row: usize, col: usize) {
        self.words[row * self.words_per_row + col / 64] |= 1 << (col % 64);
    }

    /// Adds a cell to the set, or removes it.
    #[inline]
    pub fn set(&mut self, row: usize, col: usize, is_in: bool) {
        let word = &mut self.words[row * self.words_per_row + col / 64];
        *word = *word & !(1 << (col % 64)) | u64::from(is_in) << (col % 64);
    }

    /// Returns the cells that are in both sets. Both must have one shape.
    #[must_use]
    pub fn and(mut self, other: &BitGrid) -> Self {
        assert_eq!((self.n_rows, self.n_cols), (other.n_rows, other.n_cols), "sets of one shape");
        self.words.iter_mut().zip(&other.words).for_each(|(a, b)| *a &= b);
        self
    }

    /// Returns the cells that are in either set. Both must have one shape.
    #[must_use]
    pub fn or(mut self, other: &BitGrid) -> Self {
        assert_eq!((self.n_rows, self.n_cols), (other.n_rows, other.n_cols), "sets of one shape");
        self.words.iter_mut().zip(&other.words).for_each(|(a, b)| *a |= b);
        self
    }

    /// Returns the cells that are in exactly one of the sets. Both must have one shape.
    #[must_use]
    pub fn xor(mut self, other: &BitGrid) -> Self {
        assert_eq!((self.n_rows, self.n_cols), (other.n_rows, other.n_cols), "sets of one shape");
        self.words.iter_mut().zip(&other.words).for_each(|(a, b)| *a ^= b);
        self
    }

    /// Returns the cells that are not in the set.
    #[must_use]
    pub(crate) fn complement(&self) -> Self {
        BitGrid::full(self.n_rows, self.n_cols).xor(self)
    }

    /// Iterates over rows and columns of the cells in the set, row by row from the north-west.
    pub fn cells(&self) -> impl Iterator<Item = (usize, usize)> {
        (0..self.n_rows).flat_map(|row| set_bits(self.row(row)).map(move |col| (row, col)))
    }

    /// Returns the number of cells in both this set and `other`, which has the same shape.
    pub fn count_in(&self, other: &BitGrid) -> u64 {
        n_common(&self.words, &other.words)
    }

    /// Returns the number of cells in the set.
    pub fn count(&self) -> u64 {
        self.words.iter().map(|w| u64::from(w.count_ones())).sum()
    }
}

/// Returns the number of bits that are set in both slices.
pub fn n_common(a: &[u64], b: &[u64]) -> u64 {
    dispatch!(SimdLevel::new(), simd => n_common_of(simd, a, b))
}

#[inline(always)]
fn n_common_of<S: Simd>(_: S, a: &[u64], b: &[u64]) -> u64 {
    let mut n = 0;
    for (a, b) in a.iter().zip(b) {
        n += u64::from((a & b).count_ones());
    }
    n
}

impl From<BitGrid> for Cow<'_, BitGrid> {
    fn from(cells: BitGrid) -> Self {
        Cow::Owned(cells)
    }
}

impl<'a> From<&'a BitGrid> for Cow<'a, BitGrid> {
    fn from(cells: &'a BitGrid) -> Self {
        Cow::Borrowed(cells)
    }
}

/// Iterates over the columns of a row's cells in the set, west to east.
pub fn set_bits(words: &[u64]) -> impl Iterator<Item = usize> {
    words.iter().enumerate().flat_map(|(k, word)| {
        let mut left = *word;
        std::iter::from_fn(move || {
            let bit = (left != 0).then(|| left.trailing_zeros() as usize)?;
            left &= left - 1;
            Some(64 * k + bit)
        })
    })
}

/// Returns the bits of word `word` whose columns lie in `from..to`.
#[inline]
pub(crate) fn bits_between(from: usize, to: usize, word: usize) -> u64 {
    let below = |col: usize| match col.saturating_sub(64 * word) {
        n if n >= 64 => u64::MAX,
        n => (1 << n) - 1,
    };
    below(to) & !below(from)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_between_cover_words_and_their_ends() {
        assert_eq!(bits_between(0, 64, 0), u64::MAX);
        assert_eq!(bits_between(3, 5, 0), 0b11000);
        assert_eq!(bits_between(3, 5, 1), 0);
        assert_eq!(bits_between(60, 70, 1), 0b11_1111);
        assert_eq!(bits_between(7, 7, 0), 0);
    }

    #[test]
    fn corners_are_counted_within_words_and_between_them() {
        for n_cols in [1, 63, 64, 65, 130] {
            let mut cells = BitGrid::new(7, n_cols);
            (0..7 * n_cols).filter(|k| k * k % 11 < 4).for_each(|k| cells.insert(k / n_cols, k % n_cols));
            let corners = (1..7).flat_map(|row| (1..n_cols).map(move |col| (row, col)));
            let of_corner = |(row, col): (usize, usize)| {
                let around = [(row - 1, col - 1), (row - 1, col), (row, col - 1), (row, col)];
                match around.map(|(row, col)| cells.contains(row, col)) {
                    [true, false, false, true] | [false, true, true, false] => 2,
                    of => u64::from(of.iter().filter(|is_in| **is_in).count() % 2 == 1),
                }
            };
            assert_eq!(cells.n_corners(), corners.map(of_corner).sum::<u64>(), "{n_cols} columns");
        }
    }

    #[test]
    fn a_part_holds_the_cells_of_its_window() {
        let mut whole = BitGrid::new(5, 200);
        (0..1000).filter(|k| k % 7 < 3).for_each(|k| whole.insert(k / 200, k % 200));
        for (col, n_cols) in [(0, 200), (64, 64), (1, 130), (63, 66), (130, 70), (199, 1)] {
            let window = CellWindow { row: 1, col, n_rows: 3, n_cols };
            let part = whole.part(window);
            let wanted: Vec<(usize, usize)> = (0..3)
                .flat_map(|row| (0..n_cols).map(move |k| (row, k)))
                .filter(|(row, k)| whole.contains(row + 1, col + k))
                .collect();
            assert_eq!(part.cells().collect::<Vec<_>>(), wanted, "{n_cols} columns from {col}");
            let of_window = BitGrid::of_window((5, 200), window);
            assert_eq!(of_window.count(), 3 * n_cols as u64);
            assert_eq!(whole.clone().and(&of_window).count(), wanted.len() as u64);
        }
    }
}
