//! Coordinates in degrees: which zone of UTM they belong to, and the refusal that says how to get there.

use std::path::Path;

use crate::error::Error;
use crate::raster::Crs;

/// EPSG code of the WGS 84 / UTM zone of a place \[deg\], with the wider zones of south-west Norway and Svalbard.
///
/// # References
/// NGA.STND.0037 (2014), Universal Grids and Grid Reference Systems: zones 31V, 32V and 31X to 37X.
pub fn utm_for(lon: f64, lat: f64) -> u32 {
    let lon = (lon + 180.0).rem_euclid(360.0) - 180.0;
    let regular = || (1_u32..60).find(|&zone| lon < f64::from(zone) * 6.0 - 180.0).unwrap_or(60);
    let zone = match (lon, lat) {
        (3.0..12.0, 56.0..64.0) => 32,
        (0.0..9.0, 72.0..=84.0) => 31,
        (9.0..21.0, 72.0..=84.0) => 33,
        (21.0..33.0, 72.0..=84.0) => 35,
        (33.0..42.0, 72.0..=84.0) => 37,
        _ => regular(),
    };
    zone + if lat < 0.0 { 32_700 } else { 32_600 }
}

/// Which kind of file is to be brought into another reference system.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InputKind {
    /// A raster: `gdalwarp`.
    Raster,
    /// Vectors: `ogr2ogr`.
    Vector,
}

/// The refusal of coordinates in degrees, with the command that fixes the file at `path`.
///
/// `center` is the longitude and latitude of the middle of the data \[deg\].
pub fn degrees_refusal(path: &str, crs: &Crs, kind: InputKind, center: (f64, f64)) -> Error {
    let text = format!("`{path}` is in degrees ({}); wanted a projected coordinate system in meters", crs.label());
    let on_earth = (-180.0..=360.0).contains(&center.0) && (-90.0..=90.0).contains(&center.1);
    let hint = if on_earth {
        let epsg = utm_for(center.0, center.1);
        let stem = Path::new(path).with_extension("").display().to_string();
        match kind {
            InputKind::Raster => {
                let output = format!("{stem}_{epsg}.tif");
                let (path, output) = (shell_word(path), shell_word(&output));
                format!("`--project auto`, or gdalwarp -t_srs EPSG:{epsg} -r near {path} {output}")
            }
            InputKind::Vector => {
                let output = format!("{stem}_{epsg}.geojson");
                format!("`--project auto`, or ogr2ogr -t_srs EPSG:{epsg} {} {}", shell_word(&output), shell_word(path))
            }
        }
    } else {
        let (lon, lat) = center;
        format!("its middle, longitude {lon} and latitude {lat}, is not on Earth: is the coordinate system right?")
    };
    Error::file(310, text).with_hint(hint)
}

/// A word that a POSIX shell reads back as `text`.
fn shell_word(text: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "/._-+:@%,=".contains(c);
    if !text.is_empty() && text.chars().all(plain) {
        text.to_string()
    } else {
        format!("'{}'", text.replace('\'', r"'\''"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn utm_zones_follow_the_exceptions() {
        assert_eq!(utm_for(9.18, 48.78), 32632);
        assert_eq!(utm_for(-43.2, -22.9), 32723);
        assert_eq!(utm_for(5.32, 60.39), 32632); // Bergen: zone 31 by longitude
        assert_eq!(utm_for(15.63, 78.22), 32633); // Longyearbyen
        assert_eq!(utm_for(180.0, 10.0), 32601);
        assert_eq!(utm_for(-180.0, 10.0), 32601);
        assert_eq!(utm_for(179.999, 0.0), 32660);
        assert_eq!(utm_for(6.0, 48.0), 32632);
    }

    #[test]
    fn degrees_are_refused_with_the_command_that_helps() {
        let crs = super::super::from_epsg(4326).unwrap();
        let error = degrees_refusal("maps/old town.tif", &crs, InputKind::Raster, (9.18, 48.78));
        assert_eq!(error.code(), "E310");
        assert_eq!(
            error.to_string(),
            "`maps/old town.tif` is in degrees (EPSG:4326); wanted a projected coordinate system in meters"
        );
        assert_eq!(
            error.hint(),
            Some(
                "`--project auto`, or gdalwarp -t_srs EPSG:32632 -r near 'maps/old town.tif' 'maps/old town_32632.tif'"
            )
        );
        let error = degrees_refusal("b.shp", &crs, InputKind::Vector, (-70.0, -33.0));
        assert_eq!(error.hint(), Some("`--project auto`, or ogr2ogr -t_srs EPSG:32719 b_32719.geojson b.shp"));
    }
}
