//! Footprints as GeoJSON.

use serde_json::{Value, json};

use crate::answer::{feature, feature_collection};
use crate::city::Footprint;
use crate::quantity::{Frame, meters};
use crate::raster::GeoRef;

/// Returns footprints as a GeoJSON FeatureCollection with `height`, `ground` and `z_top` \[m\].
/// Shells are counterclockwise and holes clockwise (RFC 7946). Coordinates are in the grid's CRS,
/// which is named if it has an EPSG code.
pub(super) fn of_footprints(footprints: &[Footprint], frame: Frame, grid: &GeoRef, provenance: Value) -> Value {
    let position = |p: &[i32; 2]| {
        let (x, y) = frame.world_from_lattice(f64::from(p[0]), f64::from(p[1]));
        // Lattice steps are 1/1024 m: a tenth of a millimeter keeps neighboring points apart.
        let tidy = |v: f64| (v * 1e4).round() / 1e4;
        json!([tidy(x), tidy(y)])
    };
    let ring = |points: &Vec<[i32; 2]>, shell: bool| {
        let area: i128 = points
            .iter()
            .zip(points.iter().cycle().skip(1))
            .map(|(a, b)| i128::from(a[0]) * i128::from(b[1]) - i128::from(b[0]) * i128::from(a[1]))
            .sum();
        let mut positions: Vec<Value> = points.iter().map(position).collect();
        if (area > 0) != shell {
            positions.reverse();
        }
        positions.extend(positions.first().cloned());
        Value::Array(positions)
    };
    let features: Vec<Value> = footprints
        .iter()
        .map(|footprint| {
            let polygons: Vec<Value> = footprint
                .polygons
                .iter()
                .map(|rings| rings.iter().enumerate().map(|(k, r)| ring(r, k == 0)).collect::<Vec<_>>().into())
                .collect();
            let geometry = match <[Value; 1]>::try_from(polygons) {
                Ok([polygon]) => ("Polygon", polygon),
                Err(polygons) => ("MultiPolygon", polygons.into()),
            };
            let properties = json!({
                "id": footprint.id,
                "height": footprint.height_m(),
                "ground": footprint.base.map(meters),
                "z_top": meters(footprint.top),
            });
            feature(properties, Some(geometry))
        })
        .collect();
    feature_collection(grid, provenance, features)
}
