//! Receivers that candidates see, as sets.

use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::score::word_sum;
use super::{Candidate, Score, Scorer, Weights};
use crate::coverage::{Control, maps_at_once};
use crate::error::Result;
use crate::raster::{BitGrid, n_common};

/// Sets of wanted receivers, one per candidate, packed without words that hold no wanted receiver.
#[derive(Debug, Clone)]
pub struct SeenSets {
    /// Row and word of the row of each kept word.
    pub(super) kept: Vec<(usize, usize)>,
    /// Weights of the receivers, 64 to a kept word; `None` if each counts 1.
    pub(super) weights: Option<Vec<u128>>,
    pub(super) words: Vec<u64>,
    pub(super) wanted: Vec<u64>,
}

impl SeenSets {
    /// Makes an empty collection over the wanted receivers.
    pub fn over(wanted: &BitGrid, weights: Option<&Weights>) -> Self {
        let kept: Vec<(usize, usize)> = (0..wanted.n_rows())
            .flat_map(|row| (0..wanted.words_per_row()).map(move |word| (row, word)))
            .filter(|(row, word)| wanted.row(*row)[*word] != 0)
            .collect();
        let of_word = |weights: &Weights, (row, word): (usize, usize)| -> [u128; 64] {
            let row = weights.row(row);
            std::array::from_fn(|k| row.get(64 * word + k).copied().unwrap_or(0))
        };
        let weights = weights.map(|weights| kept.iter().flat_map(|at| of_word(weights, *at)).collect());
        let wanted = kept.iter().map(|(row, word)| wanted.row(*row)[*word]).collect();
        SeenSets { kept, weights, words: Vec::new(), wanted }
    }

    /// Maps candidates: returns their scores, equal to those of [`super::scores`], and their sets.
    /// Adds 1 to `control.done` for each.
    pub fn of(scorer: &Scorer<'_>, candidates: &[Candidate], control: &Control) -> Result<(Vec<Score>, SeenSets)> {
        let mut scores = Vec::with_capacity(candidates.len());
        let mut sets = SeenSets::over(&scorer.mapper.receiver_cells(), scorer.weights);
        // Whole sets of cells are held for a few candidates at a time.
        for chunk in candidates.chunks(8 * maps_at_once()) {
            control.check()?;
            let look = |candidate: &Candidate| {
                let seen = scorer.mapper.seen_from(&candidate.uav)?.seen();
                control.done.fetch_add(1, Ordering::Relaxed);
                Ok((scorer.score_of(&seen), seen.los))
            };
            let seen: Vec<(Score, BitGrid)> = chunk.par_iter().map(look).collect::<Result<_>>()?;
            let (of_chunk, seen): (Vec<Score>, Vec<BitGrid>) = seen.into_iter().unzip();
            scores.extend(of_chunk);
            sets.extend(&seen);
        }
        Ok((scores, sets))
    }

    /// Adds sets of cells, reduced to the wanted receivers.
    pub fn extend(&mut self, sets: &[BitGrid]) {
        let kept = &self.kept;
        self.words.extend(sets.iter().flat_map(|set| kept.iter().map(|(row, word)| set.row(*row)[*word])));
    }

    /// Returns the number of sets.
    pub fn len(&self) -> usize {
        if self.kept.is_empty() { 0 } else { self.words.len() / self.kept.len() }
    }

    /// Returns the wanted receivers, 64 to a word.
    pub(super) fn wanted(&self) -> &[u64] {
        &self.wanted
    }

    /// Returns the number of words of a set.
    pub(super) fn n_words(&self) -> usize {
        self.kept.len()
    }

    /// Returns `true` if receivers have weights.
    pub(super) fn is_weighed(&self) -> bool {
        self.weights.is_some()
    }

    /// Calls `visit` for each wanted receiver with the bits of the sets that see it and its weight.
    pub(super) fn for_each_receiver(&self, mut visit: impl FnMut(usize, u128)) {
        for (word, wanted) in self.wanted.iter().enumerate() {
            for bit in (0..64).filter(|bit| wanted >> bit & 1 == 1) {
                let of_set = |set: usize| ((self.set(set)[word] >> bit & 1) as usize) << set;
                let seen_by = (0..self.len()).map(of_set).sum();
                visit(seen_by, self.weights.as_ref().map_or(1, |weights| weights[64 * word + bit]));
            }
        }
    }

    /// Returns `true` if there is no set.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    pub(super) fn set(&self, k: usize) -> &[u64] {
        &self.words[k * self.kept.len()..(k + 1) * self.kept.len()]
    }

    /// Returns the weight of the receivers of a set that are in `left`.
    pub(super) fn value(&self, set: &[u64], left: &[u64]) -> u128 {
        match &self.weights {
            None => n_common(set, left).into(),
            Some(weights) => {
                let common = set.iter().zip(left).map(|(a, b)| a & b);
                common.zip(weights.chunks_exact(64)).map(|(word, w)| word_sum(word, w)).sum()
            }
        }
    }

    /// Returns the gain of each set, if only the receivers of `left` are uncovered.
    pub(super) fn gains(&self, left: &[u64]) -> Vec<u128> {
        (0..self.len()).into_par_iter().map(|k| self.value(self.set(k), left)).collect()
    }
}
