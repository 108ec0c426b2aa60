//! Positions in documents and tables: x and y, with longitude and latitude if the user wrote these.

use schemars::JsonSchema;
use serde::Serialize;

use crate::quantity::tidy;

/// A position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Position {
    /// East \[CRS units\].
    pub(crate) x: f64,
    /// North \[CRS units\].
    pub(crate) y: f64,
    /// Longitude and latitude \[deg\]; `None` if the position was not read in degrees.
    pub(crate) lonlat: Option<[f64; 2]>,
}

/// A position in a document or a row.
#[derive(Debug, Clone, Copy, Default, Serialize, JsonSchema)]
pub(crate) struct PositionFields {
    /// East [units of the scene's reference system].
    x: Option<f64>,
    /// North [units of the scene's reference system].
    y: Option<f64>,
    /// Longitude [deg], where positions were given by longitude and latitude.
    #[serde(skip_serializing_if = "Option::is_none")]
    lon: Option<f64>,
    /// Latitude [deg], where positions were given by longitude and latitude.
    #[serde(skip_serializing_if = "Option::is_none")]
    lat: Option<f64>,
}

impl Position {
    /// Returns the position in words: `(x, y)`, or `(x, y; longitude, latitude)`.
    pub(crate) fn in_words(&self) -> String {
        let degrees = self.lonlat.map_or(String::new(), |[lon, lat]| format!("; {lon}°, {lat}°"));
        format!("({}, {}{degrees})", tidy(self.x), tidy(self.y))
    }
}

impl From<Position> for PositionFields {
    fn from(Position { x, y, lonlat }: Position) -> Self {
        PositionFields { x: Some(x), y: Some(y), lon: lonlat.map(|l| l[0]), lat: lonlat.map(|l| l[1]) }
    }
}

impl From<Option<Position>> for PositionFields {
    fn from(position: Option<Position>) -> Self {
        position.map_or_else(PositionFields::default, PositionFields::from)
    }
}
