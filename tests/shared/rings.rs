//! Rings of polygons in GeoJSON.

use serde_json::Value;

/// Corners of a ring; the last is the first.
pub(crate) type Ring = Vec<[f64; 2]>;

/// The rings of a feature, the outer one first.
pub(crate) fn rings(feature: &Value) -> Vec<Ring> {
    serde_json::from_value(feature["geometry"]["coordinates"].clone()).unwrap()
}

/// Area of a ring: positive if it runs counterclockwise.
pub(crate) fn area(ring: &Ring) -> f64 {
    // From the first corner, or large coordinates would eat the digits.
    let [x, y] = ring[0];
    ring.windows(2).map(|e| ((e[0][0] - x) * (e[1][1] - y) - (e[1][0] - x) * (e[0][1] - y)) / 2.0).sum()
}
