//! Place of a TIFF: tie point and cell size, or a matrix, or a world file; and the coordinate
//! reference system in its GeoKeys.
//!
//! Reference: OGC 19-008r4 (GeoTIFF 1.1), sections 7.4 and B.6; a negative cell height in the pixel
//! scale is read as GDAL reads it.

use std::io::Read;

use super::sidecar::Sidecar;
use super::tags::{Directory, TiffSource, tag};
use crate::crs;
use crate::crs::VerticalCrs;
use crate::error::{Cause, Error, OddRaster, Oddity, ReadFault, Result};
use crate::formats::with_true_lengths;
use crate::input::Input;
use crate::raster::{Crs, GeoRef};

/// Meters in a foot and in a US survey foot.
const FOOT: f64 = 0.3048;
const US_FOOT: f64 = 1200.0 / 3937.0;
/// Value of a key for a system that other keys define.
const USER_DEFINED: u16 = 32767;
/// Value of the key of the raster type for tie points in the middle of cells.
const PIXEL_IS_POINT: u16 = 2;
/// Largest shift across the whole raster that still counts as north-up \[cells\].
const MAX_SHEAR_CELLS: f64 = 1e-3;

/// Place of a raster, and the direction of its rows.
#[derive(Debug, Clone)]
pub(super) struct Placement {
    pub(super) georef: GeoRef,
    /// `true` if the first row of the file is the southernmost.
    pub(super) south_up: bool,
    /// Meters per unit of height, where the CRS defines it.
    pub(super) meters_per_height_unit: Option<f64>,
    /// Vertical system, where the file names it.
    pub(super) vertical: Option<VerticalCrs>,
}

/// Affine map from (column, row) of a file to the plane: `x = a·col + b·row + c`, `y = d·col +
/// e·row + f`.
#[derive(Debug, Clone, Copy)]
struct Affine {
    a: f64,
    b: f64,
    c: f64,
    d: f64,
    e: f64,
    f: f64,
}

/// Reads the place of a raster of `n_rows` rows of `n_cols` cells; the sidecar takes precedence
/// over the tags.
pub(super) fn read_placement(
    (source, directory): (&mut TiffSource, &Directory),
    sidecar: &Sidecar,
    (n_rows, n_cols): (usize, usize),
    odd: &mut Vec<Oddity>,
) -> Result<Placement> {
    let name = source.input().clone();
    let mut tell = |what| odd.push(Oddity::new(&name, what));
    let keys = GeoKeys::read(source, directory).unwrap_or_else(|error| {
        tell(OddRaster::DamagedKeys(error.to_string()));
        GeoKeys::default()
    });
    let affine = match sidecar.geo_transform {
        Some([c, a, b, f, d, e]) => Some(Affine { a, b, c, d, e, f }),
        None if sidecar.n_control_points > 0 => {
            return Err(by_control_points(source.input(), sidecar.n_control_points));
        }
        None => affine_of_tags((source, directory), &keys, &mut tell)?,
    };
    let affine = affine.or_else(|| world_file(source.input())).unwrap_or_else(|| {
        tell(OddRaster::NoPlace);
        Affine { a: 1.0, b: 0.0, c: 0.0, d: 0.0, e: -1.0, f: n_rows as f64 }
    });
    let Affine { a, b, c, d, e, f } = affine;
    let irregular = || {
        let text =
            format!("cells of {a} x {e} at {c}, {f}, wanted finite numbers and cells that do not vanish beside them");
        Error::read(source.input(), ReadFault::Irregular(text)).because(Cause::NoPlace)
    };
    if ![a, b, c, d, e, f].iter().all(|number| number.is_finite()) {
        return Err(irregular());
    }
    let (shear_x, shear_y) = (b * n_rows as f64, d * n_cols as f64);
    if shear_x.abs() > MAX_SHEAR_CELLS * a.abs() || shear_y.abs() > MAX_SHEAR_CELLS * e.abs() {
        let angle = d.atan2(a).to_degrees();
        let what = format!("its rows run {angle:.1} degrees off east, wanted a north-up raster");
        return Err(Error::read(source.input(), ReadFault::Rotated(what)));
    }
    if a < 0.0 {
        let what = "its columns run from east to west, wanted a north-up raster".into();
        return Err(Error::read(source.input(), ReadFault::Rotated(what)));
    }
    let south_up = e > 0.0;
    if south_up {
        tell(OddRaster::SouthUp);
    }
    let y_max = if south_up { f + e * n_rows as f64 } else { f };
    let crs = match &sidecar.crs {
        None => crs(&keys, &mut tell),
        Some(text) => crs::parse(text).map_err(|error| tell(OddRaster::CrsIgnored(error.to_string()))).ok(),
    };
    let georef = GeoRef::new((c, y_max), (a, e.abs()), (n_rows, n_cols), crs).ok_or_else(irregular)?;
    let georef = with_true_lengths(georef, &mut tell);
    let (vertical, meters_per_height_unit) = match &sidecar.crs {
        None => (vertical(&keys), keys.meters_per_height_unit()),
        Some(text) => {
            let vertical = VerticalCrs::in_text(text);
            (vertical.clone(), vertical.and_then(|vertical| vertical.meters_per_unit()))
        }
    };
    Ok(Placement { georef, south_up, meters_per_height_unit, vertical })
}

