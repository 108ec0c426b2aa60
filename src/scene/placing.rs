//! Placing of UAVs over a scene. A UAV may hover outside the grid, but a wrong coordinate is more
//! likely, so this warns.

use std::borrow::Borrow;

use super::Scene;
use crate::city::Site;
use crate::coverage::Uav;
use crate::earth::check_earth;
use crate::error::{CoreError, Error, ErrorRepr, OddRun, PlacesError, Result, UavError, Warning};
use crate::height_field::HeightField;
use crate::quantity::{Height, tidy};
use crate::raster::GeoRef;
use crate::sight::{SightPlan, check_receivers};
use crate::uav::UavsFound;
use skyshed_request::BadUavs;

impl Scene {
    /// Places UAVs, and keeps their sources and warnings. `whole` is the grid of the whole scene if
    /// this one is a part.
    ///
    /// # Errors
    /// E2xx for a UAV that cannot be there; E117 for receivers that the scene does not distinguish;
    /// E118 if a curved earth moves heights off the lattice.
    pub(crate) fn place(&mut self, found: &UavsFound, whole: Option<&GeoRef>, sight: &SightPlan) -> Result<Vec<Uav>> {
        let whole = whole.unwrap_or(self.grid()).clone();
        self.warnings.extend(found.warnings.iter().cloned());
        warn_of_uavs_outside(&found.sites, &whole, &mut self.warnings);
        self.place_in_tile(found, &whole, sight)
    }

    /// Places UAVs over a part of a grid without warning of UAVs outside. That warning comes once
    /// for all parts.
    ///
    /// # Errors
    /// As [`Scene::place`].
    pub(crate) fn place_in_tile(&mut self, found: &UavsFound, whole: &GeoRef, sight: &SightPlan) -> Result<Vec<Uav>> {
        self.sources.extend(found.sources.iter().cloned());
        let found = &*found.over(&self.field)?;
        let radius = sight.radius_on(whole);
        let place = |site: &Site| place_uav(site, &self.field, whole, radius);
        let uavs = place_all(found, place, &mut self.warnings)?;
        check_receivers(sight.receivers(), self.field.is_surface_only())?;
        check_earth(&uavs, &self.field, sight, &mut self.warnings)?;
        Ok(uavs)
    }
}

/// Places the UAVs of a run. Those that cannot be at their place are refused together, left out or
/// lifted, as the run says.
///
/// # Errors
/// E2xx: that of the only bad UAV, or one that names all of them.
pub(crate) fn place_all(
    found: &UavsFound,
    place: impl Fn(&Site) -> Result<Uav>,
    warnings: &mut Vec<Warning>,
) -> Result<Vec<Uav>> {
    let (mut uavs, mut faults, mut lifted) = (Vec::with_capacity(found.sites.len()), Vec::new(), Vec::new());
    for given in &found.sites {
        let site = &given.site;
        let lift = |error: &Error| {
            let top_m = top_of(error).filter(|_| found.bad == BadUavs::Lift)?;
            place(&Site { height: Height::AboveDatum(top_m), ..site.clone() }).ok()
        };
        match place(site) {
            Ok(uav) => uavs.push(uav),
            Err(error) => match lift(&error) {
                Some(uav) => {
                    lifted.push((site.id.clone(), tidy(uav.height_amsl_m())));
                    uavs.push(uav);
                }
                None => faults.push((site.id.clone(), error)),
            },
        }
    }
    let is_lenient = found.bad != BadUavs::Fail && !uavs.is_empty();
    if !faults.is_empty() && !is_lenient {
        return Err(match <[_; 1]>::try_from(faults) {
            Ok([(_, only)]) => only,
            Err(faults) => {
                let code = faults[0].1.code().trim_start_matches('E').parse().unwrap_or(201);
                let faults = faults.into_iter().map(|(id, error)| (id, error.to_string())).collect();
                PlacesError::BadUavs { of: found.sites.len(), faults, code }.into()
            }
        });
    }
    if !faults.is_empty() || !lifted.is_empty() {
        let left_out = faults.into_iter().map(|(id, error)| (id, error.to_string())).collect();
        warnings.push(OddRun::BadUavs { left_out, lifted }.into());
    }
    Ok(uavs)
}

