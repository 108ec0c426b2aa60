//! GeoJSON features with coordinates in the reference system of a grid.

use serde_json::{Map, Value, json};

use crate::raster::{Crs, GeoRef};

/// Returns a feature; `geometry` is the kind of the geometry and its coordinates.
pub(crate) fn feature(properties: Value, geometry: Option<(&str, Value)>) -> Value {
    let geometry = geometry.map(|(kind, coordinates)| json!({"type": kind, "coordinates": coordinates}));
    json!({"type": "Feature", "properties": properties, "geometry": geometry})
}

/// Returns a collection of features. It names the reference system if this has an EPSG code, and
/// holds the provenance.
pub(crate) fn feature_collection(grid: &GeoRef, provenance: Value, features: Vec<Value>) -> Value {
    let mut collection = Map::new();
    collection.insert("type".into(), "FeatureCollection".into());
    if let Some(epsg) = grid.crs().and_then(Crs::epsg) {
        let name = format!("urn:ogc:def:crs:EPSG::{epsg}");
        collection.insert("crs".into(), json!({"type": "name", "properties": {"name": name}}));
    }
    collection.insert("skyshed".into(), provenance);
    collection.insert("features".into(), features.into());
    Value::Object(collection)
}

/// Closes rings for GeoJSON: repeats the first position at the end.
pub(crate) fn closed_rings(rings: &[Vec<[f64; 2]>]) -> Vec<Vec<[f64; 2]>> {
    rings.iter().map(|ring| ring.iter().chain(ring.first()).copied().collect()).collect()
}
