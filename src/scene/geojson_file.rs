//! Reads polygons with heights from GeoJSON text.
//!
//! The geojson crate checks each feature; going feature by feature lets an error name the one that is wrong. RFC 7946
//! has no `crs` member, but GDAL and many portals write one for projected coordinates, so it is honored.

use std::path::Path;

use geojson::{Feature, GeometryValue};
use serde_json::{Map, Value};

use crate::error::{Error, Result};
use crate::raster::Crs;

/// The polygons of a file, as found.
#[derive(Debug, Clone, Default)]
pub(super) struct RawFootprints {
    pub(super) crs: Option<Crs>,
    /// The document's `attribution` member: whom a picture must credit.
    pub(super) attribution: Option<String>,
    pub(super) footprints: Vec<RawFootprint>,
    /// Features that are not polygons.
    pub(super) not_areas: usize,
}

/// One feature with areas.
#[derive(Debug, Clone)]
pub(super) struct RawFootprint {
    pub(super) id: String,
    /// Polygons of rings of positions, last point dropped if it repeats the first.
    pub(super) polygons: Vec<Vec<Vec<[f64; 2]>>>,
    pub(super) unclosed: usize,
    pub(super) height: FoundHeight,
    pub(super) levels: Option<f64>,
}

/// What a height property held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum FoundHeight {
    Meters(f64),
    DecimalComma(f64),
    Missing,
}

impl RawFootprints {
    /// West, south, east, north of all positions; `None` if there is none.
    pub(super) fn bounds(&self) -> Option<[f64; 4]> {
        let points = self.footprints.iter().flat_map(|f| f.polygons.iter().flatten().flatten());
        points.fold(None, |bounds, &[x, y]| {
            let [w, s, e, n] = bounds.unwrap_or([x, y, x, y]);
            Some([w.min(x), s.min(y), e.max(x), n.max(y)])
        })
    }
}

/// Parses a GeoJSON document.
///
/// # Errors
/// If the file cannot be read, is not UTF-8, or is not JSON (with line and column).
pub(super) fn read_document(path: &Path) -> Result<Value> {
    let bytes = std::fs::read(path).map_err(|e| Error::file(301, format!("cannot read {}: {e}", path.display())))?;
    let text = String::from_utf8(bytes).map_err(|e| {
        let place = e.utf8_error().valid_up_to();
        Error::file(302, format!("cannot read {}: byte {place} is not UTF-8, wanted GeoJSON text", path.display()))
    })?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    if text.trim().is_empty() {
        return Err(Error::file(302, format!("cannot read {}: the file is empty, wanted GeoJSON", path.display())));
    }
    serde_json::from_str(text).map_err(|e| {
        let error = Error::file(302, format!("cannot read {}: {e}, wanted one GeoJSON document", path.display()));
        if e.to_string().starts_with("trailing characters") && is_one_feature_a_line(text) {
            error.with_hint("for one feature a line, convert first: `ogr2ogr collection.geojson features.geojsonl`")
        } else {
            error
        }
    })
}

/// Whether the second line of a text begins another JSON object.
fn is_one_feature_a_line(text: &str) -> bool {
    text.trim_start().lines().nth(1).is_some_and(|line| line.starts_with(['{', '\u{1e}']))
}

