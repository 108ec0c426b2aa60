//! Buildings whose heights decide about receivers.

use rayon::prelude::*;

use crate::coverage::Control;
use crate::coverage::view::{HeightBounds, View};
use crate::error::{MapError, Result};
use crate::los::{HeightLimits, PlanCrossings, Wall};
use crate::quantity::STEPS_PER_UNIT;
use crate::raster::set_bits;

/// Answers that depend on heights of buildings that are off by at most so much.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Deciding {
    /// Receivers in range.
    pub receivers: u64,
    /// Receivers in line of sight for some heights and not for others.
    pub possibly: u64,
    /// For each building of a scene of footprints, by its number, the receivers whose answer its
    /// height alone turns, all others as they are known.
    pub by_building: Vec<u64>,
}

impl View<'_> {
    /// Finds the answers that depend on heights of buildings that are off by at most `error_m`, and
    /// the buildings that they depend on.
    ///
    /// Cost: twice the line of sight of a map, and past footprints a walk for each receiver on a
    /// roof, and for each that depends on the heights.
    ///
    /// # Errors
    /// E118 if the error is no length, or makes a roof leave ±32 768 m.
    pub fn deciding(&self, error_m: f64, control: &Control) -> Result<Deciding> {
        let scene = self.mapper.field;
        let bounds = HeightBounds::of(scene, error_m).ok_or(MapError::HeightErrors)?;
        let sure = self.sure(&bounds)?;
        let mut deciding = Deciding {
            receivers: sure.receivers.count(),
            possibly: sure.possibly.count() - sure.surely.count(),
            by_building: vec![0; scene.n_buildings()],
        };
        if scene.prisms().is_none() {
            return Ok(deciding);
        }
        #[expect(clippy::cast_possible_truncation, reason = "bounds were made of it")]
        let error = (error_m * f64::from(STEPS_PER_UNIT)).ceil() as i32;
        let unsure = sure.possibly.and(&sure.surely.complement());
        for receivers in self.receivers() {
            let wanted = receivers.in_range().into_owned().and(&unsure);
            let of_row = |mut counts: Vec<u64>, row: usize| {
                for col in set_bits(wanted.row(row)) {
                    let receiver = receivers.station((row, col));
                    let own = self.field().building_at(&receiver.place).filter(|_| receivers.are_on_roofs());
                    let link = PlanCrossings::new(self.field(), &self.uav().station, &receiver, error, error);
                    let turned = turned_by(error.into(), own, &link);
                    turned.into_iter().for_each(|building| counts[building as usize] += 1);
                }
                counts
            };
            let none = || vec![0; deciding.by_building.len()];
            let rows = (0..wanted.n_rows()).into_par_iter().filter(|_| !control.is_stopped());
            let counts = rows.fold(none, of_row).reduce(none, |a, b| a.iter().zip(&b).map(|(a, b)| a + b).collect());
            deciding.by_building.iter_mut().zip(counts).for_each(|(sum, n)| *sum += n);
        }
        control.check()?;
        Ok(deciding)
    }
}

/// Returns the buildings each of which alone turns the answer for a receiver if it is higher or
/// lower by `error`. The receiver is on the roof of `own`, or on the ground.
fn turned_by(error: i64, own: Option<u32>, link: &PlanCrossings<'_>) -> Vec<u32> {
    let with_own = |by: i64| match own {
        Some(building) => link.limits(by)?.with_error_of(building, by),
        None => link.limits(by),
    };
    let known = with_own(0);
    let is_clear = known.as_ref().is_some_and(|limits| is_clear(limits, None));
    let mut turned = Vec::new();
    if let Some(building) = own {
        let is_clear_at = |by: i64| with_own(by).is_some_and(|limits| self::is_clear(&limits, None));
        if is_clear_at(-error) != is_clear || is_clear_at(error) != is_clear {
            turned.push(building);
        }
    }
    let Some(known) = known else { return turned };
    let sides = known.walls.iter().flat_map(|wall| wall.buildings);
    let mut others: Vec<u32> = known.crossed.iter().map(|(of, _)| *of).chain(sides).collect();
    others.sort_unstable();
    others.dedup();
    // A higher building never makes a link clear.
    let by = if is_clear { error } else { -error };
    turned.extend(others.into_iter().filter(|of| self::is_clear(&known, Some((*of, by))) != is_clear));
    turned
}

/// Returns whether a link is clear, with one building higher by so much.
fn is_clear(limits: &HeightLimits, moved: Option<(u32, i64)>) -> bool {
    let has_room = |of: u32, room: i64| moved.map_or(0, |(building, by)| if building == of { by } else { 0 }) <= room;
    let is_low = |wall: &Wall| (0..2).any(|k| has_room(wall.buildings[k], wall.rooms[k]));
    limits.crossed.iter().all(|(of, room)| has_room(*of, *room)) && limits.walls.iter().all(is_low)
}
