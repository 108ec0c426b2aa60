//! CityJSON 1.0, 1.1 and 2.0: buildings and their parts as solids or surfaces.
//!
//! The geometry with the highest level of detail of each building and building part counts
//! ([`super::super::solid`]). Its footprint is the union of its ground surfaces or, without marked
//! ones, of all its surfaces as seen from above. A flat top is as high as the geometry's highest
//! point, so a pitched roof is as high as its ridge. A roof that is taken as it is consists of its
//! surfaces. Walls, being vertical, cover no ground. A building without a geometry of its own is
//! made of its parts.
//!
//! # References
//! CityJSON Specifications 2.0.1, sections 3 to 5.

use serde_json::{Map, Value};

use super::super::height_value::found_height;
use super::super::solid::{FaceKind, Solid};
use super::feature::{Feature, FeatureSet, Properties, Property, SolidHeight, crs_of, malformed, with_others};
use crate::error::{Error, ReadFault, Result, Wanted};
use crate::input::Input;
use skyshed_request::HeightUnit;

/// Returns `true` for a JSON document of type CityJSON.
pub(super) fn is_cityjson(document: &Value) -> bool {
    document.get("type").and_then(Value::as_str) == Some("CityJSON")
}

/// Reads the buildings of a document.
pub(super) fn features(input: &Input, document: &Value) -> Result<FeatureSet> {
    sequence(input, document, &[])
}

/// Reads the buildings of a document and of features that follow it, one in each line of a
/// CityJSONSeq. Features have vertices of their own, in the place and scale of the document.
pub(super) fn sequence(input: &Input, document: &Value, following: &[Value]) -> Result<FeatureSet> {
    let wrong = |found: &str| malformed(input, found, "a CityJSON document of version 1.0, 1.1 or 2.0");
    let version = document.get("version").and_then(Value::as_str).unwrap_or_default();
    if !["1.0", "1.1", "2.0"].iter().any(|known| version == *known || version.starts_with(&format!("{known}."))) {
        return Err(wrong(&format!("CityJSON version `{version}`")));
    }
    let (mut features, mut n_objects) = (Vec::new(), 0);
    for part in std::iter::once(document).chain(following) {
        n_objects += add_buildings(part, document.get("transform"), &mut features).map_err(|found| wrong(&found))?;
    }
    if n_objects == 0 {
        return Err(Error::read(input, ReadFault::Nothing(Wanted::CityObjects)));
    }
    let system = document.pointer("/metadata/referenceSystem").and_then(Value::as_str).unwrap_or_default();
    Ok(FeatureSet { crs: crs_of(input, &reference_system(system)), features, ..FeatureSet::default() })
}

/// Appends the buildings of a document, or of a feature of a sequence. Returns the number of its
/// objects.
fn add_buildings(
    part: &Value,
    transform: Option<&Value>,
    features: &mut Vec<Feature>,
) -> std::result::Result<usize, String> {
    let vertices = vertices(part, transform)?;
    let objects = part.get("CityObjects").and_then(Value::as_object).ok_or("no `CityObjects`")?;
    for (id, object) in objects {
        let kind = object.get("type").and_then(Value::as_str).unwrap_or_default();
        if !["Building", "BuildingPart"].contains(&kind) {
            continue;
        }
        // A building is made of its parts, if they are more detailed.
        let of_parts = names(object, "children").filter_map(|part| most_detailed(objects.get(part)?));
        let best = most_detailed(object).filter(|geometry| of_parts.map(detail).all(|part| part <= detail(geometry)));
        let Some(geometry) = best else { continue };
        let solid = solid_of(geometry, &vertices).map_err(|found| format!("object `{id}`: {found}"))?;
        let attributes = |object: &Value| object.get("attributes").and_then(Value::as_object).cloned();
        let building = names(object, "parents").next().filter(|_| kind == "BuildingPart");
        // A part has the attributes of its building, except those of its own.
        let of_building = building.and_then(|id| attributes(objects.get(id)?)).unwrap_or_default();
        let properties = with_others(properties(&attributes(object).unwrap_or_default()), &of_building);
        let measured = properties.iter().find(|(name, _)| **name == *"measuredHeight").map(|(_, value)| value);
        features.push(Feature {
            id: Some(id.clone()),
            height: height_of(measured, detail(geometry), solid.heights),
            part_of: building.map(str::to_string),
            properties,
            ..Feature::of_solid(solid)
        });
    }
    Ok(objects.len())
}

/// Returns `https://www.opengis.net/def/crs/EPSG/0/7415` as `EPSG:7415`; other names stay.
fn reference_system(name: &str) -> String {
    match name.rsplit_once('/') {
        Some((_, code)) if name.contains("/EPSG/") => format!("EPSG:{code}"),
        _ => name.to_string(),
    }
}