/// Returns the affine map from the tags of the file, for cells as areas.
fn affine_of_tags(
    (source, directory): (&mut TiffSource, &Directory),
    keys: &GeoKeys,
    tell: &mut impl FnMut(OddRaster),
) -> Result<Option<Affine>> {
    let mut affine = affine(source, directory, tell)?;
    if let (Some(affine), Some(PIXEL_IS_POINT)) = (&mut affine, keys.short(1025)) {
        // The tie point marks the center of a cell.
        affine.c -= 0.5 * (affine.a + affine.b);
        affine.f -= 0.5 * (affine.d + affine.e);
    }
    Ok(affine)
}

/// Returns the error of a raster that ground control points place.
fn by_control_points(input: &Input, n: usize) -> Error {
    let text = format!("it is placed by {n} ground control points, wanted a regular grid");
    Error::read(input, ReadFault::Irregular(text)).because(Cause::ControlPoints)
}

/// Reads the affine map from the tags of the file.
fn affine(source: &mut TiffSource, directory: &Directory, tell: &mut impl FnMut(OddRaster)) -> Result<Option<Affine>> {
    let scale = directory.floats(source, tag::MODEL_PIXEL_SCALE)?;
    let tie_points = directory.floats(source, tag::MODEL_TIE_POINT)?;
    let matrix = directory.floats(source, tag::MODEL_TRANSFORMATION)?;
    match (scale.as_deref(), tie_points.as_deref(), matrix.as_deref()) {
        (Some([width, height, ..]), Some([col, row, _, x, y, _, ..]), _) => {
            if *height < 0.0 {
                tell(OddRaster::NegativeHeight);
            }
            let height = height.abs();
            Ok(Some(Affine { a: *width, b: 0.0, c: x - col * width, d: 0.0, e: -height, f: y + row * height }))
        }
        (_, _, Some([a, b, _, c, d, e, _, f, ..])) => Ok(Some(Affine { a: *a, b: *b, c: *c, d: *d, e: *e, f: *f })),
        (None, None, None) => Ok(None),
        // Fewer points leave the directions of columns and rows open.
        (None, Some(points), None) if points.len() >= 3 * 6 => Err(by_control_points(source.input(), points.len() / 6)),
        _ => {
            let what = "the tags of its place are incomplete, wanted a tie point and a cell size".into();
            Err(Error::read(source.input(), ReadFault::Irregular(what)).because(Cause::NoPlace))
        }
    }
}

/// Reads the world file beside a raster without a place of its own: six numbers, the last two the
/// center of the first cell.
fn world_file(input: &Input) -> Option<Affine> {
    ["tfw", "tifw", "wld"].iter().find_map(|extension| {
        let (file, _) = input.beside(extension)?.open().ok()?;
        let mut text = String::new();
        file.take(4096).read_to_string(&mut text).ok()?;
        let numbers: Vec<f64> = text.split_whitespace().map(str::parse).collect::<std::result::Result<_, _>>().ok()?;
        let [a, d, b, e, x, y] = *numbers.as_slice() else { return None };
        Some(Affine { a, b, c: x - 0.5 * (a + b), d, e, f: y - 0.5 * (d + e) })
    })
}

