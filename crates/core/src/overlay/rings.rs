//! Rings and polygons on the lattice.

/// Lattice points around a region or a hole, not closed: the first is not repeated.
pub type Ring = Vec<[i32; 2]>;

/// A shell and its holes. Polygons made here have edges that do not cross, counterclockwise shells
/// and clockwise holes.
pub type Polygon = Vec<Ring>;

/// Ring on the finer lattice of an arrangement.
pub(crate) type FineRing = Vec<[i64; 2]>;

/// Shell and its holes on the finer lattice.
pub(crate) type FinePolygon = Vec<FineRing>;

/// Returns twice the signed area of a ring, positive if counterclockwise; exact.
pub fn doubled_area<T: Copy + Into<i128>>(ring: &[[T; 2]]) -> i128 {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| a[0].into() * b[1].into() - b[0].into() * a[1].into()).sum()
}

/// Returns the bounding box of some points: west, south, east, north. Without points the minima
/// exceed the maxima.
pub(crate) fn bounds_of(points: &[[i32; 2]]) -> [i32; 4] {
    points.iter().fold([i32::MAX, i32::MAX, i32::MIN, i32::MIN], |b, v| {
        [b[0].min(v[0]), b[1].min(v[1]), b[2].max(v[0]), b[3].max(v[1])]
    })
}
