//! Choice of several UAVs that together see most, with a bound on any other choice.
//!
//! To choose k of n sets whose union is largest is NP-hard. Greedy takes the set that adds most, k
//! times over. It covers at least 1 − (1 − 1/k)^k > 63 % of the optimum (Nemhauser, Wolsey & Fisher
//! 1978). A tighter bound holds for a given instance. Let g_j(S) be the gain of set j over a choice
//! S. The optimum O covers no more than S and O together. The gain of O over S is at most the sum
//! of the gains of its k sets one by one, so
//!
//! ```text
//!   f(O) ≤ f(S) + Σ_{j ∈ O} g_j(S) ≤ f(S) + sum of the k largest g_j(S)    for every S
//! ```
//!
//! The bound is the least of three: these over all prefixes S of the greedy choice (Leskovec et al.
//! 2007), the total, and a Lagrangian dual. For the dual, pay λ_i ≤ w_i to each chosen set that
//! covers receiver i, instead of w_i once. Then
//!
//! ```text
//!   f(O) ≤ Σ_i (w_i − λ_i) + sum over the k largest of Σ_{i ∈ j} λ_i       for every 0 ≤ λ ≤ w
//! ```
//!
//! The first sum counts w_i − λ_i of every receiver, covered or not, and each receiver that O
//! covers is paid at least λ_i. Any λ gives a bound; subgradient steps search for a good one. All
//! numbers are integers, so nothing is rounded in the unsafe direction.
//!
//! If there are few choices, all are tried (`exact_cover.rs`).
//!
//! # References
//! Nemhauser, Wolsey & Fisher 1978, Mathematical Programming 14; Leskovec et al. 2007, KDD (bounds
//! for the instance at hand); Fisher 1981, Management Science 27 (Lagrangian relaxation).

use rayon::prelude::*;

use super::exact_cover::best_choice;
use super::score::quotient;
use super::seen_sets::SeenSets;
use crate::coverage::Control;
use crate::error::Result;

/// Chosen set.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Chosen {
    /// Index of the set.
    pub set: usize,
    /// Weight that it adds to the sets before it.
    pub gain: u128,
    /// Weight that it and the sets before it cover together.
    pub covered: u128,
}

/// Sets chosen one by one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Cover {
    /// Sets in the order of choice; fewer than requested if no other set adds anything.
    pub chosen: Vec<Chosen>,
    /// Weight of all wanted receivers.
    pub wanted: u128,
    /// Upper bound on the weight that any choice of the requested number of sets covers.
    pub bound: u128,
}

impl Cover {
    /// Returns the weight that the choice covers.
    pub fn covered(&self) -> u128 {
        self.chosen.last().map_or(0, |c| c.covered)
    }

    /// Returns the largest possible distance from the optimum, as a share of the bound; `None` if
    /// nothing can be covered.
    pub fn gap(&self) -> Option<f64> {
        (self.bound > 0).then(|| quotient(self.bound - self.covered(), self.bound))
    }
}

/// Chooses `k` sets whose union is largest if choices are few enough to try all (`exact_cover.rs`),
/// else as [`greedy_cover`] does.
pub fn cover(sets: &SeenSets, k: usize, control: &Control) -> Result<Cover> {
    let greedy = greedily(sets, k, control)?;
    match best_choice(sets, k, greedy.covered(), control)? {
        Some(None) => Ok(Cover { bound: greedy.covered(), ..greedy }),
        Some(Some((best, bound))) => Ok(Cover { chosen: in_order(sets, best), bound, ..greedy }),
        None => with_dual_bound(greedy, sets, k, control),
    }
}

/// Chooses `k` sets whose union is large: greedily, of equal sets the first. Computes an upper
/// bound on every choice of `k`.
pub fn greedy_cover(sets: &SeenSets, k: usize, control: &Control) -> Result<Cover> {
    with_dual_bound(greedily(sets, k, control)?, sets, k, control)
}

/// Chooses greedily, with the bound of the prefixes, for which every round computes all gains.
fn greedily(sets: &SeenSets, k: usize, control: &Control) -> Result<Cover> {
    let mut left = sets.wanted.clone();
    let wanted = sets.value(&left, &left);
    let (mut bound, mut covered) = (wanted, 0);
    let mut chosen: Vec<Chosen> = Vec::new();
    loop {
        control.check()?;
        let gains = sets.gains(&left);
        bound = bound.min(sum_of_largest(&gains, k).saturating_add(covered));
        // The first of the largest.
        let best = (0..gains.len()).rev().max_by_key(|j| gains[*j]);
        let Some(set) = best.filter(|j| gains[*j] > 0 && chosen.len() < k) else { break };
        covered += gains[set];
        chosen.push(Chosen { set, gain: gains[set], covered });
        left.iter_mut().zip(sets.set(set)).for_each(|(left, seen)| *left &= !seen);
    }
    Ok(Cover { chosen, wanted, bound })
}

/// Adds the dual bound to a choice, unless that is known to be the best.
fn with_dual_bound(found: Cover, sets: &SeenSets, k: usize, control: &Control) -> Result<Cover> {
    let covered = found.covered();
    if covered == found.bound || k == 1 {
        return Ok(found);
    }
    Ok(Cover { bound: found.bound.min(dual_bound(sets, k, covered, control)?), ..found })
}

