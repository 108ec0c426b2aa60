//! P_LoS as a function of the UAV's height over one place, exact at every lattice height.
//!
//! A link never becomes NLoS by raising the UAV, and whether a cell holds a receiver does not depend on the UAV's height
//! (range is horizontal). So each receiver of a map has a least lattice height of the UAV from which on it is LoS, and
//! P_LoS(h) is the share of receivers whose least height is at most h: a step function, held here as a counted table.
//! Its steps are integers, so the curve at h counts exactly the receivers that a map made at h counts.
//!
//! Cost: past footprints that of casting them all ([`GridLos::least_uav_heights`]), past a raster a walk along each link up to where
//! nothing can bind more.

use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::view::SceneView;
use super::{Control, HoversOver, Receivers, SiteCoverage, Uav, class};
use crate::error::Result;
use crate::height_field::{CellKind, GridPositions, Station};
use crate::los::{GridLos, Method};
use crate::quantity::{MAX_HEIGHT_M, STEPS_PER_UNIT, VOID, share};
use crate::raster::{BitGrid, set_bits};

/// Highest lattice height \[1/1024 m\]; the lowest is its negative.
#[expect(clippy::cast_possible_truncation, reason = "2^15 · 2^10")]
const MAX_STEP: i32 = MAX_HEIGHT_M as i32 * STEPS_PER_UNIT;

/// The least height of a receiver that no UAV height within ±32 768 m sees: above every lattice height.
const NEVER: i32 = i32::MAX;

/// P_LoS of one UAV place as a function of the UAV's height.
#[derive(Debug, Clone)]
pub struct HeightCurve {
    uav: Uav,
    ground: Option<i32>,
    lowest: i32,
    receivers: u64,
    method: Method,
    /// Heights at which receivers come into sight, ascending, with the number of receivers in sight from there up.
    steps: Vec<(i32, u64)>,
}

impl HeightCurve {
    /// The curve over the place of a map's UAV, for the receivers of that map.
    ///
    /// `receivers` are those of the options of the map, and how high they are above what they stand on \[1/1024 m\].
    pub fn of(
        view: &SceneView<'_>,
        map: &SiteCoverage,
        receivers: (Receivers, i32),
        control: &Control,
    ) -> Result<Self> {
        let mut least = LeastHeights::of(view, receivers);
        least.add(&map.mask, 0, control);
        control.check()?;
        Ok(least.curve())
    }

    /// The UAV at the height that the map was made for.
    pub fn uav(&self) -> &Uav {
        &self.uav
    }

    /// Ground below the UAV \[1/1024 m above the datum\], if one is known there.
    pub fn ground(&self) -> Option<i32> {
        self.ground
    }

    /// The lowest height that the UAV may have at its place: the ground, or the roof or surface there \[1/1024 m above the
    /// datum\]. The curve begins here.
    pub fn lowest_height(&self) -> i32 {
        self.lowest
    }

    /// The engine that found the heights, exactly.
    pub fn method(&self) -> Method {
        self.method
    }

    /// Number of receivers, at any height.
    pub fn receivers(&self) -> u64 {
        self.receivers
    }

    /// Number of receivers that no UAV height within ±32 768 m sees.
    pub fn never_los(&self) -> u64 {
        self.receivers - self.steps.last().map_or(0, |s| s.1)
    }

    /// Heights \[1/1024 m above the datum\] at which receivers come into sight, ascending, each with the number of
    /// receivers in sight from there up.
    pub fn steps(&self) -> &[(i32, u64)] {
        &self.steps
    }

    /// Number of receivers in sight of a UAV at `height` \[1/1024 m above the datum\]; 0 below the lowest height.
    pub fn los_at(&self, height: i32) -> u64 {
        let above = self.steps.partition_point(|s| s.0 <= height);
        above.checked_sub(1).map_or(0, |last| self.steps[last].1)
    }

    fn is_over_nodata(&self) -> bool {
        self.uav.placement == HoversOver::Nodata
    }

    /// P_LoS of a UAV at `height` \[1/1024 m above the datum\]; `None` without a receiver, and below the lowest height,
    /// where the UAV cannot be.
    pub fn p_los_at(&self, height: i32) -> Option<f64> {
        share(self.los_at(height), self.receivers).filter(|_| height >= self.lowest && !self.is_over_nodata())
    }

