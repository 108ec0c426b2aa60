//! UAV sites: where the UAVs hover, from flags, CSV or GeoJSON.

use std::path::Path;
use std::str::FromStr;

use serde_json::Value;

use super::geojson_file::{features, named_crs, read_document};
use super::table::line_of;
use crate::error::{Error, Result};
use crate::quantity::{Height, parse_number};
use crate::raster::{Crs, CrsKind, GeoRef, transform};

/// The record of a UAV: a name, a position in the scene's CRS and a height.
#[derive(Debug, Clone, PartialEq)]
pub struct Site {
    /// Name, unique in a run.
    pub id: String,
    /// East \[CRS units\].
    pub x: f64,
    /// North \[CRS units\].
    pub y: f64,
    /// Height and what it is above.
    pub height: Height,
}

/// A site as it was given.
#[derive(Debug, Clone, PartialEq)]
pub struct GivenSite {
    /// The site.
    pub site: Site,
    /// Its longitude and latitude \[deg\], if it was given by these.
    pub lonlat: Option<[f64; 2]>,
}

impl std::ops::Deref for GivenSite {
    type Target = Site;

    fn deref(&self) -> &Site {
        &self.site
    }
}

impl From<Site> for GivenSite {
    /// A site that was given in the scene's CRS.
    fn from(site: Site) -> Self {
        GivenSite { site, lonlat: None }
    }
}

/// Reads sites from a CSV table or GeoJSON points.
///
/// CSV columns: `x,y` in the scene's CRS or `lon,lat` in degrees; `h` (or `height`, `h_m`, `height_m`) such as `120`,
/// `30roof`; optional `h_above` (`ground`, `roof`, `amsl`) and `id` (or `site`). GeoJSON points are longitude and
/// latitude (RFC 7946) unless a `crs` member says otherwise, with the same property names; `height_amsl_m`, as written
/// by this program, serves too. Sites without an id are numbered from `first_number`.
///
/// # Errors
/// File errors naming the line or feature; site errors if a position cannot be brought into the scene's CRS.
pub fn read_sites(path: &Path, grid: &GeoRef, first_number: usize) -> Result<Vec<Site>> {
    Ok(read_given_sites(path, grid, first_number)?.into_iter().map(|given| given.site).collect())
}

/// The sites of [`read_sites`], with longitude and latitude where they were given so.
///
/// # Errors
/// As [`read_sites`].
pub fn read_given_sites(path: &Path, grid: &GeoRef, first_number: usize) -> Result<Vec<GivenSite>> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let sites = match extension.as_str() {
        "geojson" | "json" => read_geojson(path, grid, first_number)?,
        _ => read_csv(path, grid, first_number)?,
    };
    if sites.is_empty() {
        return Err(Error::file(308, format!("cannot use {}: it holds no site", path.display())));
    }
    Ok(sites)
}

fn read_csv(path: &Path, grid: &GeoRef, first_number: usize) -> Result<Vec<GivenSite>> {
    let refuse = |place: &str, found: String| {
        Error::file(302, format!("cannot read {}: {place}{found}", path.display()))
            .with_hint("a table of sites is separated by commas and has the columns `x,y,h` or `lon,lat,h`, and optionally `id`, `h_above`")
    };
    let text =
        std::fs::read_to_string(path).map_err(|e| Error::file(301, format!("cannot read {}: {e}", path.display())))?;
    let text = text.trim_start_matches('\u{feff}');
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).comment(Some(b'#')).from_reader(text.as_bytes());
    let headers = reader.headers().map_err(|e| refuse("", e.to_string()))?.clone();
    let column = |names: &[&str]| headers.iter().position(|h| names.contains(&h.to_lowercase().as_str()));
    let (projected, degrees) = (
        column(&["x", "x_m", "easting"]).zip(column(&["y", "y_m", "northing"])),
        column(&["lon", "longitude", "lng"]).zip(column(&["lat", "latitude"])),
    );
    let found = || headers.iter().collect::<Vec<_>>().join(",");
    let Some((x_column, y_column)) = projected.or(degrees) else {
        return Err(refuse("line 1: ", format!("found columns `{}`, wanted a position", found())));
    };
    let Some(h_column) = column(&["h", "h_m", "height", "height_m"]) else {
        return Err(refuse("line 1: ", format!("found columns `{}`, wanted a height", found())));
    };
    let (above_column, id_column) = (column(&["h_above"]), column(&["id", "site", "name"]));
    let wgs84 = if projected.is_none() { Some(Crs::from_epsg(4326)?) } else { None };

    let mut sites = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| refuse("", e.to_string()))?;
        let place = format!("line {}: ", record.position().map_or(0, |start| line_of(text, start)));
        let field = |k: usize| record.get(k).unwrap_or_default();
        let number = |k: usize| parse_number(field(k)).map_err(|e| refuse(&place, format!("`{}`: {e}", &headers[k])));
        let height = height(field(h_column), above_column.map(field)).map_err(|e| refuse(&place, e))?;
        let id = id_column.map(field).filter(|s| !s.is_empty());
        let xy = (number(x_column)?, number(y_column)?);
        let (x, y) = in_scene(path, &place, xy, wgs84.as_ref(), grid.crs())?;
        refuse_swapped(path, &place, (xy, (x, y)), (wgs84.as_ref(), grid))?;
        let id = id.map_or_else(|| (first_number + sites.len()).to_string(), str::to_string);
        let lonlat = wgs84.as_ref().map(|_| [xy.0, xy.1]);
        sites.push(GivenSite { site: Site { id, x, y, height }, lonlat });
    }
    Ok(sites)
}

