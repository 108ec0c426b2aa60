//! Maps: every receiver of the grid against one UAV.

use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::cell_classes::{RowSets, write_classes};
use super::cell_heights::{CellHeights, FoundHeights};
use super::output_rows::{BAND_CELLS, EachPart, HeightRows, Row, in_turns, summed};
use super::stability::stability;
use super::view::{Decided, Mapper, SeenReceivers, Threads, View};
use super::{Control, HeightLayers, MapOptions, Stability, Tally, Uav};
use crate::error::Result;
use crate::height_field::HeightField;
use crate::raster::{BitGrid, CellWindow, LargeVec};

/// Coverage of one UAV: shape `[n_rows, n_cols]` each, columns running fastest, row 0 north.
#[derive(Debug, Clone)]
pub struct SiteCoverage {
    /// The UAV.
    pub uav: Uav,
    /// Classes of [`super::class`].
    pub mask: LargeVec<u8>,
    /// Receiver height less the least visible height \[m\]; ≥ 0 exactly where LoS, NaN where there
    /// is no receiver.
    pub margin: Option<Vec<f32>>,
    /// Least receiver height in line of sight \[m above the datum\], never below what the receiver
    /// stands on.
    pub least_receiver_height: Option<Vec<f32>>,
    /// Least UAV height over its place that sees the receiver \[m above the datum\], never below
    /// the surface there; +∞ where none within ±32 768 m does.
    pub least_height: Option<Vec<f32>>,
    /// Answers that a step of the lattice turns.
    pub stability: Option<Stability>,
    /// Receivers in line of sight whatever heights are within their errors: 0 never, 1 surely,
    /// 2 possibly; NaN where there is no receiver.
    pub sure: Option<Vec<f32>>,
    /// Probability of line of sight with the errors of heights, NaN where there is no receiver.
    pub p_los: Option<Vec<f32>>,
    /// Counts.
    pub tally: Tally,
}

impl SiteCoverage {
    /// Returns the coverage of a UAV without layers.
    pub fn of_mask(uav: &Uav, mask: LargeVec<u8>, tally: Tally) -> Self {
        SiteCoverage { mask, ..SiteCoverage::of_tally(uav, tally) }
    }

    /// Returns the coverage of a UAV without a mask and layers.
    pub(super) fn of_tally(uav: &Uav, tally: Tally) -> Self {
        SiteCoverage {
            uav: uav.clone(),
            mask: LargeVec::default(),
            margin: None,
            least_receiver_height: None,
            least_height: None,
            stability: None,
            sure: None,
            p_los: None,
            tally: tally.of_uav(uav),
        }
    }

    /// Returns a window of a map: of a mask and heights in the rows of the window, and of layers of
    /// all rows.
    fn cropped(self, window: CellWindow, n_cols: usize) -> Self {
        fn part<T: Copy>(cells: &[T], window: CellWindow, n_cols: usize) -> Vec<T> {
            let rows = cells.chunks(n_cols);
            rows.flat_map(|row| &row[window.col..window.col + window.n_cols]).copied().collect()
        }
        let of_rows =
            |cells: &[f32]| part(&cells[window.row * n_cols..(window.row + window.n_rows) * n_cols], window, n_cols);
        let of_layer = |layer: Option<Vec<f32>>| layer.map(|layer| part(&layer, window, n_cols));
        let mask: LargeVec<u8> = part(&self.mask, window, n_cols).into();
        SiteCoverage {
            tally: self.tally.with_others_of(&mask),
            mask,
            margin: of_layer(self.margin),
            least_receiver_height: of_layer(self.least_receiver_height),
            least_height: of_layer(self.least_height),
            stability: self.stability.map(|of_all| Stability { turns: of_rows(&of_all.turns), ..of_all }),
            sure: self.sure.as_deref().map(of_rows),
            p_los: self.p_los.as_deref().map(of_rows),
            uav: self.uav,
        }
    }
}

/// Maps what one UAV sees: [`Mapper::new`], [`Mapper::seen_from`] and [`View::map`] in one.
pub fn map_site(field: &HeightField, uav: &Uav, options: &MapOptions, control: &Control) -> Result<SiteCoverage> {
    Mapper::new(field, options)?.seen_from(uav)?.map(control)
}

