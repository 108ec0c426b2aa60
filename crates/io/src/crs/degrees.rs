//! UTM zones of coordinates in degrees.

/// Returns the EPSG code of the WGS 84 / UTM zone of a place \[deg\]. South-west Norway and
/// Svalbard have wider zones.
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
}
