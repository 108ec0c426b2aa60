//! Sums over a set of places: what is added to each is the same number for all places of a set of
//! bits.

use crate::raster::BitGrid;

/// Sum for each place of a grid.
///
/// PERF: the sums stand on edge: plane k holds bit k of all of them, 64 places to the word. Adding
/// a set to a plane is an exclusive or whose carries go to the next. A carry out of plane k is
/// needed once in 2^k times. So adding 1 to the places of a set costs a few passes over its words,
/// however many places it has.
#[derive(Debug, Clone)]
pub(super) struct PlaceSums {
    n_words: usize,
    planes: Vec<Vec<u64>>,
    carry: Vec<u64>,
}

impl PlaceSums {
    /// Sums of 0 for the places of sets with so many words.
    pub(super) fn new(n_words: usize) -> Self {
        PlaceSums { n_words, planes: Vec::new(), carry: vec![0; n_words] }
    }

    /// Adds `number` to the sum of each place of a set.
    pub(super) fn add(&mut self, places: &BitGrid, number: u128) {
        let mut left = number;
        while left != 0 {
            self.add_bit(places, left.trailing_zeros() as usize);
            left &= left - 1;
        }
    }

    fn add_bit(&mut self, places: &BitGrid, plane: usize) {
        self.carry.copy_from_slice(places.words());
        self.add_carry(plane);
    }

    /// Adds 2^`plane` to the sums of the places whose bits are left over.
    fn add_carry(&mut self, mut plane: usize) {
        loop {
            while self.planes.len() <= plane {
                self.planes.push(vec![0; self.n_words]);
            }
            let mut any = 0;
            for (sum, carry) in self.planes[plane].iter_mut().zip(&mut self.carry) {
                let both = *sum & *carry;
                *sum ^= *carry;
                *carry = both;
                any |= both;
            }
            if any == 0 {
                return;
            }
            plane += 1;
        }
    }

    /// Adds the sums of others over the same places.
    pub(super) fn plus(mut self, other: &PlaceSums) -> Self {
        for (k, plane) in other.planes.iter().enumerate() {
            self.carry.copy_from_slice(plane);
            self.add_carry(k);
        }
        self
    }

    /// Returns the sums, 64 for each word.
    pub(super) fn totals(&self) -> Vec<u128> {
        let mut totals = vec![0; self.n_words * 64];
        for (k, plane) in self.planes.iter().enumerate() {
            for (totals, word) in totals.chunks_exact_mut(64).zip(plane) {
                for (bit, total) in totals.iter_mut().enumerate() {
                    *total |= u128::from(word >> bit & 1) << k;
                }
            }
        }
        totals
    }
}
