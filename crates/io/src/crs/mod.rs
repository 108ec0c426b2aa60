//! Coordinate reference systems: their names, their units, and transformations between them.
//!
//! Coordinates are always in the order x, y (east, north; longitude, latitude in degrees), whatever
//! order an authority assigns. Rasters, GeoJSON and every GIS store them so. Only the horizontal
//! part of a compound system is kept.
//!
//! The registry and the projections come from `proj-core`, the text forms from `proj-wkt`. This
//! module adds names in Esri `.prj` files and the dialect of WKT that GDAL reads.

mod degrees;
mod antimeridian;
mod names;
mod null_datums;
mod registry;
mod vertical;
mod web_mercator;
mod wkt;

pub(crate) use antimeridian::Turn;
pub use degrees::utm_for;
use registry::{code_of, east_north, registry_entry};
pub use vertical::{VerticalCrs, VerticalDifference};
pub(crate) use web_mercator::Stretch;
pub use web_mercator::is_web_mercator;

use std::fmt;
use std::mem::discriminant;

use proj_core::{
    AreaOfInterest, AxisOrder, CrsDef, SelectionOptions, Transform, operation_candidates_between_with_selection_options,
};

use crate::error::{CrsError, Error, Result};
use crate::raster::{Crs, CrsDefinition, CrsKind};

/// Returns the reference system with an EPSG code; for a compound system, its horizontal part.
///
/// # Errors
/// E310 if the registry does not know the code.
pub fn from_epsg(code: u32) -> Result<Crs> {
    let horizontal = registry_entry(code).ok_or(CrsError::UnknownCode(code))?;
    Ok(Crs::new(Some(horizontal.epsg()), horizontal.name(), kind_of(&horizontal), CrsDefinition::Registry))
}

/// Reads any common notation: `EPSG:25832`, `25832`, `urn:ogc:def:crs:EPSG::25832`,
/// `urn:ogc:def:crs:OGC:1.3:CRS84`, `EPSG:25832+5783`, addresses of the OGC, names of German
/// surveys (`ETRS89_UTM32*DE_DHHN2016_NH`), WKT 1 (also of Esri `.prj` files), WKT 2, PROJ strings,
/// PROJJSON.
///
/// A definition without an EPSG code gets one if a registry entry has the same projection, unit,
/// ellipsoid and name of geographic base. A WKT with an unsupported projection keeps its name and
/// unit: its rasters can be used but not transformed.
///
/// # Errors
/// E310 if `text` is none of these, or names a system that the registry does not know.
pub fn parse(text: &str) -> Result<Crs> {
    let text = text.trim_start_matches('\u{feff}').trim_matches(|c: char| c.is_whitespace() || c == '\0');
    let is_wkt = text.starts_with(|c: char| c.is_ascii_alphabetic()) && text.contains('[');
    if is_wkt {
        return from_wkt(text);
    }
    if let Some(code) = names::code_in(text) {
        return from_epsg(code);
    }
    let parsed = proj_wkt::parse_crs(text).map_err(|cause| unreadable(text, &cause.to_string()))?;
    let horizontal = east_north(parsed).ok_or_else(|| unreadable(text, "it has no horizontal part"))?;
    if horizontal.epsg() != 0 {
        return from_epsg(horizontal.epsg());
    }
    // A PROJ string names no geographic base; only `datum=WGS84` is unmistakable.
    if text.contains("datum=WGS84")
        && let Some(code) = code_of(&horizontal, "WGS 84", None)
    {
        return from_epsg(code);
    }
    let name = if horizontal.name().is_empty() { text } else { horizontal.name() }.to_string();
    let kind = checked_unit(kind_of(&horizontal), text)?;
    Ok(Crs::new(None, name, kind, CrsDefinition::Proj(text.to_string())))
}

