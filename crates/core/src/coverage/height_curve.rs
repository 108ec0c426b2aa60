//! P_LoS as a function of the UAV's height over one place, exact at every lattice height.
//!
//! A link never becomes NLoS by raising the UAV. A cell that holds a receiver in range does so at
//! every height of the UAV, because range is horizontal. So each receiver has a least lattice
//! height of the UAV from which on it is LoS. P_LoS(h) is the share of receivers whose least height
//! is at most h: a step function, held here as a counted table. Its steps are integers, so the
//! curve at h counts exactly the receivers that a map made at h counts.
//!
//! Cost: past footprints that of casting them all ([`GridLos::least_uav_heights`]), past a raster a
//! walk along each link up to where nothing can bind more.

use std::ops::Range;
use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::view::{SeenReceivers, View};
use super::{Control, HoversOver, Uav};
use crate::error::Result;
use crate::los::{GridHeights, GridLos, Method};
use crate::quantity::{MAX_HEIGHT_M, STEPS_PER_UNIT, VOID, share};
use crate::raster::{BitGrid, set_bits};

/// Highest lattice height \[1/1024 m\]; the lowest is its negative.
#[expect(clippy::cast_possible_truncation, reason = "2^15 · 2^10")]
const MAX_STEP: i32 = MAX_HEIGHT_M as i32 * STEPS_PER_UNIT;

/// The least height of a receiver that no UAV height within ±32 768 m sees: above every lattice
/// height.
const NEVER: i32 = i32::MAX;

/// P_LoS of one UAV place as a function of the UAV's height.
#[derive(Debug, Clone)]
pub struct HeightCurve {
    uav: Uav,
    ground: Option<i32>,
    lowest: i32,
    receivers: u64,
    method: Method,
    /// Heights at which receivers come into sight, ascending, with the number of receivers in sight
    /// from there up.
    steps: Vec<(i32, u64)>,
}

impl HeightCurve {
    /// Returns the UAV at the height of its view.
    pub fn uav(&self) -> &Uav {
        &self.uav
    }

    /// Returns the ground below the UAV \[1/1024 m above the datum\], if one is known there.
    pub fn ground(&self) -> Option<i32> {
        self.ground
    }

    /// Returns the lowest height that the UAV may have at its place: the ground, or the roof or
    /// surface there \[1/1024 m above the datum\]. The curve begins here.
    pub fn lowest_height(&self) -> i32 {
        self.lowest
    }

    /// Returns the engine that found the heights, exactly.
    pub fn method(&self) -> Method {
        self.method
    }

    /// Returns the number of receivers, at any height.
    pub fn receivers(&self) -> u64 {
        self.receivers
    }

    /// Returns the number of receivers that no UAV height within ±32 768 m sees.
    pub fn never_los(&self) -> u64 {
        self.receivers - self.steps.last().map_or(0, |s| s.1)
    }

    /// Returns heights \[1/1024 m above the datum\] at which receivers come into sight, ascending,
    /// each with the number of receivers in sight from there up.
    pub fn steps(&self) -> &[(i32, u64)] {
        &self.steps
    }

    /// Returns the number of receivers in sight of a UAV at `height` \[1/1024 m above the datum\];
    /// 0 below the lowest height.
    pub fn los_at(&self, height: i32) -> u64 {
        let above = self.steps.partition_point(|s| s.0 <= height);
        above.checked_sub(1).map_or(0, |last| self.steps[last].1)
    }

    fn is_over_nodata(&self) -> bool {
        self.uav.placement == HoversOver::Nodata
    }

    /// Returns P_LoS of a UAV at `height` \[1/1024 m above the datum\]; `None` without a receiver,
    /// and below the lowest height, where the UAV cannot be.
    pub fn p_los_at(&self, height: i32) -> Option<f64> {
        share(self.los_at(height), self.receivers).filter(|_| height >= self.lowest && !self.is_over_nodata())
    }

    /// Returns the least height \[1/1024 m above the datum\] that has at least `percent` \[%\] of
    /// the receivers in sight.
    ///
    /// `None` where no height within ±32 768 m is enough, without a receiver, and over no data.
    pub fn least_height_reaching(&self, percent: u8) -> Option<i32> {
        // Shares are compared as products: u64 holds 100 times any count of cells.
        let reaches = |in_sight: u64| in_sight * 100 >= self.receivers * u64::from(percent);
        if self.is_over_nodata() {
            return None;
        }
        if self.receivers > 0 && reaches(0) {
            return Some(self.lowest);
        }
        self.steps.get(self.steps.partition_point(|s| !reaches(s.1))).map(|s| s.0)
    }
}

impl View<'_> {
    /// Returns the curve over the UAV's place, for the receivers in range.
    pub fn height_curve(&self, control: &Control) -> Result<HeightCurve> {
        let mut least = LeastHeights::of(self);
        least.add(0..self.field().grid().n_rows(), control);
        control.check()?;
        Ok(least.curve())
    }
}

