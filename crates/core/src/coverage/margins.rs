//! How clear or how hidden receivers are: the worst margin of a UAV, and the margins of a map in numbers.
//!
//! Where the engine finds least heights at once ([`GridLos::los_and_least_heights`]) that is every margin; elsewhere each needs a walk along
//! its link, a hundred times what a cell of a map costs, and the margins of a map are those of a systematic sample: every n-th
//! receiver in row order. Each is that of the layer `margin`, its sign decided exactly.

use std::borrow::Cow;

use rayon::prelude::*;

use super::cell_heights::{least_height_and_margin, with_margin};
use super::curved::CurvedScene;
use super::map::Mapper;
use super::range::Range;
use super::{SiteCoverage, Uav, class};
use crate::height_field::Station;
use crate::los::{GridHeights, GridLos, GridReceivers};
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

/// The receiver of a UAV with the least margin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstReceiver {
    /// Its margin \[m\], as the layer `margin` holds it; −∞ where no receiver height is enough.
    pub margin_m: f32,
    /// Its row and column.
    pub cell: (usize, usize),
}

/// The margins of the receivers of one kind in range of a UAV, as far as they are found at once.
struct Margins<'m, 'a> {
    mapper: &'m Mapper<'a>,
    uav: &'m Uav,
    receivers: &'m GridReceivers<'a>,
    in_range: Cow<'m, BitGrid>,
    /// Who is in line of sight, and the least heights.
    found: Option<(BitGrid, GridHeights)>,
}

impl<'m, 'a> Margins<'m, 'a> {
    fn of(
        mapper: &'m Mapper<'a>,
        engine: &GridLos<'_>,
        (uav, range): (&'m Uav, &Range<'_>),
        receivers: &'m GridReceivers<'a>,
    ) -> Self {
        let in_range = match range.is_everywhere() {
            true => Cow::Borrowed(&*receivers.cells),
            false => Cow::Owned(range.cut_receivers(receivers)),
        };
        let found = engine.los_and_least_heights(&uav.station, receivers, &in_range, range.window());
        Margins { mapper, uav, receivers, in_range, found }
    }

    /// The margin of the receiver of a cell.
    fn at(&self, (row, col): (usize, usize)) -> f32 {
        let cell = row * self.mapper.field.grid().n_cols() + col;
        let (z, base) = (self.receivers.height(cell), self.receivers.base(cell));
        let found = self.found.as_ref().and_then(|(los, heights)| {
            let is_los = los.contains(row, col);
            heights.settled((row, col), |height| with_margin(height, z, base, is_los).1)
        });
        found.unwrap_or_else(|| self.mapper.margin_at(self.uav, self.receivers, (row, col)))
    }
}

impl Mapper<'_> {
    /// The receiver in range with the least margin, the first of equal ones among those of `first` and then row by row;
    /// `None` without any.
    ///
    /// Cost: that of a map with margins, on the calling thread.
    pub fn worst_margin(&self, uav: &Uav, first: &[(usize, usize)]) -> Option<WorstReceiver> {
        if let Some(curved) = CurvedScene::around(self, uav) {
            return curved.mapper(self).worst_margin(uav, first);
        }
        let range = self.range_of(uav);
        let kinds: Vec<Margins<'_, '_>> =
            self.receivers.iter().map(|kind| Margins::of(self, &self.alone, (uav, &range), kind)).collect();
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

    /// The least margin of the receivers of some cells that are in range \[m\]; `None` if none is.
    ///
    /// Cost: a walk for each.
    pub fn least_margin_among(&self, uav: &Uav, cells: &[(usize, usize)]) -> Option<f32> {
        if let Some(curved) = CurvedScene::around(self, uav) {
            return curved.mapper(self).least_margin_among(uav, cells);
        }
        let range = self.range_of(uav);
        let receivers = cells.iter().flat_map(|cell| self.receivers_at(*cell));
        let in_range = receivers.filter(|(receivers, cell)| range.contains(receivers, *cell));
        in_range.map(|(receivers, cell)| self.margin_at(uav, receivers, cell)).min_by(f32::total_cmp)
    }

    /// Margins of some `most` receivers of a map that this mapper made; of all, if they are fewer, or found at once.
    pub fn margin_sample(&self, map: &SiteCoverage, most: usize) -> MarginSample {
        if let Some(curved) = CurvedScene::around(self, &map.uav) {
            return curved.mapper(self).margin_sample(map, most);
        }
        let n_receivers = usize::try_from(map.tally.receivers).unwrap_or(usize::MAX);
        let range = self.range_of(&map.uav);
        let of_kind = |kind| Margins::of(self, &self.engine, (&map.uav, &range), kind);
        let kinds: Vec<Margins<'_, '_>> = self.receivers.iter().map(of_kind).collect();
        let are_all_found = kinds.iter().all(|kind| kind.found.is_some());
        // An odd step does not fall into the rhythm of rows of even length.
        let every = if n_receivers <= most || are_all_found { 1 } else { n_receivers.div_ceil(most) | 1 };
        let is_receiver = |(_, class): &(usize, &u8)| matches!(**class, class::NLOS | class::LOS);
        let cells: Vec<usize> =
            map.mask.iter().enumerate().filter(is_receiver).step_by(every).map(|(cell, _)| cell).collect();
        let n_cols = self.field.grid().n_cols();
        let margin = |cell: usize| {
            let at = (cell / n_cols, cell % n_cols);
            let kind = kinds.iter().find(|kind| kind.receivers.cells.contains(at.0, at.1));
            let margin = kind.map_or(f32::NAN, |kind| kind.at(at));
            debug_assert!(!self.method().0.is_exact() || (map.mask[cell] == class::LOS) == (margin >= 0.0));
            (cell, margin)
        };
        MarginSample { every, margins: cells.into_par_iter().map(margin).collect() }
    }

    fn margin_at(&self, uav: &Uav, receivers: &GridReceivers<'_>, (row, col): (usize, usize)) -> f32 {
        let cell = row * self.field.grid().n_cols() + col;
        let receiver = Station { place: self.engine.positions().center(row, col), z: receivers.height(cell) };
        least_height_and_margin(self.field, uav, &receiver, receivers.base(cell)).1
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
