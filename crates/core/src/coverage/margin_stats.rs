//! Margins of receivers: how far they are from turning; the worst of a UAV, and those of a map in
//! numbers.
//!
//! Some engines find least heights at once, which gives every margin. Elsewhere each needs a walk
//! along its link, a hundred times what a cell of a map costs. The margins of a map are then those
//! of a systematic sample: every n-th receiver in row order. Each is that of the layer `margin`,
//! its sign decided exactly.

use std::borrow::Cow;

use rayon::prelude::*;

use super::view::{SeenReceivers, Threads, View};
use super::{SiteCoverage, class};
use crate::los::GridHeights;
use crate::raster::BitGrid;

/// Margins of some receivers of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct MarginSample {
    /// Every how manyth receiver, in row order from the north-west, is in it.
    pub every: usize,
    /// Cell and margin \[m\], in row order; −∞ where no receiver height is enough.
    pub margins: Vec<(usize, f32)>,
}

/// Margins within this of grazing count as such \[m\].
pub const GRAZING_M: f32 = 1.0;

/// Some margins in numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarginStats {
    /// Receivers behind them.
    pub receivers: u64,
    /// Receivers within ±[`GRAZING_M`] of grazing.
    pub grazing: u64,
    /// Margins that 5 %, 50 % and 95 % of the receivers do not exceed \[m\]; −∞ where no receiver
    /// height is enough.
    pub quantiles: [f32; 3],
}

impl MarginStats {
    /// Returns the statistics of some margins; `None` of none.
    pub fn of(mut margins: Vec<f32>) -> Option<Self> {
        if margins.is_empty() {
            return None;
        }
        margins.sort_unstable_by(f32::total_cmp);
        // The least value that so many percent do not exceed: nearest rank, in integers.
        let rank = |percent: usize| margins[(percent * margins.len()).div_ceil(100).max(1) - 1];
        Some(MarginStats {
            receivers: margins.len() as u64,
            grazing: margins.iter().filter(|m| m.abs() <= GRAZING_M).count() as u64,
            quantiles: [5, 50, 95].map(rank),
        })
    }
}

impl MarginSample {
    /// Counts receivers of the sample within ± some distance of grazing \[m\].
    pub fn near(&self, reach_m: f32) -> u64 {
        self.margins.iter().filter(|(_, margin)| margin.abs() <= reach_m).count() as u64
    }
}

/// The receiver of a UAV with the least margin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstReceiver {
    /// Its margin \[m\], as the layer `margin` holds it; −∞ where no receiver height is enough.
    pub margin_m: f32,
    /// Its row and column.
    pub cell: (usize, usize),
}

/// Margins of the receivers of one kind in range of a UAV.
struct Margins<'v> {
    seen: SeenReceivers<'v>,
    in_range: Cow<'v, BitGrid>,
    /// Receivers in line of sight, and least heights; `None` if the engine does not find them at
    /// once.
    found: Option<(BitGrid, GridHeights)>,
}

impl<'v> Margins<'v> {
    /// Returns the margins of the receivers of each kind.
    fn by_kind(view: &'v View<'v>, threads: Threads) -> Vec<Self> {
        let of_kind = |seen: SeenReceivers<'v>| {
            let in_range = seen.in_range();
            let found = seen.los_and_least_heights(&in_range, threads);
            Margins { seen, in_range, found }
        };
        view.receivers().map(of_kind).collect()
    }

    /// Returns the margin of the receiver of a cell.
    fn at(&self, cell: (usize, usize)) -> f32 {
        let (los, heights) = self.found.as_ref().map(|(los, heights)| (los, heights)).unzip();
        let is_los = los.is_some_and(|los| los.contains(cell.0, cell.1));
        self.seen.least_height_and_margin(cell, is_los, heights).1
    }
}

impl View<'_> {
    /// Returns the receiver in range with the least margin, the first of equal ones among those of
    /// `first` and then row by row; `None` without any.
    ///
    /// Cost: that of a map with margins, on the calling thread.
    pub fn worst_margin(&self, first: &[(usize, usize)]) -> Option<WorstReceiver> {
        let kinds = Margins::by_kind(self, Threads::One);
        let of_first = |cell: &(usize, usize)| {
            let cell = *cell;
            kinds.iter().filter(move |kind| kind.in_range.contains(cell.0, cell.1)).map(move |kind| (kind, cell))
        };
        let all = kinds.iter().flat_map(|kind| kind.in_range.cells().map(move |cell| (kind, cell)));
        let mut worst: Option<WorstReceiver> = None;
        for (kind, cell) in first.iter().flat_map(of_first).chain(all) {
            let margin_m = kind.at(cell);
            if worst.is_none_or(|w| margin_m < w.margin_m) {
                worst = Some(WorstReceiver { margin_m, cell });
            }
        }
        worst
    }

    /// Returns the least margin of the receivers of some cells that are in range \[m\]; `None` if
    /// none is.
    ///
    /// Cost: a walk for each.
    pub fn least_margin_among(&self, cells: &[(usize, usize)]) -> Option<f32> {
        let margins = cells.iter().flat_map(|cell| {
            let in_range = self.receivers_at(*cell).filter(|of_kind| of_kind.is_in_range(*cell));
            in_range.map(|of_kind| of_kind.walked_height_and_margin(*cell).1)
        });
        margins.min_by(f32::total_cmp)
    }

    /// Returns margins of some `most` receivers of a map of this view; of all, if they are fewer,
    /// or found at once.
    pub fn margin_sample(&self, map: &SiteCoverage, most: usize) -> MarginSample {
        let n_receivers = usize::try_from(map.tally.receivers).unwrap_or(usize::MAX);
        let kinds = Margins::by_kind(self, Threads::All);
        let are_all_found = kinds.iter().all(|kind| kind.found.is_some());
        // An odd step does not fall into the rhythm of rows of even length.
        let every = if n_receivers <= most || are_all_found { 1 } else { n_receivers.div_ceil(most) | 1 };
        let is_receiver = |(_, class): &(usize, &u8)| matches!(**class, class::NLOS | class::LOS);
        let cells: Vec<usize> =
            map.mask.iter().enumerate().filter(is_receiver).step_by(every).map(|(cell, _)| cell).collect();
        let n_cols = self.field().grid().n_cols();
        let margin = |cell: usize| {
            let at = (cell / n_cols, cell % n_cols);
            let kind = kinds.iter().find(|kind| kind.seen.receivers.cells.contains(at.0, at.1));
            (cell, kind.map_or(f32::NAN, |kind| kind.at(at)))
        };
        MarginSample { every, margins: cells.into_par_iter().map(margin).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_values_by_nearest_rank() {
        assert_eq!(MarginStats::of(Vec::new()), None);
        let hundred = MarginStats::of((1..=100_u8).rev().map(|k| f32::from(k) - 50.0).collect()).expect("values");
        assert_eq!((hundred.quantiles, hundred.receivers), ([-45.0, 0.0, 45.0], 100));
        assert_eq!(hundred.grazing, 3, "-1, 0 and 1");
        let one = MarginStats::of(vec![f32::NEG_INFINITY]).expect("a value");
        assert_eq!((one.quantiles[1], one.grazing), (f32::NEG_INFINITY, 0));
    }
}
