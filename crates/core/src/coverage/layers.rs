//! Layers over several UAVs: how many see a cell, which ones, and whether any does.

use rayon::prelude::*;

use super::class;

/// Which UAVs see each cell: one word per 32 UAVs, bit k of word w for UAV 32·w + k.
pub fn which_layer(masks: &[&[u8]]) -> Vec<Vec<u32>> {
    let n_cells = masks.first().map_or(0, |m| m.len());
    let word = |group: &[&[u8]]| {
        (0..n_cells)
            .map(|i| group.iter().enumerate().fold(0, |bits, (k, m)| bits | (u32::from(m[i] == class::LOS) << k)))
            .collect()
    };
    masks.chunks(32).map(word).collect()
}

/// The masks of many UAVs laid over each other one by one, so that none need be kept.
#[derive(Debug, Clone)]
pub struct Overlay {
    union: Vec<u8>,
    count: Vec<u32>,
}

impl Overlay {
    /// Nothing seen by anyone.
    pub fn new(n_cells: usize) -> Self {
        Overlay { union: vec![class::NODATA; n_cells], count: vec![0; n_cells] }
    }

    /// Adds the mask of one UAV.
    pub fn add(&mut self, mask: &[u8]) {
        // Parts that are long enough to be worth a thread.
        const PART: usize = 1 << 16;
        let parts = self.union.par_chunks_mut(PART).zip(self.count.par_chunks_mut(PART)).zip(mask.par_chunks(PART));
        parts.for_each(|((union, count), mask)| {
            for ((union, count), class) in union.iter_mut().zip(count).zip(mask) {
                *count += u32::from(*class == class::LOS);
                if rank(*class) < rank(*union) {
                    *union = *class;
                }
            }
        });
    }

    /// The mask of all UAVs together: LoS if any sees the cell, NLoS if it is a receiver of one, not a receiver if it is in
    /// range of one, out of range if it has a height, else nodata.
    pub fn union(&self) -> &[u8] {
        &self.union
    }

    /// Number of UAVs that see each cell.
    pub fn count(&self) -> &[u32] {
        &self.count
    }

    /// Number of receivers that exactly 0, 1, 2, … UAVs see, up to all `n_uavs` that were added.
    pub fn seen_by(&self, n_uavs: usize) -> Vec<u64> {
        let mut counts = vec![0; n_uavs + 1];
        for (class, count) in self.union.iter().zip(&self.count) {
            if matches!(*class, class::NLOS | class::LOS) {
                counts[*count as usize] += 1;
            }
        }
        counts
    }
}

/// Which class of a cell wins, the lowest first.
fn rank(class: u8) -> u8 {
    match class {
        class::LOS => 0,
        class::NLOS => 1,
        class::NOT_A_RECEIVER => 2,
        class::OUT_OF_RANGE => 3,
        _ => 4,
    }
}
