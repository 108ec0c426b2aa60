//! Method `maps` of a P_LoS study: shares and intervals from maps of a real city, on coarser cells
//! within a tolerance.

use rayon::prelude::*;

use super::coarser::coarsest_within;
use super::plan::PlosPlan;
use super::real::{Group, Real, View, bands, checked_theta_band};
use super::report::{PlosRow, RealCityFacts};
use super::sweep::{Far, Sweeps};
use crate::error::{Error, LimitError, Result};
use crate::height_field::Station;
use crate::los::{Method, MethodChoice};
use crate::los_probability::estimate::{Count, Estimate};
use crate::los_probability::real_city::resampled;
use crate::quantity::MAX_EXTENT_UNITS;

impl Real {
    /// Returns P_LoS from maps, for each height and each angle or distance.
    pub(super) fn rows(
        &self,
        plan: &PlosPlan,
        sweeps: &Sweeps,
        choice: MethodChoice,
    ) -> Result<(Vec<PlosRow>, RealCityFacts)> {
        let grid = self.field.grid();
        let unit = grid.meters_per_unit();
        for frame in [self.field.prisms_frame(), self.field.columns_frame()].into_iter().flatten() {
            let span = ((grid.x_max() - grid.x_min()) / frame.unit_x).max((grid.y_max() - grid.y_min()) / frame.unit_y);
            if span > MAX_EXTENT_UNITS {
                return Err(LimitError::Extent { word: self.word.to_string(), span }.into());
            }
        }
        let size = ((grid.x_max() - grid.x_min()) * unit).min((grid.y_max() - grid.y_min()) * unit);
        let block_m = plan.block_m.unwrap_or((size / 8.0).max(100.0));
        if block_m <= 0.0 {
            return Err(Error::number("the edge of blocks", block_m, "above 0 m"));
        }
        let theta_band = checked_theta_band(plan)?;
        let sight = View { choice, block_m, bands: bands(&sweeps.far, theta_band) };
        let (coarse, tolerance) = match plan.tolerance {
            Some(tolerance) => {
                let (coarse, facts) = coarsest_within(self, plan, (sweeps, &sight), tolerance)?;
                (coarse, Some(facts))
            }
            None => (None, None),
        };
        let field = coarse.as_ref().unwrap_or(&self.field);
        let (method, _) = Method::choose(field, choice).map_err(|wrong| self.refuse(wrong))?;
        let coarse_zones = coarse.as_ref().map(|coarse| self.zones_of(coarse)).transpose()?.flatten();
        let zones = if coarse.is_some() { coarse_zones.as_ref() } else { self.zones.as_ref() };
        let mut rows = Vec::new();
        let (mut n_positions, mut n_inside, mut n_cut, mut n_blocks) = (0, 0, 0, 0);
        for group in Group::all(sweeps) {
            let city = self.city(plan, (field, zones), group.users, &sight)?;
            n_blocks = city.n_blocks();
            let blocks = city.blocks_with_users();
            // Possible UAV positions depend on the radius. Each radius has its own, independent of
            // the other radii.
            let is_alone = |far: &Far| matches!(far, Far::Radius(_));
            for part in sweeps.far.chunk_by(|a, b| !is_alone(a) && !is_alone(b)) {
                let (uavs, cut) = self.positions(plan, part, &group)?;
                n_cut += cut;
                let here = |uav: Station| Station { place: field.place(uav.place.x, uav.place.y), z: uav.z };
                let uavs: Vec<Station> = uavs.into_iter().map(here).collect();
                n_positions += uavs.len();
                n_inside += uavs.iter().filter(|uav| city.is_inside(uav)).count();
                let uavs: Vec<Station> =
                    uavs.into_iter().filter(|uav| !(plan.uav_clear_of_roof && city.is_inside(uav))).collect();
                let bands = bands(part, theta_band);
                let counts: Vec<Vec<Count>> = uavs.par_iter().map(|uav| city.count(uav, &bands)).collect();
                let estimates = resampled(&counts, &blocks, bands.len(), plan.confidence, plan.seed);
                let row = |(far, e): (&Far, Estimate)| self.row(plan, (group, *far), e);
                rows.extend(part.iter().zip(estimates).map(row));
            }
        }
        let facts = RealCityFacts {
            city: self.word.clone(),
            positions: (n_positions, n_inside),
            cut: n_cut,
            theta_band_deg: matches!(sweeps.far.first(), Some(Far::Theta(_))).then_some(theta_band),
            engine: method,
            blocks: (n_blocks, block_m),
            fit: self.fit.clone(),
            limits: self.limits.clone(),
            tolerance,
        };
        Ok((rows, facts))
    }
}
