//! The zones of a scene as files: a raster of codes, and the parts as polygons.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::{Batch, with_suffix};
use crate::error::Result;
use crate::raster::{Bands, ClassColor, Crs, GeoRef, GeoTiffImage, TiffLayout, pam_sidecar, write_geotiff};
use crate::zones::{NONE, Zone, ZoneMap, ZonePart};

/// Adds a GeoTIFF of [`Zone::code`]s, one byte a cell, [`NONE`] as nodata, and the sidecar that names them.
///
/// # Errors
/// Those of [`Batch::add`]; internal errors from the encoder.
pub fn add_zones(batch: &mut Batch, zones: &ZoneMap, provenance: &str, path: &Path) -> Result<()> {
    let palette: Vec<ClassColor> = Zone::ALL
        .into_iter()
        .map(|zone| {
            let [r, g, b] = zone.color();
            ClassColor { value: zone.code(), name: zone.name().into(), rgba: [r, g, b, 255] }
        })
        .collect();
    let metadata = [("SKYSHED".to_string(), provenance.to_string())];
    let image = GeoTiffImage {
        georef: zones.grid(),
        bands: Bands::Byte(vec![("zone".into(), zones.codes())]),
        nodata: Some(f64::from(NONE)),
        palette: Some(&palette),
        metadata: &metadata,
        layout: TiffLayout::Cog,
    };
    batch.add_streamed(path, |file| write_geotiff(file, &image))?;
    batch.add(&with_suffix(path, ".aux.xml"), pam_sidecar(&palette).as_bytes())
}

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
    let mut collection = Map::new();
    collection.insert("type".into(), "FeatureCollection".into());
    if let Some(epsg) = grid.crs().and_then(Crs::epsg) {
        let name = format!("urn:ogc:def:crs:EPSG::{epsg}");
        collection.insert("crs".into(), json!({"type": "name", "properties": {"name": name}}));
    }
    collection.insert("skyshed".into(), provenance.clone());
    collection.insert("features".into(), features.into());
    Value::Object(collection)
}

fn rings(part: &ZonePart, grid: &GeoRef) -> Vec<Vec<[f64; 2]>> {
    let position = |[x, y]: [usize; 2]| {
        [grid.x_min() + x as f64 * grid.cell_width(), grid.y_min() + y as f64 * grid.cell_height()]
    };
    let closed = |ring: &Vec<[usize; 2]>| ring.iter().chain(ring.first()).map(|c| position(*c)).collect();
    part.rings.iter().map(closed).collect()
}
