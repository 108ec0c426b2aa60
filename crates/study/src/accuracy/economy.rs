//! Savings that a scene permits: coarser cells, and a terrain without effect.

use super::simpler::{FACTORS, Simpler, moved_to};
use crate::coverage::{MapOptions, Mapper, Uav};
use crate::error::Result;
use crate::height_field::HeightField;
use crate::quantity::share;

/// Least change of P_LoS that counts: a tenth of a percentage point.
pub const NO_CHANGE: f64 = 0.001;

/// UAVs over a scene, and the options of its maps.
#[derive(Clone, Copy)]
pub struct Setup<'a> {
    /// The scene.
    pub field: &'a HeightField,
    /// The UAVs, counted together.
    pub uavs: &'a [Uav],
    /// Options of a map of a form of the scene: cells of zones are those of its own grid.
    pub options: &'a (dyn Fn(&HeightField) -> Result<MapOptions> + Sync),
}

impl std::fmt::Debug for Setup<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Setup").field("uavs", &self.uavs).finish_non_exhaustive()
    }
}

impl Setup<'_> {
    /// Returns the receivers in range and those in line of sight, summed over the UAVs.
    pub fn count(&self) -> Result<(u64, u64)> {
        let options = (self.options)(self.field)?;
        let mapper = Mapper::new(self.field, &options)?;
        count(&mapper, self.uavs)
    }

    /// Returns P_LoS of all UAVs together; `None` without a receiver.
    pub fn p_los(&self) -> Result<Option<f64>> {
        let (receivers, los) = self.count()?;
        Ok(share(los, receivers))
    }

    /// Returns P_LoS of another form of the scene; UAVs keep their places and heights above datum.
    pub(crate) fn p_los_of(&self, field: &HeightField) -> Result<Option<f64>> {
        let uavs: Vec<Uav> = self.uavs.iter().map(|uav| moved_to(uav, field)).collect::<Result<_>>()?;
        Setup { field, uavs: &uavs, options: self.options }.p_los()
    }
}

/// Counts receivers in range and in line of sight, summed over UAVs.
fn count(mapper: &Mapper<'_>, uavs: &[Uav]) -> Result<(u64, u64)> {
    let mut sum = (0, 0);
    for uav in uavs {
        let (receivers, los) = mapper.seen_from(uav)?.count();
        sum = (sum.0 + receivers, sum.1 + los);
    }
    Ok(sum)
}

/// Effect of larger cells on P_LoS.
#[derive(Debug, Clone, PartialEq)]
pub struct CellEffect {
    /// Form of the scene.
    pub form: Simpler,
    /// P_LoS of the form, or the reason why there is none.
    pub p_los: std::result::Result<f64, String>,
}

/// Computes the effect of larger cells on P_LoS, the finest first.
pub fn cell_effects(setup: &Setup<'_>) -> Vec<CellEffect> {
    let effect = |form: Simpler| {
        let p_los = match form.of(setup.field).map(|field| setup.p_los_of(&field)) {
            Some(Ok(Some(p_los))) => Ok(p_los),
            Some(Err(why)) => Err(why.to_string()),
            Some(Ok(None)) | None => Err("no receiver in range".into()),
        };
        CellEffect { form, p_los }
    };
    Simpler::forms(setup.field, &FACTORS).into_iter().map(effect).collect()
}

/// Returns the coarsest form up to which every form of its kind changes P_LoS by less than
/// [`NO_CHANGE`]; `None` if the finest already changes it by that or more.
pub fn coarsest_unchanged(effects: &[CellEffect], p_los: f64) -> Option<Simpler> {
    let mut best: Option<Simpler> = None;
    let mut poolings: Vec<_> = effects.iter().map(|e| e.form.pooling).collect();
    poolings.dedup();
    for pooling in poolings {
        let of_kind = effects.iter().filter(|e| e.form.pooling == pooling);
        let is_unchanged = |e: &&CellEffect| e.p_los.as_ref().is_ok_and(|p| (p - p_los).abs() < NO_CHANGE);
        let last = of_kind.take_while(is_unchanged).last();
        best = best.into_iter().chain(last.map(|e| e.form)).max_by_key(|form| form.factor);
    }
    best
}

