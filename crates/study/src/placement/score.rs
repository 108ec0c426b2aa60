//! Scores of candidates: the share of the wanted receivers that each sees, by number or by weight.

use std::cmp::Ordering;
use std::sync::atomic;

use rayon::prelude::*;

use crate::coverage::{Control, Mapper, Seen, Uav};
use crate::error::Result;
use crate::raster::BitGrid;

/// Weights of cells, as multiples of a power of two. So sums are exact in any order.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Weights {
    n_cols: usize,
    of_cells: Vec<u128>,
}

/// Most binary digits of a weight: sums over 2^32 cells and 2^6 levels fit 128 bits.
const MOST_DIGITS: i32 = 88;

impl Weights {
    /// Bytes that the weight of a cell takes.
    pub const BYTES_PER_CELL: usize = 16;

    /// Makes weights of the cells of a grid with `n_cols` columns, row by row: finite and not
    /// negative. They count multiples of 1, or of the largest power of two below 1 that divides
    /// them all. Weights below 2^-35 of the largest may be rounded to 2^-87 of it. `None` if all
    /// weights are 0.
    pub fn new(weights: &[f64], n_cols: usize) -> Option<Self> {
        let parts = || weights.iter().filter(|w| **w > 0.0).map(|w| mantissa_and_exponent(*w));
        let top = parts().map(|(m, e)| e + u64::BITS.cast_signed() - m.leading_zeros().cast_signed()).max()?;
        let divisor = parts().map(|(m, e)| e + m.trailing_zeros().cast_signed()).min()?;
        let unit = divisor.min(0).max(top - MOST_DIGITS);
        let multiples = |w: &f64| {
            let (mantissa, exponent) = mantissa_and_exponent(*w);
            match (u128::from(mantissa), exponent - unit) {
                (mantissa, up @ 0..) => mantissa << up,
                (mantissa, down @ -64..) => (mantissa + (1 << (-down - 1))) >> -down,
                _ => 0,
            }
        };
        Some(Weights { n_cols, of_cells: weights.iter().map(multiples).collect() })
    }

    /// Returns the sum over the cells of a set.
    pub fn sum(&self, cells: &BitGrid) -> u128 {
        let rows = self.of_cells.chunks_exact(self.n_cols).enumerate();
        rows.map(|(row, weights)| weighted_sum(cells.row(row), weights)).sum()
    }

    /// Returns the weight of a cell, cells row by row.
    pub(super) fn of_cell(&self, cell: usize) -> u128 {
        self.of_cells[cell]
    }

    /// Returns the weights of a row of cells.
    pub(super) fn row(&self, row: usize) -> &[u128] {
        &self.of_cells[row * self.n_cols..(row + 1) * self.n_cols]
    }
}

/// Returns a number that is not negative as an integer and a power of two.
fn mantissa_and_exponent(w: f64) -> (u64, i32) {
    let bits = w.to_bits();
    let fraction = bits & ((1 << 52) - 1);
    match i32::try_from(bits >> 52 & 0x7FF).unwrap_or(0) {
        0 => (fraction, -1074),
        biased => (fraction | 1 << 52, biased - 1075),
    }
}

/// Returns the sum of the weights whose bits are set.
pub(super) fn weighted_sum(words: &[u64], weights: &[u128]) -> u128 {
    words.iter().zip(weights.chunks(64)).map(|(word, weights)| word_sum(*word, weights)).sum()
}

/// Returns the sum of up to 64 weights whose bits are set.
#[inline]
pub(super) fn word_sum(word: u64, weights: &[u128]) -> u128 {
    let mut left = word;
    let mut sum = 0;
    while left != 0 {
        sum += weights[left.trailing_zeros() as usize];
        left &= left - 1;
    }
    sum
}

/// Returns the nearest double of `part` / `whole`, for `whole` above 0 and below 2^127.
pub(super) fn quotient(part: u128, whole: u128) -> f64 {
    if part >= whole {
        return 1.0;
    }
    let is_double = |n: u128| n <= 1 << f64::MANTISSA_DIGITS;
    #[expect(clippy::cast_precision_loss, reason = "doubles hold both, and division rounds once")]
    if part == 0 || (is_double(part) && is_double(whole)) {
        return part as f64 / whole as f64;
    }
    // Sixty-four digits by long division; the last one is set if there are more.
    let (mut left, mut digits, mut exponent) = (part, 0_u64, 0);
    while digits.leading_zeros() > 0 {
        left <<= 1;
        let digit = left >= whole;
        left -= if digit { whole } else { 0 };
        digits = digits << 1 | u64::from(digit);
        exponent -= 1;
    }
    #[expect(clippy::cast_precision_loss, reason = "rounded once, to the nearest")]
    let rounded = (digits | u64::from(left > 0)) as f64;
    rounded * 2.0_f64.powi(exponent)
}

