//! Coverage as GeoJSON polygons.

use serde_json::{Value, json};

use super::MapReport;
use super::features::{closed_rings, feature_collection};
use crate::coverage::CoveragePolygon;

impl MapReport {
    /// Polygons of this run with `site`, `class`, `cells` and `area_m2`, in the grid's CRS.
    pub fn polygons(&self, polygons: &[CoveragePolygon]) -> Value {
        let feature = |polygon: &CoveragePolygon| {
            json!({
                "type": "Feature",
                "properties": {
                    "site": polygon.site,
                    "class": polygon.class_name(),
                    "cells": polygon.n_cells,
                    "area_m2": polygon.area_m2,
                },
                "geometry": {"type": "Polygon", "coordinates": closed_rings(&polygon.rings)},
            })
        };
        let features = polygons.iter().map(feature).collect();
        feature_collection(&self.facts.grid, self.document(None), features)
    }
}