/// Returns all vertices in coordinates of the reference system; `transform` scales and shifts
/// integers.
fn vertices(document: &Value, transform: Option<&Value>) -> std::result::Result<Vec<[f64; 3]>, String> {
    let triple = |value: &Value| -> Option<[f64; 3]> {
        let [x, y, z] = value.as_array()?.as_slice() else { return None };
        Some([x.as_f64()?, y.as_f64()?, z.as_f64()?])
    };
    let (scale, shift) = match transform {
        None => ([1.0; 3], [0.0; 3]),
        Some(transform) => {
            let part = |name: &str| transform.get(name).and_then(triple);
            part("scale").zip(part("translate")).ok_or("a `transform` without three numbers each")?
        }
    };
    let list = document.get("vertices").and_then(Value::as_array).ok_or("no `vertices`")?;
    let vertex = |(k, value): (usize, &Value)| {
        let v = triple(value).ok_or_else(|| format!("vertex {k}, which is not three numbers"))?;
        let v = [0, 1, 2].map(|i| v[i] * scale[i] + shift[i]);
        if v.iter().all(|c| c.is_finite()) { Ok(v) } else { Err(format!("vertex {k}, which is not finite")) }
    };
    list.iter().enumerate().map(vertex).collect()
}

/// Returns the names in a list of an object.
fn names<'a>(object: &'a Value, list: &str) -> impl Iterator<Item = &'a str> {
    object.get(list).and_then(Value::as_array).into_iter().flatten().filter_map(Value::as_str)
}

/// Returns the level of detail of a geometry.
fn detail(geometry: &Value) -> f64 {
    // 1.0 writes a number, later versions text.
    match geometry.get("lod") {
        Some(Value::Number(n)) => n.as_f64().unwrap_or(0.0),
        Some(Value::String(text)) => text.parse().unwrap_or(0.0),
        _ => 0.0,
    }
}

/// Returns the geometry with the highest level of detail; `None` without one.
fn most_detailed(object: &Value) -> Option<&Value> {
    let is_surfaces = |geometry: &&Value| {
        let kind = geometry.get("type").and_then(Value::as_str).unwrap_or_default();
        shells_above(kind).is_some()
    };
    let geometries = object.get("geometry").and_then(Value::as_array)?;
    geometries.iter().filter(is_surfaces).max_by(|a, b| detail(a).total_cmp(&detail(b)))
}

/// Returns the height of a building whose surfaces do not define it. The height of an outline alone
/// is the measured one. A block of just 3 m has an unknown height.
pub(super) fn height_of(measured: Option<&Property>, detail: f64, heights: Option<[f64; 2]>) -> Option<SolidHeight> {
    const FILLER_M: f64 = 3.0;
    let [low, high] = heights?;
    let measured = measured.and_then(|value| found_height(value, HeightUnit::Meters).meters()).filter(|m| *m >= 0.0);
    let is_outline = detail < 1.0 && high - low < 1e-6;
    // Levels such as 1.2 are made of measured roofs.
    let is_filler = (detail - 1.0).abs() < 1e-6 && (high - low - FILLER_M).abs() < 1e-6 && measured.is_none();
    match measured {
        Some(m) if is_outline => Some(SolidHeight::Measured(m)),
        _ => (is_outline || is_filler).then_some(SolidHeight::Unknown),
    }
}

/// Returns the number of lists around the surfaces of a type of geometry, beyond the one of a
/// surface list.
fn shells_above(kind: &str) -> Option<usize> {
    match kind {
        "MultiSurface" | "CompositeSurface" => Some(0),
        "Solid" => Some(1),
        "MultiSolid" | "CompositeSolid" => Some(2),
        _ => None,
    }
}

/// Returns the solid of a geometry.
fn solid_of(geometry: &Value, vertices: &[[f64; 3]]) -> std::result::Result<Solid, String> {
    let depth = geometry.get("type").and_then(Value::as_str).and_then(shells_above).unwrap_or(0);
    let mut surfaces = Vec::new();
    let boundaries = geometry.get("boundaries").ok_or("a geometry without `boundaries`")?;
    collect(boundaries, geometry.pointer("/semantics/values"), depth, &mut surfaces)?;
    let semantics = geometry.pointer("/semantics/surfaces").and_then(Value::as_array);
    let kind = |semantic: Option<u64>| {
        let surface = semantic.and_then(|k| semantics?.get(usize::try_from(k).ok()?));
        match surface.and_then(|s| s.get("type")).and_then(Value::as_str) {
            Some("GroundSurface") => FaceKind::Ground,
            Some("RoofSurface" | "OuterFloorSurface") => FaceKind::Roof,
            Some(_) => FaceKind::Other,
            None => FaceKind::Unknown,
        }
    };
    let face = |(rings, semantic)| rings_of(rings, vertices).map(|face| (face, kind(semantic)));
    Ok(Solid::of(surfaces.into_iter().map(face).collect::<std::result::Result<_, _>>()?))
}

