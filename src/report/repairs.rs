//! What was mended or left out while reading footprints, as a table and as points.

use serde_json::{Value, json};

use super::features::feature_collection;
use crate::raster::GeoRef;
use crate::read::Repair;

/// A row for each thing: feature, id, layer, what was wrong (a stable word), the code of the warning that counts it, what
/// was done, and a point of it in the scene's CRS, empty where it has no area.
pub fn repairs_table(repairs: &[Repair], layer: &str) -> Vec<Vec<String>> {
    let header = ["feature", "id", "layer", "fault", "code", "done", "x", "y"].map(str::to_string).to_vec();
    let row = |repair: &Repair| {
        let [x, y] = repair.place.map_or_else(Default::default, |place| place.map(|v| v.to_string()));
        let (number, code) = (repair.feature.to_string(), code_of(repair));
        vec![number, repair.id.clone(), layer.into(), repair.fault.word().into(), code, repair.done.into(), x, y]
    };
    std::iter::once(header).chain(repairs.iter().map(row)).collect()
}

/// The same as GeoJSON points in the CRS of a grid; what has no area has no geometry.
pub fn repairs_geojson(repairs: &[Repair], layer: &str, grid: &GeoRef, provenance: &Value) -> Value {
    let feature = |repair: &Repair| {
        let geometry = repair.place.map(|[x, y]| json!({"type": "Point", "coordinates": [x, y]}));
        json!({
            "type": "Feature",
            "properties": {
                "feature": repair.feature, "id": repair.id, "layer": layer, "fault": repair.fault.word(),
                "code": code_of(repair), "done": repair.done,
            },
            "geometry": geometry,
        })
    };
    feature_collection(grid, provenance.clone(), repairs.iter().map(feature).collect())
}

fn code_of(repair: &Repair) -> String {
    format!("W{}", repair.fault.code())
}
