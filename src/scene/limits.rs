//! Limits of the accuracy of a map, in warnings and captions: the curve of the earth, unknown
//! ground, missing heights.

use crate::city::HeightSources;
use crate::coverage::{Uav, check_drop};
use crate::error::{OddRun, Result, Warning, WarningRepr};
use crate::height_field::{EARTH_RADIUS_M, HeightField};
use crate::quantity::{counted, fixed, tidy};
use crate::raster::GeoRef;
use crate::render::percent;
use crate::sight::SightPlan;
use skyshed_io::Warning as OddFiles;
use skyshed_io::error::{OddFile, OddRaster, Oddity};

/// Returns the limits of the accuracy of a picture, in words.
pub(crate) fn limits_in_words(
    heights: Option<&HeightSources>,
    field: &HeightField,
    warnings: &[Warning],
) -> Option<String> {
    let mut limits: Vec<String> = Vec::new();
    if let Some(heights) = heights.filter(|heights| heights.missing().n > 0) {
        let share = 100.0 * heights.missing().area_share;
        limits.push(format!("{} % of the footprint area has no height: {}", fixed(share, 1), heights.treated()));
    }
    let of_files = warnings.iter().filter_map(|warning| match warning.repr() {
        WarningRepr::Io(OddFiles::File(_, odd)) => Some(odd),
        _ => None,
    });
    limits.extend(of_files.filter_map(|odd| match odd {
        OddFile::GroundOfBases { ground_m, .. } => {
            Some(format!("flat ground at {} m, the median of where buildings begin", tidy(*ground_m)))
        }
        OddFile::LeftOut { fault, n, area_share } => {
            let [one, many] = fault.names();
            let share = fixed(100.0 * area_share, 1);
            Some(format!("{} left out, {share} % of the area with a height", counted(*n as u64, one, many)))
        }
        OddFile::OtherGround { ground_m, range_m, .. } => Some(format!(
            "flat ground at {} m, where buildings begin at {} to {} m",
            tidy(*ground_m),
            tidy(range_m.0),
            tidy(range_m.1)
        )),
        OddFile::Rests { n, .. } => Some(format!(
            "outlines beside parts of {} are as high as the lowest part",
            counted(*n as u64, "building", "buildings")
        )),
        _ => None,
    }));
    let stretched = warnings.iter().find_map(|warning| match warning.repr() {
        WarningRepr::Io(OddFiles::Raster(Oddity { odd: OddRaster::WebMercator { largest_error, .. }, .. })) => {
            Some(*largest_error)
        }
        _ => None,
    });
    limits.extend(stretched.map(|off| format!("web Mercator: lengths are off by up to {} %", fixed(100.0 * off, 2))));
    if let Some(outside) = field.outside_data() {
        let share = percent(outside.count(), field.grid().n_cells() as u64);
        limits.push(format!("no data beyond the footprints ({share} of the extent)"));
    }
    if field.is_surface_only() {
        limits.push("a surface model alone: receivers stand on roofs and trees too".into());
    }
    if warnings.iter().any(|warning| matches!(warning.repr(), WarningRepr::Run(OddRun::FlatEarth { .. }))) {
        limits.push("the earth is taken as flat".into());
    }
    (!limits.is_empty()).then(|| crate::words::title_of(&limits.join("; ")))
}

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
