//! A user's track: the places of a walk or a drive in their order, from CSV or GeoJSON.

use serde_json::Value;

use super::sites::{HEIGHT_COLUMNS, RowPlaces, bad_rows, check_placeable, degrees_or_named, in_scene, refused};
use super::source::is_geojson;
use super::table::{BadRows, RowFault, Table, readable};
use super::vector::geojson::{features, named_crs, read_document};
use crate::crs;
use crate::error::{Error, PlacesIn, ReadFault, Result, Wanted};
use crate::input::Input;
use crate::raster::Crs;

/// Reads the places of a track in the scene's CRS. `-` is standard input, which is GeoJSON if it
/// begins with a brace.
///
/// CSV: columns `x,y` in the scene's CRS, or `lon,lat` in degrees; rows in the order of the track,
/// other columns ignored. GeoJSON: one LineString, a MultiLineString of one part, or Points in
/// their order; longitude and latitude unless a `crs` member names another system.
///
/// A place that repeats the one before it is dropped. Every place is at the height of the
/// receivers, so a track with heights of its own is refused.
///
/// # Errors
/// File errors naming the lines or features, also for heights and for fewer than two different
/// places; site errors if places cannot be brought into the scene's CRS.
pub fn read_track(input: impl Into<Input>, scene_crs: Option<&Crs>, bad: BadRows<'_>) -> Result<Vec<[f64; 2]>> {
    let input = &input.into();
    let mut places = match is_geojson(input)? {
        true => read_geojson(input, scene_crs, bad)?,
        false => read_csv(input, scene_crs, bad)?,
    };
    places.dedup();
    if places.len() < 2 {
        return Err(Error::read(input, ReadFault::Nothing(Wanted::Places(places.len()))));
    }
    Ok(places)
}

fn read_csv(input: &Input, scene_crs: Option<&Crs>, bad: BadRows<'_>) -> Result<Vec<[f64; 2]>> {
    let refuse = |found: String| bad_rows(input, PlacesIn::TrackTable, found, false);
    let table = Table::parse(&input.text("a table as UTF-8 text")?).map_err(refuse)?;
    let position = table.position().map_err(refuse)?;
    if let Some(column) = table.column(&HEIGHT_COLUMNS).or_else(|| table.column(&["z", "alt", "altitude", "ele"])) {
        let name = table.name(column);
        return Err(bad_rows(
            input,
            PlacesIn::TrackHeights,
            format!("line 1: found heights in column `{name}`"),
            false,
        ));
    }
    let places = RowPlaces::of(input, (&table, position), scene_crs)?;
    let is_degrees = places.position.is_degrees;
    let rows = table.rows(|_, row| places.of_row(row).map(|row| row.place.into()));
    readable(input, rows, bad, |told| refused(input, told, PlacesIn::TrackTable, is_degrees))
}

fn read_geojson(input: &Input, scene_crs: Option<&Crs>, bad: BadRows<'_>) -> Result<Vec<[f64; 2]>> {
    let document = read_document(input)?;
    let crs = named_crs(input, &document).map_err(Error::beside_scene)?.map_or_else(|| crs::from_epsg(4326), Ok)?;
    let mut rows = Vec::new();
    let mut n_lines = 0;
    for (number, feature) in features(input, document)?.into_iter().enumerate() {
        let place = format!("feature {}", number + 1);
        let line = positions_of(&feature["geometry"]);
        n_lines += usize::from(line.as_ref().is_ok_and(|line| line.len() > 1));
        if n_lines > 1 {
            let what = format!("{place}: found a second line, wanted one track");
            return Err(bad_rows(input, PlacesIn::TrackFeatures, what, false));
        }
        match line {
            Err(found) => rows.push((place, Err(RowFault::Text(found.into())))),
            Ok(line) => {
                // Programs write a third coordinate of 0 where there is no height.
                let height = line.iter().filter_map(|position| position[2].as_f64()).find(|z| *z != 0.0);
                if let Some(z) = height {
                    return Err(bad_rows(
                        input,
                        PlacesIn::TrackHeights,
                        format!("{place}: found the height {z}"),
                        false,
                    ));
                }
                for position in line {
                    let xy = position[0].as_f64().zip(position[1].as_f64());
                    let from = xy.and_then(|xy| degrees_or_named(&crs, xy));
                    check_placeable(input, from, scene_crs)?;
                    let xy = xy.ok_or_else(|| RowFault::Text("found a position without two numbers".into()));
                    let xy = xy.and_then(|xy| in_scene(xy, from, scene_crs));
                    rows.push((place.clone(), xy.map(|(x, y)| [x, y])));
                }
            }
        }
    }
    readable(input, rows, bad, |told| refused(input, told, PlacesIn::TrackFeatures, true))
}

/// Returns the positions of a line or a point.
fn positions_of(geometry: &Value) -> std::result::Result<Vec<&Value>, &'static str> {
    Ok(match geometry["type"].as_str() {
        Some("Point") => vec![&geometry["coordinates"]],
        Some("LineString") => geometry["coordinates"].as_array().into_iter().flatten().collect(),
        Some("MultiLineString") => match geometry["coordinates"].as_array().map(Vec::as_slice) {
            Some([only]) => only.as_array().into_iter().flatten().collect(),
            _ => return Err("found a MultiLineString of several parts, wanted one"),
        },
        _ => return Err("found neither a LineString nor a Point"),
    })
}
