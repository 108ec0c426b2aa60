//! Missions: plans of QGroundControl, and what their commands mean for a path.
//!
//! <https://docs.qgroundcontrol.com/master/en/qgc-dev-guide/file_formats/plan.html>; commands and
//! frames are those of MAVLink.

use serde_json::Value;

use super::super::sites::bad_rows;
use super::super::table::RowFault;
use super::super::vector::geojson::parse_document;
use super::{RawPath, RawPaths, RawVertex, VertexHeight, degrees};
use crate::error::{MOST_FOUND, PlacesIn, Result, shortened};
use crate::input::Input;
use crate::quantity::Height;

/// An item of a mission.
pub(super) struct Item {
    /// Place in the file, in words.
    pub(super) told: String,
    pub(super) command: u64,
    /// Latitude and longitude \[deg\]; `None` where the item names no place.
    pub(super) place: Option<(f64, f64)>,
    /// Height of the item \[m\], and what it is above.
    pub(super) height: std::result::Result<Option<VertexHeight>, String>,
}

/// Commands of MAVLink that move the vehicle.
const WAYPOINTS: [u64; 6] = [16, 17, 18, 19, 31, 82];
const RETURN_TO_LAUNCH: u64 = 20;
const LANDINGS: [u64; 2] = [21, 85];
const TAKEOFFS: [u64; 2] = [22, 84];

/// Returns `true` for the text of a plan.
pub(super) fn is_plan(text: &str) -> bool {
    let head = &text[..text.len().min(1 << 16)];
    let mut rest = head;
    while let Some(at) = rest.find("\"fileType\"") {
        rest = rest[at + "\"fileType\"".len()..].trim_start();
        if rest.strip_prefix(':').is_some_and(|value| value.trim_start().starts_with("\"Plan\"")) {
            return true;
        }
    }
    false
}

/// Reads the mission of a plan as one path.
pub(super) fn read(input: &Input, text: &str) -> Result<RawPaths> {
    let document = parse_document(input, text)?;
    let refuse = |found: String| bad_rows(input, PlacesIn::Path, found, false);
    let mission = &document["mission"];
    let home = mission["plannedHomePosition"]
        .as_array()
        .and_then(|home| Some((home.get(1)?.as_f64()?, home.first()?.as_f64()?)));
    let items = mission["items"].as_array().ok_or_else(|| refuse("found a plan without `mission.items`".into()))?;
    let mut flat = Vec::new();
    for (k, item) in items.iter().enumerate() {
        let told = format!("item {}", k + 1);
        if item["type"] == "ComplexItem" {
            let inner = item["TransectStyleComplexItem"]["Items"].as_array().or_else(|| item["Items"].as_array());
            let kind = item["complexItemType"].as_str().unwrap_or("without a name");
            let kind = shortened(kind, MOST_FOUND);
            let inner = inner
                .ok_or_else(|| refuse(format!("{told}: found the complex item `{kind}` without items of its own")))?;
            flat.extend(inner.iter().enumerate().map(|(n, inner)| of_json(format!("{told}.{}", n + 1), inner)));
        } else {
            flat.push(of_json(told, item));
        }
    }
    of_items(input, flat, home)
}

fn of_json(told: String, item: &Value) -> Item {
    let param = |k: usize| item["params"][k].as_f64();
    let frame = item["frame"].as_u64();
    let above = match item["AltitudeMode"].as_u64() {
        Some(1) => Some(Frame::Home),
        Some(2) => Some(Frame::Datum),
        Some(3 | 4) => Some(Frame::Ground),
        _ => frame.and_then(Frame::of),
    };
    let value = if item["AltitudeMode"].as_u64().is_some() {
        item["Altitude"].as_f64().or(param(6))
    } else {
        param(6).or(item["Altitude"].as_f64())
    };
    Item {
        told,
        command: item["command"].as_u64().unwrap_or(0),
        place: param(4).zip(param(5)),
        height: height_of(above, frame, value),
    }
}

