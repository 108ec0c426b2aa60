//! Rings and polygons on the lattice.

/// Lattice points around a region or a hole, not closed: the first is not repeated.
pub type Ring = Vec<[i32; 2]>;

/// A shell and its holes. Those that are made here have edges that do not cross, counterclockwise shells and clockwise
/// holes.
pub type Polygon = Vec<Ring>;
