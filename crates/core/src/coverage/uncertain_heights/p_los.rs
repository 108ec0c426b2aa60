//! Probability that a receiver is in line of sight, where heights of buildings are off by normal
//! errors.
//!
//! Two exact maps decide most receivers on the ground: with all buildings as low, and as high, as
//! six standard deviations make them ([`super::sure`]). The shadows of higher buildings settle the
//! others ([`crate::los::shadow_clear_probabilities`]), where no terrain is below them. Elsewhere,
//! and for each receiver on a roof, one walk finds how much higher each building may be so that its
//! link is clear, and [`super::link_probability`] the probability of that.

use std::borrow::Cow;

use rayon::prelude::*;

use super::sure::Sure;
use crate::coverage::Control;
use crate::coverage::view::{SeenReceivers, UncertainHeights, View};
use crate::error::{MapError, Result};
use crate::los::{ClearProbabilities, PlanCrossings};
use crate::raster::{BitGrid, set_bits};

impl View<'_> {
    /// Returns the probability that each receiver is in line of sight, with errors of the heights
    /// of the same scene; NaN where there is no receiver in range. Shape `[n_rows, n_cols]`, row 0
    /// north. Without errors it is the mask: 0 or 1. A receiver on a roof is as much higher or
    /// lower as that.
    ///
    /// Cost, besides two maps:
    ///
    /// | receivers | passes |
    /// |---|---|
    /// | on the ground, flat roofs on flat ground | one shadow pass for each value of a shared error, 1 to 96 |
    /// | on the ground, terrain or sloped roofs or curved earth | a walk for each that depends on heights |
    /// | on roofs | a walk for each |
    ///
    /// # Errors
    /// E118 for a raster, whose buildings are not told apart.
    pub fn p_los(&self, heights: &UncertainHeights, control: &Control) -> Result<Vec<f32>> {
        if self.field().prisms().is_none() {
            return Err(MapError::RasterProbabilities.into());
        }
        let in_range: Vec<_> = self.receivers().map(|of_kind| of_kind.in_range()).collect();
        // Receivers on roofs are settled by one walk each, not by two maps.
        let on_ground = |(of_kind, in_range): (SeenReceivers<'_>, _)| match of_kind.are_on_roofs() {
            true => Cow::Owned(self.no_cells()),
            false => Cow::clone(in_range),
        };
        let on_ground: Vec<Cow<'_, BitGrid>> = self.receivers().zip(&in_range).map(on_ground).collect();
        let sure = self.sure_of(&heights.bounds, &on_ground)?;
        let mut p_los = vec![f32::NAN; self.field().grid().n_cells()];
        for (receivers, in_range) in self.receivers().zip(&in_range) {
            let of = OfKind::new(receivers, heights, &sure, in_range);
            p_los.par_chunks_mut(in_range.n_cols()).enumerate().for_each(|(row, out)| {
                if !control.is_stopped() {
                    of.fill(row, out);
                }
            });
        }
        control.check()?;
        Ok(p_los)
    }
}

/// Receivers of one kind in range.
struct OfKind<'a> {
    receivers: SeenReceivers<'a>,
    heights: &'a UncertainHeights,
    sure: &'a Sure,
    in_range: &'a BitGrid,
    /// Probabilities that shadows find.
    cast: Option<ClearProbabilities>,
}

impl<'a> OfKind<'a> {
    fn new(receivers: SeenReceivers<'a>, heights: &'a UncertainHeights, sure: &'a Sure, in_range: &'a BitGrid) -> Self {
        let unsure = || in_range.clone().and(&sure.possibly).and(&sure.surely.complement());
        let cast = || receivers.clear_probabilities(&unsure(), &heights.errors);
        // Receivers on roofs move.
        let cast = if receivers.are_on_roofs() { None } else { cast() };
        OfKind { receivers, heights, sure, in_range, cast }
    }

    fn fill(&self, row: usize, out: &mut [f32]) {
        let is_known = !self.receivers.are_on_roofs();
        for col in set_bits(self.in_range.row(row)) {
            out[col] = match (self.sure.surely.contains(row, col), self.sure.possibly.contains(row, col)) {
                (true, _) if is_known => 1.0,
                (_, false) if is_known => 0.0,
                _ => {
                    let cast = self.cast.as_ref().and_then(|cast| cast.of(row, col));
                    #[expect(clippy::cast_possible_truncation, reason = "layers are stored as f32")]
                    let p = cast.unwrap_or_else(|| self.walked((row, col))) as f32;
                    p
                }
            };
        }
    }

    /// Returns the probability of the receiver of a cell, by a walk along its link.
    fn walked(&self, cell: (usize, usize)) -> f64 {
        let view = self.receivers.view;
        let (field, receiver) = (view.field(), self.receivers.station(cell));
        let UncertainHeights { errors, bounds, reach } = self.heights;
        let link = |fall: i32| PlanCrossings::new(field, &view.uav().station, &receiver, fall, *reach);
        match field.building_at(&receiver.place).filter(|_| self.receivers.are_on_roofs()) {
            Some(building) => errors.probability_on_roof(building, &link(bounds.by_building[building as usize])),
            None => errors.probability(None, &link(0)),
        }
    }
}