/// Least UAV heights of the receivers in range, found some rows at a time: the steps of a curve.
#[derive(Debug)]
pub struct LeastHeights<'v> {
    view: &'v View<'v>,
    /// Engine that finds heights of many receivers at once, past footprints.
    at_once: Option<GridLos<'v>>,
    /// Lowest height that the UAV may have at its place \[1/1024 m\].
    lowest: i32,
    found: Vec<i32>,
}

/// Receivers of one kind in some rows.
struct InRows<'v> {
    seen: SeenReceivers<'v>,
    cells: BitGrid,
    at_once: Option<GridHeights>,
}

impl<'v> LeastHeights<'v> {
    /// Returns no heights yet.
    pub fn of(view: &'v View<'v>) -> Self {
        let surface = view.scene().below_uav().surface;
        let lowest = if surface == VOID { -MAX_STEP } else { surface };
        LeastHeights { view, at_once: view.scene().shadows(), lowest, found: Vec::new() }
    }

    /// Returns these after heights that were found before, of other rows.
    #[must_use]
    pub fn after(self, found: Vec<i32>) -> Self {
        LeastHeights { found, ..self }
    }

    /// Returns the heights found \[1/1024 m above the datum\], to go on with later.
    pub fn into_found(self) -> Vec<i32> {
        self.found
    }

    /// Adds the receivers of some rows; fewer if it is stopped.
    pub fn add(&mut self, rows: Range<usize>, control: &Control) {
        let (uav, lowest) = (&self.view.uav().station, i64::from(self.lowest));
        let n_cols = self.view.field().grid().n_cols();
        let of_kind = |seen: SeenReceivers<'v>| {
            let mut cells = self.view.no_cells();
            let per_row = cells.words_per_row();
            let words = rows.start * per_row..rows.end * per_row;
            cells.words_mut()[words.clone()].copy_from_slice(&seen.in_range().words()[words]);
            let height = seen.height_by_cell();
            let at_once = self.at_once.as_ref().and_then(|of| of.least_uav_heights(uav, &cells, lowest, &height));
            InRows { seen, cells, at_once }
        };
        let kinds: Vec<InRows<'_>> = self.view.receivers().map(of_kind).collect();
        let of_row = |row: usize| {
            let mut least: Vec<i32> = Vec::new();
            if control.is_stopped() {
                return least;
            }
            for InRows { seen, cells, at_once } in &kinds {
                least.extend(set_bits(cells.row(row)).map(|col| {
                    let found = at_once.as_ref().and_then(|of| of.settled((row, col), |z| self.least_step_from(z)));
                    found.unwrap_or_else(|| self.least_step(seen, (row, col)))
                }));
            }
            control.done.fetch_add(n_cols as u64, Ordering::Relaxed);
            least
        };
        let rows: Vec<Vec<i32>> = rows.clone().into_par_iter().map(of_row).collect();
        rows.into_iter().for_each(|row| self.found.extend(row));
    }

    /// Returns the least lattice height of the UAV from which on it sees a receiver, not below the
    /// lowest; [`NEVER`] if there is none.
    fn least_step(&self, receivers: &SeenReceivers<'_>, cell: (usize, usize)) -> i32 {
        let step = self.view.scene().least_step(&receivers.station(cell), i64::from(self.lowest));
        step.and_then(|z| i32::try_from(z).ok()).filter(|z| *z <= MAX_STEP).unwrap_or(NEVER)
    }

    /// Returns that lattice height from any \[1/1024 m above the datum\].
    fn least_step_from(&self, least: f64) -> i32 {
        match least.max(f64::from(self.lowest)).ceil() {
            #[expect(
                clippy::cast_possible_truncation,
                reason = "a whole number between the lowest and the highest height"
            )]
            least if least <= f64::from(MAX_STEP) => least as i32,
            _ => NEVER,
        }
    }

    /// Returns the curve of the receivers that were added.
    pub fn curve(mut self) -> HeightCurve {
        self.found.par_sort_unstable();
        let receivers = self.found.len() as u64;
        let method = self.at_once.as_ref().map_or(Method::Ray, GridLos::method);
        self.found.truncate(self.found.partition_point(|z| *z < NEVER));
        let mut steps: Vec<(i32, u64)> = Vec::new();
        for (in_sight, z) in (1..).zip(self.found) {
            match steps.last_mut() {
                Some(last) if last.0 == z => last.1 = in_sight,
                _ => steps.push((z, in_sight)),
            }
        }
        let ground = Some(self.view.scene().below_uav().ground).filter(|z| *z != VOID);
        HeightCurve { uav: self.view.uav().clone(), ground, lowest: self.lowest, receivers, method, steps }
    }
}