fn from_wkt(text: &str) -> Result<Crs> {
    if !wkt::is_whole(text) {
        return Err(unreadable(text, "it ends before its brackets and quotes do"));
    }
    let node = wkt::horizontal_node(text).ok_or_else(|| unreadable(text, "it has no horizontal part"))?;
    if let Some(code) = wkt::epsg_of(node)
        && let Ok(crs) = from_epsg(code)
    {
        return Ok(crs);
    }
    let name = wkt::name_of(node).ok_or_else(|| unreadable(text, "it has no name"))?.to_string();
    if wkt::kind_of(node) == METERS && web_mercator::is_named_so(node) {
        return from_epsg(3857);
    }
    let parsed = proj_wkt::parse_crs(&wkt::for_proj_wkt(node)).ok().and_then(east_north);
    if let Some(horizontal) = &parsed {
        let base = if horizontal.is_projected() { wkt::base_name_of(node) } else { Some(name.as_str()) };
        if let Some(code) = base.and_then(|base| code_of(horizontal, base, Some(&name))) {
            return from_epsg(code);
        }
    }
    // The unit is checked as written: the parser replaces a unit of 0.
    let written = checked_unit(wkt::kind_of(node), text)?;
    let kind = parsed.as_ref().map_or(written, kind_of);
    Ok(Crs::new(None, name, kind, CrsDefinition::Wkt(node.to_string())))
}

/// Returns a system of which only name and unit are known, as in the GeoKeys of a user-defined
/// projection.
///
/// Its rasters can be used; coordinates in it cannot be transformed. `meters_per_unit` applies to
/// projected systems. A name of web Mercator in meters gives EPSG:3857 instead.
pub fn from_geokeys_citation(name: &str, meters_per_unit: Option<f64>, geographic: bool) -> Crs {
    if !geographic && meters_per_unit == Some(1.0) && web_mercator::is_named_so(name) {
        return from_epsg(3857).unwrap_or_else(|_| Crs::new(None, name, METERS, CrsDefinition::Described));
    }
    let kind = match meters_per_unit {
        _ if geographic => CrsKind::Geographic,
        Some(meters) if SENSIBLE_UNITS_M.contains(&meters) => CrsKind::Projected { meters_per_unit: meters },
        _ => CrsKind::Other,
    };
    let name = if name.trim().is_empty() { "unnamed" } else { name.trim() };
    Crs::new(None, name, kind, CrsDefinition::Described)
}

/// Returns `true` when two definitions certainly mean different systems: different EPSG codes or,
/// where one has none, different kinds, such as degrees and meters. Two writers of one system need
/// not both know its code.
pub(crate) fn contradicts(one: &Crs, other: &Crs) -> bool {
    match (one.epsg(), other.epsg()) {
        (Some(one), Some(other)) => one != other,
        _ => discriminant(&one.kind()) != discriminant(&other.kind()),
    }
}

/// Returns `true` when the authority of a system puts the latitude or the northing first.
pub(crate) fn is_north_first(crs: &Crs) -> bool {
    crs.epsg().and_then(proj_core::lookup_authority_axis_order) == Some(AxisOrder::NorthEast)
}

/// Returns `true` when a position may lie in a system: it has a place on Earth that is brought back
/// to it.
pub(crate) fn is_in_domain(crs: &Crs, place: (f64, f64)) -> bool {
    /// Largest distance of a position that is brought back \[CRS units\].
    const CLOSE: f64 = 1.0;
    let there_and_back = || -> Result<((f64, f64), (f64, f64))> {
        let wgs84 = from_epsg(4326)?;
        let lonlat = Transformation::new(crs, &wgs84, place)?.apply(place)?;
        Ok((lonlat, Transformation::new(&wgs84, crs, lonlat)?.apply(lonlat)?))
    };
    there_and_back()
        .is_ok_and(|((_, lat), back)| lat.abs() < 89.0 && (back.0 - place.0).hypot(back.1 - place.1) < CLOSE)
}

/// Returns the definition as WKT 1 in the dialect of GDAL, for `.prj` files and the like; `None` if
/// it cannot be written. A definition that was read from WKT is returned as it is.
pub fn wkt_of(crs: &Crs) -> Option<String> {
    match crs.definition() {
        CrsDefinition::Wkt(text) => Some(text.clone()),
        CrsDefinition::Described => None,
        CrsDefinition::Registry | CrsDefinition::Proj(_) => wkt::for_gdal(&horizontal(crs)?),
    }
}

