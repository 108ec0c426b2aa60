//! Positions in documents and tables: x and y, and beside them longitude and latitude where they were given.

use serde_json::{Map, Value};

use crate::quantity::tidy;

/// Where something is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Position {
    /// East \[CRS units\].
    pub x: f64,
    /// North \[CRS units\].
    pub y: f64,
    /// Longitude and latitude \[deg\], if it was given by these.
    pub lonlat: Option<[f64; 2]>,
}

impl Position {
    /// In words: `(x, y)`, or `(x, y; longitude, latitude)`.
    pub fn in_words(&self) -> String {
        let degrees = self.lonlat.map_or(String::new(), |[lon, lat]| format!("; {lon}°, {lat}°"));
        format!("({}, {}{degrees})", tidy(self.x), tidy(self.y))
    }

    /// Tells it in an object of a document.
    pub(super) fn tell(&self, object: &mut Map<String, Value>) {
        object.insert("x".into(), self.x.into());
        object.insert("y".into(), self.y.into());
        for (name, degrees) in ["lon", "lat"].into_iter().zip(self.lonlat.into_iter().flatten()) {
            object.insert(name.into(), degrees.into());
        }
    }
}

/// The cells of tables that tell positions: with longitude and latitude if any position was given so.
#[derive(Debug, Clone, Copy)]
pub(super) struct PositionCells {
    has_degrees: bool,
}

impl PositionCells {
    /// Those that some positions need.
    pub(super) fn of(mut positions: impl Iterator<Item = Position>) -> Self {
        PositionCells { has_degrees: positions.any(|position| position.lonlat.is_some()) }
    }

    /// The names of the columns, separated by commas.
    pub(super) fn names(self) -> &'static str {
        if self.has_degrees { "x,y,lon,lat" } else { "x,y" }
    }

    /// The cells of a position; empty where there is none.
    pub(super) fn cells(self, position: Option<Position>) -> Vec<String> {
        let number = |v: Option<f64>| v.map_or(String::new(), |v| v.to_string());
        let mut cells = vec![number(position.map(|p| p.x)), number(position.map(|p| p.y))];
        if self.has_degrees {
            let degrees = |k: usize| position.and_then(|p| p.lonlat).map(|lonlat| lonlat[k]);
            cells.extend([number(degrees(0)), number(degrees(1))]);
        }
        cells
    }
}
