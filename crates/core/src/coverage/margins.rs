//! How clear or how hidden receivers are: the margins of a map, from a systematic sample of its receivers.
//!
//! A margin needs a walk along the link, a hundred times what its cell of a map costs, so a comparison takes every n-th
//! receiver in row order instead of all. Each margin of the sample is that of the layer `margin`, its sign decided exactly.

use rayon::prelude::*;

use super::map::Mapper;
use super::{SiteCoverage, class};

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
    /// Those within ±[`GRAZING_M`] of grazing.
    pub grazing: u64,
    /// Margins that 5 %, 50 % and 95 % of the receivers do not exceed \[m\]; −∞ where no receiver height is enough.
    pub quantiles: [f32; 3],
}

impl MarginStats {
    /// The statistics of some margins; `None` of none.
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
    /// How many receivers of the sample are within ± some distance of grazing \[m\].
    pub fn near(&self, reach_m: f32) -> u64 {
        self.margins.iter().filter(|(_, margin)| margin.abs() <= reach_m).count() as u64
    }
}

impl Mapper<'_> {
    /// Margins of some `most` receivers of a map that this mapper made; of all, if they are fewer.
    pub fn margin_sample(&self, map: &SiteCoverage, most: usize) -> MarginSample {
        let n_receivers = usize::try_from(map.tally.receivers).unwrap_or(usize::MAX);
        // An odd step does not fall into the rhythm of rows of even length.
        let every = if n_receivers <= most { 1 } else { n_receivers.div_ceil(most) | 1 };
        let is_receiver = |(_, class): &(usize, &u8)| matches!(**class, class::NLOS | class::LOS);
        let cells: Vec<usize> =
            map.mask.iter().enumerate().filter(is_receiver).step_by(every).map(|(cell, _)| cell).collect();
        let margins = cells.into_par_iter().map(|cell| (cell, self.margin(map, cell))).collect();
        MarginSample { every, margins }
    }

    fn margin(&self, map: &SiteCoverage, cell: usize) -> f32 {
        let n_cols = self.field.grid().n_cols();
        let at = (cell / n_cols, cell % n_cols);
        let Some((receivers, _)) = self.receivers_at(at).next() else { return f32::NAN };
        let margin = self.margin_at(&map.uav, receivers, at);
        debug_assert!(!self.method().0.is_exact() || (map.mask[cell] == class::LOS) == (margin >= 0.0));
        margin
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