/// Returns the definition that the projections work with, in x, y order.
fn horizontal(crs: &Crs) -> Option<CrsDef> {
    match crs.definition() {
        CrsDefinition::Registry => registry_entry(crs.epsg()?),
        CrsDefinition::Wkt(text) => proj_wkt::parse_crs(&wkt::for_proj_wkt(text)).ok().and_then(east_north),
        CrsDefinition::Proj(text) => proj_wkt::parse_crs(text).ok().and_then(east_north),
        CrsDefinition::Described => None,
    }
}

/// Prepared transformation from one [`Crs`] to another, for many points of one place.
#[derive(Clone)]
pub struct Transformation {
    operation: Option<Transform>,
    /// Longitude of the data if results are in degrees, which are at most half a turn away from it.
    lon_of_data: Option<f64>,
    labels: (String, String),
}

impl fmt::Debug for Transformation {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let operation = self.operation.as_ref().map_or("none", |transform| &transform.selected_operation().name);
        write!(f, "Transformation({} to {} by {operation})", self.labels.0, self.labels.1)
    }
}

impl Transformation {
    /// Prepares the transformation from `from` to `to` for data around the point `near`, in
    /// coordinates of `from`.
    ///
    /// Different regions tie datums together by different operations; `near` decides between them.
    /// Operations that need a grid file are not available.
    ///
    /// # Errors
    /// E310 if one of the two is only described, if the registry has no way from one to the other,
    /// or if `near` is outside the domain of the projections.
    pub fn new(from: &Crs, to: &Crs, near: (f64, f64)) -> Result<Transformation> {
        let labels = (from.label(), to.label());
        if from == to {
            return Ok(Transformation { operation: None, lon_of_data: None, labels });
        }
        let refuse = |why: &str| no_way(format!("coordinates near `{near:?}`"), &labels, why);
        // Areas of operations end at 180 degrees.
        let is_beyond = matches!(from.kind(), CrsKind::Geographic) && near.0.abs() > 180.0;
        let near = if is_beyond { ((near.0 + 180.0).rem_euclid(360.0) - 180.0, near.1) } else { near };
        let defined = |crs: &Crs| {
            horizontal(crs).ok_or_else(|| refuse(&format!("the projection of `{}` is not known", crs.label())))
        };
        let gives_degrees = matches!(to.kind(), CrsKind::Geographic);
        let (from, to) = (defined(from)?, defined(to)?);
        let tied = || operation_near(&null_datums::tied(&from), &null_datums::tied(&to), near);
        let operation = match null_datums::are_tied(&from, &to) {
            true => tied(),
            false => operation_near(&from, &to, near).or_else(|error| tied().map_err(|_| error)),
        };
        let operation = operation.map_err(|cause| refuse(&cause.to_string()))?;
        let lon_of_data = operation.convert(near).ok().map(|(lon, _)| lon).filter(|_| gives_degrees);
        Ok(Transformation { operation: Some(operation), lon_of_data, labels })
    }

    /// Transforms one point: x, y in, x, y out \[CRS units; degrees if geographic\]. Longitudes
    /// continue past 180 degrees where the data do.
    ///
    /// # Errors
    /// E310 if the point is not finite or lies outside the domain of the projections.
    pub fn apply(&self, (x, y): (f64, f64)) -> Result<(f64, f64)> {
        let refuse = |why: &str| no_way(format!("`{x} {y}`"), &self.labels, why);
        if !(x.is_finite() && y.is_finite()) {
            return Err(refuse("coordinates must be finite"));
        }
        let Some(operation) = &self.operation else { return Ok((x, y)) };
        let (x, y) = operation.convert((x, y)).map_err(|cause| refuse(&cause.to_string()))?;
        let x = match self.lon_of_data {
            Some(lon) if (x - lon).abs() > 180.0 => x + 360.0_f64.copysign(lon - x),
            _ => x,
        };
        if x.is_finite() && y.is_finite() { Ok((x, y)) } else { Err(refuse("the result is not finite")) }
    }
}

