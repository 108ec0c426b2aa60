//! Polygons as files have them, in doubles.

/// Rings of positions \[CRS units\], the shell first; inside by the even-odd rule.
pub(super) type Polygon = Vec<Vec<[f64; 2]>>;

/// Returns twice the area of a ring, positive where it runs counterclockwise. Points are taken
/// relative to the first, so that large coordinates lose nothing.
pub(super) fn doubled_area(ring: &[[f64; 2]]) -> f64 {
    let Some(origin) = ring.first() else { return 0.0 };
    let from_origin = |p: &[f64; 2]| [p[0] - origin[0], p[1] - origin[1]];
    let pairs = ring.iter().zip(ring.iter().cycle().skip(1));
    pairs.map(|(a, b)| (from_origin(a), from_origin(b))).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum()
}
