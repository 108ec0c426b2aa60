//! Answers that are sure where heights of buildings are known to within an error.
//!
//! The lower all buildings are, the more receivers on the ground a UAV sees. So two exact maps
//! bound all others: with every building as low, and with every building as high as its error lets
//! it be. How likely errors are, and whether buildings share them, does not matter. A receiver on a
//! roof moves with it. On footprints each link says what is sure of it ([`super::on_roofs`]). On a
//! raster, where buildings are not known, [`HeightBounds`] bounds such receivers too, but few are
//! surely in line of sight then.

use std::borrow::Cow;

use rayon::prelude::*;

use super::on_roofs::RoofLink;
use crate::coverage::view::{HeightBounds, SeenReceivers, Threads, View};
use crate::error::Result;
use crate::raster::{BitGrid, set_bits};

/// Receivers of a UAV, by what is sure of them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sure {
    /// Receivers in range, by the heights that are known.
    pub receivers: BitGrid,
    /// Receivers in line of sight whatever the heights within their bounds are.
    pub surely: BitGrid,
    /// Receivers in line of sight for some heights within them: `surely`, and others.
    pub possibly: BitGrid,
}

impl Sure {
    /// Returns a layer of 0 for receivers that are never in line of sight, 1 for those that surely
    /// are and 2 for those that may be; NaN elsewhere.
    pub(in crate::coverage) fn layer(&self) -> Vec<f32> {
        let n_cols = self.receivers.n_cols();
        let mut values = vec![f32::NAN; self.receivers.n_rows() * n_cols];
        for (cells, value) in [(&self.receivers, 0.0), (&self.possibly, 2.0), (&self.surely, 1.0)] {
            cells.cells().for_each(|(row, col)| values[row * n_cols + col] = value);
        }
        values
    }
}

impl View<'_> {
    /// Finds what is sure of the receivers, whatever heights buildings have within some bounds of
    /// the same scene. Who is in range does not change. A UAV inside a building as high as it may
    /// be surely sees none.
    ///
    /// Cost: twice the line of sight of a map, by the same engine; a walk for each receiver on a
    /// roof of footprints.
    ///
    /// # Errors
    /// Errors of [`Mapper::seen_from`](crate::coverage::Mapper::seen_from).
    pub fn sure(&self, bounds: &HeightBounds) -> Result<Sure> {
        let in_range: Vec<_> = self.receivers().map(|of_kind| of_kind.in_range()).collect();
        self.sure_of(bounds, &in_range)
    }

    /// Finds what is sure of some receivers in range, kind by kind.
    pub(super) fn sure_of(&self, bounds: &HeightBounds, wanted: &[Cow<'_, BitGrid>]) -> Result<Sure> {
        let of = |wanted: &[Cow<'_, BitGrid>]| wanted.iter().fold(self.no_cells(), |all, of_kind| all.or(of_kind));
        let mut sure = Sure { possibly: self.no_cells(), surely: self.no_cells(), receivers: of(wanted) };
        let (by_links, by_maps): (Vec<_>, Vec<_>) =
            self.receivers().zip(wanted).partition(|(of_kind, _)| of_kind.are_on_footprints());
        if !by_maps.is_empty() {
            let los_of = |view: &View<'_>| {
                let kinds = view.receivers().zip(wanted).filter(|(of_kind, _)| !of_kind.are_on_footprints());
                kinds.fold(self.no_cells(), |all, (of_kind, wanted)| all.or(&of_kind.los(wanted, Threads::All)))
            };
            sure.possibly = los_of(&self.with_roofs(&bounds.low)?);
            let is_inside = self.uav().moved(&bounds.high.field, [0; 3], self.mapper.options.radius).is_err();
            if !is_inside {
                sure.surely = los_of(&self.with_roofs(&bounds.high)?);
            }
        }
        for (of_kind, wanted) in by_links {
            let (surely, possibly) = sure_on_roofs(of_kind, wanted, &bounds.by_building);
            sure.surely = sure.surely.or(&surely);
            sure.possibly = sure.possibly.or(&possibly);
        }
        Ok(sure)
    }
}

/// Returns the receivers on roofs of footprints that surely are in line of sight, and those that
/// may be. Each building is off by at most `most` \[1/1024 m\].
fn sure_on_roofs(receivers: SeenReceivers<'_>, wanted: &BitGrid, most: &[i32]) -> (BitGrid, BitGrid) {
    let view = receivers.view;
    let (mut surely, mut possibly) = (view.no_cells(), view.no_cells());
    let per_row = wanted.words_per_row().max(1);
    let rows = surely.words_mut().par_chunks_mut(per_row).zip(possibly.words_mut().par_chunks_mut(per_row));
    rows.enumerate().for_each(|(row, (surely, possibly))| {
        for col in set_bits(wanted.row(row)) {
            let receiver = receivers.station((row, col));
            let Some(own) = view.field().building_at(&receiver.place) else { continue };
            let sure = RoofLink::new(view.field(), &view.uav().station, &receiver, own, most).sure();
            surely[col / 64] |= u64::from(sure.is_surely_los) << (col % 64);
            possibly[col / 64] |= u64::from(sure.is_possibly_los) << (col % 64);
        }
    });
    (surely, possibly)
}