/// Effect of the terrain of a scene.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TerrainEffect {
    /// No effect: the ground is flat, or not known apart from the surface.
    None,
    /// Receivers that the terrain would hide without buildings, summed over the UAVs.
    Hides {
        /// Receivers that it hides.
        hidden: u64,
        /// Receivers in range.
        receivers: u64,
    },
}

/// Computes the effect of the terrain alone.
pub fn terrain_effect(setup: &Setup<'_>) -> Result<TerrainEffect> {
    let Some(terrain) = setup.field.terrain_alone() else { return Ok(TerrainEffect::None) };
    // Receivers stay those of the scene with buildings; removing a building adds none.
    let options = (setup.options)(setup.field)?;
    let cells = Mapper::new(setup.field, &options)?.receiver_cells();
    let options = MapOptions { within: Some(cells), receivers: crate::coverage::Receivers::Ground, ..options };
    let mapper = Mapper::new(&terrain, &options)?;
    let (receivers, los) = count(&mapper, setup.uavs)?;
    Ok(TerrainEffect::Hides { hidden: receivers - los, receivers })
}

/// Effect of flat roofs, each at the height of its highest point, in place of shaped ones.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoofEffect {
    /// Buildings whose roofs are not flat.
    pub shaped: usize,
    /// Receivers with another answer, summed over the UAVs; only receivers of both forms count.
    pub turned: u64,
    /// Receivers of both forms, summed over the UAVs.
    pub receivers: u64,
    /// P_LoS with flat roofs; `None` without a receiver.
    pub p_los: Option<f64>,
}

/// Computes the effect of flat roofs; `None` if all roofs are flat.
///
/// # Errors
/// As [`Uav::place`]: a UAV beside a roof may be below its ridge.
pub fn roof_effect(setup: &Setup<'_>) -> Result<Option<RoofEffect>> {
    let Some(flat) = setup.field.with_flat_roofs() else { return Ok(None) };
    let (own, of_flat) = ((setup.options)(setup.field)?, (setup.options)(&flat)?);
    let (own, of_flat) = (Mapper::new(setup.field, &own)?, Mapper::new(&flat, &of_flat)?);
    let mut effect = RoofEffect {
        shaped: setup.field.n_buildings_with_shaped_roofs(),
        turned: 0,
        receivers: 0,
        p_los: setup.p_los_of(&flat)?,
    };
    for uav in setup.uavs {
        let (as_is, as_flat) = (own.seen_from(uav)?.seen(), of_flat.seen_from(&moved_to(uav, &flat)?)?.seen());
        let both = as_is.receivers.and(&as_flat.receivers);
        effect.receivers += both.count();
        effect.turned += as_is.los.xor(&as_flat.los).and(&both).count();
    }
    Ok(Some(effect))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::height_field::Pooling;

    #[test]
    fn the_coarsest_form_is_the_last_before_p_los_first_changes() {
        let effect = |factor: usize, pooling, p_los: f64| CellEffect {
            form: Simpler { factor, pooling: Some(pooling) },
            p_los: Ok(p_los),
        };
        let (mean, maximum) = (Pooling::Mean, Pooling::Maximum);
        let effects = [
            effect(2, mean, 0.5005),
            effect(2, maximum, 0.4996),
            effect(4, mean, 0.502),
            effect(4, maximum, 0.4995),
            // Right by chance, behind one that is not.
            effect(8, mean, 0.5),
            effect(8, maximum, 0.48),
        ];
        assert_eq!(coarsest_unchanged(&effects, 0.5), Some(Simpler { factor: 4, pooling: Some(maximum) }));
        assert_eq!(coarsest_unchanged(&effects, 0.6), None);
        assert_eq!(coarsest_unchanged(&[], 0.6), None);
    }
}
