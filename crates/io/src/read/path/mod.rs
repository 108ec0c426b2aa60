//! Paths in space: flights, walks and drives, with heights and times where the file has them.
//!
//! | file | lines | points | heights |
//! |---|---|---|---|
//! | CSV | all rows, or those of one `path` | | column `h` as everywhere, or `height_amsl_m` |
//! | GeoJSON | LineString, parts of a MultiLineString | Point | third coordinate above the datum; `h` of a point |
//! | GPX 1.0, 1.1 | segments of tracks, routes | waypoints | `ele` above the datum |
//! | KML 2.x | LineString, `gx:Track` | Point | `altitudeMode` |
//! | QGroundControl `.plan` and `.waypoints` | the mission | | by mode and frame |

mod geojson;
mod gpx;
mod kml;
mod mission;
mod table;
mod waypoints;
mod xml;

use super::moment::{Moment, OneClock};
use super::sites::{bad_rows, check_placeable, degrees_or_named, in_scene, refused};
use super::table::{BadRows, RowFault, readable};
use crate::crs;
use crate::error::{Error, OddFile, PlacesIn, ReadFault, Result, Wanted, Warning};
use crate::input::Input;
use crate::quantity::Height;
use crate::raster::{Crs, CrsKind};

/// Bytes of a file that tell what it is.
const HEAD_BYTES: u64 = 1 << 16;
/// First words of a mission as plain text.
const WAYPOINTS: &str = "QGC WPL";

/// A path: its vertices in their order, joined by straight legs.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// Name in the file.
    pub name: Option<String>,
    /// Vertices, at least one.
    pub vertices: Vec<Vertex>,
}

/// A vertex of a path.
#[derive(Debug, Clone, PartialEq)]
pub struct Vertex {
    /// East in the scene's reference system.
    pub x: f64,
    /// North in the scene's reference system.
    pub y: f64,
    /// Height, if it has one.
    pub height: Option<VertexHeight>,
    /// Time \[s\], if it has one.
    pub time_s: Option<f64>,
    /// Name in the file.
    pub name: Option<String>,
    /// Longitude and latitude \[deg\], if it was given so.
    pub lonlat: Option<[f64; 2]>,
}

/// Height of a vertex.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum VertexHeight {
    /// A height of its own.
    Own(Height),
    /// Above the ground of the place where the mission begins \[m\].
    AboveHome(f64),
}

/// Paths of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Paths {
    /// Lines, each of vertices that all have a height or all have none.
    pub lines: Vec<Path>,
    /// Points that belong to no line, in their order.
    pub points: Vec<Vertex>,
    /// Place where a mission begins, in the scene's reference system.
    pub home: Option<[f64; 2]>,
}

impl Paths {
    /// Returns `true` if a vertex has a height.
    pub fn have_heights(&self) -> bool {
        self.lines.iter().flat_map(|line| &line.vertices).chain(&self.points).any(|vertex| vertex.height.is_some())
    }

    /// Returns the points, and without any the vertices of the lines.
    pub fn into_places(self) -> Vec<Vertex> {
        match self.points.is_empty() {
            true => self.lines.into_iter().flat_map(|line| line.vertices).collect(),
            false => self.points,
        }
    }
}

/// A line or loose points of a file, as they stand there.
struct RawPath {
    name: Option<String>,
    /// `true` for loose points.
    are_points: bool,
    vertices: Vec<(String, std::result::Result<RawVertex, RowFault>)>,
}

/// A vertex as it stands in a file.
#[derive(Debug, Clone)]
struct RawVertex {
    xy: (f64, f64),
    height: Option<VertexHeight>,
    moment: Option<Moment>,
    name: Option<String>,
}

/// Content of a file of paths.
struct RawPaths {
    paths: Vec<RawPath>,
    /// System of the positions; `None` for those in that of the scene.
    crs: Option<Crs>,
    home: Option<(f64, f64)>,
    /// `true` if positions were given in degrees.
    is_degrees: bool,
    /// Kind of the file, for hints.
    kind: PlacesIn,
}

