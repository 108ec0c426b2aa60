//! From sets of cells to the classes of a mask, 64 cells at a time.

use fearless_simd::Level;
use fearless_simd::prelude::*;

use crate::dispatch;

use super::class;
use crate::height_field::CellSets;
use crate::raster::bits_between;

/// What is known of the cells of one row, a bit each.
#[derive(Debug)]
pub(super) struct RowSets<'a> {
    open: &'a [u64],
    building: &'a [u64],
    in_range: (usize, usize),
    receivers: Vec<u64>,
    los: Vec<u64>,
}

/// Cells of one word by class; those of none are nodata.
#[derive(Debug, Clone, Copy)]
pub(super) struct WordSets {
    pub(super) receivers: u64,
    pub(super) los: u64,
    pub(super) not_receivers: u64,
    pub(super) out_of_range: u64,
}

impl<'a> RowSets<'a> {
    /// A row without receivers.
    pub(super) fn new(cells: &'a CellSets, row: usize, in_range: (usize, usize)) -> Self {
        let n_words = cells.open.words_per_row();
        RowSets {
            open: cells.open.row(row),
            building: cells.building.row(row),
            in_range,
            receivers: vec![0; n_words],
            los: vec![0; n_words],
        }
    }

    /// Adds receivers in range and those of them in line of sight.
    pub(super) fn add(&mut self, receivers: &[u64], los: &[u64]) {
        self.receivers.iter_mut().zip(receivers).for_each(|(sum, more)| *sum |= more);
        self.los.iter_mut().zip(los).for_each(|(sum, more)| *sum |= more);
    }

    pub(super) fn words(&self) -> impl Iterator<Item = WordSets> {
        let (from, to) = self.in_range;
        (0..self.receivers.len()).map(move |k| {
            let receivers = self.receivers[k];
            // PERF: where all are receivers the other sets are not read: a set without cells is memory that nobody touched, and the
            // kernel need not provide it.
            let known = if receivers == u64::MAX { u64::MAX } else { self.open[k] | self.building[k] };
            // Most words are in range as a whole.
            let in_range = if from <= 64 * k && 64 * (k + 1) <= to { u64::MAX } else { bits_between(from, to, k) };
            WordSets {
                receivers,
                los: self.los[k],
                not_receivers: known & in_range & !receivers,
                out_of_range: known & !in_range,
            }
        })
    }
}

pub(super) fn write_classes(sets: &RowSets<'_>, mask: &mut [u8]) {
    dispatch!(Level::new(), simd => write_words(simd, sets, mask));
}

#[inline(always)]
fn write_words<S: Simd>(simd: S, sets: &RowSets<'_>, mask: &mut [u8]) {
    let n = S::u8s::LEN;
    let splat = |class: u8| S::u8s::splat(simd, class);
    let (nodata, far, none) = (splat(class::NODATA), splat(class::OUT_OF_RANGE), splat(class::NOT_A_RECEIVER));
    let (nlos, los) = (splat(class::NLOS), splat(class::LOS));
    for (word, out) in sets.words().zip(mask.chunks_mut(64)) {
        // PERF: most words are all of one class.
        match (word.receivers, word.los) {
            (u64::MAX, 0) => {
                out.fill(class::NLOS);
                continue;
            }
            (u64::MAX, u64::MAX) => {
                out.fill(class::LOS);
                continue;
            }
            _ => {}
        }
        let mut classes = [0_u8; 64];
        for (k, lanes) in classes.chunks_exact_mut(n).enumerate() {
            let bits = |word: u64| S::mask8s::from_bitmask(simd, word >> (k * n));
            let mut of = bits(word.out_of_range).select(far, nodata);
            of = bits(word.not_receivers).select(none, of);
            of = bits(word.receivers).select(nlos, of);
            bits(word.los).select(los, of).store_slice(lanes);
        }
        out.copy_from_slice(&classes[..out.len()]);
    }
}
