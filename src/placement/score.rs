//! What a candidate is worth: the share of the wanted receivers that it sees, by number or by weight.

use std::cmp::Ordering;
use std::sync::atomic;

use rayon::prelude::*;

use crate::coverage::{Control, Mapper, Seen, Uav, interrupted};
use crate::error::Result;
use crate::raster::BitGrid;

/// What each cell counts, as integers: so sums are exact in any order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Weights {
    n_cols: usize,
    of_cells: Vec<u32>,
}

/// The largest weight: sums over 2^32 cells and 2^6 levels fit 64 bits.
const LARGEST: f64 = 16_777_216.0;

impl Weights {
    /// Weights of the cells of a grid with `n_cols` columns, row by row: finite and not negative. They are rounded to
    /// 1/2^24 of the largest; `None` if all are 0.
    pub fn new(weights: &[f64], n_cols: usize) -> Option<Self> {
        let largest = weights.iter().copied().fold(0.0, f64::max);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 2^24 after the quotient")]
        let integer = |w: &f64| (w / largest * LARGEST + 0.5).floor() as u32;
        (largest > 0.0).then(|| Weights { n_cols, of_cells: weights.iter().map(integer).collect() })
    }

    /// The sum over the cells of a set.
    pub fn sum(&self, cells: &BitGrid) -> u64 {
        let rows = self.of_cells.chunks_exact(self.n_cols).enumerate();
        rows.map(|(row, weights)| weighted_sum(cells.row(row), weights)).sum()
    }

    /// The weight of a cell, cells row by row.
    pub(super) fn of_cell(&self, cell: usize) -> u32 {
        self.of_cells[cell]
    }

    /// The weights of a row of cells.
    pub(super) fn row(&self, row: usize) -> &[u32] {
        &self.of_cells[row * self.n_cols..(row + 1) * self.n_cols]
    }
}

/// The sum of the weights whose bits are set.
pub(super) fn weighted_sum(words: &[u64], weights: &[u32]) -> u64 {
    words.iter().zip(weights.chunks(64)).map(|(word, weights)| word_sum(*word, weights)).sum()
}

/// The sum of up to 64 weights whose bits are set.
#[inline]
pub(super) fn word_sum(word: u64, weights: &[u32]) -> u64 {
    let mut left = word;
    let mut sum = 0;
    while left != 0 {
        sum += u64::from(weights[left.trailing_zeros() as usize]);
        left &= left - 1;
    }
    sum
}

/// All wanted receivers and what of them is in range and seen, in numbers or in weights.
///
/// Receivers out of range count as not seen: a place at the border of a scene, with few in range, gains nothing by that.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Score {
    /// Wanted receivers, in range or not, or their weight.
    pub wanted: u64,
    /// Of these, in range and in line of sight.
    pub seen: u64,
}

impl Score {
    /// The share seen; `None` where nothing is wanted.
    #[expect(clippy::cast_precision_loss, reason = "a share for reading; scores are compared as integers")]
    pub fn share(&self) -> Option<f64> {
        (self.wanted > 0).then(|| self.seen as f64 / self.wanted as f64)
    }

    /// The order of two shares, exact; no share is below every other.
    pub fn compare(&self, other: &Score) -> Ordering {
        match (self.wanted > 0, other.wanted > 0) {
            (true, true) => {
                let product = |a: u64, b: u64| u128::from(a) * u128::from(b);
                product(self.seen, other.wanted).cmp(&product(other.seen, self.wanted))
            }
            (a, b) => a.cmp(&b),
        }
    }
}

/// Counts or weighs what UAVs see.
#[derive(Debug, Clone, Copy)]
pub struct Scorer<'a> {
    /// The scene, made ready for the wanted receivers.
    pub(super) mapper: &'a Mapper<'a>,
    /// What each receiver counts; 1 without.
    pub(super) weights: Option<&'a Weights>,
    /// All wanted receivers, or their weight.
    pub(super) wanted: u64,
}

impl<'a> Scorer<'a> {
    /// Scores over a scene that was made ready for the wanted receivers; each counts 1, or its weight.
    pub fn new(mapper: &'a Mapper<'a>, weights: Option<&'a Weights>) -> Self {
        let cells = mapper.receiver_cells();
        let wanted = weights.map_or_else(|| cells.count(), |weights| weights.sum(&cells));
        Scorer { mapper, weights, wanted }
    }

    /// The score of one UAV.
    pub fn score(&self, uav: &Uav) -> Score {
        match self.weights {
            None => Score { wanted: self.wanted, seen: self.mapper.count(uav).1 },
            Some(_) => self.score_of(&self.mapper.seen(uav)),
        }
    }

    /// The score of what a UAV sees.
    pub fn score_of(&self, seen: &Seen) -> Score {
        let seen = self.weights.map_or_else(|| seen.los.count(), |weights| weights.sum(&seen.los));
        Score { wanted: self.wanted, seen }
    }
}

/// The scores of some UAVs, in their order; each is worked on by one thread. Adds 1 to `control.done` for each.
///
/// # Errors
/// Only [`crate::error::ErrorClass::Interrupted`], when `control.stop` was set.
pub fn scores(scorer: &Scorer<'_>, uavs: &[&Uav], control: &Control) -> Result<Vec<Score>> {
    let score = |uav: &&Uav| {
        if control.stop.load(atomic::Ordering::Relaxed) {
            return Err(interrupted());
        }
        let score = scorer.score(uav);
        control.done.fetch_add(1, atomic::Ordering::Relaxed);
        Ok(score)
    };
    uavs.par_iter().map(score).collect()
}

/// The indices of scores, best first, equal ones in their order.
pub fn ranked(scores: &[Score]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..scores.len()).collect();
    order.sort_by(|a, b| scores[*b].compare(&scores[*a]));
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_compared_as_products_and_ties_keep_their_order() {
        let score = |seen, wanted| Score { wanted, seen };
        let scores = [score(1, 2), score(0, 0), score(2, 4), score(u64::MAX - 1, u64::MAX), score(u64::MAX, u64::MAX)];
        assert_eq!(ranked(&scores), [4, 3, 0, 2, 1]);
        assert_eq!((scores[1].share(), scores[0].share()), (None, Some(0.5)));
    }

    #[test]
    fn weights_sum_over_sets_across_words() {
        let mut of_cells = vec![0.0; 140];
        (of_cells[0], of_cells[69], of_cells[139]) = (1.0, 0.5, 2.0);
        let weights = Weights::new(&of_cells, 70).expect("some are above 0");
        let mut cells = BitGrid::full(2, 70);
        let unit = 1 << 23;
        assert_eq!(weights.sum(&cells), unit + unit / 2 + 2 * unit);
        cells.words_mut()[0] &= !1;
        assert_eq!(weights.sum(&cells), unit / 2 + 2 * unit);
        assert_eq!(Weights::new(&[0.0; 4], 2), None);
    }
}