/// Reads the paths of a file into a scene's reference system. `-` is standard input.
///
/// Vertices that repeat the one before them in place, height and time are dropped. A third
/// coordinate that is 0 everywhere is no height (W386). Bad rows are left out with a warning (W380) if
/// `skips_bad`.
///
/// # Errors
/// File errors that name the lines or features; site errors if places cannot be brought into the
/// scene's system.
pub fn read_paths(
    input: impl Into<Input>,
    scene_crs: Option<&Crs>,
    (skips_bad, warnings): (bool, &mut Vec<Warning>),
) -> Result<Paths> {
    let input = &input.into();
    let mut raw = read_raw(input, scene_crs)?;
    if drop_zero_heights(&mut raw.paths) {
        warnings.push(Warning::of(input, OddFile::ZeroHeights));
    }
    let is_degrees = raw.is_degrees || raw.crs.as_ref().is_some_and(|crs| matches!(crs.kind(), CrsKind::Geographic));
    let place = |xy: (f64, f64)| {
        let from = raw.crs.as_ref().and_then(|crs| degrees_or_named(crs, xy));
        if from.is_none() && raw.kind == PlacesIn::Path {
            return Err(RowFault::Place(format!("found the position {}, {}, wanted degrees", xy.0, xy.1)));
        }
        in_scene(xy, from, scene_crs)
    };
    let positions =
        raw.paths.iter().flat_map(|path| &path.vertices).filter_map(|(_, vertex)| Some(vertex.as_ref().ok()?.xy));
    // GeoJSON with positions far beyond degrees is in the scene's own system.
    let mut froms = positions.map(|xy| raw.crs.as_ref().and_then(|crs| degrees_or_named(crs, xy)));
    check_placeable(input, froms.find(Option::is_some).flatten(), scene_crs)?;
    let mut clock = OneClock::default();
    let mut rows = Vec::new();
    for (k, path) in raw.paths.iter_mut().enumerate() {
        for (told, vertex) in path.vertices.drain(..) {
            let vertex = vertex.and_then(|vertex| {
                let (x, y) = place(vertex.xy)?;
                let time_s = vertex.moment.map(|moment| clock.seconds(moment)).transpose()?;
                let lonlat = (is_degrees && raw.crs.is_some()).then_some([vertex.xy.0, vertex.xy.1]);
                Ok((k, Vertex { x, y, height: vertex.height, time_s, name: vertex.name, lonlat }))
            });
            rows.push((told, vertex));
        }
    }
    let home = raw.home.map(place).transpose();
    let home = home.map_err(|fault| bad_rows(input, raw.kind, format!("home: {fault}"), false))?;
    let kind = raw.kind;
    let bad = if skips_bad { BadRows::LeaveOut(warnings) } else { BadRows::Refuse };
    let vertices = readable(input, rows, bad, |told| refused(input, told, kind, is_degrees))?;
    let mut paths = Paths { home: home.map(<[f64; 2]>::from), ..Paths::default() };
    let mut vertices = vertices.into_iter().peekable();
    for (k, path) in raw.paths.into_iter().enumerate() {
        let mut own = Vec::new();
        while let Some((_, vertex)) = vertices.next_if(|(of, _)| *of == k) {
            own.push(vertex);
        }
        if path.are_points {
            paths.points.append(&mut own);
        } else if !own.is_empty() {
            paths.lines.push(Path { name: path.name, vertices: own });
        }
    }
    Ok(paths)
}

/// Reads the paths of a track: its lines, or without any its points as one line.
///
/// # Errors
/// As [`read_paths`]; also for fewer than two different places, for paths of which only a part has
/// heights or times, and for times that go back.
pub fn read_track(input: impl Into<Input>, scene_crs: Option<&Crs>, told: (bool, &mut Vec<Warning>)) -> Result<Paths> {
    let input = &input.into();
    let mut paths = read_paths(input, scene_crs, told)?;
    if paths.lines.is_empty() {
        let vertices = std::mem::take(&mut paths.points);
        paths.lines.push(Path { name: None, vertices });
    }
    paths.points.clear();
    for path in &mut paths.lines {
        path.vertices.dedup_by(|b, a| (a.x, a.y, a.height, a.time_s) == (b.x, b.y, b.height, b.time_s));
    }
    let n_places = paths.lines.iter().map(|path| path.vertices.len()).max().unwrap_or(0);
    paths.lines.retain(|path| path.vertices.len() > 1);
    if paths.lines.is_empty() {
        return Err(Error::read(input, ReadFault::Nothing(Wanted::Places(n_places))));
    }
    let has_heights = paths.have_heights();
    for (k, path) in paths.lines.iter().enumerate() {
        check_vertices(path, has_heights).map_err(|found| {
            let of = if paths.lines.len() > 1 { format!("path {}, ", k + 1) } else { String::new() };
            bad_rows(input, PlacesIn::Path, format!("{of}{found}"), false)
        })?;
    }
    Ok(paths)
}

