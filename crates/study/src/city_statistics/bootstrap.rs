//! Bootstrap for intervals over a real city and for comparisons. It draws clusters with replacement
//! a thousand times and forms ratios of sums anew.
//!
//! Ratios that are estimated together are resampled together: in each drawing a block of ground has
//! the same weight in all of them. So the difference of two maps is resampled as a difference cell
//! by cell. Parts that both maps share do not widen its interval.
//!
//! Maps are exact, so over the ground that they show P_LoS has no error. The interval measures how
//! far P_LoS would move over other ground of the same kind. It treats the blocks as a sample of a
//! larger city, seen by UAVs in the same relative positions. It covers neither errors of the
//! heights in the file nor other positions of the UAV. Where obstacles hide ground beyond a
//! neighboring block, blocks are not independent and the interval is somewhat too narrow. Larger
//! blocks show by how much.
//!
//! # References
//! Efron & Tibshirani 1993, "An Introduction to the Bootstrap", chapters 8 and 13 (blocks,
//! percentile intervals).

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rayon::prelude::*;

use crate::los_probability::estimate::FEWEST_CLUSTERS;

/// Number of resamplings behind an interval.
pub const RESAMPLINGS: u64 = 1000;

/// Random numbers of one resampling. Its own stream makes it independent of the order of work.
pub(crate) struct Drawing(ChaCha8Rng);

impl Drawing {
    /// Returns the `k`th resampling of a seed.
    pub(crate) fn nth(seed: u64, k: u64) -> Self {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(k);
        Drawing(random)
    }

    /// Returns how often each of `n` clusters occurs in `n` draws with replacement.
    pub(crate) fn times(&mut self, n: usize) -> Vec<f64> {
        let mut times = vec![0.0; n];
        for _ in 0..n {
            #[expect(clippy::cast_possible_truncation, reason = "below n")]
            let drawn = ((u128::from(self.0.next_u64()) * n as u128) >> 64) as usize;
            times[drawn] += 1.0;
        }
        times
    }
}

/// Spread of a value over its resamplings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Spread {
    /// Percentile interval, widened to contain the value.
    pub(crate) interval: (f64, f64),
    pub(crate) std_error: f64,
}

/// Returns the spread of a ratio over resampled numerators and denominators. `None` if more than
/// one in a hundred resamplings has no denominator, because too few clusters contribute.
pub(crate) fn spread(value: f64, resampled: impl Iterator<Item = (f64, f64)>, confidence: f64) -> Option<Spread> {
    let mut ratios: Vec<f64> = resampled.filter(|r| r.1 > 0.0).map(|r| r.0 / r.1).collect();
    ratios.sort_by(f64::total_cmp);
    let n = ratios.len() as f64;
    if ratios.is_empty() || n < 0.99 * RESAMPLINGS as f64 {
        return None;
    }
    let quantile = |p: f64| {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "an index of `ratios`")]
        let k = (p * (n - 1.0)).round() as usize;
        ratios[k]
    };
    let tail = 0.5 * (1.0 - confidence);
    let mean = ratios.iter().sum::<f64>() / n;
    let std_error = (ratios.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
    Some(Spread { interval: (quantile(tail).min(value), quantile(1.0 - tail).max(value)), std_error })
}

/// Contribution of one block to a ratio of sums.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Share {
    /// Term of the numerator; may be negative if the ratio is a difference.
    pub part: i64,
    /// Term of the denominator.
    pub whole: u64,
}

/// A ratio of sums over blocks, with its interval.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RatioEstimate {
    /// Σ part / Σ whole; `None` if nothing was counted.
    pub value: Option<f64>,
    /// Interval of the value; `None` if too few blocks contribute.
    pub interval: Option<(f64, f64)>,
    /// Number of blocks that contribute.
    pub blocks: u64,
}

impl RatioEstimate {
    /// Returns `true` if the interval excludes 0; `None` without an interval.
    pub fn exceeds(&self) -> Option<bool> {
        self.interval.map(|(low, high)| low > 0.0 || high < 0.0)
    }
}