/// Returns the coordinate reference system that the keys name, with warnings where it is missing or
/// unreliable.
fn crs(keys: &GeoKeys, tell: &mut impl FnMut(OddRaster)) -> Option<Crs> {
    let (code_key, citation_key, geographic) = match (keys.short(1024), keys.short(3072), keys.short(2048)) {
        (Some(2), _, _) | (None, None, Some(_)) => (2048, 2049, true),
        (Some(1), _, _) | (None, Some(_), _) => (3072, 3073, false),
        (None, None, None) => {
            tell(OddRaster::NoCrs);
            return None;
        }
        (Some(model), _, _) => {
            tell(OddRaster::ModelType(model));
            return None;
        }
    };
    let meters_per_unit = if geographic { None } else { keys.meters_per_unit(3076, 3077) };
    let citation = keys.text(citation_key).or_else(|| keys.text(1026)).unwrap_or_default();
    let named = |name: &str| Some(crs::from_geokeys_citation(name, meters_per_unit, geographic));
    match keys.short(code_key) {
        Some(code) if code != USER_DEFINED && code != 0 => match crs::from_epsg(u32::from(code)) {
            Ok(crs) => Some(crs),
            Err(error) => {
                tell(OddRaster::CrsByName(error.to_string()));
                named(&format!("EPSG:{code}"))
            }
        },
        // Esri writes the whole definition into the citation.
        _ => match citation.split_once("ESRI PE String = ").map(|(_, wkt)| crs::parse(wkt)) {
            Some(Ok(crs)) => Some(crs),
            _ if citation.is_empty() => named("user-defined"),
            _ => named(&citation),
        },
    }
}

/// Returns the vertical system that the keys name.
fn vertical(keys: &GeoKeys) -> Option<VerticalCrs> {
    let citation = keys.text(4097);
    match keys.short(4096) {
        Some(code) if code != USER_DEFINED && code != 0 => {
            Some(VerticalCrs::from_epsg(u32::from(code), citation.as_deref()))
        }
        _ => citation.map(|name| VerticalCrs::named(&name)),
    }
}

/// Reference systems that GeoKeys name.
#[cfg(feature = "point-clouds")]
#[derive(Debug, Clone, Default)]
pub(crate) struct GeoKeySystems {
    /// Horizontal system.
    pub(crate) crs: Option<Crs>,
    /// Vertical system.
    pub(crate) vertical: Option<VerticalCrs>,
    /// Length of the unit of heights \[m\].
    pub(crate) meters_per_height_unit: Option<f64>,
}

/// Returns the systems in the three tables of GeoKeys outside of a TIFF: keys, doubles, texts.
#[cfg(feature = "point-clouds")]
pub(crate) fn systems_of_geo_keys(
    (table, doubles, texts): (&[u16], &[f64], &[u8]),
    tell: &mut impl FnMut(OddRaster),
) -> GeoKeySystems {
    let Some(keys) = GeoKeys::parse(table, doubles, texts) else {
        tell(OddRaster::DamagedKeys("a key points outside the GeoKey tables".into()));
        return GeoKeySystems::default();
    };
    let meters_per_height_unit = keys.meters_per_height_unit();
    GeoKeySystems { crs: crs(&keys, tell), vertical: vertical(&keys), meters_per_height_unit }
}

/// GeoKey directory: numbers and texts by key.
#[derive(Debug, Default)]
struct GeoKeys {
    keys: Vec<(u16, GeoValue)>,
}

#[derive(Debug)]
enum GeoValue {
    Short(u16),
    Double(f64),
    Text(String),
}

impl GeoKeys {
    fn read(source: &mut TiffSource, directory: &Directory) -> Result<GeoKeys> {
        let Some(table) = directory.integers(source, tag::GEO_KEY_DIRECTORY)? else { return Ok(GeoKeys::default()) };
        let table: Vec<u16> = table.iter().map(|v| u16::try_from(*v).unwrap_or(u16::MAX)).collect();
        let doubles = directory.floats(source, tag::GEO_DOUBLE_PARAMS)?.unwrap_or_default();
        let texts = directory.text(source, tag::GEO_ASCII_PARAMS)?.unwrap_or_default();
        GeoKeys::parse(&table, &doubles, texts.as_bytes())
            .ok_or_else(|| source.malformed("a key points outside the GeoKey tables"))
    }

