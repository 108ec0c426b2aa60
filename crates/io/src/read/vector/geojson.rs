//! GeoJSON text: its document, its CRS, its features.
//!
//! The geojson crate checks each feature by itself, so that an error can name the bad one. RFC 7946
//! has no `crs` member, but GDAL and many portals write one for projected coordinates, so it is
//! honored.

use std::collections::HashSet;
use std::sync::Arc;

use geojson::{Feature, GeometryValue};
use rayon::prelude::*;
use serde_json::value::RawValue;
use serde_json::{Map, Value};

use super::super::polygon::Polygon;
use super::super::solid::Face;
use super::cityjson;
use super::feature::{self, FeatureSet, Property};
use super::surfaces::Areas;
use super::unique::{self, Members};
use crate::crs;
use crate::error::{Error, MOST_FOUND, Place, ReadFault, Result, shortened};
use crate::input::Input;
use crate::raster::Crs;

/// A FeatureCollection of which only the outermost level is parsed.
struct Collection<'a> {
    /// All members but the features.
    members: Value,
    features: Vec<&'a RawValue>,
}

/// Parses the outermost level of a text, if it is a FeatureCollection. For any other text,
/// [`parse_document`] names its kind or its fault.
///
/// PERF: all features as JSON values take twenty times the memory of the text.
fn collection(text: &str) -> Option<Collection<'_>> {
    let Members(mut members) = serde_json::from_str::<Members<&RawValue>>(text).ok()?;
    let features = members.remove("features")?;
    let parsed = |(name, raw): (String, &RawValue)| Some((name, unique::parse(raw.get()).ok()?));
    if members.get("type")?.get() != "\"FeatureCollection\"" {
        return None;
    }
    let members = Value::Object(members.into_iter().map(parsed).collect::<Option<Map<String, Value>>>()?);
    Some(Collection { members, features: serde_json::from_str(features.get()).ok()? })
}

/// Parses a GeoJSON document.
pub(in crate::read) fn read_document(input: &Input) -> Result<Value> {
    parse_document(input, text_of(&input.text("GeoJSON text")?))
}

/// Returns a text without a byte order mark.
fn text_of(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

pub(in crate::read) fn parse_document(input: &Input, text: &str) -> Result<Value> {
    if text.trim().is_empty() {
        return Err(Error::malformed(input, "the file is empty, wanted GeoJSON"));
    }
    unique::parse(text).map_err(|e| {
        let found = shortened(&e.to_string(), MOST_FOUND).into_owned();
        Error::malformed(input, format!("{found}, wanted one GeoJSON document"))
    })
}

/// Returns the features of a document: of a collection, of a single feature, or of a bare geometry.
pub(in crate::read) fn features(input: &Input, document: Value) -> Result<Vec<Value>> {
    let wrong = |found: String| Error::malformed(input, format!("found {found}, wanted a GeoJSON FeatureCollection"));
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
        "Polygon" | "MultiPolygon" | "GeometryCollection" | "Point" | "LineString" | "MultiLineString" => {
            let mut feature = Map::new();
            feature.insert("type".into(), "Feature".into());
            feature.insert("properties".into(), Value::Null);
            feature.insert("geometry".into(), Value::Object(object));
            Ok(vec![Value::Object(feature)])
        }
        "" => Err(wrong("an object without `type`".into())),
        other => Err(wrong(format!("type `{other}`"))),
    }
}

/// Returns the CRS that a document's `crs` member names, if it has one.
pub(in crate::read) fn named_crs(input: &Input, document: &Value) -> Result<Option<Crs>> {
    let Some(member) = document.get("crs").filter(|c| !c.is_null()) else { return Ok(None) };
    let Some(name) = member.pointer("/properties/name").and_then(Value::as_str) else {
        let kind = member.get("type").and_then(Value::as_str).unwrap_or("nothing");
        return Err(Error::read(input, ReadFault::CrsMember(kind.to_string())));
    };
    let said = || format!("its `crs` is `{name}`");
    crs::parse(name).map(Some).map_err(|e| Error::read(input, ReadFault::Crs(said(), e.to_string())))
}

