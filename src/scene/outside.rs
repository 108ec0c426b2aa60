//! UAVs beside the grid: they may hover there, but more often a coordinate is wrong.

use std::borrow::Borrow;

use crate::city::Site;
use crate::coverage::Uav;
use crate::error::{Result, Warning};
use crate::height_field::HeightField;
use crate::quantity::tidy;
use crate::raster::GeoRef;

/// Says how far outside the grid UAVs are, and in which direction.
pub(crate) fn warn_of_uavs_outside<S: Borrow<Site>>(sites: &[S], grid: &GeoRef, warnings: &mut Vec<Warning>) {
    /// UAVs that are told one by one.
    const MOST_TOLD: usize = 5;
    let outside: Vec<(&str, String)> = sites
        .iter()
        .map(Borrow::borrow)
        .filter_map(|site| Some((site.id.as_str(), way_outside(site, grid)?)))
        .collect();
    let text = match &outside[..] {
        [] => return,
        [(id, way)] => format!("UAV `{id}` is {way} of the grid"),
        several => {
            let told: Vec<String> = several.iter().take(MOST_TOLD).map(|(id, way)| format!("`{id}` {way}")).collect();
            let n_more = several.len().saturating_sub(MOST_TOLD);
            let more = if n_more > 0 { format!(", and {n_more} more") } else { String::new() };
            format!("{} UAVs are outside the grid: {}{more}", several.len(), told.join(", "))
        }
    };
    warnings.push(Warning::new(204, text));
}

/// Places a UAV; what is wrong outside the grid is told with how far outside.
pub(crate) fn place_uav(site: &Site, field: &HeightField, grid: &GeoRef, radius: Option<f64>) -> Result<Uav> {
    Ok(Uav::place(site, field, radius).map_err(|error| match way_outside(site, grid) {
        Some(way) => error.within(format!("{way} of the grid")),
        None => error,
    })?)
}

/// How far and in which direction a site is from the nearest point of the grid; nothing inside.
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
    fn the_way_from_the_grid_is_told_of_a_few() {
        let grid = GeoRef::new((100.0, 200.0), (1.0, 1.0), (50, 50), None).expect("a valid grid");
        let site = |(k, [x, y]): (usize, &[f64; 2])| Site {
            id: k.to_string(),
            x: *x,
            y: *y,
            height: Height::AboveGround(9.0),
        };
        let told = |places: &[[f64; 2]]| {
            let mut warnings = Vec::new();
            let sites: Vec<Site> = places.iter().enumerate().map(site).collect();
            warn_of_uavs_outside(&sites, &grid, &mut warnings);
            warnings.iter().map(|w| w.text().to_string()).collect::<Vec<_>>()
        };
        // The corners and edges of the grid belong to it.
        assert_eq!(told(&[[100.0, 150.0], [150.0, 200.0], [120.0, 170.0]]), Vec::<String>::new());
        assert_eq!(told(&[[120.0, 170.0], [97.0, 146.0]]), ["UAV `1` is 5 m south-west of the grid"]);
        assert_eq!(told(&[[120.0, 30_200.0]]), ["UAV `0` is 30 km north of the grid"]);
        let many = told(&[[151.5, 170.0]; 7]);
        assert!(many[0].starts_with("7 UAVs are outside the grid: `0` 1.5 m east, `1`"), "{many:?}");
        assert!(many.len() == 1 && many[0].ends_with("`4` 1.5 m east, and 2 more"), "{many:?}");
    }
}
