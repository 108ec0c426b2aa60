//! Warnings about an earth that is taken as flat, and checks of a curved one.

use crate::coverage::{Uav, check_drop};
use crate::error::{OddRun, Result, Warning};
use crate::height_field::{EARTH_RADIUS_M, HeightField};
use crate::raster::GeoRef;
use crate::sight::SightPlan;

/// Warns where a flat earth matters: where the drop d²/2R at the farthest receiver exceeds 1 m.
pub(crate) fn warn_of_flat_earth(uavs: &[Uav], grid: &GeoRef, sight: &SightPlan, warnings: &mut Vec<Warning>) {
    if sight.curvature().is_none() {
        warn_of_drop(farthest_m(uavs, grid, sight), warnings);
    }
}

/// Warns as [`warn_of_flat_earth`], and checks that a curved earth keeps all heights on the
/// lattice.
///
/// # Errors
/// E118.
pub(crate) fn check_earth(
    uavs: &[Uav],
    field: &HeightField,
    sight: &SightPlan,
    warnings: &mut Vec<Warning>,
) -> Result<()> {
    warn_of_flat_earth(uavs, field.grid(), sight, warnings);
    let drop_m = sight.curvature().map_or(0.0, |of| of.drop_m(farthest_m(uavs, field.grid(), sight)));
    Ok(check_drop(drop_m, field.lowest_known())?)
}

/// Returns the largest possible distance of a receiver from some UAVs \[m\].
fn farthest_m(uavs: &[Uav], grid: &GeoRef, sight: &SightPlan) -> f64 {
    let of = |uav: &Uav| {
        let place = &uav.station.place;
        let dx = (grid.x_max() - place.x).abs().max((grid.x_min() - place.x).abs());
        let dy = (grid.y_max() - place.y).abs().max((grid.y_min() - place.y).abs());
        dx.hypot(dy) * grid.meters_per_unit()
    };
    uavs.iter().map(of).fold(0.0, f64::max).min(sight.radius_m().unwrap_or(f64::INFINITY))
}

/// Warns as [`warn_of_flat_earth`] where UAVs and receivers are anywhere on a grid, at most
/// `most_m` apart. `is_choice` is `true` if the user could have curved the earth.
pub(crate) fn warn_of_drop_across(grid: &GeoRef, most_m: f64, is_choice: bool, warnings: &mut Vec<Warning>) {
    warnings.extend(flat_earth(across_m(grid).min(most_m), is_choice));
}

/// Returns the diagonal of the grid \[m\].
pub(crate) fn across_m(grid: &GeoRef) -> f64 {
    (grid.x_max() - grid.x_min()).hypot(grid.y_max() - grid.y_min()) * grid.meters_per_unit()
}

/// Warns as [`warn_of_flat_earth`] for receivers at most `farthest_m` away.
pub(crate) fn warn_of_drop(farthest_m: f64, warnings: &mut Vec<Warning>) {
    warnings.extend(flat_earth(farthest_m, true));
}

fn flat_earth(farthest_m: f64, is_choice: bool) -> Option<Warning> {
    let drop_m = farthest_m * farthest_m / (2.0 * EARTH_RADIUS_M);
    (drop_m > 1.0).then(|| OddRun::FlatEarth { farthest_m, drop_m, is_choice }.into())
}
