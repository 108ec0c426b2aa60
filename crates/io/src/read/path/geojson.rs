//! Paths of GeoJSON.

use serde_json::Value;

use super::super::moment::Moment;
use super::super::sites::HEIGHT_COLUMNS;
use super::super::table::{RowFault, height};
use super::super::vector::geojson::{features, named_crs, parse_document};
use super::{RawPath, RawPaths, RawVertex, VertexHeight, degrees};
use crate::error::{Error, PlacesIn, Result};
use crate::input::Input;
use crate::quantity::Height;

/// Reads the lines and points of GeoJSON: longitude and latitude, unless a `crs` member names
/// another system. Times of lines stand in `coordTimes` or `times`, of points in `time`.
pub(super) fn read(input: &Input, text: &str) -> Result<RawPaths> {
    let document = parse_document(input, text)?;
    let crs = match named_crs(input, &document).map_err(Error::beside_scene)? {
        Some(crs) => Some(crs),
        None => degrees()?,
    };
    let mut paths: Vec<RawPath> = Vec::new();
    for (number, feature) in features(input, document)?.iter().enumerate() {
        let told = format!("feature {}", number + 1);
        let name = property(feature, &["name", "id"]);
        let (geometry, times) = (&feature["geometry"], times_of(feature));
        match geometry["type"].as_str() {
            Some("Point") => {
                let vertex = point(feature).map(|vertex| RawVertex { name, ..vertex });
                match paths.last_mut().filter(|last| last.are_points) {
                    Some(points) => points.vertices.push((told, vertex)),
                    None => paths.push(RawPath { name: None, are_points: true, vertices: vec![(told, vertex)] }),
                }
            }
            Some("LineString") => paths.push(line(&told, name, &geometry["coordinates"], times)),
            Some("MultiLineString") => {
                for (k, part) in geometry["coordinates"].as_array().into_iter().flatten().enumerate() {
                    let times = times.and_then(|times| times.get(k));
                    paths.push(line(&told, name.clone(), part, times));
                }
            }
            _ => {
                let fault = RowFault::Text("found neither a LineString nor a Point".into());
                paths.push(RawPath { name, are_points: false, vertices: vec![(told, Err(fault))] });
            }
        }
    }
    Ok(RawPaths { paths, crs, home: None, is_degrees: false, kind: PlacesIn::TrackFeatures })
}

/// Returns the times of the vertices of a line.
fn times_of(feature: &Value) -> Option<&Value> {
    let properties = feature.get("properties")?;
    let times = |of: &'_ Value| -> Option<Value> { of.get("coordTimes").or_else(|| of.get("times")).cloned() };
    let inner = properties.get("coordinateProperties");
    let found = times(properties).is_some();
    match (found, inner) {
        (true, _) => properties.get("coordTimes").or_else(|| properties.get("times")),
        (false, Some(inner)) => inner.get("times"),
        (false, None) => None,
    }
}

fn line(told: &str, name: Option<String>, positions: &Value, times: Option<&Value>) -> RawPath {
    let vertex = |(k, position): (usize, &Value)| {
        let moment = times.map(|times| moment_of(&times[k])).transpose();
        let vertex = position_of(position)
            .and_then(|vertex| Ok(RawVertex { moment: moment.map_err(RowFault::Text)?, ..vertex }));
        (format!("{told}, vertex {}", k + 1), vertex)
    };
    let vertices = positions.as_array().into_iter().flatten().enumerate().map(vertex).collect();
    RawPath { name, are_points: false, vertices }
}

fn point(feature: &Value) -> std::result::Result<RawVertex, RowFault> {
    let vertex = position_of(&feature["geometry"]["coordinates"])?;
    let own = match property(feature, &HEIGHT_COLUMNS) {
        Some(text) => Some(height(&text, property(feature, &["h_above"]).as_deref())),
        None => property(feature, &["height_amsl_m"]).map(|text| height(&text, Some("amsl"))),
    };
    let own = own.transpose().map_err(RowFault::Text)?.map(VertexHeight::Own);
    let time = feature.get("properties").and_then(|of| of.get("time").or_else(|| of.get("t")));
    let moment = time.filter(|time| !time.is_null()).map(moment_of).transpose().map_err(RowFault::Text)?;
    Ok(RawVertex { height: own.or(vertex.height), moment, ..vertex })
}

/// Reads a position of two or three numbers; the third is a height above the datum.
fn position_of(position: &Value) -> std::result::Result<RawVertex, RowFault> {
    let number = |k: usize| position[k].as_f64();
    let xy = number(0).zip(number(1));
    let xy = xy.ok_or_else(|| RowFault::Text("found a position without two numbers".into()))?;
    let height = number(2).map(|z| VertexHeight::Own(Height::AboveDatum(z)));
    Ok(RawVertex { xy, height, moment: None, name: None })
}

/// Reads a time: text, or a number of seconds.
fn moment_of(value: &Value) -> std::result::Result<Moment, String> {
    match value {
        Value::String(text) => Moment::parse(text, 1.0),
        other => Moment::parse(&other.to_string(), 1.0),
    }
}

fn property(feature: &Value, names: &[&str]) -> Option<String> {
    let properties = feature.get("properties")?;
    let value = names.iter().find_map(|name| properties.get(name)).filter(|value| !value.is_null())?;
    Some(value.as_str().map_or_else(|| value.to_string(), str::to_string))
}
