//! Web Mercator: the projection of map tiles, whose lengths are true at the equator only.
//!
//! Elsewhere a unit is about cos φ meters on the ground. Over a city that factor hardly changes, so
//! the factor of the middle serves for all lengths.

use proj_core::ProjectionMethod;

use super::{Transformation, from_epsg, horizontal, utm_for};
use crate::raster::Crs;

/// Equatorial radius \[m\] and squared eccentricity of the ellipsoid of WGS 84.
const RADIUS_M: f64 = 6_378_137.0;
const ECCENTRICITY_SQUARED: f64 = 0.006_694_379_990_141_3;

/// Returns `true` for web Mercator, whose meters are true at the equator only.
pub fn is_web_mercator(crs: &Crs) -> bool {
    crs.epsg() == Some(3857)
        || horizontal(crs)
            .and_then(|crs| crs.as_projected().map(|projected| projected.method()))
            .is_some_and(|method| matches!(method, ProjectionMethod::WebMercator))
}

/// Returns `true` when a name, or a WKT in meters, means web Mercator. WKT 1 has no projection of
/// its own for it: GDAL wrote the ellipsoidal one, and the sphere into an extension.
pub(super) fn is_named_so(text: &str) -> bool {
    let text = text.to_lowercase().replace(['_', '-'], " ");
    let names = ["web mercator", "pseudo mercator", "google maps global mercator"];
    let is_sphere = ["+proj=merc", "+a=6378137", "+b=6378137"].iter().all(|part| text.contains(part));
    is_sphere || names.iter().any(|name| text.contains(name))
}

/// Stretch of lengths by web Mercator over a box of data.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stretch {
    /// Length of a unit at the middle \[m\]: cos φ.
    pub(crate) meters_per_unit: f64,
    /// Latitude of the middle \[deg\].
    pub(crate) lat: f64,
    /// Largest relative error of lengths in the box that are measured with `meters_per_unit`.
    pub(crate) largest_error: f64,
    /// EPSG code of the UTM zone of the middle.
    pub(crate) utm_epsg: u32,
}

impl Stretch {
    /// Measures the stretch over west, south, east, north; `None` in other systems, and off the
    /// earth.
    pub(crate) fn of(crs: &Crs, [west, south, east, north]: [f64; 4]) -> Option<Stretch> {
        if !is_web_mercator(crs) {
            return None;
        }
        let (x, y) = ((west + east) / 2.0, (south + north) / 2.0);
        let to_degrees = Transformation::new(crs, &from_epsg(4326).ok()?, (x, y)).ok()?;
        let (lon, lat) = to_degrees.apply((x, y)).ok()?;
        let [cos, of_south, of_north] = [y, south, north].map(|y| (y / RADIUS_M).cosh().recip());
        let largest_error =
            [of_south, of_north].into_iter().flat_map(lengths_of_unit).map(|meters| (meters / cos - 1.0).abs());
        Some(Stretch {
            meters_per_unit: cos,
            lat,
            largest_error: largest_error.fold(0.0, f64::max),
            utm_epsg: utm_for(lon, lat),
        })
    }

    /// Returns the system with the true length of its unit in the box.
    pub(crate) fn apply(self, crs: Crs) -> Crs {
        crs.with_true_meters_per_unit(self.meters_per_unit)
    }
}

/// Returns the lengths of a unit to the north and to the east on the ellipsoid \[m\], at a latitude
/// of this cosine.
///
/// # References
/// IOGP Publication 373-7-2, Popular Visualisation Pseudo-Mercator (method 1024).
fn lengths_of_unit(cos: f64) -> [f64; 2] {
    let w = 1.0 - ECCENTRICITY_SQUARED * (1.0 - cos * cos);
    [cos * (1.0 - ECCENTRICITY_SQUARED) / w.powf(1.5), cos / w.sqrt()]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Oslo: `pyproj.Geod(ellps="WGS84")` measures 50.05 m between places that are 100 units apart
    /// to the north.
    #[test]
    fn lengths_in_oslo_are_about_half() {
        let crs = from_epsg(3857).unwrap();
        let stretch = Stretch::of(&crs, [1_196_400.0, 8_379_450.0, 1_196_970.0, 8_380_010.0]).unwrap();
        assert!((stretch.lat - 59.9).abs() < 0.1, "{stretch:?}");
        assert!((stretch.meters_per_unit - stretch.lat.to_radians().cos()).abs() < 1e-9);
        assert!((0.002..0.003).contains(&stretch.largest_error), "{stretch:?}");
        assert_eq!(stretch.utm_epsg, 32632);
        assert!((stretch.apply(crs.clone()).meters_per_unit() - stretch.meters_per_unit).abs() < 1e-12);
        assert!(Stretch::of(&from_epsg(25832).unwrap(), [0.0, 0.0, 1.0, 1.0]).is_none());
    }

    #[test]
    fn writers_of_wkt_1_mean_web_mercator_by_its_name_or_its_sphere() {
        let wkt = |name: &str, extension: &str| {
            format!(
                r#"PROJCS["{name}",GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Mercator_1SP"],PARAMETER["central_meridian",0],PARAMETER["scale_factor",1],PARAMETER["false_easting",0],PARAMETER["false_northing",0],UNIT["metre",1]{extension}]"#
            )
        };
        let sphere = r#",EXTENSION["PROJ4","+proj=merc +a=6378137 +b=6378137 +nadgrids=@null +wktext"]"#;
        for text in [wkt("WGS 84 / Pseudo-Mercator", ""), wkt("Google", sphere), wkt("WGS_1984_Web_Mercator", "")] {
            assert_eq!(super::super::parse(&text).unwrap().epsg(), Some(3857), "{text}");
        }
        assert_eq!(super::super::parse(&wkt("WGS 84 / World Mercator", "")).unwrap().epsg(), Some(3395));
        let described = super::super::from_geokeys_citation("WGS 84 / Pseudo-Mercator", Some(1.0), false);
        assert_eq!(described.epsg(), Some(3857));
    }

    #[test]
    fn the_error_grows_with_the_height_of_the_box() {
        let crs = from_epsg(3857).unwrap();
        let error = |half: f64| Stretch::of(&crs, [0.0, 6e6 - half, 1e3, 6e6 + half]).unwrap().largest_error;
        assert!(error(1e5) > 0.01 && error(1e3) < 0.004, "{} {}", error(1e5), error(1e3));
    }
}
