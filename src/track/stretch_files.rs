//! Stretches of tracks as lines: GeoJSON, and GPX and KML in degrees.

use std::path::Path;

use serde_json::json;

use super::TrackWalk;
use crate::answer::{Answer, feature, feature_collection};
use crate::coverage::{TrackState, WayStretch};
use crate::crs::{from_epsg, transform};
use crate::error::RequestError;
use crate::error::Result;
use crate::formats::xml_text;
use crate::quantity::tidy;
use crate::words::pretty;

/// Returns a line of each stretch with its facts, in the scene's reference system.
pub(super) fn geojson(walk: &TrackWalk) -> Result<String> {
    let lines = walk.told_stretches().map(|(_, stretch)| {
        let positions = ends_of(walk, stretch).map(|([x, y], z)| z.map_or_else(|| json!([x, y]), |z| json!([x, y, z])));
        json!(positions)
    });
    let features = walk.stretch_rows().into_iter().zip(lines);
    let features = features.map(|(row, line)| feature(json!(row), Some(("LineString", line)))).collect();
    Ok(pretty(&feature_collection(walk.scene.grid(), walk.provenance(), features)))
}

/// Returns both ends of a stretch: x, y and height above the datum \[m\].
fn ends_of(walk: &TrackWalk, stretch: &WayStretch) -> [([f64; 2], Option<f64>); 2] {
    stretch.at.map(|t| walk.ways[stretch.way].place(stretch.leg, t))
}

/// A stretch in degrees.
struct Line {
    name: String,
    state: TrackState,
    /// Longitude, latitude \[deg\], and height above the datum \[m\].
    ends: [(f64, f64, Option<f64>); 2],
}

/// Returns all stretches in degrees.
///
/// # Errors
/// E109 for a scene without a reference system; E310 for one without a way to degrees.
fn lines(walk: &TrackWalk, path: &Path) -> Result<Vec<Line>> {
    let crs = walk.scene.grid().crs().ok_or_else(|| RequestError::NoCrs(path.display().to_string()))?;
    let wgs84 = from_epsg(4326)?;
    let line = |(uav, stretch): (&str, &WayStretch)| {
        let [from, to] = ends_of(walk, stretch);
        let degrees = |([x, y], z): ([f64; 2], Option<f64>)| -> Result<_> {
            let (lon, lat) = transform(crs, &wgs84, (x, y))?;
            Ok((lon, lat, z))
        };
        let who = match uav {
            "" => "all UAVs".to_string(),
            id => format!("UAV {id}"),
        };
        let [from_m, to_m] = stretch.along_m.map(tidy);
        let name = format!("{}, {who}, path {}, {from_m} to {to_m} m", stretch.state.name(), stretch.way + 1);
        Ok(Line { name, state: stretch.state, ends: [degrees(from)?, degrees(to)?] })
    };
    walk.told_stretches().map(line).collect()
}

/// Returns a track of GPX 1.1 for each stretch.
pub(super) fn gpx(walk: &TrackWalk, path: &Path) -> Result<String> {
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <gpx version=\"1.1\" creator=\"skyshed\" xmlns=\"http://www.topografix.com/GPX/1/1\">\n",
    );
    for Line { name, state, ends } in lines(walk, path)? {
        text += &format!("<trk><name>{}</name><type>{}</type><trkseg>\n", xml_text(&name), state.name());
        for (lon, lat, z) in ends {
            let ele = z.map_or(String::new(), |z| format!("<ele>{z}</ele>"));
            text += &format!("<trkpt lat=\"{lat}\" lon=\"{lon}\">{ele}</trkpt>\n");
        }
        text += "</trkseg></trk>\n";
    }
    Ok(text + "</gpx>\n")
}

/// Colors of lines in KML, as alpha, blue, green, red: those of pictures.
const COLORS: [(TrackState, &str); 4] = [
    (TrackState::Los, "ffb27200"),
    (TrackState::Nlos, "ff009fe6"),
    (TrackState::Inside, "ff8c5e84"),
    (TrackState::Nodata, "ff999999"),
];

/// Returns a line of KML for each stretch.
pub(super) fn kml(walk: &TrackWalk, path: &Path) -> Result<String> {
    let name = xml_text(&format!("Line of sight along a track over {}", walk.facts.scene_name));
    let mut text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n<name>{name}</name>\n"
    );
    for (state, color) in COLORS {
        let state = state.name();
        text +=
            &format!("<Style id=\"{state}\"><LineStyle><color>{color}</color><width>5</width></LineStyle></Style>\n");
    }
    for Line { name, state, ends } in lines(walk, path)? {
        let mode = if ends[0].2.is_some() { "absolute" } else { "clampToGround" };
        let position =
            |(lon, lat, z): (f64, f64, Option<f64>)| z.map_or(format!("{lon},{lat}"), |z| format!("{lon},{lat},{z}"));
        text += &format!(
            "<Placemark><name>{}</name><styleUrl>#{}</styleUrl><LineString><altitudeMode>{mode}</altitudeMode>\
             <coordinates>{}</coordinates></LineString></Placemark>\n",
            xml_text(&name),
            state.name(),
            ends.map(position).join(" ")
        );
    }
    Ok(text + "</Document>\n</kml>\n")
}