impl View<'_> {
    /// Maps what the UAV sees.
    ///
    /// Cost: that of the engine (see [`crate::los`]), plus a walk per receiver and solid for layers
    /// of heights, of which the sweep finds margins and ceilings without one. Shared by all threads
    /// of the current pool.
    pub fn map(&self, control: &Control) -> Result<SiteCoverage> {
        let map = self.map_in_parts(control, None, true)?;
        Ok(match self.mapper.options.window {
            Some(window) => map.cropped(window, self.field().grid().n_cols()),
            None => map,
        })
    }

    /// Maps what the UAV sees in the rows of the window, and calls `each_part` with one part of the
    /// mask after another, from the north, while others are made. Unless `keep`, that is all there
    /// is of the mask, and there are no layers.
    pub(super) fn map_in_parts(
        &self,
        control: &Control,
        mut each_part: Option<EachPart<'_>>,
        keep: bool,
    ) -> Result<SiteCoverage> {
        let (n_rows, n_cols) = (self.field().grid().n_rows(), self.field().grid().n_cols());
        let window = self.mapper.options.window.unwrap_or_else(|| self.field().grid().window());
        let rows = window.row..window.row + window.n_rows;
        let layers = if keep { self.mapper.options.layers } else { HeightLayers::default() };
        let map = OneMap::new(self, layers, control);
        // Rows enough for every thread, also of wide grids; all of them where nobody takes parts.
        let n_at_once = match &each_part {
            Some(_) => BAND_CELLS.div_ceil(n_cols).max(8 * rayon::current_num_threads()),
            None => n_rows,
        };
        let mut hand_over = |cells: &[u8]| match &mut each_part {
            Some(each_part) if !control.is_stopped() => each_part(cells),
            _ => {}
        };
        if !keep {
            let masks = rows.clone().step_by(n_at_once);
            let masks = masks.map(|first| (first, vec![0; n_at_once.min(rows.end - first) * n_cols]));
            let fill = |(first, mask): &mut (usize, Vec<u8>)| {
                let rows = mask.par_chunks_mut(n_cols).enumerate();
                summed(rows.map(|(k, mask)| map.fill(*first + k, &mut Row::of_mask(mask))))
            };
            let tally = in_turns(masks, fill, |(_, mask)| hand_over(mask));
            control.check()?;
            return Ok(SiteCoverage::of_tally(self.uav(), tally));
        }
        let mut mask = LargeVec::<u8>::zeroed(rows.len() * n_cols);
        let mut heights = HeightRows::new(layers, rows.len(), n_cols);
        let mut out = rows.clone().zip(heights.rows(0..rows.len(), &mut mask));
        let bands = std::iter::from_fn(move || {
            Some(out.by_ref().take(n_at_once).collect()).filter(|band: &Vec<_>| !band.is_empty())
        });
        let fill = |band: &mut Vec<(usize, Row<'_>)>| summed(band.par_iter_mut().map(|(row, out)| map.fill(*row, out)));
        let tally = in_turns(bands, fill, |band| band.iter().for_each(|(_, row)| hand_over(row.mask)));
        control.check()?;
        let mut coverage = SiteCoverage::of_mask(self.uav(), mask, tally);
        let [margin, mut least_receiver_height, least_height] = heights.into_layers();
        if let Some(heights) = &mut least_receiver_height {
            self.raise(heights, rows.start);
        }
        coverage = SiteCoverage { margin, least_receiver_height, least_height, ..coverage };
        let scenes = &self.mapper.layers;
        let decided: Vec<Decided<'_>> = map.receivers.into_iter().map(|of_kind| of_kind.decided).collect();
        coverage.stability =
            scenes.by_one_step.as_ref().map(|roofs| stability(self, &decided, roofs, control)).transpose()?;
        coverage.sure = scenes.sure.as_ref().map(|bounds| self.sure(bounds)).transpose()?.map(|sure| sure.layer());
        control.check()?;
        coverage.p_los = scenes.p_los.as_ref().map(|errors| self.p_los(errors, control)).transpose()?;
        Ok(coverage)
    }
}

/// A map that is being made.
struct OneMap<'m> {
    view: &'m View<'m>,
    control: &'m Control,
    heights: CellHeights,
    receivers: Vec<DecidedReceivers<'m>>,
}