/// Returns the registry's best operation around a point that is neither withdrawn nor in need of a
/// grid file. A withdrawn first choice is returned if no other can be built.
///
/// `proj-core` ranks some withdrawn operations first: EPSG 1508 (CH1903 to WGS 84) is wrong by 100
/// km.
fn operation_near(from: &CrsDef, to: &CrsDef, near: (f64, f64)) -> proj_core::Result<Transform> {
    let area = AreaOfInterest::source_crs_point(near.into());
    let options = SelectionOptions::new().with_area_of_interest(area).with_wgs84_pivot();
    let first = Transform::from_crs_defs_with_selection_options(from, to, options.clone())?;
    if !first.selected_operation().deprecated {
        return Ok(first);
    }
    let others = operation_candidates_between_with_selection_options(from, to, &options)?;
    let valid = others.iter().filter(|other| !other.deprecated && !other.uses_grids).filter_map(|other| other.id);
    let built = |id| Transform::from_crs_defs_with_selection_options(from, to, options.clone().with_operation(id)).ok();
    Ok(valid.filter_map(built).next().unwrap_or(first))
}

/// Returns `true` when the projection of a system is known, so that it can be transformed.
pub(crate) fn is_projection_known(crs: &Crs) -> bool {
    horizontal(crs).is_some()
}

/// Transforms one point from one system to another; for many points prepare a [`Transformation`].
///
/// # Errors
/// E310 as for [`Transformation`].
pub fn transform(from: &Crs, to: &Crs, xy: (f64, f64)) -> Result<(f64, f64)> {
    Transformation::new(from, to, xy)?.apply(xy)
}

/// Kind of projected systems in meters.
const METERS: CrsKind = CrsKind::Projected { meters_per_unit: 1.0 };

/// Accepted lengths of a unit of coordinates \[m\].
const SENSIBLE_UNITS_M: std::ops::RangeInclusive<f64> = 1e-3..=1e5;

/// Refuses a unit outside [`SENSIBLE_UNITS_M`].
fn checked_unit(kind: CrsKind, text: &str) -> Result<CrsKind> {
    match kind {
        CrsKind::Projected { meters_per_unit } if !SENSIBLE_UNITS_M.contains(&meters_per_unit) => {
            Err(unreadable(text, &format!("its unit is {meters_per_unit:e} m, wanted 0.001 to 100000 m")))
        }
        kind => Ok(kind),
    }
}

fn unreadable(text: &str, why: &str) -> Error {
    let shown: String = text.chars().take(80).collect();
    CrsError::Unreadable(shown, why.to_string()).into()
}

fn no_way(what: String, (from, to): &(String, String), why: &str) -> Error {
    CrsError::NoWay { what, from: from.clone(), to: to.clone(), why: why.to_string() }.into()
}