/// Estimates ratios of sums over blocks, `[ratio][block]`, all resampled together.
///
/// Blocks without any denominator, such as those under one large building, are not part of the
/// sample. An interval needs ten blocks or more.
///
/// Cost: a thousand times the number of blocks and ratios, shared by all threads. The result does
/// not depend on their number.
pub fn resampled_ratios(ratios: &[Vec<Share>], confidence: f64, seed: u64) -> Vec<RatioEstimate> {
    let n_blocks = ratios.first().map_or(0, Vec::len);
    let blocks: Vec<usize> = (0..n_blocks).filter(|b| ratios.iter().any(|r| r[*b].whole > 0)).collect();
    // Block by block, so that a drawn block adds one row. Counts below 2^53 need no rounding.
    let terms: Vec<f64> =
        blocks.iter().flat_map(|b| ratios.iter().flat_map(move |r| [r[*b].part as f64, r[*b].whole as f64])).collect();
    let n_terms = 2 * ratios.len();
    let is_enough = blocks.len() as u64 >= FEWEST_CLUSTERS;
    let resamplings: Vec<Vec<f64>> = (0..if is_enough { RESAMPLINGS } else { 0 })
        .into_par_iter()
        .map(|k| {
            let mut sums = vec![0.0; n_terms];
            let times = Drawing::nth(seed, k).times(blocks.len());
            for (weight, terms) in times.iter().zip(terms.chunks_exact(n_terms)).filter(|(weight, _)| **weight > 0.0) {
                sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += weight * term);
            }
            sums
        })
        .collect();
    let estimate = |(k, shares): (usize, &Vec<Share>)| {
        let (part, whole) = shares.iter().fold((0, 0), |sum, s| (sum.0 + s.part, sum.1 + s.whole));
        let bearing = shares.iter().filter(|s| s.whole > 0).count() as u64;
        let value = (whole > 0).then(|| part as f64 / whole as f64);
        let resampled = resamplings.iter().map(|sums| (sums[2 * k], sums[2 * k + 1]));
        let spread =
            value.filter(|_| bearing >= FEWEST_CLUSTERS).and_then(|value| spread(value, resampled, confidence));
        RatioEstimate { value, interval: spread.map(|s| s.interval), blocks: bearing }
    };
    ratios.par_iter().enumerate().map(estimate).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shares(parts: impl IntoIterator<Item = i64>) -> Vec<Share> {
        parts.into_iter().map(|part| Share { part, whole: 10 }).collect()
    }

    #[test]
    fn what_is_alike_in_all_blocks_has_no_spread() {
        let [alike, none] =
            resampled_ratios(&[shares([4; 30]), shares([0; 30])], 0.95, 1).try_into().expect("two ratios");
        assert_eq!((alike.value, alike.interval, alike.blocks), (Some(0.4), Some((0.4, 0.4)), 30));
        assert_eq!((none.interval, none.exceeds()), (Some((0.0, 0.0)), Some(false)));
        assert_eq!(alike.exceeds(), Some(true));
    }

    #[test]
    fn few_blocks_have_a_value_and_no_interval() {
        let nine = resampled_ratios(&[shares(0..9)], 0.95, 1)[0];
        assert_eq!((nine.value, nine.interval, nine.exceeds()), (Some(0.4), None, None));
        let ten = resampled_ratios(&[shares(0..10)], 0.95, 1)[0];
        assert!(ten.interval.is_some_and(|(low, high)| low < 0.45 && high > 0.45));
        // Ten blocks of another ratio do not help.
        let mut few = vec![Share::default(); 20];
        few[3] = Share { part: 1, whole: 2 };
        let both = resampled_ratios(&[shares(0..20), few], 0.95, 1);
        assert_eq!((both[1].value, both[1].interval, both[1].blocks), (Some(0.5), None, 1));
        assert_eq!(resampled_ratios(&[vec![Share::default(); 20]], 0.95, 1)[0].value, None);
    }

    #[test]
    fn a_difference_is_resampled_as_a_difference() {
        // Blocks differ much, but the second map sees one receiver more in each of them.
        let (a, b): (Vec<i64>, Vec<i64>) = ((0..50).map(|k| k % 9).collect(), (0..50).map(|k| k % 9 + 1).collect());
        let difference = shares(a.iter().zip(&b).map(|(a, b)| b - a));
        let all = resampled_ratios(&[shares(a), shares(b), difference], 0.95, 7);
        let width = |r: &RatioEstimate| r.interval.map_or(f64::NAN, |(low, high)| high - low);
        assert!(width(&all[0]) > 0.1 && width(&all[1]) > 0.1);
        assert_eq!(all[2].interval, Some((0.1, 0.1)));
    }
}