    /// The least height \[1/1024 m above the datum\] from which at least `percent` \[%\] of the receivers are in sight;
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

/// The least UAV heights of the receivers of a map, found some rows at a time: what a curve is counted from.
#[derive(Debug)]
pub struct LeastHeights<'a> {
    view: &'a SceneView<'a>,
    rx_height: i32,
    /// Whether receivers over buildings are above the ground, not the roof.
    are_in_air: bool,
    /// What finds those of many receivers at once, past footprints.
    at_once: Option<GridLos<'a>>,
    positions: GridPositions,
    /// Lowest height that the UAV may have at its place \[1/1024 m\].
    lowest: i32,
    found: Vec<i32>,
}

impl<'a> LeastHeights<'a> {
    /// None yet, over the place of a UAV; with the receivers' height above what they stand on \[1/1024 m\].
    pub fn of(view: &'a SceneView<'a>, (receivers, rx_height): (Receivers, i32)) -> Self {
        let are_in_air = receivers == Receivers::Air;
        let surface = view.below_uav().surface;
        let lowest = if surface == VOID { -MAX_STEP } else { surface };
        let (at_once, positions) = (view.shadows(), view.field().positions());
        LeastHeights { view, rx_height, are_in_air, at_once, positions, lowest, found: Vec::new() }
    }

    /// These after heights that were found before, of other rows of the same map.
    #[must_use]
    pub fn after(self, found: Vec<i32>) -> Self {
        LeastHeights { found, ..self }
    }

    /// The heights found \[1/1024 m above the datum\], to go on with later.
    pub fn into_found(self) -> Vec<i32> {
        self.found
    }

    /// Adds the receivers of rows of a mask from `first_row` on; fewer if it is stopped.
    pub fn add(&mut self, mask: &[u8], first_row: usize, control: &Control) {
        let (n_rows, n_cols) = (self.view.field().grid().n_rows(), self.view.field().grid().n_cols());
        let mut receivers = BitGrid::new(n_rows, n_cols);
        for (row, mask) in (first_row..).zip(mask.chunks(n_cols)) {
            let is_receiver = |(_, class): &(usize, &u8)| matches!(**class, class::LOS | class::NLOS);
            mask.iter().enumerate().filter(is_receiver).for_each(|(col, _)| receivers.insert(row, col));
        }
        let height = |row: usize, col: usize| self.height_of(row, col);
        let lowest = i64::from(self.lowest);
        let at_once = self.at_once.as_ref();
        let at_once =
            at_once.and_then(|engine| engine.least_uav_heights(&self.view.uav().station, &receivers, lowest, &height));
        let of_row = |row: usize| {
            let mut least: Vec<i32> = Vec::new();
            if control.stop.load(Ordering::Relaxed) {
                return least;
            }
            least.extend(set_bits(receivers.row(row)).map(|col| {
                let found = at_once.as_ref().and_then(|found| found.settled((row, col), |z| self.least_step_from(z)));
                found.unwrap_or_else(|| self.least_step((row, col)))
            }));
            control.done.fetch_add(n_cols as u64, Ordering::Relaxed);
            least
        };
        let end = first_row + mask.len().div_ceil(n_cols);
        let rows: Vec<Vec<i32>> = (first_row..end).into_par_iter().map(of_row).collect();
        rows.into_iter().for_each(|row| self.found.extend(row));
    }

    /// Height of the receiver of a cell \[1/1024 m above the datum\].
    fn height_of(&self, row: usize, col: usize) -> i32 {
        let cell = row * self.view.field().grid().n_cols() + col;
        let place = self.positions.center(row, col);
        match self.view.field().cell_kind(cell, &place) {
            CellKind::Building(_) if self.are_in_air => self.view.field().ground_at(&place) + self.rx_height,
            CellKind::Open(stands_on) | CellKind::Building(stands_on) => stands_on + self.rx_height,
            _ => self.rx_height,
        }
    }

    /// The least lattice height of the UAV from which on it sees a receiver, not below the lowest; [`NEVER`] if there is none.
    fn least_step(&self, (row, col): (usize, usize)) -> i32 {
        let receiver = Station { place: self.positions.center(row, col), z: i64::from(self.height_of(row, col)) };
        let step = self.view.least_step(&receiver, i64::from(self.lowest));
        step.and_then(|z| i32::try_from(z).ok()).filter(|z| *z <= MAX_STEP).unwrap_or(NEVER)
    }

    /// That lattice height from any \[1/1024 m above the datum\].
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

    /// The curve of the receivers that were added.
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
        let ground = Some(self.view.below_uav().ground).filter(|z| *z != VOID);
        HeightCurve { uav: self.view.uav().clone(), ground, lowest: self.lowest, receivers, method, steps }
    }
}
