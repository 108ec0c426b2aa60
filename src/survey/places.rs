//! Description of a file of places: UAVs, or the track of a user.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;
use serde_json::Value;

use super::INFO_SCHEMA;
use crate::answer::{Answer, CommandFacts, Spent, document_of};
use skyshed_io::error::ReadFault;

use crate::city::GivenSite;
use crate::crs;
use crate::error::{Error, ErrorRepr, Result};
use crate::export::{Batch, Format};
use crate::picture::Look;
use crate::quantity::{Height, counted, tidy};
use crate::raster::{Crs, CrsKind, GeoRef};
use crate::read::{BadRows, Paths, VertexHeight, read_sites, read_track};
use crate::words::version;

/// Places of a file.
#[derive(Debug)]
pub(crate) struct Places {
    command: CommandFacts,
    path: PathBuf,
    what: What,
    crs: Option<Crs>,
}

#[derive(Debug)]
enum What {
    Uavs(Vec<GivenSite>),
    Track(Paths),
}

/// Kind of a file, judged by its beginning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Looks {
    Uavs,
    Track,
    Neither,
}

impl Places {
    /// Returns `true` for a file of UAVs or of a track, judged by its beginning.
    pub(crate) fn is_one(path: &Path) -> bool {
        looks_of(path) != Looks::Neither
    }

    /// Reads the places of a file; `None` if the file is of another kind.
    ///
    /// # Errors
    /// Faults of the file, as [`read_sites`] and [`read_track`].
    pub(crate) fn of(path: &Path, crs: Option<Crs>, command: &CommandFacts) -> Result<Option<Places>> {
        let looks = looks_of(path);
        if looks == Looks::Neither {
            return Ok(None);
        }
        let places = |what, crs| Places { command: command.clone(), path: path.to_path_buf(), what, crs };
        let found = match read(path, looks, crs.clone()) {
            // Without a scene, degrees stay degrees.
            Err(error) if lacks_scene_crs(&error) => {
                let degrees = Some(crs::from_epsg(4326)?);
                places(read(path, looks, degrees.clone())?, degrees)
            }
            read => places(read?, crs),
        };
        Ok(Some(found))
    }

    fn positions(&self) -> Vec<[f64; 2]> {
        match &self.what {
            What::Uavs(sites) => sites.iter().map(|site| [site.x, site.y]).collect(),
            What::Track(paths) => paths.lines.iter().flat_map(|path| &path.vertices).map(|v| [v.x, v.y]).collect(),
        }
    }

    /// Returns west, south, east, north.
    fn extent(&self) -> [f64; 4] {
        let start = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        self.positions().iter().fold(start, |[w, s, e, n], [x, y]| [w.min(*x), s.min(*y), e.max(*x), n.max(*y)])
    }

    /// Returns the length of a track \[CRS units\]; `None` for places in degrees and for UAVs.
    fn length(&self) -> Option<f64> {
        let is_degrees = self.crs.as_ref().is_some_and(|crs| matches!(crs.kind(), CrsKind::Geographic));
        match &self.what {
            What::Track(paths) if !is_degrees => {
                let legs = paths.lines.iter().flat_map(|path| path.vertices.windows(2));
                Some(legs.map(|ends| (ends[1].x - ends[0].x).hypot(ends[1].y - ends[0].y)).sum())
            }
            _ => None,
        }
    }