fn kind_of(horizontal: &CrsDef) -> CrsKind {
    match horizontal {
        CrsDef::Geographic(_) => CrsKind::Geographic,
        CrsDef::Projected(projected) => CrsKind::Projected { meters_per_unit: projected.linear_unit_to_meter() },
        CrsDef::Geocentric(_) | CrsDef::Compound(_) => CrsKind::Other,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: (f64, f64), b: (f64, f64), tolerance: f64) -> bool {
        (a.0 - b.0).abs() <= tolerance && (a.1 - b.1).abs() <= tolerance
    }

    #[test]
    fn notations_of_one_system_are_equal() {
        let wanted = from_epsg(25832).unwrap();
        assert_eq!((wanted.label().as_str(), wanted.name().as_str()), ("EPSG:25832", "ETRS89 / UTM zone 32N"));
        assert_eq!(wanted.kind(), CrsKind::Projected { meters_per_unit: 1.0 });
        for text in [
            "EPSG:25832",
            " epsg:25832\n",
            "25832",
            "urn:ogc:def:crs:EPSG::25832",
            "http://www.opengis.net/def/crs/EPSG/0/25832",
            "EPSG:25832+5783",
            "EPSG:5555",
            "+init=epsg:25832",
        ] {
            assert_eq!(parse(text).unwrap(), wanted, "{text}");
        }
        assert_eq!(parse("urn:ogc:def:crs:OGC:1.3:CRS84").unwrap().epsg(), Some(4326));
        assert_eq!(parse("urn:ogc:def:crs:EPSG::4326").unwrap(), from_epsg(4326).unwrap());
        assert_eq!(parse("+proj=utm +zone=33 +datum=WGS84").unwrap().epsg(), Some(32633));
        assert!(is_web_mercator(&parse("EPSG:900913").unwrap()) && !is_web_mercator(&wanted));
    }

    #[test]
    fn esri_names_are_recognized() {
        let prj = |name: &str, base: &str, ellipsoid: &str, projection: &str| {
            format!(
                r#"PROJCS["{name}",GEOGCS["{base}",DATUM["D_X",SPHEROID["X",{ellipsoid}]],PRIMEM["Greenwich",0.0],UNIT["Degree",0.0174532925199433]],{projection},UNIT["Meter",1.0]]"#
            )
        };
        let utm = r#"PROJECTION["Transverse_Mercator"],PARAMETER["False_Easting",500000.0],PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",9.0],PARAMETER["Scale_Factor",0.9996],PARAMETER["Latitude_Of_Origin",0.0]"#;
        let grs = "6378137.0,298.257222101";
        let etrs = prj("ETRS_1989_UTM_Zone_32N", "GCS_ETRS_1989", grs, utm);
        assert_eq!(parse(&etrs).unwrap().epsg(), Some(25832));
        let wgs = prj("WGS_1984_UTM_Zone_32N", "GCS_WGS_1984", "6378137.0,298.257223563", utm);
        assert_eq!(parse(&wgs).unwrap().epsg(), Some(32632));
        let gauss =
            utm.replace("Transverse_Mercator", "Gauss_Kruger").replace("500000", "3500000").replace("0.9996", "1.0");
        let dhdn =
            prj("DHDN_3_Degree_Gauss_Zone_3", "GCS_Deutsches_Hauptdreiecksnetz", "6377397.155,299.1528128", &gauss);
        assert_eq!(parse(&dhdn).unwrap().epsg(), Some(31467));
        let feet = r#"PROJECTION["Lambert_Conformal_Conic"],PARAMETER["False_Easting",984250.0],PARAMETER["False_Northing",0.0],PARAMETER["Central_Meridian",-74.0],PARAMETER["Standard_Parallel_1",40.66666666666666],PARAMETER["Standard_Parallel_2",41.03333333333333],PARAMETER["Latitude_Of_Origin",40.16666666666666]"#;
        let name = "NAD_1983_StatePlane_New_York_Long_Island_FIPS_3104_Feet";
        let state_plane = prj(name, "GCS_North_American_1983", grs, feet)
            .replace(r#"UNIT["Meter",1.0]"#, r#"UNIT["Foot_US",0.3048006096012192]"#);
        assert_eq!(parse(&state_plane).unwrap().epsg(), Some(2263));
        let unknown = prj("My city", "GCS_ETRS_1989", grs, &utm.replace("9.0", "8.5"));
        let unknown = parse(&unknown).unwrap();
        assert_eq!((unknown.epsg(), unknown.label().as_str()), (None, "My city"));
        assert_eq!(unknown.kind(), CrsKind::Projected { meters_per_unit: 1.0 });
    }

    #[test]
    fn an_unsupported_projection_keeps_its_unit() {
        let text = r#"PROJCS["odd",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Bonne"],PARAMETER["standard_parallel_1",60],UNIT["foot",0.3048]]"#;
        let crs = parse(text).unwrap();
        assert_eq!(crs.kind(), CrsKind::Projected { meters_per_unit: 0.3048 });
        assert_eq!(wkt_of(&crs).as_deref(), Some(text));
        assert!(transform(&crs, &from_epsg(4326).unwrap(), (0.0, 0.0)).is_err());
    }

    type Pair = (f64, f64);

    /// EPSG code, point in degrees, and the result of PROJ 9.5.1 without grids
    /// (`pyproj.Transformer.from_crs(4326, code, always_xy=True)`).
    const PROJ_VALUES: [(u32, Pair, Pair); 17] = [
        (25832, (9.18, 48.78), (513223.5394, 5403015.5180)),
        (32632, (9.18, 48.78), (513223.5394, 5403015.5182)),
        (25830, (-3.7, 40.4), (440598.0789, 4472390.0310)),
        (2154, (2.35, 48.86), (652310.7180, 6862414.6368)),
        (28992, (4.9, 52.37), (121819.3652, 487013.7615)),
        (3857, (9.18, 48.78), (1021912.9255, 6237614.1076)),
        (27700, (-0.13, 51.5), (529897.1019, 179553.2861)),
        (2056, (8.54, 47.37), (2683186.2856, 1247156.7441)),
        (3035, (9.18, 48.78), (4260716.6254, 2852189.9267)),
        (31370, (4.35, 50.85), (148679.4474, 171066.8103)),
        (5514, (14.42, 50.09), (-742860.0835, -1042721.3635)),
        (31467, (9.18, 48.78), (3513304.5125, 5404737.5973)),
        (21781, (8.54, 47.37), (683186.2856, 247156.7441)),
        (2263, (-73.97, 40.78), (992558.4427, 223453.2998)),
        (6677, (139.75, 35.68), (-7543.1243, -35499.1822)),
        (28355, (144.96, -37.81), (320422.8203, 5813305.2226)),
        (2193, (174.76, -36.85), (1756911.9449, 5920321.8182)),
    ];

    #[test]
    fn values_agree_with_proj() {
        let wgs84 = from_epsg(4326).unwrap();
        for (code, lonlat, wanted) in PROJ_VALUES {
            let crs = from_epsg(code).unwrap();
            let found = transform(&wgs84, &crs, lonlat).unwrap();
            // Where the registry has several datum operations of the same accuracy, PROJ may take
            // another one.
            let tolerance = match code {
                21781 => 2.0,
                31370 | 5514 => 0.1,
                _ => 1e-3,
            };
            assert!(close(found, wanted, tolerance), "EPSG:{code}: {found:?}, wanted {wanted:?}");
            let back = transform(&crs, &wgs84, found).unwrap();
            assert!(close(back, lonlat, 2e-8), "EPSG:{code}: {back:?}, wanted {lonlat:?}");
        }
    }

    #[test]
    fn a_withdrawn_datum_operation_is_not_used() {
        // The default of proj-core for this pair, EPSG operation 1508, is wrong by 100 km.
        let (wgs84, lv03) = (from_epsg(4326).unwrap(), from_epsg(21781).unwrap());
        let bern = transform(&wgs84, &lv03, (7.438637, 46.951082)).unwrap();
        assert!(close(bern, (600_000.0, 200_000.0), 3.0), "{bern:?}");
    }

    #[test]
    fn wkt_carries_the_code_and_is_read_back() {
        for code in [25832, 32632, 25830, 2154, 28992, 3857, 4326, 27700, 2056, 3035, 31370, 5514, 31467, 2263] {
            let crs = from_epsg(code).unwrap();
            let wkt = wkt_of(&crs).unwrap();
            assert!(wkt.ends_with(&format!(r#"AUTHORITY["EPSG","{code}"]]"#)), "{wkt}");
            assert!(!wkt.contains("EPSG datum"), "{wkt}");
            assert_eq!(parse(&wkt).unwrap(), crs);
        }
        // Longitude from Paris: better none than a wrong one.
        assert_eq!(from_epsg(27572).ok().and_then(|crs| wkt_of(&crs)), None);
    }

    #[test]
    fn a_described_system_cannot_be_transformed() {
        let crs = from_geokeys_citation("City grid", Some(0.3048), false);
        assert_eq!(crs.label(), "City grid");
        assert_eq!(crs.kind(), CrsKind::Projected { meters_per_unit: 0.3048 });
        assert_eq!(wkt_of(&crs), None);
        assert!(transform(&crs, &from_epsg(25832).unwrap(), (0.0, 0.0)).is_err());
        assert_eq!(transform(&crs, &crs.clone(), (1.0, 2.0)).unwrap(), (1.0, 2.0));
    }
}