/// The features of a document: of a collection, of a single feature, or of a bare geometry.
///
/// # Errors
/// If the document is none of these.
pub(super) fn features(path: &Path, document: Value) -> Result<Vec<Value>> {
    let wrong = |found: String| {
        Error::file(302, format!("cannot read {}: found {found}, wanted a GeoJSON FeatureCollection", path.display()))
    };
    let Value::Object(mut object) = document else {
        return Err(wrong(format!("{} at the top level", kind_of(&document))));
    };
    let kind = object.get("type").and_then(Value::as_str).unwrap_or_default().to_string();
    match kind.as_str() {
        "FeatureCollection" => match object.remove("features") {
            Some(Value::Array(features)) => Ok(features),
            Some(other) => Err(wrong(format!("`features` holding {}", kind_of(&other)))),
            None => Err(wrong("a FeatureCollection without `features`".into())),
        },
        "Feature" => Ok(vec![Value::Object(object)]),
        "Polygon" | "MultiPolygon" | "GeometryCollection" => {
            let mut feature = Map::new();
            feature.insert("type".into(), "Feature".into());
            feature.insert("properties".into(), Value::Null);
            feature.insert("geometry".into(), Value::Object(object));
            Ok(vec![Value::Object(feature)])
        }
        "" => Err(wrong("an object without `type`".into())),
        "CityJSON" => Err(wrong("type `CityJSON`".into())
            .with_hint("convert its footprints, with their heights as a property, to GeoJSON")),
        other => Err(wrong(format!("type `{other}`"))),
    }
}

/// The CRS that a document's `crs` member names, if it has one.
///
/// # Errors
/// If it names one that is not known.
pub(super) fn named_crs(path: &Path, document: &Value) -> Result<Option<Crs>> {
    let Some(member) = document.get("crs").filter(|c| !c.is_null()) else { return Ok(None) };
    let Some(name) = member.pointer("/properties/name").and_then(Value::as_str) else { return Ok(None) };
    Crs::parse(name).map(Some).map_err(|e| {
        Error::file(310, format!("cannot read {}: its `crs` is `{name}`: {e}", path.display()))
            .with_hint("override it with `--crs EPSG:n`")
    })
}

/// Reads the polygons of a file with their heights from property `height_field`, or `top_field` if given.
pub(super) fn read_raw_footprints(path: &Path, height_field: &str, top_field: Option<&str>) -> Result<RawFootprints> {
    let document = read_document(path)?;
    let attribution = document.get("attribution").and_then(Value::as_str).map(str::to_string);
    let mut raw = RawFootprints { crs: named_crs(path, &document)?, attribution, ..RawFootprints::default() };
    for (number, value) in features(path, document)?.into_iter().enumerate() {
        let number = number + 1;
        let refuse = |found: String| {
            Error::file(
                302,
                format!("cannot read {}: feature {number}: {found}, wanted a GeoJSON feature", path.display()),
            )
        };
        let feature: Feature = serde_json::from_value(value).map_err(|e| refuse(e.to_string()))?;
        let Some(footprint) = footprint(&feature, number, height_field, top_field).map_err(refuse)? else {
            raw.not_areas += 1;
            continue;
        };
        if let Some(bad) = footprint.polygons.iter().flatten().flatten().flatten().find(|v| !v.is_finite()) {
            return Err(refuse(format!("found coordinate `{bad}`")));
        }
        raw.footprints.push(footprint);
    }
    Ok(raw)
}

/// The areas of a feature with their height, `None` if it has none; the error says what is wrong with its positions.
fn footprint(
    feature: &Feature,
    number: usize,
    height_field: &str,
    top_field: Option<&str>,
) -> std::result::Result<Option<RawFootprint>, String> {
    let mut polygons = Vec::new();
    let mut unclosed = 0;
    if let Some(geometry) = &feature.geometry {
        collect_polygons(&geometry.value, &mut polygons, &mut unclosed)?;
    }
    if polygons.is_empty() {
        return Ok(None);
    }
    let property = |name: &str| feature.properties.as_ref().and_then(|p| p.get(name)).filter(|v| !v.is_null());
    let as_text = |v: &Value| v.as_str().map_or_else(|| v.to_string(), str::to_string);
    let id = match &feature.id {
        Some(geojson::feature::Id::String(s)) => s.clone(),
        Some(geojson::feature::Id::Number(n)) => n.to_string(),
        None => property("id").map_or_else(|| number.to_string(), as_text),
    };
    let height = property(top_field.unwrap_or(height_field)).map_or(FoundHeight::Missing, found_height);
    let levels = property("building:levels").and_then(|v| match found_height(v) {
        FoundHeight::Meters(n) if n > 0.0 => Some(n),
        _ => None,
    });
    Ok(Some(RawFootprint { id, polygons, unclosed, height, levels }))
}