    /// Returns the number and range of the heights, by their reference.
    fn heights(&self) -> BTreeMap<&'static str, (usize, [f64; 2])> {
        let mut heights = BTreeMap::new();
        let told = |height: Height| match height {
            Height::AboveGround(_) => ("ground", height.value()),
            Height::AboveRoof(_) => ("roof", height.value()),
            Height::AboveDatum(_) => ("datum", height.value()),
        };
        let of_vertex = |height: VertexHeight| match height {
            VertexHeight::Own(height) => told(height),
            VertexHeight::AboveHome(m) => ("home", m),
        };
        let all: Vec<(&'static str, f64)> = match &self.what {
            What::Uavs(sites) => sites.iter().map(|site| told(site.height)).collect(),
            What::Track(paths) => {
                let vertices = paths.lines.iter().flat_map(|path| &path.vertices);
                vertices.filter_map(|vertex| vertex.height).map(of_vertex).collect()
            }
        };
        for (above, h) in all {
            let (n, [low, high]) = heights.entry(above).or_insert((0, [h, h]));
            (*n, *low, *high) = (*n + 1, low.min(h), high.max(h));
        }
        heights
    }

    /// Returns faults that a run with these places would refuse, and repeated places.
    fn faults(&self) -> Vec<String> {
        let What::Uavs(sites) = &self.what else { return Vec::new() };
        let (mut ids, mut places) = (BTreeSet::new(), BTreeSet::new());
        let mut faults = Vec::new();
        for site in sites {
            if !ids.insert(site.id.as_str()) {
                faults.push(format!("id `{}` is given twice: a map refuses that", site.id));
            }
            if !places.insert((site.x.to_bits(), site.y.to_bits(), site.height.to_string())) {
                faults.push(format!("`{}` is at the place and height of another", site.id));
            }
        }
        faults
    }

    fn kind(&self) -> &'static str {
        match self.what {
            What::Uavs(_) => "uavs",
            What::Track(_) => "track",
        }
    }

    fn advice(&self) -> String {
        let path = self.path.display();
        match self.what {
            What::Uavs(_) => format!("skyshed map SCENE --uavs {path} -o coverage.png"),
            What::Track(_) => format!("skyshed track SCENE --uav X,Y,H --track {path} -o track.png"),
        }
    }
}

/// Places of a file.
#[derive(Debug, Serialize, JsonSchema)]
pub(crate) struct PlacesInfo {
    /// Kind of document and its version.
    schema: &'static str,
    /// Version of the program.
    version: &'static str,
    #[serde(flatten)]
    command: CommandFacts,
    /// uavs or track.
    kind: &'static str,
    /// Path of the file.
    path: String,
    /// Number of places.
    places: usize,
    /// West, south, east, north [units of the reference system].
    extent: [f64; 4],
    /// Reference system; null for that of the scene.
    crs: Option<String>,
    /// Heights of UAVs, by reference.
    heights: BTreeMap<&'static str, HeightsInfo>,
    /// Length of a track [units of the reference system].
    length: Option<f64>,
    /// Reason for having no length.
    reason: Option<&'static str>,
    /// Faults that a run would refuse, and repeated places.
    faults: Vec<String>,
    /// Suggested use of the file.
    #[serde(rename = "use")]
    advice: String,
}

/// Heights with one reference.
#[derive(Debug, Serialize, JsonSchema)]
struct HeightsInfo {
    /// Number of places.
    places: usize,
    /// Lowest and highest [m].
    range_m: [f64; 2],
}

impl Answer for Places {
    fn is_in_words(&self) -> bool {
        true
    }

    fn document(&self, _: Option<Spent>) -> Value {
        let heights = self.heights().into_iter();
        let length = self.length();
        document_of(&PlacesInfo {
            schema: INFO_SCHEMA,
            version: version(),
            command: self.command.clone(),
            kind: self.kind(),
            path: self.path.display().to_string(),
            places: self.positions().len(),
            extent: self.extent(),
            crs: self.crs.as_ref().map(Crs::label),
            heights: heights.map(|(above, (places, range_m))| (above, HeightsInfo { places, range_m })).collect(),
            length,
            reason: length.is_none().then_some("a length needs a track in a plane"),
            faults: self.faults(),
            advice: self.advice(),
        })
    }