/// Checks that all vertices have what some have, and that time does not go back.
fn check_vertices(path: &Path, has_heights: bool) -> std::result::Result<(), String> {
    let vertex = |k: usize| match &path.vertices[k].name {
        Some(name) => format!("vertex {} (`{name}`)", k + 1),
        None => format!("vertex {}", k + 1),
    };
    if let Some(k) = path.vertices.iter().position(|v| v.height.is_some() != has_heights) {
        return Err(format!("{}: found no height, wanted one at every vertex or at none", vertex(k)));
    }
    let n_timed = path.vertices.iter().filter(|v| v.time_s.is_some()).count();
    if n_timed > 0
        && let Some(k) = path.vertices.iter().position(|v| v.time_s.is_none())
    {
        return Err(format!("{}: found no time, wanted one at every vertex or at none", vertex(k)));
    }
    match path.vertices.windows(2).position(|ends| ends[1].time_s < ends[0].time_s) {
        Some(k) => Err(format!("{}: found a time before that of the vertex before it", vertex(k + 1))),
        None => Ok(()),
    }
}

/// Drops third coordinates that are all 0, as programs write where there is no height; `true` if
/// there were any.
fn drop_zero_heights(paths: &mut [RawPath]) -> bool {
    let mut vertices: Vec<_> =
        paths.iter_mut().flat_map(|path| &mut path.vertices).filter_map(|(_, v)| v.as_mut().ok()).collect();
    let is_zero = |height: Option<VertexHeight>| height == Some(VertexHeight::Own(Height::AboveDatum(0.0)));
    let are_zero =
        vertices.iter().any(|v| v.height.is_some()) && vertices.iter().all(|v| v.height.is_none() || is_zero(v.height));
    if are_zero {
        vertices.iter_mut().for_each(|vertex| vertex.height = None);
    }
    are_zero
}

/// Returns `true` for XML or a mission, whose vertices may be UAVs; other places are those of tables and
/// GeoJSON.
///
/// # Errors
/// E301 if the file cannot be read.
pub fn is_path_file(input: &Input) -> Result<bool> {
    // A stream is a table or GeoJSON.
    if input.is_stream() {
        return Ok(false);
    }
    let head = input.head(HEAD_BYTES)?;
    let head = String::from_utf8_lossy(&head);
    let start = head.trim_start_matches('\u{feff}').trim_start();
    Ok(start.starts_with('<') || start.starts_with(WAYPOINTS) || mission::is_plan(start))
}

/// Reads a file as it stands, by its first bytes.
fn read_raw(input: &Input, scene_crs: Option<&Crs>) -> Result<RawPaths> {
    let text = input.text("a table, or a path, as UTF-8 text")?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(&text);
    let start = text.trim_start();
    if start.starts_with(WAYPOINTS) {
        return waypoints::read(input, text);
    }
    if start.starts_with('{') {
        return match mission::is_plan(text) {
            true => mission::read(input, text),
            false => geojson::read(input, text),
        };
    }
    if start.starts_with('<') {
        return match root_name(start) {
            Some("gpx") => gpx::read(input, text),
            Some("kml") => kml::read(input, text),
            root => {
                let found = root.map_or("no XML".to_string(), |root| format!("XML of `{root}`"));
                Err(bad_rows(input, PlacesIn::Path, format!("found {found}, wanted GPX or KML"), false))
            }
        };
    }
    table::read((input, text), scene_crs)
}

/// Returns the name of the first element of XML, without its prefix.
fn root_name(text: &str) -> Option<&str> {
    let mut rest = text;
    loop {
        rest = &rest[rest.find('<')?..];
        let end = match rest {
            _ if rest.starts_with("<!--") => "-->",
            _ if rest.starts_with("<?") || rest.starts_with("<!") => ">",
            _ => break,
        };
        rest = &rest[rest.find(end)? + end.len()..];
    }
    let name = rest[1..].split(|c: char| c.is_whitespace() || c == '>' || c == '/').next()?;
    Some(name.rsplit(':').next().unwrap_or(name))
}

/// Returns WGS 84, the system of degrees in files that name none.
fn degrees() -> Result<Option<Crs>> {
    Ok(Some(crs::from_epsg(4326)?))
}