/// Reads the features of GeoJSON text, or of CityJSON.
pub(super) fn read(input: &Input) -> Result<FeatureSet> {
    let text = input.text("GeoJSON text")?;
    let text = text_of(&text);
    if let Some(set) = collection(text).and_then(|collection| set_of_collection(input, &collection)) {
        return Ok(set);
    }
    if let Some(records) = records(text) {
        return read_sequence(input, &records);
    }
    let document = parse_document(input, text)?;
    if cityjson::is_cityjson(&document) { cityjson::features(input, &document) } else { feature_set(input, document) }
}

/// Returns the objects of a text with one in each line, or after each record separator (RFC 8142);
/// `None` for a single document.
fn records(text: &str) -> Option<Vec<&str>> {
    const SEPARATOR: char = '\u{1e}';
    let text = text.trim_start();
    let all: Vec<&str> = match text.strip_prefix(SEPARATOR) {
        Some(records) => records.split(SEPARATOR).map(str::trim).filter(|record| !record.is_empty()).collect(),
        None => text.lines().map(str::trim).filter(|line| !line.is_empty()).collect(),
    };
    // Lines of one document are no objects of their own.
    let is_object = |record: &&str| record.starts_with('{') && record.ends_with('}');
    let is_sequence = text.starts_with(SEPARATOR) || all.len() > 1 && all.iter().take(2).all(is_object);
    is_sequence.then_some(all)
}

/// Reads the features of a GeoJSON or CityJSON sequence.
fn read_sequence(input: &Input, records: &[&str]) -> Result<FeatureSet> {
    let wrong = |number: usize, found: String| {
        let found = shortened(&found, MOST_FOUND).into_owned();
        Error::malformed(input, format!("{found}, wanted a feature")).at(Place::Feature(number as u64 + 1))
    };
    let parse = |(number, record): (usize, &&str)| unique::parse(record).map_err(|e| wrong(number, e.to_string()));
    if let Some(first) = records.first()
        && let Ok(document) = unique::parse(first)
        && cityjson::is_cityjson(&document)
    {
        let following = records.par_iter().enumerate().skip(1).map(parse).collect::<Result<Vec<Value>>>()?;
        return cityjson::sequence(input, &document, &following);
    }
    let feature = |names: &mut HashSet<Arc<str>>, (number, record): (usize, &&str)| {
        let parsed = unique::parse_feature(record);
        let parsed = match parsed {
            Some(feature) => feature,
            None => {
                let value = parse((number, record))?;
                serde_json::from_value(value).map_err(|e| wrong(number, e.to_string()))?
            }
        };
        feature_of(parsed, names).map_err(|found| wrong(number, found))
    };
    let features = records.par_iter().enumerate().map_init(HashSet::new, feature).collect::<Result<Vec<_>>>()?;
    Ok(FeatureSet { features, ..FeatureSet::default() })
}

/// Parses the features of a collection in parallel; `None` if any is faulty.
fn set_of_collection(input: &Input, collection: &Collection<'_>) -> Option<FeatureSet> {
    let feature =
        |names: &mut HashSet<Arc<str>>, raw: &&RawValue| feature_of(unique::parse_feature(raw.get())?, names).ok();
    let features = collection.features.par_iter().map_init(HashSet::new, feature).collect::<Option<Vec<_>>>()?;
    Some(FeatureSet { features, ..without_features(input, &collection.members) })
}

/// Returns the members of a document beside its features.
fn without_features(input: &Input, document: &Value) -> FeatureSet {
    let text = |key: &str| document.get(key).and_then(Value::as_str).map(str::to_string);
    // A name with an underscore is that of a table, not of a place.
    let name = text("name").filter(|name| !name.contains('_')).and_then(|name| {
        let mut letters = name.chars();
        letters.next().map(|first| first.to_uppercase().chain(letters).collect())
    });
    let attribution = text("attribution");
    FeatureSet { crs: named_crs(input, document), name, attribution, ..FeatureSet::default() }
}

