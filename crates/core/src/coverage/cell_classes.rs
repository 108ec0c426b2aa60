//! From sets of cells to the classes of a mask, 64 cells at a time.

use fearless_simd::Level;
use fearless_simd::prelude::*;

use crate::dispatch;

use super::class;
use super::range::Range;
use crate::height_field::CellSets;
use crate::raster::bits_between;

/// Cells of one row by what is known of them, a bit each.
#[derive(Debug)]
pub(super) struct RowSets<'a> {
    open: &'a [u64],
    building: &'a [u64],
    /// Cells in range; of receivers that elevations leave out, see [`RowSets::add`]. Not filled if
    /// all are.
    in_range: Vec<u64>,
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
    /// Returns row `row` of some cells without receivers; it is number `row_of_range` of the whole
    /// grid.
    pub(super) fn new(cells: &'a CellSets, row: usize, (range, row_of_range): (&Range<'_>, usize)) -> Self {
        let n_words = cells.open.words_per_row();
        let mut in_range = Vec::new();
        if !range.is_everywhere() {
            in_range = vec![0; n_words];
            for (from, to) in range.cols(row_of_range) {
                (from / 64..to.div_ceil(64)).for_each(|word| in_range[word] |= bits_between(from, to, word));
            }
        }
        RowSets {
            open: cells.open.row(row),
            building: cells.building.row(row),
            in_range,
            receivers: vec![0; n_words],
            los: vec![0; n_words],
        }
    }

    /// Adds those of all receivers of a kind that are in range, and those of them in line of sight.
    pub(super) fn add(&mut self, all: &[u64], receivers: &[u64], los: &[u64]) {
        // The elevation of a receiver may be out of range where its cell is not.
        self.in_range.iter_mut().zip(all.iter().zip(receivers)).for_each(|(within, (all, of))| *within &= !(all & !of));
        self.receivers.iter_mut().zip(receivers).for_each(|(sum, more)| *sum |= more);
        self.los.iter_mut().zip(los).for_each(|(sum, more)| *sum |= more);
    }

    pub(super) fn words(&self) -> impl Iterator<Item = WordSets> {
        (0..self.receivers.len()).map(move |k| {
            let receivers = self.receivers[k];
            // PERF: where all are receivers the other sets are not read: a set without cells is
            // memory that nobody touched, and the kernel need not provide it.
            let known = if receivers == u64::MAX { u64::MAX } else { self.open[k] | self.building[k] };
            let in_range = self.in_range.get(k).copied().unwrap_or(u64::MAX);
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
            (0, _) if word.out_of_range == u64::MAX => {
                out.fill(class::OUT_OF_RANGE);
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
