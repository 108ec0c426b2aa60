//! The probability that a receiver is in line of sight, where heights of buildings are off by normal errors.
//!
//! Two exact maps tell of most receivers on the ground, with all buildings as low and as high as six standard deviations make them ([`super::sure`]). For each of the
//! others the shadows of higher buildings tell ([`crate::los::shadow_clear_probabilities`]), where no terrain is below them. Else, and
//! for each receiver on a roof, one walk finds how much higher each building may be so that its link is clear, and [`super::height_errors`] what is the probability of that.

use rayon::prelude::*;

use super::super::curved::CurvedScene;
use super::height_errors::CERTAIN;
use super::sure::{HeightBounds, Sure};
use crate::coverage::{Control, HeightErrors, Mapper, Uav};
use crate::error::{MapError, Result};
use crate::height_field::{HeightField, Station};
use crate::los::{ClearProbabilities, GridReceivers, PlanCrossings};
use crate::quantity::STEPS_PER_UNIT;
use crate::raster::{BitGrid, set_bits};

/// A scene of footprints with the errors of their heights, ready for any number of UAVs.
#[derive(Debug)]
pub struct UncertainHeights {
    errors: HeightErrors,
    /// As far as errors are reckoned with.
    bounds: HeightBounds,
    /// The most that a top is above the known one by an error that is reckoned with \[1/1024 m\].
    reach: i32,
}

impl UncertainHeights {
    /// Makes ready; `None` if an error is no length, or makes a roof leave ±32 768 m, or there is not one for each building.
    pub fn of(field: &HeightField, errors: &HeightErrors) -> Option<Self> {
        let bounds = HeightBounds::within(field, errors, CERTAIN)?;
        // The sum of two errors is no more than √2 of what both together are.
        let most = (0..u32::try_from(field.n_buildings()).ok()?).map(|b| errors.own_m(b)).fold(0.0, f64::max);
        #[expect(clippy::cast_possible_truncation, reason = "saturates")]
        let reach = (CERTAIN * (most + errors.shared_m) * f64::from(STEPS_PER_UNIT)).ceil() as i32;
        Some(UncertainHeights { errors: errors.clone(), bounds, reach })
    }
}

impl Mapper<'_> {
    /// The probability that each receiver of a UAV is in line of sight, with errors of the heights of the same scene; NaN where there is no receiver
    /// in range. Shape `[n_rows, n_cols]`, row 0 north. Without errors it is the mask: 0 or 1. A receiver on a roof is as much higher or lower as
    /// that.
    ///
    /// It is good to about 10⁻⁵; to 2·10⁻⁴ for errors of 1 m along walls with sloped roofs, where rooms are whole steps of the lattice.
    ///
    /// Cost: twice the line of sight of a map, and the shadows of higher buildings, with an error that is shared for some values of it; a walk for each
    /// receiver on a roof, and for each that hangs on the heights over a terrain, beside sloped roofs and on a curved earth.
    ///
    /// # Errors
    /// E118 for a raster, whose buildings are not told apart, and for an earth so curved that heights would leave the lattice.
    pub fn p_los(&self, uav: &Uav, heights: &UncertainHeights, control: &Control) -> Result<Vec<f32>> {
        if self.field.prisms().is_none() {
            return Err(MapError::RasterProbabilities.into());
        }
        let curved = CurvedScene::checked_around(self, uav)?;
        let curved = curved.as_ref().map(|curved| curved.mapper(self));
        let seen = curved.as_ref().unwrap_or(self);
        let in_range = seen.in_range_by_kind(uav);
        // Receivers on roofs are settled by one walk each, not by two maps.
        let on_ground: Vec<BitGrid> = in_range
            .iter()
            .enumerate()
            .map(
                |(kind, cells)| {
                    if self.is_on_roofs(kind) { BitGrid::new(cells.n_rows(), cells.n_cols()) } else { cells.clone() }
                },
            )
            .collect();
        let sure = self.sure_of(uav, &heights.bounds, &on_ground)?;
        let n_cols = self.field.grid().n_cols();
        let mut p_los = vec![f32::NAN; self.field.grid().n_cells()];
        for (kind, (receivers, in_range)) in seen.receivers.iter().zip(&in_range).enumerate() {
            let is_on_roofs = self.is_on_roofs(kind);
            let unsure = in_range.clone().and(&sure.possibly).and(&sure.surely.complement());
            let steps = f64::from(STEPS_PER_UNIT);
            let own = |building: u32| heights.errors.own_m(building) * steps;
            let deviations = (&own, heights.errors.shared_m * steps);
            let cast = || seen.engine.clear_probabilities(&uav.station, receivers, &unsure, deviations);
            // Receivers on roofs move.
            let cast = if is_on_roofs { None } else { cast() };
            let of = OfKind { mapper: seen, uav, heights, receivers, is_on_roofs, cast };
            p_los.par_chunks_mut(n_cols).enumerate().for_each(|(row, out)| {
                if control.check().is_ok() {
                    of.fill(row, in_range, &sure, out);
                }
            });
        }
        control.check()?;
        Ok(p_los)
    }
}

/// The receivers of one kind, as a UAV sees them.
struct OfKind<'a> {
    mapper: &'a Mapper<'a>,
    uav: &'a Uav,
    heights: &'a UncertainHeights,
    receivers: &'a GridReceivers<'a>,
    is_on_roofs: bool,
    /// What shadows tell, if they do.
    cast: Option<ClearProbabilities>,
}

impl OfKind<'_> {
    fn fill(&self, row: usize, in_range: &BitGrid, sure: &Sure, out: &mut [f32]) {
        for col in set_bits(in_range.row(row)) {
            out[col] = match (sure.surely.contains(row, col), sure.possibly.contains(row, col)) {
                (true, _) if !self.is_on_roofs => 1.0,
                (_, false) if !self.is_on_roofs => 0.0,
                _ => {
                    let cast = self.cast.as_ref().and_then(|cast| cast.of(row, col));
                    #[expect(clippy::cast_possible_truncation, reason = "layers are stored as f32")]
                    let p = cast.unwrap_or_else(|| self.probability(row, col)) as f32;
                    p
                }
            };
        }
    }

    fn probability(&self, row: usize, col: usize) -> f64 {
        let field = self.mapper.field;
        let place = self.mapper.engine.positions().center(row, col);
        let receiver = Station { place, z: self.receivers.height(row * field.grid().n_cols() + col) };
        let UncertainHeights { errors, bounds, reach } = self.heights;
        let link = |fall: i32| PlanCrossings::new(field, &self.uav.station, &receiver, fall, *reach);
        match field.building_at(&place).filter(|_| self.is_on_roofs) {
            Some(building) => errors.probability_on_roof(building, &link(bounds.of_building(building))),
            None => errors.probability(None, &link(0)),
        }
    }
}
