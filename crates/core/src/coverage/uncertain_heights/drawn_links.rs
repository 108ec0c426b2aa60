//! Draws of the heights of footprints, decided link by link.
//!
//! Two exact maps decide most receivers on the ground ([`super::sure`]). In one every building is as
//! low as in its lowest draw, in the other as high as in its highest. A receiver between them has
//! one walk along its link through the highest buildings, which finds how much lower each must be
//! ([`HeightLimits`]). A draw hides it if and only if it leaves a building higher than that.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::coverage::Control;
use crate::coverage::view::{HeightBounds, MovedRoofs, View};
use crate::error::Result;
use crate::height_field::{HeightField, Station};
use crate::los::{HeightLimits, PlanCrossings, limit_by_blocking_prisms};
use crate::raster::{BitGrid, set_bits};

/// Most errors that are held: of all buildings in all draws.
const MOST_ERRORS: usize = 1 << 24;

/// Errors of the heights of footprints in some draws.
#[derive(Debug)]
pub(super) struct DrawnErrors {
    n_draws: usize,
    /// Building by building, the errors of all draws less the highest of them \[1/1024 m\].
    below_highest: Vec<i32>,
    /// The scene as low, and as high, as any draw makes each building.
    bounds: HeightBounds,
}

impl DrawnErrors {
    /// Returns `true` if draws of a scene can be decided link by link: of footprints with flat
    /// roofs, and not so many that their errors take much memory.
    pub(super) fn can_hold(field: &HeightField, n_draws: usize) -> bool {
        let is_flat = field.prisms().is_some_and(|prisms| !prisms.are_sloped());
        is_flat && n_draws > 0 && field.n_buildings().saturating_mul(n_draws) <= MOST_ERRORS
    }

    /// Makes ready, from the errors of all buildings of each draw; `None` if a roof would leave
    /// ±32 768 m.
    pub(super) fn of(field: &HeightField, draws: &[Vec<i32>]) -> Option<Self> {
        let of = |building: usize| draws.iter().map(move |draw| draw[building]);
        let lowest = |building: u32| of(building as usize).min().unwrap_or(0);
        let highest = |building: u32| of(building as usize).max().unwrap_or(0);
        let moved = |by: &dyn Fn(u32) -> i32| MovedRoofs::by_building(field, by);
        let bounds = HeightBounds { low: moved(&lowest)?, high: moved(&highest)?, by_building: Vec::new() };
        let n_buildings = u32::try_from(field.n_buildings()).ok()?;
        let mut below_highest = Vec::with_capacity(field.n_buildings() * draws.len());
        for building in 0..n_buildings {
            let highest = highest(building);
            below_highest.extend(of(building as usize).map(|error| error - highest));
        }
        Some(DrawnErrors { n_draws: draws.len(), below_highest, bounds })
    }

    /// Returns the errors of a building in all draws, less the highest of them.
    fn of_building(&self, building: u32) -> &[i32] {
        &self.below_highest[building as usize * self.n_draws..][..self.n_draws]
    }

    /// Finds for each draw whether it hides a receiver: 1 if so, else 0.
    // PERF: numbers as wide as errors, so that many draws are compared at once.
    fn hide(&self, limits: &HeightLimits, is_hidden: &mut [u32]) {
        is_hidden.fill(0);
        for (building, room) in &limits.crossed {
            let room = saturated(*room);
            let draws = is_hidden.iter_mut().zip(self.of_building(*building));
            draws.for_each(|(is_hidden, error)| *is_hidden |= u32::from(*error > room));
        }
        for wall in &limits.walls {
            let [a, b] = wall.buildings.map(|building| self.of_building(building));
            let rooms = wall.rooms.map(saturated);
            let draws = is_hidden.iter_mut().zip(a.iter().zip(b));
            draws.for_each(|(is_hidden, (a, b))| *is_hidden |= u32::from((*a > rooms[0]) & (*b > rooms[1])));
        }
    }
}

/// Receivers that draws hide so far, and room to find more.
struct Hidden {
    /// By draw, of the current rows.
    counts: Vec<u32>,
    is_hidden: Vec<u32>,
    limits: HeightLimits,
}

impl View<'_> {
    /// Counts the receivers on the ground in line of sight in each draw, of those in range.
    ///
    /// Cost: two maps, and a walk for each receiver whose answer is not the same in all draws.
    pub(super) fn los_by_draw(
        &self,
        drawn: &DrawnErrors,
        in_range: &[Cow<'_, BitGrid>],
        control: &Control,
    ) -> Result<Vec<u64>> {
        let sure = self.sure_of(&drawn.bounds, in_range)?;
        let mut los = vec![sure.possibly.count(); drawn.n_draws];
        // Ground does not move, so it hides none of them.
        let unsure = sure.possibly.and(&sure.surely.complement());
        let highest = self.with_roofs(&drawn.bounds.high)?;
        for (receivers, in_range) in self.receivers().zip(in_range) {
            let wanted = unsure.clone().and(in_range);
            let none = || Hidden {
                counts: vec![0; drawn.n_draws],
                is_hidden: vec![0; drawn.n_draws],
                limits: HeightLimits::default(),
            };
            let of_row = |mut hidden: Hidden, row: usize| {
                for col in set_bits(wanted.row(row)) {
                    let Hidden { counts, is_hidden, limits } = &mut hidden;
                    highest.limit_by_blocking(&receivers.station((row, col)), limits);
                    drawn.hide(limits, is_hidden);
                    counts.iter_mut().zip(is_hidden).for_each(|(n, is_hidden)| *n += *is_hidden);
                }
                hidden
            };
            let rows = (0..wanted.n_rows()).into_par_iter().filter(|_| !control.is_stopped());
            for hidden in rows.fold(none, of_row).collect::<Vec<Hidden>>() {
                los.iter_mut().zip(hidden.counts).for_each(|(los, n)| *los -= u64::from(n));
            }
        }
        control.check()?;
        Ok(los)
    }

    /// Finds the rooms of the buildings that hide a receiver, in place of other limits.
    fn limit_by_blocking(&self, receiver: &Station, limits: &mut HeightLimits) {
        limits.crossed.clear();
        limits.walls.clear();
        let uav = &self.uav().station;
        let (from, to) = (uav.on_prisms(), receiver.on_prisms());
        if (from.x, from.y) == (to.x, to.y) {
            *limits = PlanCrossings::new(self.field(), uav, receiver, 0, 0).limits(0).unwrap_or_default();
        } else if let Some(prisms) = self.field().prisms() {
            limit_by_blocking_prisms(prisms, from, to, limits);
        }
    }
}

/// Returns a room as an error that compares alike.
fn saturated(room: i64) -> i32 {
    i32::try_from(room).unwrap_or(if room < 0 { i32::MIN } else { i32::MAX })
}
