//! Which buildings decide about receivers, by their heights.

use rayon::prelude::*;

use super::super::curved::CurvedScene;
use crate::coverage::{Control, HeightBounds, Mapper, Uav};
use crate::error::{MapError, Result};
use crate::height_field::Station;
use crate::los::{HeightLimits, PlanCrossings, Wall};
use crate::quantity::STEPS_PER_UNIT;
use crate::raster::set_bits;

/// What hangs on heights of buildings that are off by at most so much.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Deciding {
    /// Receivers in range.
    pub receivers: u64,
    /// Those that are in line of sight for some heights and not for others.
    pub possibly: u64,
    /// For each building of a scene of footprints, by its number, the receivers whose answer its height alone turns, all others as they are known.
    pub by_building: Vec<u64>,
}

impl Mapper<'_> {
    /// What hangs on heights of the buildings of the scene that are off by at most so much \[m\], for one UAV.
    ///
    /// Cost: twice the line of sight of a map, and past footprints a walk for each receiver on a roof, and for each that hangs on the heights.
    ///
    /// # Errors
    /// E118 if the error is no length, or makes a roof leave ±32 768 m, and for an earth so curved that heights would leave the lattice.
    pub fn deciding(&self, uav: &Uav, error_m: f64, control: &Control) -> Result<Deciding> {
        let bounds = HeightBounds::of(self.field, error_m).ok_or(MapError::HeightErrors)?;
        let curved = CurvedScene::checked_around(self, uav)?;
        let curved = curved.as_ref().map(|curved| curved.mapper(self));
        let seen = curved.as_ref().unwrap_or(self);
        let in_range = seen.in_range_by_kind(uav);
        let sure = self.sure_of(uav, &bounds, &in_range)?;
        let mut deciding = Deciding {
            receivers: sure.receivers.count(),
            possibly: sure.possibly.count() - sure.surely.count(),
            by_building: vec![0; self.field.n_buildings()],
        };
        if self.field.prisms().is_none() {
            return Ok(deciding);
        }
        #[expect(clippy::cast_possible_truncation, reason = "bounds were made of it")]
        let error = (error_m * f64::from(STEPS_PER_UNIT)).ceil() as i32;
        let (field, n_cols) = (seen.field, self.field.grid().n_cols());
        for (kind, (receivers, in_range)) in seen.receivers.iter().zip(&in_range).enumerate() {
            let of_row = |counts: Vec<u64>, row: usize| {
                let unsure = in_range.row(row).iter().zip(sure.possibly.row(row)).zip(sure.surely.row(row));
                let unsure: Vec<u64> = unsure.map(|((all, may), does)| all & may & !does).collect();
                let mut counts = counts;
                for col in set_bits(&unsure) {
                    let place = seen.engine.positions().center(row, col);
                    let z = receivers.height(row * n_cols + col);
                    let own = field.building_at(&place).filter(|_| self.is_on_roofs(kind));
                    let link = PlanCrossings::new(field, &uav.station, &Station { place, z }, error, error);
                    let turned = turned_by(error.into(), own, &link);
                    turned.into_iter().for_each(|building| counts[building as usize] += 1);
                }
                counts
            };
            let none = || vec![0; deciding.by_building.len()];
            let rows = (0..in_range.n_rows()).into_par_iter().filter(|_| control.check().is_ok());
            let counts = rows.fold(none, of_row).reduce(none, |a, b| a.iter().zip(&b).map(|(a, b)| a + b).collect());
            deciding.by_building.iter_mut().zip(counts).for_each(|(sum, n)| *sum += n);
        }
        control.check()?;
        Ok(deciding)
    }
}

/// The buildings each of which alone turns the answer for a receiver if it is higher or lower by so much: on the roof of one of them, or on the
/// ground.
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

/// Whether a link is clear, with one building higher by so much.
fn is_clear(limits: &HeightLimits, moved: Option<(u32, i64)>) -> bool {
    let has_room = |of: u32, room: i64| moved.map_or(0, |(building, by)| if building == of { by } else { 0 }) <= room;
    let is_low = |wall: &Wall| (0..2).any(|k| has_room(wall.buildings[k], wall.rooms[k]));
    limits.crossed.iter().all(|(of, room)| has_room(*of, *room)) && limits.walls.iter().all(is_low)
}