fn collect_polygons(
    geometry: &GeometryValue,
    polygons: &mut Vec<Vec<Vec<[f64; 2]>>>,
    unclosed: &mut usize,
) -> std::result::Result<(), String> {
    let plane = |p: &geojson::Position| match p.as_slice() {
        [x, y, ..] => Ok([*x, *y]),
        [_] => Err("found a position with one number".to_string()),
        [] => Err("found a position without a number".to_string()),
    };
    let mut add = |rings: &Vec<Vec<geojson::Position>>| {
        let mut polygon = Vec::with_capacity(rings.len());
        for ring in rings {
            let mut points = ring.iter().map(plane).collect::<std::result::Result<Vec<[f64; 2]>, String>>()?;
            if points.len() > 1 && points.first() == points.last() {
                points.pop();
            } else {
                *unclosed += usize::from(!points.is_empty());
            }
            polygon.push(points);
        }
        polygons.push(polygon);
        Ok(())
    };
    match geometry {
        GeometryValue::Polygon { coordinates } => add(coordinates),
        GeometryValue::MultiPolygon { coordinates } => coordinates.iter().try_for_each(add),
        GeometryValue::GeometryCollection { geometries } => {
            geometries.iter().try_for_each(|g| collect_polygons(&g.value, polygons, unclosed))
        }
        _ => Ok(()),
    }
}

/// A height from a JSON value: a number of meters, or text such as `12`, `12.5 m`, `40 ft`, `12,5`.
fn found_height(value: &Value) -> FoundHeight {
    let text = match value {
        Value::Number(n) => return n.as_f64().map_or(FoundHeight::Missing, FoundHeight::Meters),
        Value::String(s) => s.trim(),
        _ => return FoundHeight::Missing,
    };
    let (number, meters_per_unit) = [("ft", 0.3048), ("'", 0.3048), ("m", 1.0)]
        .iter()
        .find_map(|(unit, factor)| text.strip_suffix(unit).map(|n| (n.trim_end(), *factor)))
        .unwrap_or((text, 1.0));
    if let Ok(v) = number.parse::<f64>() {
        return if v.is_finite() { FoundHeight::Meters(v * meters_per_unit) } else { FoundHeight::Missing };
    }
    // One comma and no point: a decimal comma, not a thousands separator followed by three digits.
    match number.split_once(',') {
        Some((whole, decimals)) if decimals.len() != 3 && !number.contains('.') => format!("{whole}.{decimals}")
            .parse::<f64>()
            .map_or(FoundHeight::Missing, |v| FoundHeight::DecimalComma(v * meters_per_unit)),
        _ => FoundHeight::Missing,
    }
}

fn kind_of(value: &Value) -> &'static str {
    match value {
        Value::Null => "null",
        Value::Bool(_) => "a boolean",
        Value::Number(_) => "a number",
        Value::String(_) => "a string",
        Value::Array(_) => "an array",
        Value::Object(_) => "an object",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_are_read_with_their_units_and_nonsense_is_missing() {
        let read = |text: &str| found_height(&Value::String(text.into()));
        assert_eq!(read("12 m"), FoundHeight::Meters(12.0));
        assert_eq!(read("12.5"), FoundHeight::Meters(12.5));
        assert_eq!(read("100 ft"), FoundHeight::Meters(30.48));
        assert_eq!(read("12,5"), FoundHeight::DecimalComma(12.5));
        assert_eq!(read("1,200"), FoundHeight::Missing);
        assert_eq!(read("tall"), FoundHeight::Missing);
        assert_eq!(read("inf"), FoundHeight::Missing);
        assert_eq!(found_height(&Value::Bool(true)), FoundHeight::Missing);
    }
}