    fn text(&self, _: &Look) -> Result<String> {
        let [west, south, east, north] = self.extent().map(tidy);
        let crs = self
            .crs
            .as_ref()
            .map_or("coordinates of the scene".to_string(), |c| format!("{}, {}", c.label(), c.name()));
        let kind = match self.what {
            What::Uavs(_) => "places of UAVs",
            What::Track(_) => "track of a user",
        };
        let n = counted(self.positions().len() as u64, "place", "places");
        let mut text = format!("{} ({kind})\nplaces     {n}\n", self.path.display());
        text += &format!("extent     x {west} to {east}, y {south} to {north}\nCRS        {crs}\n");
        for (above, (n, [low, high])) in self.heights() {
            text += &format!("heights    {n} above the {above}: {} to {} m\n", tidy(low), tidy(high));
        }
        if let Some(length) = self.length() {
            text += &format!("length     {}\n", tidy(length));
        }
        for fault in self.faults() {
            text += &format!("fault      {fault}\n");
        }
        Ok(text + &format!("use        {}\n", self.advice()))
    }

    fn add(&self, _: &mut Batch, _: &Path, _: Format, _: &Look) -> Result<()> {
        Ok(())
    }
}

fn read(path: &Path, looks: Looks, crs: Option<Crs>) -> Result<What> {
    if looks == Looks::Track {
        // Faults that stop nothing are told when the track is used.
        return Ok(What::Track(read_track(path, crs.as_ref(), (false, &mut Vec::new()))?));
    }
    // Reading needs only the reference system of a scene: places need not lie in one.
    let grid = GeoRef::new((0.0, 0.0), (1.0, 1.0), (1, 1), crs).ok_or(Error::fault("a grid of one cell is valid"))?;
    Ok(What::Uavs(read_sites(path, &grid, 1, BadRows::Refuse)?))
}

/// Returns the kind of a file, by its extension and contents.
fn looks_of(path: &Path) -> Looks {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    match extension.as_str() {
        "csv" | "txt" | "tsv" => table_looks(path).unwrap_or(Looks::Neither),
        "geojson" | "json" => geojson_looks(path).unwrap_or(Looks::Neither),
        "gpx" | "plan" | "waypoints" => Looks::Track,
        "kml" => kml_looks(path).unwrap_or(Looks::Neither),
        _ => Looks::Neither,
    }
}

/// Returns `Uavs` for a table with heights, `Track` for any other. Reading a table that is neither
/// fails with its fault.
fn table_looks(path: &Path) -> Option<Looks> {
    let lines = BufReader::new(File::open(path).ok()?.take(1 << 16)).lines();
    let header = lines
        .map_while(std::io::Result::ok)
        .find(|line| !(line.starts_with('#') || line.trim().is_empty()))?
        .to_lowercase();
    let names: Vec<&str> = header
        .trim_start_matches('\u{feff}')
        .split([',', ';', '\t'])
        .map(|name| name.trim().trim_matches('"'))
        .collect();
    let has_height = ["h", "h_m", "height", "height_m"].iter().any(|name| names.contains(name));
    Some(if has_height { Looks::Uavs } else { Looks::Track })
}

/// Returns `Neither` for KML with polygons, which may be a scene.
fn kml_looks(path: &Path) -> Option<Looks> {
    let mut text = String::new();
    File::open(path).ok()?.read_to_string(&mut text).ok()?;
    Some(if text.contains("<Polygon") { Looks::Neither } else { Looks::Track })
}

/// Returns `Neither` for GeoJSON with polygons, which is a scene. Otherwise lines are a track, and
/// points are UAVs.
fn geojson_looks(path: &Path) -> Option<Looks> {
    let mut text = String::new();
    File::open(path).ok()?.read_to_string(&mut text).ok()?;
    let has = |kind: &str| text.contains(&format!("\"{kind}\""));
    if ["Polygon", "MultiPolygon", "CityJSON"].into_iter().any(has) {
        return Some(Looks::Neither);
    }
    if ["LineString", "MultiLineString"].into_iter().any(has) {
        return Some(Looks::Track);
    }
    Some(if has("Point") { Looks::Uavs } else { Looks::Neither })
}

/// Returns `true` for degrees in a file of a scene that names no reference system.
fn lacks_scene_crs(error: &Error) -> bool {
    match error.repr() {
        ErrorRepr::Io(skyshed_io::Error::Read(error)) => matches!(error.fault, ReadFault::NoSceneCrs(_)),
        _ => false,
    }
}