/// Reads the features of a GeoJSON document.
fn feature_set(input: &Input, document: Value) -> Result<FeatureSet> {
    let set = without_features(input, &document);
    let (mut found, mut names) = (Vec::new(), HashSet::new());
    for (number, value) in features(input, document)?.into_iter().enumerate() {
        let refuse = |found: String| {
            let what = format!("{found}, wanted a GeoJSON feature");
            Error::malformed(input, what).at(Place::Feature(number as u64 + 1))
        };
        let feature: Feature =
            serde_json::from_value(value).map_err(|e| refuse(shortened(&e.to_string(), MOST_FOUND).into_owned()))?;
        found.push(feature_of(feature, &mut names).map_err(refuse)?);
    }
    Ok(FeatureSet { features: found, ..set })
}

/// Converts a feature with its areas; the error names the fault of its positions. `names` holds the
/// property names found so far.
fn feature_of(feature: Feature, names: &mut HashSet<Arc<str>>) -> std::result::Result<feature::Feature, String> {
    let mut areas = Areas::default();
    if let Some(geometry) = &feature.geometry {
        collect_areas(&geometry.value, &mut areas)?;
    }
    let id = feature.id.map(|id| match id {
        geojson::feature::Id::String(text) => text,
        geojson::feature::Id::Number(number) => number.to_string(),
    });
    let properties = feature.properties.into_iter().flatten();
    let mut shared = |name: String| match names.get(name.as_str()) {
        Some(known) => Arc::clone(known),
        None => {
            let name: Arc<str> = name.into();
            names.insert(Arc::clone(&name));
            name
        }
    };
    let mut tags = None;
    let properties = properties.map(|(name, value)| {
        let property = Property::of_json(&value);
        if let ("tags", Value::Object(of)) = (name.as_str(), value) {
            tags = Some(of);
        }
        (shared(name), property)
    });
    let properties: Vec<_> = properties.collect();
    let properties = match &tags {
        Some(tags) => feature::with_others(properties, tags),
        None => properties,
    };
    Ok(feature::Feature { id, properties, ..areas.into_feature() })
}

/// Adds the areas of a geometry; the error names the fault of its positions.
fn collect_areas(geometry: &GeometryValue, areas: &mut Areas) -> std::result::Result<(), String> {
    let plane = |p: &geojson::Position| match p.as_slice() {
        [x, y, ..] => Ok([*x, *y]),
        [_] => Err("found a position with one number".to_string()),
        [] => Err("found a position without a number".to_string()),
    };
    let space = |p: &geojson::Position| if let [x, y, z, ..] = p.as_slice() { Some([*x, *y, *z]) } else { None };
    let mut add = |rings: &Vec<Vec<geojson::Position>>| {
        let has_z = rings.first().and_then(|ring| ring.first()).is_some_and(|p| p.len() > 2);
        let face = || rings.iter().map(|ring| ring.iter().map(space).collect()).collect::<Option<Face>>();
        if let Some(face) = has_z.then(face).flatten() {
            areas.push_face(face);
            return Ok(());
        }
        let ring = |ring: &Vec<geojson::Position>| ring.iter().map(plane).collect();
        areas.push(rings.iter().map(ring).collect::<std::result::Result<Polygon, String>>()?);
        Ok(())
    };
    match geometry {
        GeometryValue::Polygon { coordinates } => add(coordinates),
        GeometryValue::MultiPolygon { coordinates } => coordinates.iter().try_for_each(add),
        GeometryValue::GeometryCollection { geometries } => {
            geometries.iter().try_for_each(|g| collect_areas(&g.value, areas))
        }
        _ => {
            areas.has_other_parts = true;
            Ok(())
        }
    }
}

impl Property {
    /// Converts a JSON value to a property; lists and objects become `null`.
    pub(in crate::read) fn of_json(value: &Value) -> Property {
        match value {
            Value::Number(n) => n.as_f64().map_or(Property::Null, Property::Number),
            Value::String(text) => Property::Text(text.clone()),
            Value::Bool(yes) => Property::Text(if *yes { "yes" } else { "no" }.into()),
            Value::Null | Value::Array(_) | Value::Object(_) => Property::Null,
        }
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