/// A surface as its rings, and the index of its semantic surface.
type Surface<'a> = (&'a Value, Option<u64>);

/// Collects the surfaces `depth` lists further down, each with the number at the same place of
/// `values`.
fn collect<'a>(
    boundaries: &'a Value,
    values: Option<&'a Value>,
    depth: usize,
    surfaces: &mut Vec<Surface<'a>>,
) -> std::result::Result<(), String> {
    let parts = boundaries.as_array().ok_or("`boundaries` that are no lists")?;
    for (k, part) in parts.iter().enumerate() {
        let value = values.and_then(|v| v.get(k));
        match depth {
            0 => surfaces.push((part, value.and_then(Value::as_u64))),
            _ => collect(part, value, depth - 1, surfaces)?,
        }
    }
    Ok(())
}

fn rings_of(surface: &Value, vertices: &[[f64; 3]]) -> std::result::Result<Vec<Vec<[f64; 3]>>, String> {
    let vertex = |index: &Value| {
        let vertex = index.as_u64().and_then(|k| vertices.get(usize::try_from(k).ok()?));
        vertex.copied().ok_or_else(|| format!("vertex number {index}, of {} vertices", vertices.len()))
    };
    let ring = |ring: &Value| {
        let indices = ring.as_array().ok_or("a ring that is no list")?;
        indices.iter().map(vertex).collect()
    };
    surface.as_array().ok_or("a surface that is no list")?.iter().map(ring).collect()
}

fn properties(attributes: &Map<String, Value>) -> Properties {
    attributes.iter().map(|(name, value)| (name.as_str().into(), Property::of_json(value))).collect()
}

#[cfg(test)]
mod tests {
    use super::super::super::polygon::doubled_area;
    use super::*;

    /// Returns a house of 10 × 6 m from (100, 200, 50) with its ridge at 59 m, in integers of a
    /// millimeter.
    fn house(version: &str, lod: Value, semantics: bool) -> Value {
        let mut geometry = serde_json::json!({
            "type": "Solid", "lod": lod,
            "boundaries": [[
                [[0, 3, 2, 1]], [[0, 1, 5, 4]], [[2, 3, 7, 6]], [[1, 2, 6, 9, 5]], [[3, 0, 4, 8, 7]],
                [[4, 5, 9, 8]], [[8, 9, 6, 7]]
            ]],
        });
        if semantics {
            let kinds = [("type", "GroundSurface"), ("type", "WallSurface"), ("type", "RoofSurface")];
            let surfaces: Vec<Value> = kinds.iter().map(|(k, v)| serde_json::json!({*k: *v})).collect();
            geometry["semantics"] = serde_json::json!({"surfaces": surfaces, "values": [[0, 1, 1, 1, 1, 2, 2]]});
        }
        serde_json::json!({
            "type": "CityJSON", "version": version,
            "metadata": {"referenceSystem": "https://www.opengis.net/def/crs/EPSG/0/7415"},
            "transform": {"scale": [0.001, 0.001, 0.001], "translate": [100.0, 200.0, 50.0]},
            "vertices": [
                [0, 0, 0], [10000, 0, 0], [10000, 6000, 0], [0, 6000, 0],
                [0, 0, 6000], [10000, 0, 6000], [10000, 6000, 6000], [0, 6000, 6000],
                [0, 3000, 9000], [10000, 3000, 9000]
            ],
            "CityObjects": {"h": {"type": "Building", "attributes": {"storeys": 2}, "geometry": [geometry]}},
        })
    }

    #[test]
    fn a_house_is_as_high_as_its_ridge_and_covers_its_ground_surface() {
        for (version, lod) in [("1.0", serde_json::json!(2)), ("1.1", serde_json::json!("2.2"))] {
            let set = features(&"h.city.json".into(), &house(version, lod, true)).expect("a house");
            assert_eq!(set.crs.expect("known").and_then(|c| c.epsg()), Some(28992));
            let [house] = set.features.as_slice() else { panic!("{:?}", set.features) };
            assert_eq!(house.heights, Some([50.0, 59.0]));
            assert_eq!(house.polygons, [vec![vec![[100.0, 200.0], [100.0, 206.0], [110.0, 206.0], [110.0, 200.0]]]]);
            assert_eq!(house.property("storeys", None), Some(&Property::Number(2.0)));
        }
    }

    #[test]
    fn without_semantics_all_surfaces_but_walls_cover_ground() {
        let set = features(&"h.json".into(), &house("2.0", "1.3".into(), false)).expect("a house");
        assert_eq!(set.features[0].polygons.len(), 3);
        let area: f64 = set.features[0].polygons.iter().map(|p| doubled_area(&p[0]).abs() / 2.0).sum();
        assert!((area - 120.0).abs() < 1e-6, "{area}");
    }
}
