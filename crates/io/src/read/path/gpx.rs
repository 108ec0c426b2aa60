//! Paths of GPX 1.0 and 1.1: <https://www.topografix.com/GPX/1/1/>.

use roxmltree::{Document, Node};

use super::super::moment::Moment;
use super::super::table::RowFault;
use super::xml::{named, parse_xml, text_of};
use super::{RawPath, RawPaths, RawVertex, VertexHeight, degrees};
use crate::error::{PlacesIn, Result};
use crate::input::Input;
use crate::quantity::{Height, parse_number};

/// Reads segments of tracks and routes as lines, waypoints as points; `ele` is above the datum.
pub(super) fn read(input: &Input, text: &str) -> Result<RawPaths> {
    let document: Document = parse_xml(input, text)?;
    let root = document.root_element();
    let mut paths = Vec::new();
    for track in named(root, "trk") {
        for segment in named(track, "trkseg") {
            let told = format!("segment {}", paths.len() + 1);
            paths.push(line(&told, text_of(track, "name"), named(segment, "trkpt")));
        }
    }
    for route in named(root, "rte") {
        let told = format!("route {}", paths.len() + 1);
        paths.push(line(&told, text_of(route, "name"), named(route, "rtept")));
    }
    let waypoints = line("waypoint", None, named(root, "wpt"));
    paths.push(RawPath { are_points: true, ..waypoints });
    Ok(RawPaths { paths, crs: degrees()?, home: None, is_degrees: false, kind: PlacesIn::Path })
}

fn line<'a, 'b: 'a>(told: &str, name: Option<String>, points: impl Iterator<Item = Node<'a, 'b>>) -> RawPath {
    let vertices = points.enumerate().map(|(k, point)| (format!("{told}, point {}", k + 1), vertex(point))).collect();
    RawPath { name, are_points: false, vertices }
}

fn vertex(point: Node<'_, '_>) -> std::result::Result<RawVertex, RowFault> {
    let wrong = |what: &str, found: String| RowFault::Text(format!("`{what}`: {found}, wanted a number"));
    let degrees = |name: &str| {
        let text = point.attribute(name).ok_or_else(|| wrong(name, "found none".into()))?;
        parse_number(text).map_err(|found| wrong(name, found))
    };
    let height =
        text_of(point, "ele").map(|text| parse_number(&text)).transpose().map_err(|found| wrong("ele", found))?;
    let moment = text_of(point, "time").map(|text| Moment::parse(&text, 1.0)).transpose().map_err(RowFault::Text)?;
    Ok(RawVertex {
        xy: (degrees("lon")?, degrees("lat")?),
        height: height.map(|z| VertexHeight::Own(Height::AboveDatum(z))),
        moment,
        name: text_of(point, "name"),
    })
}
