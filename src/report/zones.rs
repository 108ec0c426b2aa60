//! The zones of a scene as polygons.

use serde_json::{Value, json};

use super::features::feature_collection;
use crate::raster::GeoRef;
use crate::zones::{Zone, ZoneMap, ZonePart};

/// The parts of all zones as GeoJSON polygons with `zone`, `id` (`crossroad-7`), `cells` and `area_m2`; along the cell
/// edges, in the grid's CRS. `meters_per_unit` is the length of a unit of that \[m\].
pub fn zones_geojson(zones: &ZoneMap, meters_per_unit: f64, provenance: &Value) -> Value {
    let grid = zones.grid();
    let cell_m2 = grid.cell_width() * grid.cell_height() * meters_per_unit * meters_per_unit;
    let parts = |zone| zones.parts(zone).into_iter().enumerate();
    let features: Vec<Value> = Zone::ALL
        .into_iter()
        .flat_map(parts)
        .map(|(k, part)| {
            #[expect(clippy::cast_precision_loss, reason = "counts of cells are far below 2^53")]
            let area = part.n_cells as f64 * cell_m2;
            json!({
                "type": "Feature",
                "properties": {
                    "zone": part.zone.name(),
                    "id": format!("{}-{}", part.zone.name(), k + 1),
                    "cells": part.n_cells,
                    "area_m2": area,
                },
                "geometry": {"type": "Polygon", "coordinates": rings(&part, grid)},
            })
        })
        .collect();
    feature_collection(grid, provenance.clone(), features)
}

fn rings(part: &ZonePart, grid: &GeoRef) -> Vec<Vec<[f64; 2]>> {
    let position = |[x, y]: [usize; 2]| {
        [grid.x_min() + x as f64 * grid.cell_width(), grid.y_min() + y as f64 * grid.cell_height()]
    };
    let closed = |ring: &Vec<[usize; 2]>| ring.iter().chain(ring.first()).map(|c| position(*c)).collect();
    part.rings.iter().map(closed).collect()
}
