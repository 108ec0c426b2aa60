//! Counts of masks by block and zone, and their resampling.

use rayon::prelude::*;

use super::facts::{GroupDifference, GroupShare, IntervalFacts, MarginFacts, N_GROUPS};
use crate::city_statistics::bootstrap::{RatioEstimate, Share, resampled_ratios};
use crate::coverage::{CellGroups, MarginSample, MarginStats, PairCounts, count_pairs};
use crate::zones::N_CODES;

/// Values of placements and of pairs of them, by group.
#[derive(Debug)]
pub(super) struct Tables {
    /// Values by placement.
    pub(super) shares: Vec<[GroupShare; N_GROUPS]>,
    /// Values by pair, in the order of [`pairs_of`].
    pub(super) differences: Vec<[GroupDifference; N_GROUPS]>,
}

/// Returns all pairs of `n` placements, the first always before the second.
pub(super) fn pairs_of(n: usize) -> Vec<(usize, usize)> {
    (0..n).flat_map(|first| (first + 1..n).map(move |second| (first, second))).collect()
}

/// Counts masks and pairs of masks, and resamples all counts together.
pub(super) fn tables(masks: &[&[u8]], cells: &CellGroups<'_>, intervals: &IntervalFacts) -> Tables {
    let n = masks.len();
    // The pair of a placement with itself holds its receivers, and those in line of sight.
    let wanted: Vec<(usize, usize)> = (0..n).map(|k| (k, k)).chain(pairs_of(n)).collect();
    let counted: Vec<([PairCounts; N_GROUPS], [Vec<Share>; N_GROUPS])> = wanted
        .into_par_iter()
        .map(|(first, second)| {
            let of_blocks = by_group(count_pairs(masks[first], masks[second], cells));
            let share = |counts: &PairCounts| {
                let part = if first == second { signed(counts.both) } else { counts.gain() };
                Share { part, whole: counts.compared() }
            };
            let total =
                |of_blocks: &Vec<PairCounts>| of_blocks.iter().fold(PairCounts::default(), |sum, c| sum.plus(c));
            (
                std::array::from_fn(|k| total(&of_blocks[k])),
                std::array::from_fn(|k| of_blocks[k].iter().map(share).collect()),
            )
        })
        .collect();
    let (totals, shares): (Vec<_>, Vec<_>) = counted.into_iter().unzip();
    let ratios: Vec<Vec<Share>> = shares.into_iter().flatten().collect();
    let estimates = resampled_ratios(&ratios, intervals.confidence, intervals.seed);
    let groups = |k: usize| -> [(PairCounts, RatioEstimate); N_GROUPS] {
        std::array::from_fn(|group| (totals[k][group], estimates[N_GROUPS * k + group]))
    };
    let share = |(counts, p_los): (PairCounts, RatioEstimate)| GroupShare {
        receivers: counts.compared(),
        los: counts.both,
        p_los,
    };
    let difference = |(counts, difference): (PairCounts, RatioEstimate)| GroupDifference { counts, difference };
    Tables {
        shares: (0..n).map(|k| groups(k).map(share)).collect(),
        differences: (n..totals.len()).map(|k| groups(k).map(difference)).collect(),
    }
}

fn signed(n: u64) -> i64 {
    i64::try_from(n).unwrap_or(i64::MAX)
}

/// Converts counts by zone code and block, `[block][code]`, to counts of all cells and of each
/// zone, `[group][block]`.
fn by_group(of_blocks: Vec<[PairCounts; N_CODES]>) -> [Vec<PairCounts>; N_GROUPS] {
    let all = |counts: &[PairCounts; N_CODES]| counts.iter().fold(PairCounts::default(), |sum, c| sum.plus(c));
    // Zone codes and groups of zones both count from 1. Code 0 is no zone; group 0 is all cells.
    std::array::from_fn(|group| match group {
        0 => of_blocks.iter().map(all).collect(),
        code => of_blocks.iter().map(|counts| counts[code]).collect(),
    })
}

/// Returns the margins of a sample by group, from the zone code of every cell.
pub(super) fn margin_facts(sample: &MarginSample, zones: &[u8]) -> MarginFacts {
    let of_group = |group: usize| {
        let is_in = |(cell, _): &&(usize, f32)| group == 0 || usize::from(zones[*cell]) == group;
        MarginStats::of(sample.margins.iter().filter(is_in).map(|(_, margin)| *margin).collect())
    };
    MarginFacts { every: sample.every, groups: std::array::from_fn(of_group) }
}