/// Orders chosen sets: next comes the one that adds most, of equal ones the first. Sets that add
/// nothing are dropped.
fn in_order(sets: &SeenSets, mut choice: Vec<usize>) -> Vec<Chosen> {
    let (mut left, mut covered, mut chosen) = (sets.wanted.clone(), 0, Vec::new());
    while !choice.is_empty() {
        let gains: Vec<u128> = choice.iter().map(|set| sets.value(sets.set(*set), &left)).collect();
        let best = (0..gains.len()).rev().max_by_key(|k| gains[*k]).unwrap_or(0);
        let (set, gain) = (choice.remove(best), gains[best]);
        if gain == 0 {
            break;
        }
        covered += gain;
        chosen.push(Chosen { set, gain, covered });
        left.iter_mut().zip(sets.set(set)).for_each(|(left, seen)| *left &= !seen);
    }
    chosen
}

/// Returns the sum of the `k` largest values, saturating; no bound is that high.
fn sum_of_largest(values: &[u128], k: usize) -> u128 {
    largest(values, k).iter().fold(0, |sum, j| sum.saturating_add(values[*j]))
}

/// Returns the indices of the `k` largest values, of equal ones the first.
fn largest(values: &[u128], k: usize) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    let by_value = |j: &usize| (std::cmp::Reverse(values[*j]), *j);
    if k < order.len() {
        order.select_nth_unstable_by_key(k, by_value);
        order.truncate(k);
    }
    order
}

/// Number of levels of λ between 0 and the weight of a receiver, as a power of two.
const LEVEL_BITS: u32 = 6;
const LEVELS: i32 = 1 << LEVEL_BITS;
/// Most words read by all steps together: seconds, not minutes.
const MOST_WORDS: u64 = 1 << 32;
const MOST_STEPS: u64 = 120;

/// Computes the Lagrangian bound, the best of some steps from λ = w/2 on. Each step raises λ of the
/// receivers that the best-paid sets leave uncovered, and lowers it where they overlap.
///
/// λ_i is w_i times a level of up to [`LEVELS`], in units of 1/[`LEVELS`]. Each bit of the levels
/// is a plane of receivers, so that sums are counts.
fn dual_bound(sets: &SeenSets, k: usize, covered: u128, control: &Control) -> Result<u128> {
    let n_words = sets.kept.len();
    let words_each = if sets.weights.is_some() { 32 } else { u64::from(LEVEL_BITS) + 1 };
    let cost = (sets.words.len() as u64).saturating_mul(words_each);
    let n_steps = (MOST_WORDS / cost.max(1)).min(MOST_STEPS);
    let mut levels = vec![f64::from(LEVELS) / 2.0; 64 * n_words];
    let mut least = u128::MAX;
    let mut stride = f64::from(LEVELS) / 4.0;
    let mut since_better = 0;
    for _ in 0..n_steps {
        control.check()?;
        let planes = planes_of(&levels, &sets.wanted);
        let paid: Vec<u128> = (0..sets.len()).into_par_iter().map(|j| paid_by(sets, j, &planes)).collect();
        let all = planes.iter().enumerate().map(|(b, plane)| sets.value(plane, &sets.wanted) << b).sum::<u128>();
        let total = sets.value(&sets.wanted, &sets.wanted);
        let payers = largest(&paid, k);
        // The covered weight is an integer, so the bound may be rounded down.
        let bound = sum_of_largest(&paid, k).saturating_add((total << LEVEL_BITS) - all) >> LEVEL_BITS;
        if bound < least {
            (least, since_better) = (bound, 0);
        } else {
            since_better += 1;
        }
        if least <= covered {
            break;
        }
        if since_better >= 4 {
            (stride, since_better) = (stride * 0.6, 0);
        }
        step(&mut levels, sets, &payers, stride);
    }
    Ok(least)
}

/// Returns the receivers by the bits of their levels, lowest first.
fn planes_of(levels: &[f64], wanted: &[u64]) -> Vec<Vec<u64>> {
    let mut planes = vec![vec![0_u64; wanted.len()]; LEVEL_BITS as usize + 1];
    for (k, (wanted, levels)) in wanted.iter().zip(levels.chunks_exact(64)).enumerate() {
        for (bit, level) in levels.iter().enumerate().filter(|(bit, _)| wanted >> bit & 1 == 1) {
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to LEVELS")]
            let level = level.round() as u64;
            for (b, plane) in planes.iter_mut().enumerate() {
                plane[k] |= (level >> b & 1) << bit;
            }
        }
    }
    planes
}

/// Returns the pay of a set, in units of 1/[`LEVELS`].
fn paid_by(sets: &SeenSets, j: usize, planes: &[Vec<u64>]) -> u128 {
    planes.iter().enumerate().map(|(b, plane)| sets.value(sets.set(j), plane) << b).sum()
}

/// Raises λ where no payer covers, lowers it where several do.
fn step(levels: &mut [f64], sets: &SeenSets, payers: &[usize], stride: f64) {
    for (k, levels) in levels.chunks_exact_mut(64).enumerate() {
        for (bit, level) in levels.iter_mut().enumerate() {
            let times = payers.iter().filter(|j| sets.set(**j)[k] >> bit & 1 == 1).count();
            *level = (*level + stride * (1.0 - times as f64)).clamp(0.0, f64::from(LEVELS));
        }
    }
}
