//! Choice of k sets whose union is largest, by trying all choices if there are few.

use std::sync::Mutex;

use rayon::prelude::*;

use super::seen_sets::SeenSets;
use crate::coverage::Control;
use crate::error::Result;

/// Most sets for which one table holds all choices: 2^22 sums of 16 bytes.
const MOST_IN_TABLE: usize = 22;
/// Most words of 64 receivers that an enumeration reads: about a second of two threads.
const MOST_WORDS: u64 = 1 << 32;
/// Cost of a word whose receivers have weights, in words without.
const WEIGHED: u64 = 32;

/// Choice of sets, ascending, and its covered weight.
type Choice = (Vec<usize>, u128);

/// Returns a choice of `k` sets that covers most. The inner `None` means that none covers more than
/// `least`, the outer one that there are too many choices to try.
pub(super) fn best_choice(sets: &SeenSets, k: usize, least: u128, control: &Control) -> Result<Option<Option<Choice>>> {
    if k >= sets.len() || k <= 1 {
        // The greedy choice is the best.
        return Ok(Some(None));
    }
    if sets.len() <= MOST_IN_TABLE {
        return Ok(Some(by_table(sets, k).filter(|(_, covered)| *covered > least)));
    }
    let words_each = sets.n_words() as u64 * if sets.is_weighed() { WEIGHED } else { 1 };
    let n_choices = (0..k).try_fold(1_u64, |n, j| Some(n.checked_mul((sets.len() - j) as u64)? / (j as u64 + 1)));
    match n_choices.and_then(|n| n.checked_mul(words_each)) {
        Some(words) if words <= MOST_WORDS => Enumeration::of(sets, k, least).run(control).map(Some),
        _ => Ok(None),
    }
}

/// Finds the best choice by a table. A choice leaves uncovered the receivers that only other sets
/// see. Their weight is a sum over all subsets of these sets, built set by set for all choices at
/// once.
fn by_table(sets: &SeenSets, k: usize) -> Option<Choice> {
    let n = sets.len();
    let mut only: Vec<u128> = vec![0; 1 << n];
    let mut total = 0;
    sets.for_each_receiver(|seen_by, weight| {
        only[seen_by] += weight;
        total += weight;
    });
    for set in 0..n {
        for others in (0..1 << n).filter(|others| others >> set & 1 == 1) {
            only[others] += only[others & !(1 << set)];
        }
    }
    let all = (1_usize << n) - 1;
    let choices = (0..=all).filter(|choice| choice.count_ones() as usize == k);
    // The first of the choices that cover most.
    let best = choices.min_by_key(|choice| only[all & !choice])?;
    Some(((0..n).filter(|set| best >> set & 1 == 1).collect(), total - only[all & !best]))
}

/// Enumeration of all choices, set after set, without those that cannot reach the best one so far.
struct Enumeration<'a> {
    sets: &'a SeenSets,
    k: usize,
    /// Sets by falling weight, and these weights.
    order: Vec<usize>,
    values: Vec<u128>,
    best: Mutex<(Vec<usize>, u128)>,
}

impl<'a> Enumeration<'a> {
    fn of(sets: &'a SeenSets, k: usize, least: u128) -> Self {
        let all = sets.gains(sets.wanted());
        let mut order: Vec<usize> = (0..sets.len()).collect();
        order.sort_by_key(|set| (std::cmp::Reverse(all[*set]), *set));
        let values = order.iter().map(|set| all[*set]).collect();
        Enumeration { sets, k, order, values, best: Mutex::new((Vec::new(), least)) }
    }

    fn run(self, control: &Control) -> Result<Option<Choice>> {
        (0..self.order.len()).into_par_iter().try_for_each(|first| {
            self.go_on(&mut Vec::new(), first..first + 1, (self.sets.wanted(), 0));
            control.check()
        })?;
        let (mut choice, covered) = self.best.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
        choice.iter_mut().for_each(|place| *place = self.order[*place]);
        choice.sort_unstable();
        Ok((!choice.is_empty()).then_some((choice, covered)))
    }

    /// Extends a choice, given as places in `order`, by each of some places.
    fn go_on(&self, choice: &mut Vec<usize>, places: std::ops::Range<usize>, (left, covered): (&[u64], u128)) {
        let n_more = self.k - choice.len();
        for place in places {
            // Later sets cover less each.
            let most = covered + self.values[place..].iter().take(n_more).sum::<u128>();
            if most < self.best.lock().map_or(0, |best| best.1) {
                return;
            }
            let set = self.sets.set(self.order[place]);
            let covered = covered + self.sets.value(set, left);
            choice.push(place);
            if n_more == 1 {
                self.offer(choice, covered);
            } else {
                let left: Vec<u64> = left.iter().zip(set).map(|(left, seen)| left & !seen).collect();
                self.go_on(choice, place + 1..self.order.len(), (&left, covered));
            }
            choice.pop();
        }
    }

    /// Keeps a choice that covers more, or as much and comes first, so that threads do not matter.
    fn offer(&self, choice: &[usize], covered: u128) {
        let Ok(mut best) = self.best.lock() else { return };
        if covered > best.1 || covered == best.1 && !best.0.is_empty() && choice < best.0.as_slice() {
            *best = (choice.to_vec(), covered);
        }
    }
}
