//! Two maps of one scene, cell by cell: what both see, what is lost and what is gained from the
//! first to the second.
//!
//! Only cells that hold a receiver in range of both are compared. Receivers of one map alone are
//! counted apart, so that no change of range passes for a change of line of sight.

use rayon::prelude::*;

use super::class;
use crate::raster::CellBlocks;

/// Cells of two masks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PairCounts {
    /// Receivers of both that both see.
    pub both: u64,
    /// Receivers of both that only the first sees.
    pub only_first: u64,
    /// Receivers of both that only the second sees.
    pub only_second: u64,
    /// Receivers of both that neither sees.
    pub neither: u64,
    /// Cells that are a receiver of the first alone.
    pub receivers_of_first: u64,
    /// Cells that are a receiver of the second alone.
    pub receivers_of_second: u64,
}

impl PairCounts {
    /// Returns receivers of both.
    pub fn compared(&self) -> u64 {
        self.both + self.only_first + self.only_second + self.neither
    }

    /// Returns receivers gained from the first to the second, less those lost.
    #[expect(clippy::cast_possible_wrap, reason = "counts of cells are far below 2^63")]
    pub fn gain(&self) -> i64 {
        self.only_second as i64 - self.only_first as i64
    }

    /// Returns the sum of the counts of disjoint cells.
    #[must_use]
    pub fn plus(&self, other: &PairCounts) -> PairCounts {
        PairCounts {
            both: self.both + other.both,
            only_first: self.only_first + other.only_first,
            only_second: self.only_second + other.only_second,
            neither: self.neither + other.neither,
            receivers_of_first: self.receivers_of_first + other.receivers_of_first,
            receivers_of_second: self.receivers_of_second + other.receivers_of_second,
        }
    }
}

/// Cells that are counted together: blocks of ground, and in each of them groups such as zones.
#[derive(Debug, Clone, Copy)]
pub struct CellGroups<'a> {
    /// Blocks of ground.
    pub blocks: &'a CellBlocks,
    /// The group of every cell.
    pub groups: &'a [u8],
    /// Columns of the grid.
    pub n_cols: usize,
}

/// Counts two masks by block and group, `[block][group]`; a mask with itself counts its receivers
/// (`both` and `neither`).
///
/// Cost: one pass over the cells.
pub fn count_pairs<const N: usize>(first: &[u8], second: &[u8], cells: &CellGroups<'_>) -> Vec<[PairCounts; N]> {
    // By the state of the cell in either mask: not in line of sight, in line of sight, no receiver.
    let mut counts = vec![[[0_u64; 9]; N]; cells.blocks.count()];
    let state = |class: u8| usize::from(class.min(2));
    let rows = |mask| <[u8]>::chunks_exact(mask, cells.n_cols);
    for (row, ((first, second), groups)) in rows(first).zip(rows(second)).zip(rows(cells.groups)).enumerate() {
        let first_block = cells.blocks.first_of_row(row);
        let width = cells.blocks.n_cols();
        let parts = first.chunks(width).zip(second.chunks(width)).zip(groups.chunks(width));
        for (counts, ((first, second), groups)) in counts[first_block..].iter_mut().zip(parts) {
            for ((first, second), group) in first.iter().zip(second).zip(groups) {
                counts[usize::from(*group)][3 * state(*first) + state(*second)] += 1;
            }
        }
    }
    let named = |counts: [u64; 9]| {
        let [neither, only_second, first_a, only_first, both, first_b, second_a, second_b, _] = counts;
        PairCounts {
            both,
            only_first,
            only_second,
            neither,
            receivers_of_first: first_a + first_b,
            receivers_of_second: second_a + second_b,
        }
    };
    counts.into_iter().map(|groups| groups.map(named)).collect()
}

/// Returns the difference of two masks, cell by cell.
///
/// 0 where neither sees the receiver, 1 where only the first does (lost on the way to the second),
/// 2 where only the second does (gained), 3 where both do. 255 where the cell is not a receiver of
/// both.
pub fn difference_layer(first: &[u8], second: &[u8]) -> Vec<u8> {
    let of = |(first, second): (&u8, &u8)| match (*first, *second) {
        (first @ ..=class::LOS, second @ ..=class::LOS) => first + 2 * second,
        _ => class::NODATA,
    };
    first.par_iter().zip(second).map(of).collect()
}

/// Most placements whose sets of cells are counted.
pub const MOST_SETS: usize = 8;

/// Returns the number of receivers that exactly the placements of each set see, bit k for mask k,
/// `[2^masks]`. A receiver of any mask counts. `None` for more than [`MOST_SETS`] masks.
pub fn count_sets(masks: &[&[u8]]) -> Option<Vec<u64>> {
    if masks.is_empty() || masks.len() > MOST_SETS {
        return None;
    }
    let n_sets = 1 << masks.len();
    let mut counts = vec![0_u64; n_sets];
    for cell in 0..masks[0].len() {
        let (mut set, mut is_receiver) = (0, false);
        for (k, mask) in masks.iter().enumerate() {
            set |= usize::from(mask[cell] == class::LOS) << k;
            is_receiver |= mask[cell] <= class::LOS;
        }
        counts[set] += u64::from(is_receiver);
    }
    Some(counts)
}