    /// Parses the tables; `None` if the directory is not of version 1 or points outside them.
    fn parse(table: &[u16], doubles: &[f64], texts: &[u8]) -> Option<GeoKeys> {
        let [1, _, _, n_keys, rest @ ..] = table else { return None };
        let mut keys = Vec::new();
        for key in rest.chunks_exact(4).take(usize::from(*n_keys)) {
            let (at, count) = (usize::from(key[3]), usize::from(key[2]));
            let value = match key[1] {
                0 => GeoValue::Short(key[3]),
                tag::GEO_DOUBLE_PARAMS => GeoValue::Double(*doubles.get(at)?),
                tag::GEO_ASCII_PARAMS => {
                    // Writers disagree on whether the final separator belongs to the text, and to
                    // the tag.
                    let text = texts.get(at..(at + count).min(texts.len()))?;
                    GeoValue::Text(String::from_utf8_lossy(text).trim_end_matches(['|', '\0']).trim().to_owned())
                }
                _ => continue,
            };
            keys.push((key[0], value));
        }
        Some(GeoKeys { keys })
    }

    fn get(&self, key: u16) -> Option<&GeoValue> {
        self.keys.iter().find(|(k, _)| *k == key).map(|(_, value)| value)
    }

    fn short(&self, key: u16) -> Option<u16> {
        match self.get(key)? {
            GeoValue::Short(value) => Some(*value),
            _ => None,
        }
    }

    fn text(&self, key: u16) -> Option<String> {
        match self.get(key)? {
            GeoValue::Text(text) if !text.is_empty() => Some(text.clone()),
            _ => None,
        }
    }

    /// Returns the meters per unit of height. The unit of a registered system belongs to it, and is
    /// often not repeated.
    fn meters_per_height_unit(&self) -> Option<f64> {
        let of_system = || vertical(self)?.meters_per_unit();
        self.meters_per_unit(4099, 4098).or_else(of_system)
    }

    /// Returns the meters per linear unit from an EPSG unit code, or from the key with the size of
    /// a user-defined one.
    fn meters_per_unit(&self, unit_key: u16, size_key: u16) -> Option<f64> {
        match self.short(unit_key)? {
            9001 => Some(1.0),
            9002 => Some(FOOT),
            9003 => Some(US_FOOT),
            9036 => Some(1000.0),
            USER_DEFINED => match self.get(size_key)? {
                GeoValue::Double(size) if size.is_finite() && *size > 0.0 => Some(*size),
                _ => None,
            },
            _ => None,
        }
    }
}

/// Returns the meters per unit of height from the name that GDAL stores for a band.
pub(in crate::formats) fn meters_per_named_unit(name: &str) -> Option<f64> {
    match name.trim().to_ascii_lowercase().as_str() {
        "m" | "metre" | "meter" | "metres" | "meters" => Some(1.0),
        "ft" | "foot" | "feet" | "international foot" => Some(FOOT),
        "ftus" | "us survey foot" | "us-ft" | "us_survey_foot" | "foot_us" | "sfoot" => Some(US_FOOT),
        "cm" | "centimeter" | "centimetre" => Some(0.01),
        "dm" | "decimeter" | "decimetre" => Some(0.1),
        "mm" | "millimeter" | "millimetre" => Some(0.001),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn geo_keys_give_numbers_texts_and_units() {
        let table = [1, 1, 0, 4, 1024, 0, 1, 1, 3073, 34737, 5, 0, 3076, 0, 1, 32767, 3077, 34736, 1, 1];
        let keys = GeoKeys::parse(&table, &[7.0, 0.3], b"abcd|").expect("a valid table");
        assert_eq!(keys.short(1024), Some(1));
        assert_eq!(keys.text(3073).as_deref(), Some("abcd"));
        assert_eq!(keys.meters_per_unit(3076, 3077), Some(0.3));
        assert_eq!(keys.short(2048), None);
    }

    #[test]
    fn geo_keys_that_point_outside_their_tables_are_refused() {
        assert!(GeoKeys::parse(&[1, 1, 0, 1, 3077, 34736, 1, 1], &[0.3], b"").is_none());
        assert!(GeoKeys::parse(&[1, 1, 0, 1, 3073, 34737, 2, 9], &[], b"abc").is_none());
        assert!(GeoKeys::parse(&[7, 1, 0, 0], &[], b"").is_none());
        assert!(GeoKeys::parse(&[], &[], b"").is_none());
    }
}