/// Reference of the heights of an item.
#[derive(Debug, Clone, Copy)]
pub(super) enum Frame {
    Datum,
    Home,
    Ground,
}

impl Frame {
    /// Returns the frame of MAVLink; `None` for one without places on earth.
    pub(super) fn of(number: u64) -> Option<Frame> {
        match number {
            0 | 5 => Some(Frame::Datum),
            3 | 6 => Some(Frame::Home),
            10 | 11 => Some(Frame::Ground),
            _ => None,
        }
    }
}

/// Returns the height of an item; an error only where one is needed.
pub(super) fn height_of(
    above: Option<Frame>,
    number: Option<u64>,
    value: Option<f64>,
) -> std::result::Result<Option<VertexHeight>, String> {
    let Some(above) = above else {
        return Err(format!(
            "found the frame {}, wanted 0, 3 or 10",
            number.map_or("none".to_string(), |n| n.to_string())
        ));
    };
    Ok(value.map(|value| match above {
        Frame::Datum => VertexHeight::Own(Height::AboveDatum(value)),
        Frame::Home => VertexHeight::AboveHome(value),
        Frame::Ground => VertexHeight::Own(Height::AboveGround(value)),
    }))
}

/// Returns the path that the items of a mission fly, as QGroundControl draws it: from home if it
/// takes off, and back there if it returns.
///
/// # Errors
/// E302 without a vertex, and for a mission that needs its home and has none.
pub(super) fn of_items(input: &Input, items: Vec<Item>, home: Option<(f64, f64)>) -> Result<RawPaths> {
    let ground = Some(VertexHeight::Own(Height::AboveGround(0.0)));
    let vertex = |xy, height| RawVertex { xy, height, moment: None, name: None };
    let mut vertices: Vec<(String, std::result::Result<RawVertex, RowFault>)> = Vec::new();
    let no_home = || RowFault::Text("found no planned home position, wanted one for what begins or ends there".into());
    let home_vertex = || home.map(|home| vertex(home, ground)).ok_or_else(no_home);
    for item in items {
        let Item { told, command, place, height } = item;
        // Autopilots read 0, 0 as the place where the vehicle is.
        let place = place.filter(|place| *place != (0.0, 0.0)).map(|(lat, lon)| (lon, lat));
        let last = vertices.iter().rev().find_map(|(_, vertex)| vertex.as_ref().ok()).map(|vertex| vertex.xy);
        let is_takeoff = TAKEOFFS.contains(&command);
        if is_takeoff && vertices.is_empty() {
            vertices.push((format!("{told}, home"), home_vertex()));
        }
        if command == RETURN_TO_LAUNCH {
            vertices.push((format!("{told}, home"), home_vertex()));
            break;
        }
        let is_landing = LANDINGS.contains(&command);
        if !(is_takeoff || is_landing || WAYPOINTS.contains(&command)) {
            continue;
        }
        let at = place.or(if is_takeoff { home.or(last) } else { last });
        let height = if is_landing {
            Ok(ground)
        } else {
            height.and_then(|height| height.map(Some).ok_or_else(|| "found no altitude".to_string()))
        };
        let made = match (at, height) {
            (None, _) => Err(RowFault::Text("found no place, wanted latitude and longitude".into())),
            (_, Err(found)) => Err(RowFault::Text(found)),
            (Some(at), Ok(height)) => Ok(vertex(at, height)),
        };
        vertices.push((told, made));
    }
    let needs_home =
        vertices.iter().any(|(_, v)| v.as_ref().is_ok_and(|v| matches!(v.height, Some(VertexHeight::AboveHome(_)))));
    if needs_home && home.is_none() {
        let found = "found heights above home, and no planned home position".to_string();
        return Err(bad_rows(input, PlacesIn::Path, found, false));
    }
    if vertices.is_empty() {
        return Err(bad_rows(input, PlacesIn::Path, "found no waypoint".into(), false));
    }
    let paths = vec![RawPath { name: None, are_points: false, vertices }];
    Ok(RawPaths { paths, crs: degrees()?, home, is_degrees: false, kind: PlacesIn::Path })
}
