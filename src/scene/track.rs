//! A user's track: the places of a walk or a drive in their order, from CSV or GeoJSON.

use std::path::Path;

use serde_json::Value;

use super::geojson_file::{features, named_crs, read_document};
use super::sites::in_scene;
use super::table::line_of;
use crate::error::{Error, Result};
use crate::quantity::parse_number;
use crate::raster::{Crs, CrsKind};

/// Reads the places of a track in the scene's CRS.
///
/// CSV: columns `x,y` in the scene's CRS, or `lon,lat` in degrees; rows in the order of the track, other columns ignored.
/// GeoJSON: one LineString (a MultiLineString of one part, or Points in their order, serve too), longitude and latitude
/// unless a `crs` member says otherwise. A place that repeats the one before it is dropped.
///
/// # Errors
/// File errors naming the line or feature, also for fewer than two different places; site errors if a place cannot be
/// brought into the scene's CRS.
pub fn read_track(path: &Path, scene_crs: Option<&Crs>) -> Result<Vec<[f64; 2]>> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let mut places = match extension.as_str() {
        "geojson" | "json" => read_geojson(path, scene_crs)?,
        _ => read_csv(path, scene_crs)?,
    };
    places.dedup();
    if places.len() < 2 {
        let text = format!("cannot use {}: found {} different places, wanted at least 2", path.display(), places.len());
        return Err(Error::file(308, text));
    }
    Ok(places)
}

fn read_csv(path: &Path, scene_crs: Option<&Crs>) -> Result<Vec<[f64; 2]>> {
    let refuse = |found: String| {
        Error::file(302, format!("cannot read {}: {found}", path.display()))
            .with_hint("a track is a table separated by commas with the columns `x,y` or `lon,lat`")
    };
    let text =
        std::fs::read_to_string(path).map_err(|e| Error::file(301, format!("cannot read {}: {e}", path.display())))?;
    let text = text.trim_start_matches('\u{feff}');
    let mut reader =
        csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).flexible(true).from_reader(text.as_bytes());
    let headers = reader.headers().map_err(|e| refuse(e.to_string()))?.clone();
    let column = |names: &[&str]| headers.iter().position(|h| names.contains(&h.to_lowercase().as_str()));
    let projected = column(&["x", "x_m", "easting"]).zip(column(&["y", "y_m", "northing"]));
    let degrees = column(&["lon", "longitude", "lng"]).zip(column(&["lat", "latitude"]));
    let Some((x_column, y_column)) = projected.or(degrees) else {
        let found = headers.iter().collect::<Vec<_>>().join(",");
        return Err(refuse(format!("line 1: found columns `{found}`, wanted a position")));
    };
    let wgs84 = if projected.is_none() { Some(Crs::from_epsg(4326)?) } else { None };
    let mut places = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| refuse(e.to_string()))?;
        let place = format!("line {}: ", record.position().map_or(0, |start| line_of(text, start)));
        let number = |k: usize| {
            let field = record.get(k).unwrap_or_default();
            parse_number(field).map_err(|found| refuse(format!("{place}`{}`: {found}", &headers[k])))
        };
        let (x, y) = in_scene(path, &place, (number(x_column)?, number(y_column)?), wgs84.as_ref(), scene_crs)?;
        places.push([x, y]);
    }
    Ok(places)
}

fn read_geojson(path: &Path, scene_crs: Option<&Crs>) -> Result<Vec<[f64; 2]>> {
    let document = read_document(path)?;
    let crs = match named_crs(path, &document)? {
        Some(crs) => crs,
        None => Crs::from_epsg(4326)?,
    };
    let mut places = Vec::new();
    let mut n_lines = 0;
    for (number, feature) in features(path, document)?.into_iter().enumerate() {
        let refuse = |found: &str| {
            Error::file(302, format!("cannot read {}: feature {}: {found}", path.display(), number + 1))
                .with_hint("a track is one LineString, or Points in their order")
        };
        let geometry = &feature["geometry"];
        let line: Vec<&Value> = match geometry["type"].as_str() {
            Some("Point") => vec![&geometry["coordinates"]],
            Some("LineString") => geometry["coordinates"].as_array().into_iter().flatten().collect(),
            Some("MultiLineString") => match geometry["coordinates"].as_array().map(Vec::as_slice) {
                Some([only]) => only.as_array().into_iter().flatten().collect(),
                _ => return Err(refuse("found a MultiLineString of several parts, wanted one")),
            },
            _ => return Err(refuse("found neither a LineString nor a Point")),
        };
        n_lines += usize::from(line.len() > 1);
        if n_lines > 1 {
            return Err(refuse("found a second line, wanted one track"));
        }
        for position in line {
            let (Some(x), Some(y)) = (position[0].as_f64(), position[1].as_f64()) else {
                return Err(refuse("found a position without two numbers"));
            };
            // Positions far outside the range of degrees cannot be meant as such.
            let is_degrees = matches!(crs.kind(), CrsKind::Geographic) && x.abs() <= 360.0 && y.abs() <= 90.0;
            let from = (is_degrees || !matches!(crs.kind(), CrsKind::Geographic)).then_some(&crs);
            let (x, y) = in_scene(path, &format!("feature {}: ", number + 1), (x, y), from, scene_crs)?;
            places.push([x, y]);
        }
    }
    Ok(places)
}
