//! The zones of a scene as polygons.

use serde_json::{Value, json};

use super::features::{closed_rings, feature_collection};
use crate::zones::{Zone, ZoneMap};

/// The parts of all zones as GeoJSON polygons with `zone`, `id` (`crossroad-7`), `cells` and `area_m2`; along the cell
/// edges, in the grid's CRS. `meters_per_unit` is the length of a unit of that \[m\].
pub fn zones_geojson(zones: &ZoneMap, meters_per_unit: f64, provenance: &Value) -> Value {
    let grid = zones.grid();
    let cell_m2 = grid.cell_width() * grid.cell_height() * meters_per_unit * meters_per_unit;
    let parts = |zone: Zone| zones.parts(zone).into_iter().enumerate().map(move |(k, part)| (zone, k, part));
    let features: Vec<Value> = Zone::ALL
        .into_iter()
        .flat_map(parts)
        .map(|(zone, k, part)| {
            #[expect(clippy::cast_precision_loss, reason = "counts of cells are far below 2^53")]
            let area = part.n_cells as f64 * cell_m2;
            let rings: Vec<Vec<[f64; 2]>> =
                part.rings.iter().map(|ring| ring.iter().map(|c| grid.world_from_corner(*c)).collect()).collect();
            json!({
                "type": "Feature",
                "properties": {
                    "zone": zone.name(),
                    "id": format!("{}-{}", zone.name(), k + 1),
                    "cells": part.n_cells,
                    "area_m2": area,
                },
                "geometry": {"type": "Polygon", "coordinates": closed_rings(&rings)},
            })
        })
        .collect();
    feature_collection(grid, provenance.clone(), features)
}
