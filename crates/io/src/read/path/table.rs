//! Paths of a table: a vertex in each row.

use super::super::moment::Moment;
use super::super::sites::{HEIGHT_COLUMNS, RowPlaces, bad_rows};
use super::super::table::{Row, Table};
use super::{RawPath, RawPaths, RawVertex, VertexHeight};
use crate::error::{PlacesIn, Result};
use crate::input::Input;
use crate::quantity::Height;
use crate::raster::Crs;

/// Seconds of a bare number in a column of times.
const SECOND: f64 = 1.0;

/// Reads the rows of a table in their order. A column `path` cuts them into paths where its content
/// changes.
pub(super) fn read((input, text): (&Input, &str), scene_crs: Option<&Crs>) -> Result<RawPaths> {
    let refuse = |found: String| bad_rows(input, PlacesIn::TrackTable, found, false);
    let table = Table::parse(text).map_err(refuse)?;
    let position = table.position().map_err(refuse)?;
    let (h, above) = (table.column(&HEIGHT_COLUMNS), table.column(&["h_above"]));
    let amsl = table.column(&["height_amsl_m"]).filter(|_| h.is_none());
    if let Some(column) = table.column(&["z", "alt", "altitude", "ele"]).filter(|_| h.is_none() && amsl.is_none()) {
        let name = table.name(column);
        let found = format!("line 1: found heights in column `{name}`, which does not say above what");
        return Err(bad_rows(input, PlacesIn::PathHeights, found, false));
    }
    let (time, of_path) = (table.column(&["t", "time", "time_s"]), table.column(&["path"]));
    let name = table.column(&["id", "name"]);
    let places = RowPlaces::of(input, (&table, position), scene_crs)?;
    let is_degrees = places.position.is_degrees;
    let text_of = |column: Option<usize>, row: &Row| {
        column.map(|column| row.field(column).to_string()).filter(|text| !text.is_empty())
    };
    let rows = table.rows(|_, row| {
        let height = match (h, amsl) {
            (Some(column), _) => Some(table.height(row, column, above)?),
            (None, Some(column)) => Some(Height::AboveDatum(table.number(row, column, "a height")?)),
            (None, None) => None,
        };
        let moment = text_of(time, row).map(|text| Moment::parse(&text, SECOND)).transpose();
        let vertex = RawVertex {
            xy: places.of_row(row)?.place,
            height: height.map(VertexHeight::Own),
            moment: moment.map_err(super::RowFault::Text)?,
            name: text_of(name, row),
        };
        Ok((text_of(of_path, row), vertex))
    });
    let mut paths: Vec<RawPath> = Vec::new();
    for (told, row) in rows {
        let (name, vertex) = match row {
            Ok((name, vertex)) => (Some(name), Ok(vertex)),
            Err(fault) => (None, Err(fault)),
        };
        let begins = paths.last().is_none_or(|last| name.as_ref().is_some_and(|name| *name != last.name));
        if begins {
            paths.push(RawPath { name: name.flatten(), are_points: false, vertices: Vec::new() });
        }
        if let Some(last) = paths.last_mut() {
            last.vertices.push((told, vertex));
        }
    }
    Ok(RawPaths { paths, crs: None, is_degrees, home: None, kind: PlacesIn::TrackTable })
}
