//! Paths of KML 2.2 and 2.3: <https://docs.ogc.org/is/12-007r2/12-007r2.html>.

use roxmltree::Node;

use super::super::moment::Moment;
use super::super::sites::bad_rows;
use super::super::table::RowFault;
use super::xml::{named, parse_xml, text_of};
use super::{RawPath, RawPaths, RawVertex, VertexHeight, degrees};
use crate::error::{MOST_FOUND, PlacesIn, Result, shortened};
use crate::input::Input;
use crate::quantity::{Height, parse_number};

/// Reads the lines, tracks and points of all placemarks. Heights are as their `altitudeMode` says;
/// without one they lie on the ground, and are none.
pub(super) fn read(input: &Input, text: &str) -> Result<RawPaths> {
    let document = parse_xml(input, text)?;
    let mut paths = Vec::new();
    let placemarks = document.descendants().filter(|node| node.tag_name().name() == "Placemark");
    for (k, placemark) in placemarks.enumerate() {
        let name = text_of(placemark, "name");
        let told = match &name {
            Some(name) => format!("placemark {} (`{}`)", k + 1, shortened(name, MOST_FOUND)),
            None => format!("placemark {}", k + 1),
        };
        let moment = named(placemark, "TimeStamp").next().and_then(|stamp| text_of(stamp, "when"));
        for geometry in placemark.descendants() {
            match geometry.tag_name().name() {
                "Point" => {
                    let mut point = of_coordinates((&told, &name), geometry, moment.as_deref());
                    point.are_points = true;
                    paths.push(point);
                }
                "LineString" => paths.push(of_coordinates((&told, &name), geometry, None)),
                "Track" => paths.push(of_track((&told, &name), geometry)),
                _ => {}
            }
        }
    }
    if paths.is_empty() {
        let found = "found no Point, LineString or Track in a Placemark".to_string();
        return Err(bad_rows(input, PlacesIn::Path, found, false));
    }
    Ok(RawPaths { paths, crs: degrees()?, home: None, is_degrees: false, kind: PlacesIn::Path })
}

/// Reference of the heights of a geometry.
#[derive(Debug, Clone, Copy)]
enum Mode {
    OnGround,
    AboveGround,
    AboveDatum,
}

fn mode_of(geometry: Node<'_, '_>) -> std::result::Result<Mode, RowFault> {
    match text_of(geometry, "altitudeMode").as_deref() {
        None | Some("clampToGround" | "clampToSeaFloor") => Ok(Mode::OnGround),
        Some("relativeToGround" | "relativeToSeaFloor") => Ok(Mode::AboveGround),
        Some("absolute") => Ok(Mode::AboveDatum),
        Some(other) => Err(RowFault::Text(format!(
            "found the altitudeMode `{}`, wanted clampToGround, relativeToGround or absolute",
            shortened(other, MOST_FOUND)
        ))),
    }
}

fn of_coordinates((told, name): (&str, &Option<String>), geometry: Node<'_, '_>, moment: Option<&str>) -> RawPath {
    let text = text_of(geometry, "coordinates").unwrap_or_default();
    let tuples: Vec<&str> = text.split_whitespace().collect();
    let vertices = tuples
        .iter()
        .enumerate()
        .map(|(k, tuple)| {
            let vertex = mode_of(geometry).and_then(|mode| {
                let numbers: Vec<&str> = tuple.split(',').collect();
                vertex_of(&numbers, mode, moment)
            });
            let told = if tuples.len() > 1 { format!("{told}, vertex {}", k + 1) } else { told.to_string() };
            (told, vertex.map(|vertex| RawVertex { name: name.clone().filter(|_| tuples.len() == 1), ..vertex }))
        })
        .collect();
    RawPath { name: name.clone(), are_points: false, vertices }
}

/// Reads a `gx:Track`: as many `when` as `coord`.
fn of_track((told, name): (&str, &Option<String>), track: Node<'_, '_>) -> RawPath {
    let texts = |name| named(track, name).map(|node| node.text().unwrap_or_default().trim().to_string());
    let (times, places): (Vec<String>, Vec<String>) = (texts("when").collect(), texts("coord").collect());
    let fault = (!times.is_empty() && times.len() != places.len()).then(|| {
        RowFault::Text(format!("found {} times of {} places, wanted one for each", times.len(), places.len()))
    });
    let vertex = |(k, place): (usize, &String)| {
        let numbers: Vec<&str> = place.split_whitespace().collect();
        let vertex = match &fault {
            Some(fault) => Err(fault.clone()),
            None => mode_of(track).and_then(|mode| vertex_of(&numbers, mode, times.get(k).map(String::as_str))),
        };
        (format!("{told}, place {}", k + 1), vertex)
    };
    RawPath { name: name.clone(), are_points: false, vertices: places.iter().enumerate().map(vertex).collect() }
}

fn vertex_of(numbers: &[&str], mode: Mode, moment: Option<&str>) -> std::result::Result<RawVertex, RowFault> {
    let wrong = |found: String| RowFault::Text(format!("{found}, wanted longitude, latitude and a height"));
    let number = |k: usize| parse_number(numbers[k]).map_err(wrong);
    if !(2..=3).contains(&numbers.len()) {
        return Err(wrong(format!("found {} numbers", numbers.len())));
    }
    let height = if numbers.len() > 2 { Some(number(2)?) } else { None };
    let height = match (mode, height) {
        (Mode::OnGround, _) => None,
        (Mode::AboveGround, z) => Some(Height::AboveGround(z.unwrap_or(0.0))),
        (Mode::AboveDatum, Some(z)) => Some(Height::AboveDatum(z)),
        (Mode::AboveDatum, None) => return Err(wrong("found no height above the datum".into())),
    };
    let moment = moment.map(|text| Moment::parse(text, 1.0)).transpose().map_err(RowFault::Text)?;
    Ok(RawVertex { xy: (number(0)?, number(1)?), height: height.map(VertexHeight::Own), moment, name: None })
}
