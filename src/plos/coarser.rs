//! Tolerance over a real city: the coarsest sufficient cells for its maps, measured from some of
//! the positions.

use rayon::prelude::*;

use super::plan::PlosPlan;
use super::real::{Group, Real, View};
use super::report::{PlosToleranceFacts, PlosTried};
use super::sweep::Sweeps;
use crate::accuracy::{CONFIDENCE, FACTORS, Paired, Simpler, paired_difference};
use crate::error::Result;
use crate::height_field::{HeightField, Station};
use crate::los_probability::estimate::Count;

/// Most positions of a group from which maps of both forms are compared.
const COMPARED: usize = 32;

/// Returns the form of a city to map, `None` for the city itself, and the measurements.
pub(super) fn coarsest_within(
    real: &Real,
    plan: &PlosPlan,
    (sweeps, sight): (&Sweeps, &View),
    tolerance: f64,
) -> Result<(Option<HeightField>, PlosToleranceFacts)> {
    let groups = Group::all(sweeps);
    let mut compared: Vec<Vec<Station>> = Vec::with_capacity(groups.len());
    let mut are_all = true;
    for group in &groups {
        let (mut uavs, _) = real.positions(plan, &sweeps.far, group)?;
        are_all &= uavs.len() <= COMPARED;
        uavs.truncate(COMPARED);
        compared.push(uavs);
    }
    let count = |field: &HeightField| -> Result<Vec<Vec<Vec<Count>>>> {
        groups.iter().zip(&compared).map(|(group, uavs)| totals(real, plan, (field, sight), (group, uavs))).collect()
    };
    let exact = count(&real.field)?;
    let coarsest_first: Vec<usize> = FACTORS.into_iter().rev().collect();
    let forms = Simpler::forms(&real.field, &coarsest_first);
    let n_values = groups.len() * sweeps.far.len();
    let risk = (1.0 - CONFIDENCE) / (2 * forms.len() * n_values).max(1) as f64;
    let grid = real.field.grid();
    let mut facts = PlosToleranceFacts {
        tolerance,
        cell_m: grid.cell_width() * grid.meters_per_unit(),
        taken: Simpler::SAME,
        positions: compared.iter().map(Vec::len).sum(),
        tried: Vec::new(),
    };
    for form in forms {
        let Some(field) = form.of(&real.field) else { continue };
        let tried = match count(&field) {
            Ok(coarse) => bound(&coarse, &exact, are_all, risk),
            Err(why) => Err(why.to_string()),
        };
        let is_within = tried.as_ref().is_ok_and(|bound| *bound <= tolerance);
        facts.tried.push(PlosTried { form, bound: tried });
        if is_within {
            facts.taken = form;
            return Ok((Some(field), facts));
        }
    }
    Ok((None, facts))
}

/// Counts the users and the links of a group by maps of a form of the city, `[position][band]`.
fn totals(
    real: &Real,
    plan: &PlosPlan,
    (field, sight): (&HeightField, &View),
    (group, uavs): (&Group, &[Station]),
) -> Result<Vec<Vec<Count>>> {
    let zones = real.zones_of(field)?;
    let city = real.city(plan, (field, zones.as_ref()), group.users, sight)?;
    let of_uav = |uav: &Station| {
        let uav = Station { place: field.place(uav.place.x, uav.place.y), z: uav.z };
        if plan.uav_clear_of_roof && city.is_inside(&uav) {
            return vec![Count::default(); sight.n_bands()];
        }
        let counts = sight.count(&city, &uav);
        let mut sums = vec![Count::default(); sight.n_bands()];
        for of_block in counts.chunks(sight.n_bands()) {
            for (sum, count) in sums.iter_mut().zip(of_block) {
                sum.receivers += count.receivers;
                sum.los += count.los;
            }
        }
        sums
    };
    Ok(uavs.par_iter().map(of_uav).collect())
}

/// Returns the largest bound over all values. Fails with a reason if one value has no bound.
fn bound(
    coarse: &[Vec<Vec<Count>>],
    exact: &[Vec<Vec<Count>>],
    are_all: bool,
    risk: f64,
) -> std::result::Result<f64, String> {
    let mut most = 0.0_f64;
    for (coarse, exact) in coarse.iter().zip(exact) {
        let n_bands = exact.first().map_or(0, Vec::len);
        for band in 0..n_bands {
            let pairs: Vec<(Count, Count)> = coarse.iter().zip(exact).map(|(c, e)| (c[band], e[band])).collect();
            if pairs.iter().all(|(c, e)| c.receivers == 0 && e.receivers == 0) {
                continue;
            }
            match paired_difference(&pairs, are_all, risk) {
                Some(Paired { bound, .. }) => most = most.max(bound),
                None => return Err("too few positions with users to compare a value".into()),
            }
        }
    }
    Ok(most)
}