/// Returns the top of what a UAV is in \[m above the datum\], if that is why it cannot be there.
fn top_of(error: &Error) -> Option<f64> {
    let ErrorRepr::Core(error) = error.repr() else { return None };
    match error.innermost() {
        CoreError::Uav { why: UavError::InsideBuilding { roof_m, .. }, .. } => Some(*roof_m),
        CoreError::Uav { why: UavError::BelowGround { surface_m, .. }, .. } => Some(*surface_m),
        _ => None,
    }
}

/// Warns of UAVs outside the grid, with distance and direction.
pub(crate) fn warn_of_uavs_outside<S: Borrow<Site>>(sites: &[S], grid: &GeoRef, warnings: &mut Vec<Warning>) {
    let sites = sites.iter().map(Borrow::borrow);
    let outside: Vec<_> = sites.filter_map(|site| Some((site.id.clone(), way_outside(site, grid)?))).collect();
    if !outside.is_empty() {
        warnings.push(OddRun::OutsideGrid(outside).into());
    }
}

/// Places a UAV. The error of a UAV outside the grid holds its distance and direction.
pub(crate) fn place_uav(site: &Site, field: &HeightField, grid: &GeoRef, radius: Option<f64>) -> Result<Uav> {
    Uav::place_in_part(site, field, grid, radius).map_err(|error| match way_outside(site, grid) {
        Some(way) => error.within(format!("{way} of the grid")).into(),
        None => error.into(),
    })
}

/// Returns the distance and direction of a site from the grid; `None` inside.
fn way_outside(site: &Site, grid: &GeoRef) -> Option<String> {
    let beyond = |v: f64, low: f64, high: f64| (v - high).max(0.0) + (v - low).min(0.0);
    let (east, north) = (beyond(site.x, grid.x_min(), grid.x_max()), beyond(site.y, grid.y_min(), grid.y_max()));
    let distance_m = east.hypot(north) * grid.meters_per_unit();
    if distance_m <= 0.0 {
        return None;
    }
    let word = |v: f64, names: [&'static str; 2]| match v {
        v if v > 0.0 => names[0],
        v if v < 0.0 => names[1],
        _ => "",
    };
    let directions = [word(north, ["north", "south"]), word(east, ["east", "west"])];
    let direction = directions.into_iter().filter(|name| !name.is_empty()).collect::<Vec<_>>().join("-");
    let distance = if distance_m < 10_000.0 { tidy(distance_m) + " m" } else { tidy(distance_m / 1000.0) + " km" };
    Some(format!("{distance} {direction}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Height;

    #[test]
    fn the_way_from_the_grid_is_told_in_kilometers_and_of_a_few() {
        let grid = GeoRef::new((100.0, 200.0), (1.0, 1.0), (50, 50), None).expect("a valid grid");
        let site = |(k, [x, y]): (usize, &[f64; 2])| Site::new(k.to_string(), (*x, *y), Height::AboveGround(9.0));
        let told = |places: &[[f64; 2]]| {
            let mut warnings = Vec::new();
            let sites: Vec<Site> = places.iter().enumerate().map(site).collect();
            warn_of_uavs_outside(&sites, &grid, &mut warnings);
            warnings.iter().map(ToString::to_string).collect::<Vec<_>>()
        };
        assert_eq!(told(&[[120.0, 30_200.0]]), ["UAV `0` is 30 km north of the grid"]);
        let many = told(&[[151.5, 170.0]; 7]);
        assert!(many.len() == 1 && many[0].ends_with("`4` 1.5 m east, and 2 more"), "{many:?}");
    }
}