/// Compares two quotients with denominators above 0, by continued fractions.
fn compare_quotients(mut a: (u128, u128), mut b: (u128, u128)) -> Ordering {
    loop {
        match ((a.0 / a.1).cmp(&(b.0 / b.1)), a.0 % a.1, b.0 % b.1) {
            (Ordering::Equal, 0, 0) => return Ordering::Equal,
            (Ordering::Equal, 0, _) => return Ordering::Less,
            (Ordering::Equal, _, 0) => return Ordering::Greater,
            // The rests are p/q < r/s if s/r < q/p.
            (Ordering::Equal, of_a, of_b) => (a, b) = ((b.1, of_b), (a.1, of_a)),
            (unequal, ..) => return unequal,
        }
    }
}

/// Wanted receivers, and those in range and seen, by number or by weight.
///
/// Receivers out of range count as not seen. So a place at the border of a scene has no advantage
/// from the few in range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Score {
    /// Number or weight of the wanted receivers, in range or not.
    pub wanted: u128,
    /// Number or weight of these that are in range and in line of sight.
    pub seen: u128,
}

impl Score {
    /// Returns the share seen, as the nearest double; `None` if no receiver is wanted.
    pub fn share(&self) -> Option<f64> {
        (self.wanted > 0).then(|| quotient(self.seen, self.wanted))
    }

    /// Compares two shares exactly; a missing share is below every other.
    pub fn compare(&self, other: &Score) -> Ordering {
        match (self.wanted > 0, other.wanted > 0) {
            (true, true) => match (self.seen.checked_mul(other.wanted), other.seen.checked_mul(self.wanted)) {
                (Some(a), Some(b)) => a.cmp(&b),
                _ => compare_quotients((self.seen, self.wanted), (other.seen, other.wanted)),
            },
            (a, b) => a.cmp(&b),
        }
    }
}

/// Scorer of UAVs: counts or weighs the receivers that they see.
#[derive(Debug, Clone, Copy)]
pub struct Scorer<'a> {
    /// Scene prepared for the wanted receivers.
    pub(super) mapper: &'a Mapper<'a>,
    /// Weight of each receiver; `None` if each counts 1.
    pub(super) weights: Option<&'a Weights>,
    /// Number or weight of all wanted receivers.
    pub(super) wanted: u128,
}

impl<'a> Scorer<'a> {
    /// Makes a scorer over a scene prepared for the wanted receivers; each counts 1, or its weight.
    pub fn new(mapper: &'a Mapper<'a>, weights: Option<&'a Weights>) -> Self {
        let cells = mapper.receiver_cells();
        let wanted = weights.map_or_else(|| cells.count().into(), |weights| weights.sum(&cells));
        Scorer { mapper, weights, wanted }
    }

    /// The score of one UAV.
    ///
    /// # Errors
    /// As [`Mapper::seen_from`].
    pub fn score(&self, uav: &Uav) -> Result<Score> {
        let view = self.mapper.seen_from(uav)?;
        Ok(match self.weights {
            None => Score { wanted: self.wanted, seen: view.count().1.into() },
            Some(_) => self.score_of(&view.seen()),
        })
    }

    /// Returns the score of a map.
    pub(crate) fn score_of(&self, seen: &Seen) -> Score {
        let seen = self.weights.map_or_else(|| seen.los.count().into(), |weights| weights.sum(&seen.los));
        Score { wanted: self.wanted, seen }
    }
}

/// Scores UAVs in their order, each on one thread. Adds 1 to `control.done` for each.
pub fn scores(scorer: &Scorer<'_>, uavs: &[&Uav], control: &Control) -> Result<Vec<Score>> {
    let score = |uav: &&Uav| {
        control.check()?;
        let score = scorer.score(uav)?;
        control.done.fetch_add(1, atomic::Ordering::Relaxed);
        Ok(score)
    };
    uavs.par_iter().map(score).collect()
}

/// Returns the indices of scores, best first, equal ones in their order.
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
        let most = (1_u128 << 126) - 1;
        let scores = [
            score(1, 2),
            score(0, 0),
            score(2, 4),
            score(most - 1, most),
            score(most, most),
            score(most - 2, most - 1),
        ];
        assert_eq!(ranked(&scores), [4, 3, 5, 0, 2, 1]);
        assert_eq!((scores[1].share(), scores[0].share()), (None, Some(0.5)));
    }
}