/// Receivers of one kind with their answers.
struct DecidedReceivers<'m> {
    seen: SeenReceivers<'m>,
    decided: Decided<'m>,
    found: FoundHeights,
}

impl<'m> OneMap<'m> {
    /// Decides all receivers in range, and finds the heights that the engine finds at once.
    fn new(view: &'m View<'m>, layers: HeightLayers, control: &'m Control) -> Self {
        let heights = CellHeights::new(view, layers);
        let of_kind = |seen: SeenReceivers<'m>| {
            let in_range = seen.in_range();
            let (found, los) = match control.is_stopped() {
                true => (FoundHeights::default(), Some(view.no_cells())),
                false => heights.found(&seen, &in_range),
            };
            let los = los.unwrap_or_else(|| seen.los(&in_range, Threads::All));
            DecidedReceivers { seen, decided: Decided { in_range, los }, found }
        };
        OneMap { view, control, heights, receivers: view.receivers().map(of_kind).collect() }
    }

    /// Fills one row of every output.
    fn fill(&self, row: usize, out: &mut Row<'_>) -> Tally {
        let mut tally = Tally::default();
        if self.control.is_stopped() {
            return tally;
        }
        let mut sets = RowSets::new(self.view.field().cells(), row, (&self.view.range, row));
        for DecidedReceivers { seen, decided: Decided { in_range, los }, found } in &self.receivers {
            let (in_range, los): (&[u64], &[u64]) = (in_range.row(row), los.row(row));
            sets.add(seen.receivers.cells.row(row), in_range, los);
            tally.add_receivers(&seen.elevations(row), in_range, los);
            self.heights.fill(out, seen, row, (in_range, los), found);
        }
        let n_cols = self.view.field().grid().n_cols();
        tally.add_others(&sets, n_cols);
        write_classes(&sets, out.mask);
        self.control.done.fetch_add(n_cols as u64, Ordering::Relaxed);
        tally
    }
}

/// Cells that a UAV sees.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Seen {
    /// Receivers in range.
    pub receivers: BitGrid,
    /// Receivers in line of sight.
    pub los: BitGrid,
}

impl View<'_> {
    /// Returns the number of receivers in range, and of those in line of sight: what [`View::map`]
    /// counts, without a mask. The work of one thread, for many UAVs at once.
    pub fn count(&self) -> (u64, u64) {
        self.receivers().fold((0, 0), |sum, receivers| {
            let Decided { in_range, los } = receivers.decided(Threads::One);
            (sum.0 + in_range.count(), sum.1 + los.count())
        })
    }

    /// Returns the receivers in range, and those in line of sight. The work of one thread.
    pub fn seen(&self) -> Seen {
        let none = Seen { receivers: self.no_cells(), los: self.no_cells() };
        self.receivers().fold(none, |sum, receivers| {
            let Decided { in_range, los } = receivers.decided(Threads::One);
            Seen { receivers: sum.receivers.or(&in_range), los: sum.los.or(&los) }
        })
    }

    /// Returns the cells that hold receivers in range.
    pub fn receivers_in_range(&self) -> BitGrid {
        self.receivers().fold(self.no_cells(), |all, receivers| all.or(&receivers.in_range()))
    }

    /// Returns the cells in range, with receivers or without; `None` if all are. A cell without a
    /// receiver has no height, so only distance and azimuth leave it out.
    pub fn cells_in_range(&self) -> Option<BitGrid> {
        let range = &self.range;
        if range.is_everywhere() {
            return None;
        }
        let mut cells = range.cut(&self.no_cells().complement());
        for receivers in self.receivers().filter(|_| range.limits_heights()) {
            let beyond = (*receivers.receivers.cells).clone().xor(&receivers.in_range());
            cells = cells.and(&beyond.complement());
        }
        Some(cells)
    }

    /// Returns whether the receiver of a row and column is in line of sight, in range or not, by
    /// one exact ray; `None` without a receiver there.
    pub fn is_los(&self, cell: (usize, usize)) -> Option<bool> {
        let receiver = self.receivers_at(cell).next()?.station(cell);
        Some(self.scene().is_los(&receiver))
    }
}
