//! Areas from files of vector data.

use super::scene_files::SceneFiles;
use super::sites::{check_placeable, in_scene};
use super::vector::{Selection, bounds, opened, read_features};
use crate::city::Area;
use crate::crs;
use crate::error::{Error, ReadFault, Result, Wanted};
use crate::input::Input;
use crate::raster::GeoRef;

/// Reads an area from the polygons of a file of vector data.
///
/// Positions are longitude and latitude (RFC 7946) unless a `crs` member names another system.
/// Positions beyond the range of degrees are taken for the scene's own coordinates, as those of
/// sites are.
///
/// # Errors
/// File errors naming the feature (E301, E302, E310), and E308 without a polygon. Site errors if a
/// position cannot be brought into the scene's CRS (E206) or no polygon meets the grid (E208).
pub fn read_area(input: impl Into<Input>, grid: &GeoRef) -> Result<Area> {
    let input = &input.into();
    let set = SceneFiles::of(input)
        .and_then(|files| read_features(input, &files, Selection::default(), &mut Vec::new()))
        .map_err(Error::beside_scene)?;
    let named = set.crs.map_err(Error::beside_scene)?;
    let areas: Vec<_> = set.features.into_iter().enumerate().filter(|(_, f)| !f.polygons.is_empty()).collect();
    if areas.is_empty() {
        return Err(Error::read(input, ReadFault::Nothing(Wanted::Area)));
    }
    let is_degrees = bounds(areas.iter().flat_map(|(_, f)| &f.polygons))
        .is_some_and(|b| b[0].abs().max(b[2].abs()) <= 360.0 && b[1].abs().max(b[3].abs()) <= 90.0);
    let from = match named {
        Some(crs) => Some(crs),
        // A scene without a CRS is in local coordinates, and so is an area over it.
        None if is_degrees && grid.crs().is_some() => Some(crs::from_epsg(4326)?),
        None => None,
    };
    check_placeable(input, from.as_ref(), grid.crs())?;
    let mut polygons = Vec::new();
    for (number, feature) in areas {
        let place = format!("polygon `{}`", feature.known_id().unwrap_or_else(|| (number + 1).to_string()));
        let moved = |p: [f64; 2]| {
            let moved = in_scene((p[0], p[1]), from.as_ref(), grid.crs()).map(|(x, y)| [x, y]);
            moved.map_err(|fault| {
                let what = format!("{place}: {fault}");
                Error::read(input, ReadFault::Misplaced { what, is_degrees: false, some_are_good: false })
            })
        };
        for polygon in opened(feature.polygons).0 {
            let ring = |ring: Vec<[f64; 2]>| ring.into_iter().map(moved).collect::<Result<Vec<_>>>();
            polygons.push(polygon.into_iter().map(ring).collect::<Result<Vec<_>>>()?);
        }
    }
    let area = Area::new(polygons);
    if !area.meets(grid) {
        let scene = [grid.x_min(), grid.y_min(), grid.x_max(), grid.y_max()];
        return Err(Error::read(input, ReadFault::OutsideScene(scene)));
    }
    Ok(area)
}