fn read_geojson(path: &Path, grid: &GeoRef, first_number: usize) -> Result<Vec<GivenSite>> {
    let document = read_document(path)?;
    let crs = match named_crs(path, &document)? {
        Some(crs) => crs,
        None => Crs::from_epsg(4326)?,
    };
    let mut sites = Vec::new();
    for (number, feature) in features(path, document)?.into_iter().enumerate() {
        let place = format!("feature {}: ", number + 1);
        let refuse = |found: String| {
            Error::file(302, format!("cannot read {}: {place}{found}", path.display()))
                .with_hint("a site is a Point with the property `h`, and optionally `id`, `h_above`")
        };
        let coordinate = |k: usize| feature.pointer(&format!("/geometry/coordinates/{k}")).and_then(Value::as_f64);
        let is_point = feature.pointer("/geometry/type").and_then(Value::as_str) == Some("Point");
        let (true, Some(x), Some(y)) = (is_point, coordinate(0), coordinate(1)) else {
            return Err(refuse("found no Point with two numbers".into()));
        };
        let text = |v: &Value| v.as_str().map_or_else(|| v.to_string(), str::to_string);
        let property = |names: &[&str]| {
            names.iter().find_map(|n| feature.get("properties")?.get(n)).filter(|v| !v.is_null()).map(text)
        };
        let above = property(&["h_above"]);
        let height = match (property(&["h", "h_m", "height", "height_m"]), property(&["height_amsl_m"])) {
            (Some(h), _) => height(&h, above.as_deref()),
            (None, Some(h)) => height(&h, Some("amsl")),
            (None, None) => Err("found no height `h`".into()),
        };
        let height = height.map_err(refuse)?;
        let id = property(&["id", "site", "name"]).or_else(|| feature.get("id").map(text));
        // Positions far outside the range of degrees cannot be meant as such.
        let named_projected = !matches!(crs.kind(), CrsKind::Geographic);
        let plausible = x.abs() <= 360.0 && y.abs() <= 90.0;
        let from = (named_projected || plausible).then_some(&crs);
        let (given, (x, y)) = ((x, y), in_scene(path, &place, (x, y), from, grid.crs())?);
        refuse_swapped(path, &place, (given, (x, y)), (from, grid))?;
        let id = id.unwrap_or_else(|| (first_number + number).to_string());
        let is_degrees = from.is_some_and(|crs| matches!(crs.kind(), CrsKind::Geographic));
        let lonlat = is_degrees.then_some([given.0, given.1]);
        sites.push(GivenSite { site: Site { id, x, y, height }, lonlat });
    }
    Ok(sites)
}

fn height(text: &str, above: Option<&str>) -> std::result::Result<Height, String> {
    let Some(above) = above.filter(|a| !a.is_empty()) else { return Height::from_str(text) };
    let value = parse_number(text).map_err(|found| format!("height: {found}"))?;
    match above {
        "ground" | "agl" => Ok(Height::AboveGround(value)),
        "roof" => Ok(Height::AboveRoof(value)),
        "amsl" | "datum" => Ok(Height::AboveDatum(value)),
        other => Err(format!("`h_above` is `{other}`, wanted `ground`, `roof` or `amsl`")),
    }
}

/// Refuses longitude and latitude that lie outside the scene, but inside when they are exchanged.
fn refuse_swapped(
    path: &Path,
    place: &str,
    (given, found): ((f64, f64), (f64, f64)),
    (from, grid): (Option<&Crs>, &GeoRef),
) -> Result<()> {
    let is_inside =
        |(x, y): (f64, f64)| x >= grid.x_min() && x <= grid.x_max() && y >= grid.y_min() && y <= grid.y_max();
    let (Some(from), Some(to)) = (from.filter(|f| matches!(f.kind(), CrsKind::Geographic)), grid.crs()) else {
        return Ok(());
    };
    if is_inside(found) || !transform(from, to, (given.1, given.0)).is_ok_and(is_inside) {
        return Ok(());
    }
    let (lon, lat) = given;
    let text = format!(
        "cannot place {}: {place}longitude {lon} and latitude {lat} are far from the scene; exchanged, they lie in it",
        path.display()
    );
    Err(Error::site(206, text).with_hint("longitude comes first in GeoJSON, and the columns are `lon,lat`"))
}

/// A position in the scene's CRS; `from` is `None` where it already is.
pub(super) fn in_scene(
    path: &Path,
    place: &str,
    xy: (f64, f64),
    from: Option<&Crs>,
    scene_crs: Option<&Crs>,
) -> Result<(f64, f64)> {
    let Some(from) = from else { return Ok(xy) };
    let Some(to) = scene_crs else {
        return Err(Error::site(
            206,
            format!("cannot place {}: {place}position in {}, but the scene names no CRS", path.display(), from.label()),
        )
        .with_hint("give the scene's CRS with `--crs EPSG:n`, or sites as `x,y` in the scene's own coordinates"));
    };
    if from.epsg().is_some() && from.epsg() == to.epsg() {
        return Ok(xy);
    }
    transform(from, to, xy).map_err(|e| {
        Error::site(206, format!("cannot place {}: {place}{e} ({} to {})", path.display(), from.label(), to.label()))
    })
}
