//! Rings and polygons on the lattice.

/// Lattice points around a region or a hole, not closed: the first is not repeated.
pub type Ring = Vec<[i32; 2]>;

/// A shell and its holes. Those that are made here have edges that do not cross, counterclockwise shells and clockwise
/// holes.
pub type Polygon = Vec<Ring>;

/// Twice the signed area of a ring, positive counterclockwise; exact.
pub fn doubled_area<T: Copy + Into<i128>>(ring: &[[T; 2]]) -> i128 {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| a[0].into() * b[1].into() - b[0].into() * a[1].into()).sum()
}
